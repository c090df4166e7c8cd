# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Images as sync reads them, against what Cycles shows of them."""

import bpy
import numpy as np
import pytest

SIZE = 8

PIXELS = np.random.default_rng(1).uniform(0.05, 0.95, (SIZE, SIZE, 4)).astype(np.float32)
PIXELS[..., 3] = 1.0


def saved(path, pixels: np.ndarray, is_float: bool = False):
    """An image file of these pixels, as they are, loaded by Blender."""
    import OpenImageIO

    specification = OpenImageIO.ImageSpec(SIZE, SIZE, 4, OpenImageIO.FLOAT if is_float else OpenImageIO.UINT8)
    if not is_float:
        specification["oiio:UnassociatedAlpha"] = 1
    output = OpenImageIO.ImageOutput.create(str(path))
    output.open(str(path), specification)
    output.write_image(np.ascontiguousarray(pixels[::-1]))
    output.close()
    return bpy.data.images.load(str(path))


@pytest.fixture
def shown(file, add, quad, material, synced, pictures):
    """Function: colours that sync reads for a texture, and those that a render of it by Cycles has, texel by texel."""
    pytest.importorskip("_cycles")
    pytest.importorskip("OpenImageIO")

    def run(image, alpha_linked: bool = False):
        bpy.ops.preferences.addon_enable(module="cycles")
        made, tree, output = material()
        texture, emission = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
        texture.image, texture.interpolation = image, "Closest"
        tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
        if alpha_linked:  # to a mix of the same twice, so that it changes nothing but what becomes of colour
            mix = tree.nodes.new("ShaderNodeMixShader")
            tree.links.new(texture.outputs["Alpha"], mix.inputs[0])
            tree.links.new(emission.outputs[0], mix.inputs[1])
            twin = tree.nodes.new("ShaderNodeEmission")
            twin.inputs["Strength"].default_value = 1.0001  # Cycles would see through exact twins
            tree.links.new(texture.outputs["Color"], twin.inputs["Color"])
            tree.links.new(twin.outputs[0], mix.inputs[2])
            tree.links.new(mix.outputs[0], output)
        else:
            tree.links.new(emission.outputs[0], output)
        data = quad()
        data.materials.append(made)
        add("Quad", data)
        file.camera.location, file.camera.rotation_euler = (0.0, 0.0, 5.0), (0.0, 0.0, 0.0)
        file.camera.data.type, file.camera.data.ortho_scale = "ORTHO", 2.0
        render = file.scene.render
        render.resolution_x = render.resolution_y = SIZE
        scene = synced()
        surface = scene.materials[0].surface
        node = (surface["a"] if alpha_linked else surface)["color"]
        color = scene.images[node.settings["image"]].pixels[..., :3]
        render.engine = "CYCLES"
        cycles = file.scene.cycles
        cycles.samples, cycles.use_denoising, cycles.filter_width, cycles.pixel_filter_type = 1, False, 0.01, "BOX"
        picture = pictures()["ViewLayer"]["Combined"][..., :3]
        return np.broadcast_to(color, picture.shape), picture, scene

    return run


@pytest.mark.parametrize("space", ["sRGB", "Non-Color", "Linear Rec.709", "Display P3"])
def test_bytes(shown, tmp_path, space):
    image = saved(tmp_path / "image.png", PIXELS)
    image.colorspace_settings.name = space
    read, picture, scene = shown(image)
    assert scene.warnings == []
    # Cycles keeps some spaces in half floats or bytes of its own.
    assert read == pytest.approx(picture, abs=3e-3)


@pytest.mark.parametrize("mode", ["STRAIGHT", "CHANNEL_PACKED", "NONE"])
@pytest.mark.parametrize("alpha_linked", [False, True])
def test_alpha_of_bytes(shown, tmp_path, mode, alpha_linked):
    pixels = PIXELS.copy()
    pixels[..., 3] = np.linspace(0.75, 1.0, SIZE)  # less of it, and little is left of Cycles' bytes
    image = saved(tmp_path / "image.png", pixels)
    image.alpha_mode = mode
    read, picture, _ = shown(image, alpha_linked)
    # A step of Cycles' bytes, which hold colour times alpha, where sRGB is steepest.
    assert read == pytest.approx(picture, abs=2.2 / 255 / 0.75)


def test_floats(shown, tmp_path):
    image = saved(tmp_path / "image.exr", PIXELS * 4.0, is_float=True)
    image.colorspace_settings.name = "Linear Rec.709"
    image.alpha_mode = "NONE"
    read, picture, _ = shown(image)
    assert read == pytest.approx(picture, rel=1e-3)
    assert read.max() > 2.0


def test_packed(shown, tmp_path):
    image = saved(tmp_path / "image.png", PIXELS)
    image.pack()
    (tmp_path / "image.png").unlink()
    read, picture, scene = shown(image)
    assert scene.warnings == [] and read == pytest.approx(picture, abs=3e-3)


def test_generated_and_painted(shown):
    image = bpy.data.images.new("Painted", SIZE, SIZE)
    image.pixels.foreach_set(PIXELS.ravel())
    read, picture, _ = shown(image)
    assert read == pytest.approx(picture, abs=3e-3)
    assert np.ptp(read) > 0.5


def test_deleted_file_is_magenta_and_named(shown, tmp_path):
    image = saved(tmp_path / "image.png", PIXELS)
    (tmp_path / "image.png").unlink()
    image.reload()
    read, picture, scene = shown(image)
    assert read == pytest.approx(picture)
    assert read[0, 0].tolist() == [1.0, 0.0, 1.0]
    [warning] = scene.warnings
    assert f"'{image.name}'" in warning and "Find Missing Files" in warning


def test_tiles_and_sequences_are_named(shown, tmp_path):
    image = saved(tmp_path / "image.png", PIXELS)
    image.source = "SEQUENCE"
    _, _, scene = shown(image)
    assert any("sequence" in warning for warning in scene.warnings)


def test_pixels_that_are_not_numbers(shown):
    image = bpy.data.images.new("Broken", SIZE, SIZE, float_buffer=True)
    pixels = PIXELS.copy()
    pixels[0, 0, 0] = np.nan
    image.pixels.foreach_set(pixels.ravel())
    read, _, scene = shown(image)
    assert np.isfinite(read).all() and read[0, 0, 0] == 0.0
    assert "'Broken'" in scene.warnings[0]
