# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Datablocks that a stranger may have made to hang Blender, or to read what is not theirs."""

import ast
import os
import pathlib
import struct
import time
import types
import zlib

import bpy
import numpy as np
import pytest

from sdf_lights.blender.nodes import groups, writing
from sdf_lights.blender.nodes.tree import GROUP, output_of
from sdf_lights.blender.sync import images, node_inputs, pixels
from sdf_lights.render.scene import Scene


def nested(levels: int, side_by_side: bool) -> bpy.types.NodeTree:
    """A group with two of the next in it, and so on: side by side, or one after the other."""
    inner = None
    for _ in range(levels):
        tree = bpy.data.node_groups.new("Nested", "ShaderNodeTree")
        tree.interface.new_socket("in", in_out="INPUT", socket_type="NodeSocketFloat")
        tree.interface.new_socket("out", in_out="OUTPUT", socket_type="NodeSocketFloat")
        start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        total = tree.nodes.new("ShaderNodeMath")
        parts = []
        for _ in range(2 if inner else 0):
            parts.append(tree.nodes.new("ShaderNodeGroup"))
            parts[-1].node_tree = inner
        source = start.outputs[0]
        for index, part in enumerate(parts):
            tree.links.new(start.outputs[0] if side_by_side else source, part.inputs[0])
            source = part.outputs[0]
            if side_by_side:
                tree.links.new(source, total.inputs[index])
        if not parts or not side_by_side:
            tree.links.new(source, total.inputs[0])
        tree.links.new(total.outputs[0], end.inputs[0])
        inner = tree
    return inner


@pytest.mark.parametrize(
    "levels, side_by_side, told",
    [
        (14, True, ("groups are nested so often",)),
        (11, False, ("groups are nested so often", "chains of nodes are too long")),
    ],
)
def test_groups_that_double_at_each_level(file, stage, pictures, capfd, levels, side_by_side, told):
    material = bpy.data.materials.new("Nested")
    material.use_nodes = True
    group = material.node_tree.nodes.new("ShaderNodeGroup")
    group.node_tree = nested(levels, side_by_side)
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    material.node_tree.links.new(group.outputs[0], shader.inputs["Roughness"])
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    mesh.data.materials.clear()
    mesh.data.materials.append(material)
    capfd.readouterr()
    pictures()
    output = capfd.readouterr()
    assert any(f"Material 'Nested': its {what}" in output.out for what in told), output.out[-500:]
    assert "Traceback" not in output.out + output.err


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="there are no devices")
def test_devices_are_no_files(file):
    assert not pixels.exists("/dev/zero")
    light = bpy.data.lights.new("Text", "POINT")
    light.use_nodes = True
    texture = light.node_tree.nodes.new("ShaderNodeTexIES")
    texture.mode, texture.filepath = "EXTERNAL", "/dev/zero"
    assert node_inputs.ies_text(texture) == ""


def test_long_texts_are_no_light_distributions(file, tmp_path):
    path = tmp_path / "long.ies"
    with open(path, "wb") as long:
        long.truncate(node_inputs.MOST_IES_BYTES + 1)
    light = bpy.data.lights.new("Text", "POINT")
    light.use_nodes = True
    texture = light.node_tree.nodes.new("ShaderNodeTexIES")
    texture.mode, texture.filepath = "EXTERNAL", str(path)
    assert node_inputs.ies_text(texture) == ""


# -- what a stranger's words might do -------------------------------------------------------------------------------


@pytest.fixture
def trap(tmp_path):
    """A file that is there if somebody's words were run as Python, and such words."""
    path = tmp_path / "ran"
    return path, f"__import__('pathlib').Path({str(path)!r}).touch()"


PLACES = ["expression", "text", "emission", "name", "property", "driver", "IES"]


@pytest.mark.parametrize("place", PLACES)
def test_words_are_never_run(file, stage, pictures, tmp_path, trap, capfd, place):
    """In every place that has words, saved to a file and opened as files of strangers are: without their scripts."""
    ran, words = trap
    light = bpy.data.objects["Lamp"].data
    lamp = light.sdf_lamp
    text = bpy.data.texts.new("register.py")
    text.write(f"import bpy\n{words}\n")
    text.use_module = True  # scripts that run when a trusted file is opened
    if place in ("expression", "name"):
        lamp.source = "EXPRESSION"
        lamp.expression = words if place == "expression" else f"{words[:40]} + sphere(1)"
    elif place == "text":
        lamp.source, lamp.text = "EXPRESSION", text
    elif place == "emission":
        lamp.emission.source, lamp.emission.expression = "EXPRESSION", words
    elif place == "property":
        light["sdf_size"] = words
        lamp.source, lamp.expression = "EXPRESSION", "size = slider(1, 0, 2)\nsphere(size)"
    elif place == "driver":
        driver = light.driver_add("energy").driver
        driver.type, driver.expression = "SCRIPTED", f"{words} or 100.0"
    else:
        other = bpy.data.lights.new("Lines", "POINT")
        other.use_nodes = True
        node = other.node_tree.nodes.new("ShaderNodeTexIES")
        node.mode, node.ies = "INTERNAL", text
        other.node_tree.links.new(node.outputs[0], other.node_tree.nodes["Emission"].inputs["Strength"])
        file.scene.collection.objects.link(bpy.data.objects.new("Lines", other))
    path = tmp_path / "stranger.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    ran.unlink(missing_ok=True)  # a driver that is made in this process is this user's own
    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
    file.scene = bpy.context.scene
    capfd.readouterr()
    pictures()
    output = capfd.readouterr()
    assert not ran.exists()
    assert "Traceback" not in output.out + output.err


