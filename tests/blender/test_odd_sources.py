# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Odd texts, meshes, pictures and files at F12: each is a lamp, or is named in one sentence, and the others are
rendered."""

import bpy
import numpy as np
import pytest

from sdf_lights.sdf.data.network import EXAMPLE
from support import grids

GLYPHS = (*range(33, 127), *range(161, 384), *range(0x391, 0x3CA), *range(0x410, 0x450))
"""Of Blender's own font."""


@pytest.fixture
def lamp_from(file, lamp, add):
    """Function: adds a lamp of a source, with settings."""

    def make(name: str, data: bpy.types.ID | None = None, **settings) -> None:
        light = lamp(name)
        if data is not None:
            settings = dict(source="OBJECT", object=add(f"{name} Source", data)) | settings
        for key, value in settings.items():
            setattr(light.sdf_lamp, key, value)
        add(name, light)

    return make


def _text(body: str) -> bpy.types.Curve:
    curve = bpy.data.curves.new("Text", "FONT")
    curve.body = body
    return curve


def _mesh(vertices, faces) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new("Mesh")
    mesh.from_pydata(np.asarray(vertices).tolist(), [], np.asarray(faces).tolist())
    return mesh


def _suzanne() -> bpy.types.Mesh:
    bpy.ops.mesh.primitive_monkey_add()
    mesh = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    return mesh


def _wide() -> bpy.types.Image:
    pixels = np.zeros((20, 20_000, 4), np.float32)
    pixels[5:15, 100:-100] = 1.0
    image = bpy.data.images.new("Wide", 20_000, 20, alpha=True)
    image.pixels.foreach_set(pixels.ravel())
    return image


