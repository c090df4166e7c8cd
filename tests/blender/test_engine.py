# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine at F12: what Blender has in its render result afterwards."""

import dataclasses
import time

import bpy
import numpy as np
import pytest

from sdf_lights.blender.engine import clock, status
from sdf_lights.blender.passes import blender_name, owner_of
from sdf_lights.render import session
from sdf_lights.render.passes import PASSES
from sdf_lights.render.session import Progress
from sdf_lights.render.settings import Device, Settings


def combined(pictures) -> np.ndarray:
    return pictures["ViewLayer"]["Combined"]


def test_every_pass_arrives(file, stage, pictures):
    bpy.ops.preferences.addon_enable(module="cycles")
    for item in PASSES:
        if item.switch:
            setattr(owner_of(item, file.layer), item.switch, True)
    found = pictures()["ViewLayer"]
    assert set(found) == {blender_name(item) for item in PASSES}
    for item in PASSES:
        assert found[blender_name(item)].shape == (16, 24, len(item.channels)), item.name
    assert (found["Sample Count"] == 2.0).all()
    seen_lamp = found["SDF Lamps"].max()
    assert seen_lamp > 0.0 and found["Combined"][..., :3].max() == pytest.approx(seen_lamp)
    floor = found["Position"][0, 12]
    assert floor[2] == pytest.approx(0.0, abs=1e-4) and -5.0 < floor[1] < 0.0
    assert found["Depth"][0, 12] == pytest.approx(floor[1] + 5.0, rel=1e-3)
    assert found["Normal"][0, 12] == pytest.approx([0.0, 0.0, 1.0], abs=1e-5)


@pytest.mark.parametrize("device", ["REFERENCE", "CPU"])
def test_diffuse_color_is_that_of_cycles(file, add, quad, material, pictures, device):
    """Cycles counts sheen and what is translucent, and nothing of glossy layers, metal or glass."""
    pytest.importorskip("_cycles")
    bpy.ops.preferences.addon_enable(module="cycles")
    color = (0.8, 0.5, 0.2, 1.0)
    floor = quad()
    add("Floor", floor, scale=(5.0, 5.0, 1.0))
    file.camera.location, file.camera.rotation_euler = (0.0, -2.0, 2.0), (np.pi / 4, 0.0, 0.0)
    file.camera.data.type, file.camera.data.ortho_scale = "ORTHO", 0.01
    file.layer.use_pass_diffuse_color = True
    file.scene.sdf_lights.device = device
    file.scene.cycles.samples, file.scene.cycles.use_denoising = 1, False
    found: dict = {"SDF_LIGHTS": [], "CYCLES": []}
    for kind, inputs in (
        ("BsdfDiffuse", {"Roughness": 1.0}),
        ("BsdfTranslucent", {}),
        ("BsdfAnisotropic", {}),
        ("BsdfGlass", {}),
        ("BsdfPrincipled", {"Metallic": 0.3, "Transmission Weight": 0.4, "Coat Weight": 0.5}),
        ("BsdfPrincipled", {"Sheen Weight": 1.0, "Specular IOR Level": 0.0}),
    ):
        made, tree, output = material(kind)
        node = tree.nodes.new(f"ShaderNode{kind}")
        node.inputs[0].default_value = color
        for name, value in inputs.items():
            node.inputs[name].default_value = value
        tree.links.new(node.outputs[0], output)
        floor.materials.clear()
        floor.materials.append(made)
        for file.scene.render.engine in found:
            passes = pictures()["ViewLayer"]
            found[file.scene.render.engine].append(next(passes[name] for name in passes if name.startswith("Diff")))
    ours, cycles = map(np.array, found.values())
    assert ours[2].max() == 0.0
    np.testing.assert_allclose(ours, cycles, rtol=2e-3)
    assert (ours[-1] - color[:3] > 0.005).all()


def test_rows_are_the_right_way_up(file, stage, pictures):
    """The floor is in the lower half, and nothing lights the upper half but the lamp in its middle."""
    picture = combined(pictures())[..., :3]
    assert picture[0].min() > 0.0 and picture[-1].max() == 0.0
    assert picture[8, 12].min() > 0.0


def test_border_is_the_same_picture(file, stage, pictures):
    file.scene.sdf_lights.device = "CPU"  # whose samples belong to a place in the frame
    whole = combined(pictures())
    render = file.scene.render
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.8, 0.1, 0.7
    part = combined(pictures())
    inside = np.zeros((16, 24), bool)
    inside[1:11, 6:19] = True
    assert part.shape == whole.shape
    assert part[inside] == pytest.approx(whole[inside])
    assert (part[~inside] == 0.0).all()
    render.use_crop_to_border = True
    cropped = combined(pictures())
    assert cropped.shape == (10, 13, 4)
    assert cropped == pytest.approx(whole[1:11, 6:19])


def test_percentage_and_aspect(file, stage, pictures):
    file.scene.render.resolution_percentage = 50
    file.scene.render.pixel_aspect_x = 2.0
    assert combined(pictures()).shape == (8, 12, 4)


def test_view_layers_have_pictures_of_their_own(file, stage, pictures):
    lit = bpy.data.collections.new("Lit")
    file.scene.collection.children.link(lit)
    file.scene.collection.objects.unlink(stage)
    lit.objects.link(stage)
    dark = file.scene.view_layers.new("Dark")
    dark.layer_collection.children["Lit"].exclude = True
    found = pictures()
    assert found["ViewLayer"]["Combined"][..., :3].max() > 0.0
    assert found["Dark"]["Combined"][..., :3].max() == 0.0