def test_nothing_of_the_program_runs_words_or_unpickles():
    """The one place that unpickles is the cache, after a checksum and a look at the owner (tests/test_kernel_cache.py).
    The one that starts processes starts Python with words of its own, to compile kernels."""
    forbidden = {"eval", "exec", "compile", "__import__"}
    modules = {"pickle", "marshal", "shelve", "subprocess", "code", "ctypes", "runpy"}
    found = set()
    for path in (pathlib.Path(__file__).resolve().parents[2] / "sdf_lights").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in forbidden:
                found.add((path.name, node.func.id))
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") in {"system", "popen", "driver_namespace"}:
                found.add((path.name, node.func.attr))
            if isinstance(node, ast.keyword) and node.arg == "allow_pickle" and ast.unparse(node.value) != "False":
                found.add((path.name, node.arg))
            names = [alias.name for alias in node.names] if isinstance(node, (ast.Import, ast.ImportFrom)) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            found |= {(path.name, name) for name in names if name.partition(".")[0] in modules}
    assert {pair for pair in found if pair[1] != "ctypes"} == {
        ("kernel_cache.py", "pickle"),
        ("background.py", "subprocess"),
    }


# -- files that are none ----------------------------------------------------------------------------------------------


@pytest.fixture
def pictured(stage, material):
    """The image texture node of the floor."""
    made, tree, output = material("Floor")
    emission, texture = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeTexImage")
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output)
    bpy.data.objects["Floor"].data.materials.append(made)
    return texture


def told(capfd, pictures) -> list[str]:
    capfd.readouterr()
    started = time.process_time()
    pictures()
    assert time.process_time() - started < 20.0
    output = capfd.readouterr()
    assert "Traceback" not in output.out + output.err
    return [line for line in output.out.splitlines() if line.startswith("Warning: ")]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes in the file system")
@pytest.mark.parametrize("source", ["FILE", "SEQUENCE", "TILED", "MOVIE"])
@pytest.mark.parametrize("kind", ["pipe", "folder", "text", "nothing"])
def test_images_that_are_no_pictures(pictured, pictures, capfd, tmp_path, source, kind):
    """A pipe has no end, and nobody writes to it; of a text nothing is shown."""
    name = {"SEQUENCE": "wall0001.png", "TILED": "wall.1001.png", "MOVIE": "wall.mp4"}.get(source, "wall.png")
    path = tmp_path / name
    image = bpy.data.images.new("Wall", 4, 4)
    image.source, image.filepath_raw = source, str(path).replace("1001", "<UDIM>")
    if kind == "pipe" and source != "MOVIE":  # a movie is opened by Blender alone, also without this add-on
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "text":
        path.write_text("root:x:0:0:root:/root:/bin/bash\n" * 100)
    pictured.image = image
    found = told(capfd, pictures)
    # A tile without a file that was never saved is one that Blender generates.
    assert len(found) == 1 or source == "TILED" and not found
    assert all("'Wall'" in line and "root:" not in line for line in found)