CUBE = [(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
RING = [(np.cos(a), np.sin(a), 0.0) for a in np.arange(8) * np.pi / 4.0]


def _curve(points, kind="POLY", closed=False, radii=None, weights=None, **settings) -> bpy.types.Curve:
    curve = bpy.data.curves.new("Curve", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.1
    spline = curve.splines.new(kind)
    made = spline.bezier_points if kind == "BEZIER" else spline.points
    made.add(len(points) - 1)
    for index, (point, co) in enumerate(zip(made, points)):
        weight = 1.0 if weights is None else weights[index]
        point.co = co if kind == "BEZIER" else (*co, weight)
        point.radius = 1.0 if radii is None else radii[index]
    spline.use_cyclic_u = closed
    for name, value in settings.items():
        setattr(curve, name, value)
    return curve


def _picture(values: np.ndarray, is_float=False, alpha=True) -> bpy.types.Image:
    """Of values (height, width) in all channels."""
    height, width = values.shape
    image = bpy.data.images.new("Picture", width, height, alpha=alpha, float_buffer=is_float)
    image.pixels.foreach_set(np.repeat(values.astype(np.float32).ravel(), 4))
    image.update()
    return image


def _from_file(values: np.ndarray, path, mode: str, depth: str) -> bpy.types.Image:
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", mode, depth
    _picture(values).save_render(str(path))
    return bpy.data.images.load(str(path))


def _tapered(heights) -> bpy.types.Curve:
    curve = _curve(RING)
    taper = _curve([(float(i), height, 0.0) for i, height in enumerate(heights)])
    curve.taper_object = bpy.data.objects.new("Taper", taper)
    bpy.context.scene.collection.objects.link(curve.taper_object)
    return curve


def _said_once(scene, name: str) -> str:
    told = [sentence for sentence in scene.warnings if sentence.startswith(f"Lamp '{name}'")]
    assert len(told) == 1 and "left out" in told[0], (name, scene.warnings)
    assert told[0].endswith(".") and ":" in told[0] and "\n" not in told[0] and len(told[0]) < 300
    return told[0]


def test_odd_curves_and_texts_are_lamps_or_are_named_in_one_sentence(synced, lamp_from):
    flat = dict(dimensions="2D", fill_mode="BOTH", bevel_depth=0.0, extrude=0.1)
    lamps = {
        "Repeated Points": _curve([(0, 0, 0), (0, 0, 0), (1, 0, 0), (1, 0, 0)]),
        "Same Points": _curve([(0, 0, 0)] * 4, closed=True),
        "Bezier Point": _curve([(0, 0, 0)], "BEZIER", closed=True),
        "Closed NURBS": _curve(RING, "NURBS", closed=True),
        "Short NURBS": _curve(RING[:2], "NURBS"),
        "Pointed": _curve(RING, radii=[1, 1, 1, 1, 1, 0.5, 0.2, 0]),
        "Cone": _curve([(0, 0, 0), (0.01, 0, 0)], radii=[0, 20]),
        "Tapered": _tapered([1.0, 0.0]),
        "Eight": _curve([(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)], closed=True, **flat),
        "Emoji": _text("😀🎉"),
        "Private": _text("\ue000\ufffe"),
        "Scripts": _text("漢字 مرحبا e\u0301"),
    }
    refused = {
        "Zero Weights": _curve(RING, "NURBS", closed=True, weights=[0] * 8),
        "Zero Radii": _curve(RING, radii=[0] * 8),
        "Undefined Radius": _curve(RING, radii=[np.nan, *[1] * 7]),
        "Tapered Away": _tapered([0.0, 0.0]),
        "Shrunk Away": _curve(RING, closed=True, offset=-3.0, **flat),
        "No Letters": _text("\n\t\u200b"),
        "No Splines": bpy.data.curves.new("Nothing", "CURVE"),
    }
    for name, data in (lamps | refused).items():
        lamp_from(name, data)
    scene = synced()
    assert {lamp.name for lamp in scene.lamps if lamp.name not in refused} == set(lamps)
    assert all(lamp.shape.certified for lamp in scene.lamps)
    for name in refused.keys() - {"Shrunk Away"}:  # what has no volume is told when it is built
        _said_once(scene, name)


def test_a_lamp_that_its_offset_leaves_nothing_of_is_named_at_f12(file, lamp_from, capfd, pictures):
    lamp_from("Shrunk Away", _curve(RING, closed=True, offset=-3.0, dimensions="2D", fill_mode="BOTH", bevel_depth=0.0))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    file.scene.collection.objects.link(camera)
    file.scene.camera = camera
    assert pictures()["ViewLayer"]["Combined"][..., :3].max() == 0.0
    assert "Shrunk Away" in "".join(capfd.readouterr())


def test_odd_pictures_are_lamps_or_are_named_in_one_sentence(synced, lamp_from, tmp_path):
    disk = np.hypot(*(np.mgrid[:32, :32] - 15.5)) < 10.0
    lamp_from("No Alpha", source="IMAGE", image=_picture(disk, alpha=False))
    lamp_from("One Pixel", source="IMAGE", image=_picture(np.ones((1, 1))))
    lamp_from("Infinite", source="IMAGE", image=_picture(np.where(disk, np.inf, 0.0), True), image_part="BRIGHT")
    for mode in ("BW", "RGBA"):
        image = _from_file(disk, tmp_path / f"{mode}.png", mode, "16")
        lamp_from(f"16 Bits {mode}", source="IMAGE", image=image, image_part="BRIGHT")
    lamp_from("Clear Pixel", source="IMAGE", image=_picture(np.zeros((1, 1))))
    lamp_from("Undefined", source="IMAGE", image=_picture(np.full((8, 8), np.nan), True))
    (tmp_path / "cut.png").write_bytes((tmp_path / "BW.png").read_bytes()[:60])
    lamp_from("Cut", source="IMAGE", image=bpy.data.images.load(str(tmp_path / "cut.png")))
    scene = synced()
    found = {lamp.name: lamp.shape for lamp in scene.lamps}
    assert found.keys() == {"No Alpha", "One Pixel", "Infinite", "16 Bits BW", "16 Bits RGBA"}
    for name in ("16 Bits BW", "16 Bits RGBA"):
        assert found[name].volume() == pytest.approx(np.pi * (10.0 / 32.0) ** 2 * found[name].height, rel=0.1)
    for name in ("Clear Pixel", "Undefined", "Cut"):
        _said_once(scene, name)


def test_odd_meshes_are_lamps_or_are_named_in_one_sentence(synced, lamp_from, tmp_path):
    lamp_from("Loose Point", _mesh([*CUBE, (np.nan, 0, 0)], CUBE_FACES), voxel_size=0.1)
    lamp_from("Far", _mesh(np.array(CUBE) + (1e5, 0, 0), CUBE_FACES), voxel_size=0.1)
    lamp_from("Small", _mesh(1e-6 * np.array(CUBE), CUBE_FACES))
    lamp_from("Mirrored", _mesh(CUBE, CUBE_FACES), voxel_size=0.1)
    bpy.data.objects["Mirrored Source"].scale = -1.0, 1.0, 1.0
    lamp_from("Modified", _mesh(CUBE, CUBE_FACES), voxel_size=0.05)
    thing = bpy.data.objects["Modified Source"]
    thing.modifiers.new("Smooth", "SUBSURF")
    thing.modifiers.new("Nothing", "BOOLEAN")
    library = bpy.data.objects.new("Shared", _mesh(CUBE, CUBE_FACES))
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {library})
    bpy.data.objects.remove(library)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.objects = ["Shared"]
    lamp_from("Linked", source="OBJECT", object=wanted.objects[0], voxel_size=0.1)
    lamp_from("Infinite", _mesh([*CUBE[:-1], (np.inf, 1, 1)], CUBE_FACES))
    lamp_from("Huge", _mesh(1e30 * np.array(CUBE), CUBE_FACES))
    lamp_from("Line", _mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)], [(0, 1, 2, 3)]))
    lamp_from("Fine", _mesh(CUBE, CUBE_FACES), voxel_size=1e-6)
    lamp_from("Instances", _mesh(CUBE, CUBE_FACES))
    nodes = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    nodes.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    cube, instances, output = (
        nodes.nodes.new(kind) for kind in ("GeometryNodeMeshCube", "GeometryNodeInstanceOnPoints", "NodeGroupOutput")
    )
    for socket in ("Points", "Instance"):
        nodes.links.new(cube.outputs["Mesh"], instances.inputs[socket])
    nodes.links.new(instances.outputs[0], output.inputs[0])
    bpy.data.objects["Instances Source"].modifiers.new("Nodes", "NODES").node_group = nodes
    scene = synced()
    shapes = {lamp.name: lamp.shape for lamp in scene.lamps}
    assert shapes.keys() == {"Loose Point", "Far", "Small", "Mirrored", "Modified", "Linked"}
    assert all(shape.certified for shape in shapes.values())
    middle = np.array([[0.5, 0.5, 0.5]])
    for name in ("Loose Point", "Mirrored", "Modified", "Linked"):
        assert shapes[name].distance(middle)[0] < 0.0, name
    for name in ("Infinite", "Huge", "Line", "Fine"):
        _said_once(scene, name)
    assert "Realize Instances" in _said_once(scene, "Instances")


