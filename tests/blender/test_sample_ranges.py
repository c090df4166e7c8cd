# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of renders without a window, and pictures whose samples several renders share."""

import json
import pathlib

import bpy
import numpy as np
import pytest

from sdf_lights.blender import command_line, movie, render_job
from sdf_lights.blender.shader_trees import use_nodes
from sdf_lights.render import merge_files, merging
from sdf_lights.render.errors import RenderError
from sdf_lights.render.settings import Device

PASSES = (
    "z normal uv object_index ambient_occlusion diffuse_direct diffuse_indirect diffuse_color glossy_direct "
    "glossy_color environment cryptomatte_object cryptomatte_material"
)


def test_arguments_are_read():
    words = "blender -b -- other --sdf-device cpu --sdf-threads=8 --sdf-samples 64:128 --sdf-log info --sdf-strict"
    found = command_line.arguments(words.split())
    assert found.strict and found.log == "info"
    assert found.settings == dict(device=Device.CPU, threads=8, sample_offset=64, samples=64)
    assert command_line.arguments(["blender", "--", "--sdf-samples", "12"]).settings == dict(samples=12)
    assert command_line.arguments(["blender", "--sdf-threads", "8"]).settings == {}  # Blender's own


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--sdf-device tpu", "--sdf-device tpu: choose from automatic, cpu"),
        ("--sdf-threads many", "--sdf-threads many: write a whole number from 0 to 1024"),
        ("--sdf-threads", "--sdf-threads: write a whole number"),
        ("--sdf-samples 8:8", "the range has no sample"),
        ("--sdf-samples 0:" + "9" * 400, "write a whole number"),
        ("--sdf-log loud", "choose from debug, info"),
        ("--sdf-sample 8", "There is no argument --sdf-sample: choose from --sdf-device"),
    ],
)
def test_a_wrong_argument_is_named(words, told):
    with pytest.raises(RenderError) as error:
        command_line.arguments(["blender", "--", *words.split()])
    assert told in str(error.value) and str(error.value).endswith(".")


def test_a_wrong_argument_fails_the_render(file, stage, monkeypatch):
    monkeypatch.setattr("sys.argv", ["blender", "--", "--sdf-samples", "none"])
    with pytest.raises(RuntimeError, match="--sdf-samples none: write a whole number"):
        bpy.ops.render.render()


def test_the_log_says_what_is_rendered(file, stage, monkeypatch, caplog):
    monkeypatch.setattr("sys.argv", ["blender", "--", "--sdf-samples", "3", "--sdf-log", "info"])
    with caplog.at_level("INFO", logger="sdf_lights"):
        bpy.ops.render.render()
    assert [record.message for record in caplog.records] == [
        "frame 1 of view layer 'ViewLayer': 1 objects, 1 SDF lamps",
        "frame 1 of view layer 'ViewLayer': 3 samples by the NumPy reference",
    ]


@pytest.fixture
def ranges(file, stage, add, quad, material, lamp, tmp_path, monkeypatch):
    """Function: the file of the samples of a range, such as "8:16"."""
    made, tree, output = material("Metal")
    node = tree.nodes.new("ShaderNodeBsdfGlossy")
    node.inputs["Roughness"].default_value = 0.3
    tree.links.new(node.outputs[0], output)
    mesh = quad("Metal")
    mesh.materials.append(made)
    board = add("Metal", mesh, (0.8, 1.0, 0.8), (1.5, 0.0, 0.4), (0.6, 0.6, 1.0))
    board.pass_index = 3
    # Mattes of what moves share pixels, in other parts for each range.
    add("Bar", quad("Bar"), (-0.9, 0.0, 0.8), (1.5, 0.4, 0.1), (0.05, 0.7, 1.0))
    scene, settings = file.scene, file.scene.render.image_settings
    own = scene.sdf_lights
    own.device, own.guided_samples, own.indirect_paths, own.seed = "CPU", False, 2, 5
    own.animate_seed = False
    for name in PASSES.split():
        setattr(file.layer, f"use_pass_{name}", True)
    file.layer.sdf_lights.use_pass_sample_count = True
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"

    def run(samples: str) -> pathlib.Path:
        path = tmp_path / f"{samples.replace(':', '-')}.exr"
        monkeypatch.setattr("sys.argv", ["blender", "--", "--sdf-samples", samples])
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        return path

    return run


def passes_of(parts: list[merge_files.Part]) -> dict[str, np.ndarray]:
    (passes,) = merge_files.groups(parts).values()
    return {name: parts[part].pixels[..., channels] for name, (part, channels) in passes.items()}