def png(width: int, height: int, data: bytes = b"") -> bytes:
    """A PNG that says that it is so large."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", width, height, 16, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def test_damaged_words_of_files_are_no_faults(tmp_path):
    """OpenImageIO quotes them in its errors, whatever bytes they have."""
    openimageio = pytest.importorskip("OpenImageIO")
    path = tmp_path / "picture.exr"
    output = openimageio.ImageOutput.create(str(path))
    output.open(str(path), openimageio.ImageSpec(8, 4, 3, "half"))
    output.write_image(np.zeros((4, 8, 3), np.float32))
    output.close()
    whole = path.read_bytes()
    refused = 0
    for place in range(400):
        path.write_bytes(whole[:place] + b"\xa1" + whole[place + 1 :])
        try:
            pixels.File(str(path)).read(pixels.Form())
        except OSError as error:
            refused += str(error) != ""
    assert 0 < refused < 400


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("size", [(250_000, 250_000), (1_000_000, 1_000_000)])
def test_images_that_say_that_they_are_huge(pictured, pictures, capfd, tmp_path, size, packed):
    """A few bytes that would take hundreds of gigabytes of memory."""
    path = tmp_path / "huge.png"
    path.write_bytes(png(*size, zlib.compress(bytes(1000))))
    pictured.image = bpy.data.images.load(str(path))
    if packed:
        pictured.image.pack()
    found = told(capfd, pictures)
    assert len(found) == 1 and "'huge.png'" in found[0] and "magenta" in found[0]


def test_images_that_fill_the_memory_together(monkeypatch):
    """Each by itself would fit."""
    monkeypatch.setattr(images.memory, "available", lambda: 1000)
    warnings: list[str] = []
    found = images.Images(Scene(None, 1, 1), warnings.append)
    image = types.SimpleNamespace(name="Wall")
    assert [found._fits(image, 10, 10, each) for each in (3, 1, 2)] == [True, True, False]
    assert warnings[0] == (
        "Image 'Wall' has 10 × 10 pixels, which take 0 MB, but only 0 MB of memory are free: it is shown in magenta; make it "
        "smaller."
    )


def test_generated_images_that_are_huge(pictured, pictures, capfd):
    """Blender would make their pixels when it is asked for them."""
    image = bpy.data.images.new("Wall", 4, 4)
    image.generated_width = image.generated_height = 65536
    if image.generated_width * image.generated_height * images.GENERATED_BYTES < 0.5 * images.memory.available():
        pytest.skip("there is memory for it")
    pictured.image = image
    found = told(capfd, pictures)
    assert len(found) == 1 and "'Wall'" in found[0] and "magenta" in found[0]


def test_every_tile_of_an_image_is_missing(pictured, pictures, capfd, tmp_path):
    """One sentence for each of a hundred is too many to read, but no more than there are tiles."""
    image = bpy.data.images.new("Wall", 4, 4, tiled=True)
    for number in range(1002, 1101):
        image.tiles.new(number)
    image.source, image.filepath_raw = "TILED", str(tmp_path / "wall.<UDIM>.png")
    pictured.image = image
    assert len(told(capfd, pictures)) <= 100


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes in the file system")
def test_pipes_are_no_light_distributions_and_no_volumes(file, stage, pictures, capfd, tmp_path, monkeypatch):
    path = tmp_path / "pipe.vdb"
    os.mkfifo(path)
    light = bpy.data.lights.new("Lines", "POINT")
    light.use_nodes = True
    node = light.node_tree.nodes.new("ShaderNodeTexIES")
    node.mode, node.filepath = "EXTERNAL", str(path)
    assert node_inputs.ies_text(node) == ""
    monkeypatch.setattr(node_inputs, "MOST_IES_BYTES", 1000)
    long = bpy.data.texts.new("Long")
    long.from_string("1 " * 501)
    node.mode, node.ies = "INTERNAL", long
    assert node_inputs.ies_text(node) == ""
    volume = bpy.data.volumes.new("Smoke")
    volume.filepath = str(tmp_path / "missing.vdb")
    file.scene.collection.objects.link(bpy.data.objects.new("Smoke", volume))
    told(capfd, pictures)


def test_libraries_that_are_gone(file, stage, pictures, capfd, tmp_path):
    """What was linked from them is left out; the rest is rendered. A library that is damaged Blender does not open."""
    library = tmp_path / "library.blend"
    light = bpy.data.lights.new("Linked", "POINT")
    light.sdf_lamp.use = True
    bpy.data.libraries.write(str(library), {bpy.data.objects.new("Linked", light)})
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.objects = ["Linked"]
    file.scene.collection.objects.link(wanted.objects[0])
    path = tmp_path / "file.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    library.unlink()
    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
    file.scene = bpy.context.scene
    told(capfd, pictures)


def test_lamp_nodes_in_groups_that_double_at_each_level(file, stage, pictures, capfd):
    """Nodes of shapes have groups of their own kind: these say a union of tens of thousands of balls."""

    def filled(tree: bpy.types.NodeTree, end: bpy.types.NodeSocket, inner: bpy.types.NodeTree | None) -> None:
        union = tree.nodes.new("SDFLIGHTS_Node_union")
        for socket in list(union.inputs)[:2]:
            part = tree.nodes.new(GROUP if inner else "SDFLIGHTS_Node_sphere")
            if inner:
                part.node_tree = inner
                part.match_interface()
            tree.links.new(part.outputs[0], socket)
        tree.links.new(union.outputs[0], end)

    inner = None
    for _ in range(15):
        tree = groups.empty_group("Double")
        filled(tree, next(node for node in tree.nodes if node.bl_idname == "NodeGroupOutput").inputs[0], inner)
        inner = tree
    tree = writing.new_tree("Whole")[0]
    filled(tree, output_of(tree).inputs[0], inner)
    lamp = bpy.data.objects["Lamp"].data.sdf_lamp
    lamp.source, lamp.nodes = "NODES", tree
    found = told(capfd, pictures)
    assert all("'Lamp'" in line for line in found)