def test_transparent_film_and_exposure(file, stage, pictures):
    opaque = combined(pictures())
    assert (opaque[..., 3] == 1.0).all()
    file.scene.render.film_transparent, file.scene.sdf_lights.exposure = True, 2.0
    clear = combined(pictures())
    assert (clear[-1, :, 3] == 0.0).all() and (clear[0, :, 3] == 1.0).all()
    assert clear[0, :, :3] == pytest.approx(2.0 * opaque[0, :, :3], rel=1e-5)


def test_the_same_seed_gives_the_same_picture(file, stage, pictures):
    first, again = combined(pictures()), combined(pictures())
    assert (first == again).all()
    file.scene.frame_set(2)
    assert (combined(pictures()) != first).any()
    file.scene.sdf_lights.animate_seed = False
    still = combined(pictures())
    file.scene.frame_set(3)
    assert (combined(pictures()) == still).all()


def test_animation(file, stage, tmp_path):
    file.scene.frame_start, file.scene.frame_end = 1, 3
    file.scene.render.filepath = str(tmp_path / "frame")
    file.scene.render.image_settings.file_format = "PNG"
    bpy.ops.render.render(animation=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["frame0001.png", "frame0002.png", "frame0003.png"]


def test_machine_code_agrees_with_the_reference(file, stage, pictures):
    file.scene.sdf_lights.samples = 64
    reference = combined(pictures())[..., :3]
    file.scene.sdf_lights.device = "CPU"
    picture = combined(pictures())[..., :3]
    assert picture.mean() == pytest.approx(reference.mean(), rel=0.05)


def test_cancelling_keeps_what_there_is(file, stage, pictures, monkeypatch):
    """Only the key press is made up: headless Blender has no keyboard."""
    file.scene.sdf_lights.samples = 1 << 20
    progress = []

    def render(scene, passes, cancelled, on_progress, on_update):
        def note(state):
            progress.append(state)
            on_progress(state)

        return whole(scene, passes, lambda: cancelled() or len(progress) > 8, note, on_update)

    whole = session.render
    monkeypatch.setattr(session, "render", render)
    picture = combined(pictures())
    assert picture[0, :, :3].min() > 0.0
    assert 0.0 < progress[-1].samples < 1 << 20


def test_one_sentence_for_an_error(file, stage):
    file.camera.scale = (0.0, 0.0, 0.0)
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.render.render()
    assert str(caught.value).count("Camera 'Camera'") == 1 and "Traceback" not in str(caught.value)
    file.camera.scale = (1.0, 1.0, 1.0)
    assert bpy.ops.render.render() == {"FINISHED"}


def test_an_unexpected_error_is_told_too(file, stage, monkeypatch):
    monkeypatch.setattr("sdf_lights.render.session.render", lambda *arguments, **options: 1 / 0)
    with pytest.raises(RuntimeError, match="ZeroDivisionError.*--debug-python"):
        bpy.ops.render.render()


def test_rendering_after_enabling_again(file, stage, registered, pictures):
    before = combined(pictures())
    registered.unregister()
    registered.register()
    file.scene.render.engine = "SDF_LIGHTS"
    assert (combined(pictures()) == before).all()


@pytest.mark.parametrize(
    "changes",
    [
        dict(samples=64, noise_threshold=0.2),
        dict(samples=64, noise_threshold=0.2, min_samples=32),
        dict(samples=7, guided_samples=False),
    ],
)
def test_sampling_is_that_of_a_session(file, stage, pictures, synced, changes):
    """Settings reach the renderer: each pixel gets as many samples as in a session with the same settings."""
    settings = file.scene.sdf_lights
    settings.device = "CPU"
    for name, value in changes.items():
        setattr(settings, name, value)
    file.layer.sdf_lights.use_pass_sample_count = True
    counts = pictures()["ViewLayer"]["Sample Count"]
    expected = Settings(
        device=Device.CPU,
        noise_threshold=changes.get("noise_threshold", 0.0),
        samples=changes["samples"],
        min_samples=changes.get("min_samples", Settings().min_samples),
        guided_samples=changes.get("guided_samples", True),
    )
    scene = synced()
    # The frame seeds the pattern.
    scene.settings = dataclasses.replace(expected, seed=scene.settings.seed)
    film = session.render(scene, ("Sample Count",))
    assert (counts == film.read("Sample Count")).all()
    assert counts.max() == changes["samples"]
    assert (counts.min() < counts.max()) == ("noise_threshold" in changes)
    assert counts.min() >= changes.get("min_samples", 0)


def test_time_limit(file, stage, pictures):
    file.scene.sdf_lights.device = "CPU"
    pictures()  # compiles, if need be
    file.scene.sdf_lights.samples, file.scene.sdf_lights.time_limit = 1 << 20, 0.5
    file.layer.sdf_lights.use_pass_sample_count = True
    started = time.perf_counter()
    found = pictures()["ViewLayer"]
    assert 0.5 < time.perf_counter() - started < 5.0
    assert 0 < found["Sample Count"].min() and found["Sample Count"].max() < 1 << 20
    assert found["Combined"][0, :, :3].min() > 0.0


def test_status():
    assert clock(0.4) == "00:00" and clock(61.6) == "01:02" and clock(3723.0) == "1:02:03"
    line = status(Progress("Sample 4/64", 0.0625, 4, 1.0, 15.2, 512 << 20, 0.0123))
    assert line == "Remaining: 00:15 | Mem: 512M | Noise: 0.0123 | Sample 4/64"
    assert status(Progress("Preparing")) == "Preparing"