def test_four_ranges_are_one_render(ranges, file, tmp_path, capsys):
    whole = passes_of(merge_files.read(ranges("0:256")))
    parts = [ranges(f"{first}:{first + 64}") for first in (64, 0, 192, 128)]
    assert merge_files.main([str(tmp_path / "out.exr"), *map(str, parts)]) == 0
    joined = passes_of(merge_files.read(tmp_path / "out.exr"))
    assert set(joined) == set(whole) and len(whole) >= 16
    for name, expected in whole.items():
        found = joined[name]
        if name.startswith("Crypto"):
            # What covers as much as another thing may stand before it, and the least of four may have had no room.
            number, cover = expected[..., 0::2], expected[..., 1::2]
            assert np.isclose(found[..., 1::2], cover, atol=1e-6).mean() > 0.99, name
            sure = np.abs(np.diff(cover, axis=-1)).min(axis=-1) > 1e-3
            assert sure.any() or not name.endswith("00"), name
            assert (found[..., 0] == number[..., 0])[sure].all(), name
            continue
        np.testing.assert_allclose(found, expected, rtol=2e-5, atol=2e-6, err_msg=name)
    # The file says what it has, so it can be joined with more.
    assert told(tmp_path / "out.exr") == {"ViewLayer": (merging.Share(5, 0, 256),)}
    file.layer.sdf_lights.use_pass_denoising_data = True
    halves = [str(ranges(samples)) for samples in ("256:260", "260:264")]
    for name, words in (("noisy", []), ("clean", ["--denoise"])):
        assert merge_files.main([*words, "--frame", "7", str(tmp_path / f"{name}_##.exr"), *halves]) == 0
    noisy, clean = (passes_of(merge_files.read(tmp_path / f"{name}_07.exr")) for name in ("noisy", "clean"))
    assert not np.allclose(clean["Combined"], noisy["Combined"], rtol=1e-3)
    np.testing.assert_allclose(clean["Combined"].mean((0, 1)), noisy["Combined"].mean((0, 1)), rtol=0.1)
    np.testing.assert_array_equal(clean["Depth"], noisy["Depth"])


def told(path: pathlib.Path) -> dict:
    return merging.shares(
        {item.name: str(item.value) for part in merge_files.read(path) for item in part.spec.extra_attribs}
    )


def test_a_joined_file_knows_its_gaps(ranges, tmp_path, capsys):
    first, gap, third = (str(ranges(samples)) for samples in ("0:2", "2:4", "4:6"))
    out, whole = tmp_path / "out.exr", tmp_path / "whole.exr"
    assert merge_files.main([str(out), first, third]) == 0
    assert told(out) == {"ViewLayer": (merging.Share(5, 0, 2), merging.Share(5, 4, 2))}
    assert merge_files.main([str(whole), str(out), third]) == 1
    assert "two renders have the same samples (4 to 5 and 4 to 5, seed 5)" in capsys.readouterr().err
    assert merge_files.main([str(whole), gap, str(out)]) == 0
    assert told(whole) == {"ViewLayer": (merging.Share(5, 0, 6),)}
    assert merge_files.main([str(tmp_path / "at_once.exr"), first, gap, third]) == 0
    at_once = passes_of(merge_files.read(tmp_path / "at_once.exr"))["Combined"]
    np.testing.assert_allclose(passes_of(merge_files.read(whole))["Combined"], at_once, rtol=1e-6, atol=1e-7)


def test_places_that_cannot_be_written(ranges, tmp_path, capsys):
    parts = [str(ranges(samples)) for samples in ("0:2", "2:4")]
    (tmp_path / "folder.exr").mkdir()
    (tmp_path / "file").write_text("not a folder")
    for place, sentence in (
        ("out.png", "name a file that ends with .exr"),
        ("folder.exr", "folder.exr cannot be written"),
        ("missing/out.exr", "out.exr cannot be written"),
        ("file/out.exr", "out.exr cannot be written"),
    ):
        assert merge_files.main([str(tmp_path / place), *parts]) == 1
        assert sentence in capsys.readouterr().err
    assert [path.name for path in tmp_path.rglob(".*")] == []