@pytest.mark.parametrize("triangles", [3_000, pytest.param(300_000, marks=pytest.mark.slow)])
def test_odd_sources_are_lamps_or_are_named_in_one_sentence(synced, lamp_from, tmp_path, triangles):
    ring, faces = grids.torus(0.7, 0.25, 48, 24)
    lamp_from("Glyphs", _text("\n".join(map("".join, np.array_split([chr(code) for code in GLYPHS], 20)))))
    lamp_from("Paragraph", _text("\n".join(["the quick brown fox."] * 10)))
    lamp_from("Suzanne", _suzanne(), voxel_size=0.05)
    lamp_from("Scan", _mesh(*grids.scan(triangles)), voxel_size=0.0 if triangles > 10_000 else 0.05)
    lamp_from("Open", _mesh(ring, faces[200:]), voxel_size=0.05)
    lamp_from("Bare", _mesh(ring, np.zeros((0, 3), int)))
    lamp_from("Sheet", _mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 1, 2)]))
    lamp_from("Undefined", _mesh([(0, 0, 0), (1, 0, 0), (0, np.nan, 0)], [(0, 1, 2)]))
    lamp_from("Picture", source="IMAGE", image=_wide(), image_size=2.0)
    whole = EXAMPLE.read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    lamp_from("Network", source="NETWORK", network=str(tmp_path / "cut.npz"))
    (tmp_path / "cut.vdb").write_bytes(b" BDV" + bytes(4) + (224).to_bytes(4, "little") + bytes(20))
    volume = bpy.data.volumes.new("Volume")
    volume.filepath = str(tmp_path / "cut.vdb")
    lamp_from("Volume", volume)
    scene = synced()
    expected = {"Glyphs", "Paragraph", "Suzanne", "Scan", "Open", "Picture"}
    assert {lamp.name for lamp in scene.lamps} == expected
    for name in ("Bare", "Sheet", "Undefined", "Network", "Volume"):
        told = [sentence for sentence in scene.warnings if sentence.startswith(f"Lamp '{name}' is left out. ")]
        assert len(told) == 1, (name, scene.warnings)
        assert told[0].endswith(".") and ":" in told[0] and "\n" not in told[0] and len(told[0]) < 300
    assert not [sentence for sentence in scene.warnings if any(f"Lamp '{name}'" in sentence for name in expected)]