def test_files_that_cannot_be_joined(ranges, file, tmp_path, capsys):
    file.scene.sdf_lights.samples = 4
    first, same = ranges("0:4"), ranges("2:6")
    (tmp_path / "broken.exr").write_bytes(first.read_bytes()[:300])
    (tmp_path / "half.exr").write_bytes(first.read_bytes()[: first.stat().st_size // 2])
    file.scene.render.resolution_x = 16
    other = ranges("8:12")
    file.layer.use_pass_uv = False
    fewer = ranges("16:20")
    out = tmp_path / "out.exr"
    for path, sentence in (
        (same, "two renders have the same samples (0 to 3 and 2 to 5, seed 5)"),
        (tmp_path / "broken.exr", "broken.exr cannot be read"),
        (tmp_path / "half.exr", "half.exr cannot be read"),
        (tmp_path / "missing.exr", "missing.exr cannot be read"),
        (other, "8-12.exr has another size"),
        (fewer, "16-20.exr has other passes"),
    ):
        assert merge_files.main([str(out), str(first), str(path)]) == 1
        assert sentence in capsys.readouterr().err and not out.exists()
    assert {path.name for path in tmp_path.iterdir() if path.name.startswith(".")} == set()


def test_jobs_have_every_sample_once():
    for samples, count in ((256, 4), (10, 3), (2, 8), (1, 1)):
        found = render_job.ranges(samples, count)
        assert [index for first, end in found for index in range(first, end)] == list(range(samples))
        assert len(found) == min(samples, count)


@pytest.mark.parametrize("words", ["--samples -4", "--samples 0", "--tasks 0", "--frames 10-1", "--frames all"])
def test_a_wrong_job_gets_one_sentence(registered, words, tmp_path, capsys):
    """As argparse ends a program. The number or the frames are named."""
    with pytest.raises(SystemExit) as end:
        render_job.command([str(tmp_path / "job.json"), str(tmp_path / "room.blend"), *words.split()])
    assert end.value.code == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert f"argument {words.split()[0]}: '{words.split()[1]}'" in said
    assert not (tmp_path / "job.json").exists()


def test_a_job_has_the_frames_of_the_command(file, tmp_path):
    job, blend = tmp_path / "job.json", tmp_path / "Büro 2.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    for frames in ("7", "-3-4", "1-100:2", "1, 5-9"):
        assert render_job.command([str(job), str(blend), f"--frames={frames}"]) == 0
        names = {item["name"]: item.get("default") for item in json.loads(job.read_text())["parameterDefinitions"]}
        assert names["Frames"] == frames and names["File"] == blend.name


def test_a_job_is_written(file, stage, tmp_path):
    blend, job = tmp_path / "room.blend", tmp_path / "job.json"
    with pytest.raises(RuntimeError, match="save it, so that other machines can open it"):
        bpy.ops.sdf_lights.render_job_write(filepath=str(job))
    file.scene.frame_end, file.scene.frame_step, file.scene.sdf_lights.samples = 9, 2, 12
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.sdf_lights.render_job_write(filepath=str(job), tasks=3)
    made = json.loads(job.read_text())
    assert {item["name"]: item["default"] for item in made["parameterDefinitions"]} == {
        "File": "room.blend",
        "Folder": "room frames",
        "Frames": "1-9:2",
        "Blender": "blender",
    }
    render, merge = made["steps"]
    values = {item["name"]: item["range"] for item in render["parameterSpace"]["taskParameterDefinitions"]}
    assert values == {"Frame": "{{Param.Frames}}", "First": ["0", "4", "8"], "End": ["4", "8", "12"]}
    parts = [word for word in merge["script"]["actions"]["onRun"]["args"] if "parts" in word]
    assert parts == [f"{{{{Param.Folder}}}}/parts/{first}_####.exr" for first in (0, 4, 8)]
    with pytest.raises(RuntimeError, match="choose another folder"):
        bpy.ops.sdf_lights.render_job_write(filepath=str(tmp_path / "missing" / "job.json"))


def test_a_movie_is_made_as_the_scene_shows_it(file, pictures, tmp_path, capsys):
    """In the order of numbers, with the view transform of the file; odd sizes lose a line, as H.264 asks."""
    scene, blend, out = file.scene, str(tmp_path / "room.blend"), tmp_path / "movie.mp4"
    scene.world = bpy.data.worlds.new("World")
    color = use_nodes(scene.world).nodes["Background"].inputs["Color"]
    scene.render.resolution_x, scene.render.resolution_y, scene.render.fps = 33, 25, 30
    shades = {}
    for frame, strength in ((9999, 0.2), (10_000, 0.8)):
        color.default_value = (strength, strength, strength, 1.0)
        pictures()
        (tmp_path / "picture.exr").rename(tmp_path / f"{frame}.exr")
    for transform in ("Standard", "Raw"):
        scene.view_settings.view_transform = transform
        bpy.ops.wm.save_as_mainfile(filepath=blend, check_existing=False)
        assert movie.command([str(out), blend, str(tmp_path / "*.exr")]) == 0
        scene = bpy.context.scene
        assert "has 2 frames" in capsys.readouterr().out and len(bpy.data.scenes) == 1
        clip = bpy.data.movieclips.load(str(out))
        assert tuple(clip.size) == (32, 24) and clip.frame_duration == 2 and clip.fps == pytest.approx(30.0)
        image = bpy.data.images.load(str(out))
        image.colorspace_settings.name = "Non-Color"
        shades[transform] = np.array(image.pixels[:4])[0]
        bpy.data.images.remove(image)
        bpy.data.movieclips.remove(clip)
    assert shades["Raw"] == pytest.approx(0.2, abs=0.02)  # the frame with the lower number is the first
    assert shades["Standard"] == pytest.approx(0.485, abs=0.02)
    assert movie.command([str(out), blend, str(tmp_path / "missing.exr")]) == 1
    assert "there is no picture" in capsys.readouterr().out
    (tmp_path / "text.exr").write_text("no picture")
    assert movie.command([str(out), blend, str(tmp_path / "text.exr")]) == 1
    assert "text.exr is not a picture" in capsys.readouterr().out
