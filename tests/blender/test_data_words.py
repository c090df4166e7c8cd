# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Words and nodes of data in Blender: what names mean, that lamps stay live, and that nothing is lost with files and
undo."""

import math

import bpy
import numpy as np
import pytest

from sdf_lights.blender import parameters, sources
from sdf_lights.blender.lamp import pattern_of, shape_of
from sdf_lights.blender.nodes import editor
from sdf_lights.blender.objects import curves
from sdf_lights.render.errors import RenderError


def _box(name: str, half: float = 0.5):
    mesh = bpy.data.meshes.new(name)
    corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def _picture(name: str = "Logo", size: int = 32):
    image = bpy.data.images.new(name, size, size, alpha=True)
    pixels = np.zeros((size, size, 4), np.float32)
    pixels[size // 4 : -size // 4, size // 4 : -size // 4] = 1.0
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


@pytest.fixture
def says(lamp, add):
    """Function: a lamp, in the scene, with an expression."""

    def make(text: str):
        light = lamp()
        light.sdf_lamp.source, light.sdf_lamp.expression = "EXPRESSION", text
        add("Lamp", light)
        bpy.context.view_layer.update()
        return light

    return make


def _height(light) -> float:
    low, high = shape_of(light.sdf_lamp).bounds()
    return float(high[2] - low[2])


ALL = "text('OPEN', 0.5, thickness=0.2) | object('Cube') - image('Logo', part='bright') | mesh('Cube', 0.1)"


def test_words_mean_things_of_the_file(file, says):
    _box("Cube"), _picture()
    shape = shape_of(says(ALL).sdf_lamp)
    assert shape.validate() == "" and shape.certified
    for text, low, high in (
        ("image('Logo', width=2, thickness=0.5)", (-0.5, -0.5, -0.25), (0.5, 0.5, 0.25)),
        ("text('HI', thickness=0.4) & box(5)", (-0.55, -0.37, -0.2), (0.55, 0.37, 0.2)),
    ):
        np.testing.assert_allclose(shape_of(says(text).sdf_lamp).bounds(), [low, high], atol=0.15)
    neon = shape_of(says("text('O', neon_radius=0.03, gap=0.1)").sdf_lamp)
    assert type(neon).__name__ == "Tube" and neon.balls[:, 3].max() == pytest.approx(0.03)


def test_a_text_leaves_nothing_in_the_file(file, says):
    before = len(bpy.data.objects), len(bpy.data.curves)
    says("text('some letters')")
    assert (len(bpy.data.objects), len(bpy.data.curves)) == (before[0] + 1, before[1])
    curves._letters.clear()
    assert shape_of(bpy.data.objects["Lamp"].data.sdf_lamp).volume() > 0.0


def test_data_of_an_emission_make_it_vary(file, says):
    _box("Cube")
    light = says("sphere(1)")
    light.sdf_lamp.emission.source = "EXPRESSION"
    light.sdf_lamp.emission.expression = "select(object('Cube')(p) < 0, 1, 0.1)"
    placed = pattern_of(light.sdf_lamp).placed(shape_of(light.sdf_lamp))
    np.testing.assert_allclose(placed.evaluate(np.array([[0.0, 0, 0], [0.9, 0, 0]]))[:, 0], [1.0, 0.1])


@pytest.mark.parametrize(
    "text, sentence",
    [
        ("object('Cub')", "there is no curve, mesh, metaball, text or volume 'Cub': did you mean 'Cube'?"),
        ("mesh('Sun')", "there is no mesh 'Sun': make one, or write the name of another, such as 'Cube'"),
        ("object('Lamp')", "a lamp cannot be made of itself: write the name of a text, a curve or a mesh"),
        ("image('//logo.png')", "there is no image or file '//logo.png'"),
        ("text('')", "text '' has no letters that can be seen: write some"),
        ("text(' ')", "text ' ' has no letters that can be seen: write some"),
        ("object('Line')", "curve 'Line' has no inside: give it a bevel depth, or close it; or make a neon tube of it"),
        ("image('Empty')", "image 'Empty' has nothing above the threshold"),
    ],
)
def test_what_cannot_be_made_says_so_with_its_place(file, says, add, text, sentence):
    _box("Cube"), bpy.data.images.new("Empty", 4, 4, alpha=True).pixels.foreach_set(np.zeros(64, np.float32))
    line = bpy.data.curves.new("Line", "CURVE")
    line.splines.new("POLY").points.add(2)
    add("Line", line)
    with pytest.raises(RenderError) as caught:
        shape_of(says(text).sdf_lamp)
    assert "In its expression: Line 1, column 1: " + sentence in str(caught.value)


def _tagged() -> set[str]:
    """Names of lights that an update of the scene tells of, and the one after it."""
    found = []
    bpy.app.handlers.depsgraph_update_post.append(lambda scene, graph: found.extend(u.id.name for u in graph.updates))
    for _ in range(2):
        bpy.context.view_layer.update()
    bpy.app.handlers.depsgraph_update_post.pop()
    return {name for name in found if name in bpy.data.lights}


@pytest.mark.parametrize("kind", ["EXPRESSION", "NODES", "TEXT", "EMISSION"])
def test_a_lamp_follows_what_its_texts_name(file, says, kind):
    obj = _box("Cube")
    light = says("object('Cube')" if kind != "EMISSION" else "sphere(1)")
    if kind == "NODES":
        editor.to_nodes(light)
    elif kind == "TEXT":
        light.sdf_lamp.text = parameters.new_text("Words", "n = 'Cube'\nobject(n) | sphere(0.1)")
    elif kind == "EMISSION":
        light.sdf_lamp.emission.source = "EXPRESSION"
        light.sdf_lamp.emission.expression = "exp(object('Cube')(p))"
    bpy.context.view_layer.update()
    assert _tagged() == set()
    obj.location.x = 3.0  # its shape stays where the lamp is
    assert _tagged() == set()
    before = _height(light)
    obj.modifiers.new("Array", "ARRAY").relative_offset_displace = (0.0, 0.0, 1.0)
    assert _tagged() == {light.name}
    if kind != "EMISSION":
        assert _height(light) == pytest.approx(before + 1.0, abs=0.3)  # coarser voxels, and room around them


def test_an_object_that_depends_on_its_lamp_comes_to_rest(file, says):
    obj = _box("Cube")
    light = says("object('Cube')")
    modifier = obj.modifiers.new("Displace", "DISPLACE")
    curve = modifier.driver_add("strength").driver
    curve.type, variable = "SUM", curve.variables.new()
    variable.targets[0].id_type, variable.targets[0].id = "LIGHT", light
    variable.targets[0].data_path = "energy"
    light.energy = 0.25
    for _ in range(4):
        bpy.context.view_layer.update()
    assert _tagged() == set()


def test_a_renamed_object_stays_and_the_lamp_says_so(file, says):
    obj = _box("Cube")
    light = says("object('Cube')")
    before = _height(light)
    obj.name = "Crate"
    assert _height(light) == before
    assert sources.remarks(light.sdf_lamp) == ["'Cube' is called 'Crate' now: write the new name in the expression."]
    light.sdf_lamp.expression = "object('Crate')"
    assert sources.remarks(light.sdf_lamp) == [] and _height(light) == before
    bpy.data.objects.remove(obj)
    with pytest.raises(RenderError, match="there is no .* 'Crate'"):
        shape_of(light.sdf_lamp)


def test_a_viewport_keeps_the_last_good_shape_when_an_object_is_gone(file, says):
    from sdf_lights.blender.lamp import keep, last_good

    obj = _box("Cube")
    light = says("object('Cube')")
    keep(light, shape_of(light.sdf_lamp), None)
    bpy.data.objects.remove(obj)
    with pytest.raises(RenderError):
        shape_of(light.sdf_lamp)
    assert last_good(light)[0].validate() == ""


def test_things_that_are_named_have_a_user_and_lose_it(file, says):
    image, users = _picture(), _box("Cube").users
    light = says("object('Cube') | image('Logo')")
    assert bpy.data.objects["Cube"].users == users + 1 and image.users == 1
    light.sdf_lamp.expression = "sphere(1)"
    assert bpy.data.objects["Cube"].users == users and image.users == 0


def _file(folder, says, kind: str, picture: str = "Logo"):
    """A file with a lamp of all words; its bounds."""
    _box("Cube"), _picture().pack()
    light = says(ALL.replace("'Logo'", repr(picture)))
    if kind == "NODES":
        editor.to_nodes(light)
    path = folder / "lamps.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path, shape_of(light.sdf_lamp).bounds()


@pytest.mark.parametrize("kind", ["EXPRESSION", "NODES"])
def test_files_keep_all_that_lamps_name(file, says, tmp_path, kind):
    path, bounds = _file(tmp_path, says, kind)
    curves._letters.clear()
    bpy.ops.wm.open_mainfile(filepath=str(path))
    light = bpy.data.objects["Lamp"].data
    np.testing.assert_allclose(shape_of(light.sdf_lamp).bounds(), bounds)
    np.testing.assert_allclose(shape_of(light.copy().sdf_lamp).bounds(), bounds)


@pytest.mark.parametrize("kind", ["EXPRESSION", "NODES"])
@pytest.mark.parametrize("link", [False, True])
def test_what_a_lamp_names_comes_along_into_another_file(file, says, tmp_path, kind, link):
    """Also where that file has other things of the same name."""
    path, bounds = _file(tmp_path, says, kind)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    _box("Cube", 2.0), _picture("Logo", 8)
    with bpy.data.libraries.load(str(path), link=link) as (_, wanted):
        wanted.objects = ["Lamp"]
    light = wanted.objects[0].data
    np.testing.assert_allclose(shape_of(light.sdf_lamp).bounds(), bounds, atol=1e-6)


def test_a_picture_from_a_path_beside_the_file_is_loaded_and_found_again(file, says, tmp_path):
    image = _picture("Away")
    (tmp_path / "pictures").mkdir()
    image.filepath_raw, image.file_format = str(tmp_path / "pictures" / "sign.png"), "PNG"
    image.save()
    bpy.data.images.remove(image)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "lamps.blend"))
    light = says("image('//pictures/sign.png', width=2)")
    np.testing.assert_allclose(shape_of(light.sdf_lamp).bounds()[1], [0.5, 0.5, 0.05], atol=1e-3)
    assert [image.filepath for image in bpy.data.images if image.source == "FILE"] == ["//pictures/sign.png"]
    assert sources.remarks(light.sdf_lamp) == []
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "lamps.blend"))
    light = bpy.data.objects["Lamp"].data
    assert shape_of(light.sdf_lamp).volume() == pytest.approx(0.1, rel=1e-2)
    bpy.data.images["sign.png"].pack()
    (tmp_path / "pictures" / "sign.png").unlink()
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "lamps.blend"))
    assert shape_of(bpy.data.objects["Lamp"].data.sdf_lamp).volume() == pytest.approx(0.1, rel=1e-2)


def test_undo_brings_names_back(file, says):
    bpy.context.preferences.edit.use_global_undo = True
    _box("Cube"), _box("Crate", 1.0)
    light = says("object('Cube')")
    small = _height(light)
    bpy.ops.ed.undo_push(message="one")
    light.sdf_lamp.expression = "object('Crate')"
    bpy.ops.ed.undo_push(message="two")
    bpy.ops.ed.undo()
    light = bpy.data.objects["Lamp"].data
    assert [item.name for item in light.sdf_lamp.data] == ["Cube"] and _height(light) == small


def test_nodes_say_the_same_as_the_words(file, says):
    _box("Cube"), _picture()
    light = says(ALL)
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (400, 3))
    before = shape_of(light.sdf_lamp).distance(points)
    tree = editor.to_nodes(light)
    kinds = {node.bl_label: node for node in tree.nodes}
    assert kinds["Text"].body == "OPEN" and kinds["Object"].object.name == "Cube"
    assert kinds["Image"].image.name == "Logo" and kinds["Image"].part == "BRIGHT"
    assert kinds["Mesh"].object.name == "Cube" and kinds["Mesh"].value_voxel_size == pytest.approx(0.1)
    np.testing.assert_allclose(shape_of(light.sdf_lamp).distance(points), before, atol=1e-6)
    text = editor.expression_of(light)
    assert "text('OPEN'" in text and "image('Logo'" in text
    light.sdf_lamp.source, light.sdf_lamp.text = "EXPRESSION", parameters.new_text("Back", text)
    np.testing.assert_allclose(shape_of(light.sdf_lamp).distance(points), before, atol=1e-6)


def test_nodes_without_data_say_what_to_do(file, says):
    light = says("text('A')")
    tree = editor.to_nodes(light)
    node = next(node for node in tree.nodes if node.bl_label == "Text")
    node.body = ""
    with pytest.raises(RenderError, match="Nothing is written: write something"):
        shape_of(light.sdf_lamp)
    node.body = "quotes \" ' and \\ and\nlines"
    assert shape_of(light.sdf_lamp).volume() > 0.0
    light.sdf_lamp.expression, light.sdf_lamp.source = editor.expression_of(light).split("\n")[-2], "EXPRESSION"


@pytest.mark.parametrize("source", ["OBJECT", "IMAGE"])
def test_lamps_of_one_object_or_picture_can_be_written_as_words(file, lamp, source):
    light = lamp()
    light.sdf_lamp.source, light.sdf_lamp.object, light.sdf_lamp.image = source, _box("Cube"), _picture()
    light.sdf_lamp.image_part = "BRIGHT"
    bounds = shape_of(light.sdf_lamp).bounds()
    editor.to_nodes(light)
    np.testing.assert_allclose(shape_of(light.sdf_lamp).bounds(), bounds, atol=1e-6)


def test_a_render_has_what_the_words_say(synced, says):
    obj = _box("Cube")
    obj.modifiers.new("Array", "ARRAY").relative_offset_displace = (0.0, 0.0, 1.0)
    obj.hide_render = True
    says("object('Cube', voxel_size=0.05) | text('glow')")
    (found,) = synced().lamps
    inside = found.shape.distance(np.array([[0.3, 0.3, 1.3], [0.3, 0.3, 1.7]])) < 0.0
    assert inside.tolist() == [True, False]  # with the modifier, though the object is hidden in renders
    assert math.isfinite(found.shape.volume() or 0.0)


# -- colours -----------------------------------------------------------------------------------------------------------


def _halves(name: str = "Halves"):
    """An opaque picture, red to the left and blue to the right, with codes of sRGB."""
    image = bpy.data.images.new(name, 16, 8, alpha=True)
    pixels = np.ones((8, 16, 4), np.float32)
    pixels[:, :8, :3], pixels[:, 8:, :3] = (1.0, 0.5, 0.0), (0.0, 0.5, 1.0)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def test_a_picture_glows_in_its_own_colours(file, lamp):
    light = lamp()
    settings = light.sdf_lamp
    settings.source, settings.image, settings.image_size = "IMAGE", _halves(), 2.0
    assert pattern_of(settings) is None
    settings.image_colors = True
    found = pattern_of(settings).placed(shape_of(settings)).evaluate(np.array([[-0.9, 0.4, 0.0], [0.9, -0.4, 0.0]]))
    half = 0.2140411  # of the code 0.5, by IEC 61966-2-1
    np.testing.assert_allclose(found, [(1.0, half, 0.0), (0.0, half, 1.0)], atol=2e-3)
    settings.emission.source = "EXPRESSION"
    settings.emission.expression = "3"
    again = pattern_of(settings).placed(shape_of(settings)).evaluate(np.array([[-0.9, 0.4, 0.0]]))
    np.testing.assert_allclose(again, 3.0 * found[:1], atol=1e-5)
    settings.image.pixels.foreach_set(np.ones(16 * 8 * 4, np.float32))
    settings.image.update()
    settings.image.update_tag()
    bpy.context.view_layer.update()
    from sdf_lights.blender import picture_lamps

    picture_lamps.forget({settings.image.session_uid})
    white = pattern_of(settings).placed(shape_of(settings)).evaluate(np.array([[-0.9, 0.4, 0.0]]))
    np.testing.assert_allclose(white, 3.0, atol=1e-5)


def test_colours_along_a_curve_follow_a_slider_with_a_driver(file, says, add):
    line = bpy.data.curves.new("Line", "CURVE")
    line.dimensions, line.bevel_depth = "3D", 0.1
    spline = line.splines.new("POLY")
    spline.points.add(1)
    spline.points[0].co, spline.points[1].co = (0.0, 0.0, 0.0, 1.0), (4.0, 0.0, 0.0, 1.0)
    add("Line", line)
    light = says("object('Line')")
    light.sdf_lamp.emission.source = "EXPRESSION"
    light.sdf_lamp.emission.text = parameters.new_text(
        "Glow", "place = slider(0.5, 0, 1)\nramp(along, 0, (1, 0, 0), place, (0, 1, 0), 1, (0, 0, 1))"
    )
    parameters.update(light)
    at = np.array([[2.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    np.testing.assert_allclose(
        pattern_of(light.sdf_lamp).placed(shape_of(light.sdf_lamp)).evaluate(at), [(0, 1, 0), (0.5, 0.5, 0)], atol=1e-6
    )
    light.driver_add('["sdf_emission.place"]').driver.expression = "0.25"
    bpy.context.view_layer.update()
    np.testing.assert_allclose(
        pattern_of(light.sdf_lamp).placed(shape_of(light.sdf_lamp)).evaluate(at[1:]), [(0, 1, 0)], atol=1e-6
    )


def test_nodes_have_the_colours_of_a_picture_and_places_in_the_lamp(file, says):
    image = _halves()
    light = says("box(1, 0.5, 0.1)")
    light.sdf_lamp.emission.source = "EXPRESSION"
    light.sdf_lamp.emission.expression = "image_color('Halves', u, v) * (1 - along)"
    at = np.array([[-0.7, 0.1, 0.0], [0.7, 0.1, 0.0]])
    before = pattern_of(light.sdf_lamp).placed(shape_of(light.sdf_lamp)).evaluate(at)
    assert before[0, 0] > 0.9 and before[1, 2] > 0.9
    tree = editor.to_nodes(light)
    (node,) = (node for node in tree.nodes if node.bl_label == "Image Color")
    assert node.image == image
    np.testing.assert_allclose(
        pattern_of(light.sdf_lamp).placed(shape_of(light.sdf_lamp)).evaluate(at), before, atol=1e-6
    )
    for link in [link for socket in node.inputs for link in socket.links]:
        tree.links.remove(link)  # then it is across the box
    np.testing.assert_allclose(
        pattern_of(light.sdf_lamp).placed(shape_of(light.sdf_lamp)).evaluate(at), before, atol=1e-6
    )
    assert "image_color('Halves', u, v)" in editor.emission_text_of(light)
    node.image = None
    with pytest.raises(RenderError, match="No image is chosen"):
        pattern_of(light.sdf_lamp)


def test_a_render_has_the_colours_of_a_picture(pictures, says):
    _halves()
    light = says("rotate_x(box(2, 1, 0.2), 90)")
    light.energy = 3000.0
    light.sdf_lamp.emission.source = "EXPRESSION"
    light.sdf_lamp.emission.expression = "image_color('Halves', u, height)"
    bpy.data.objects["Lamp"].location.z = 1.0
    picture = pictures()["ViewLayer"]["Combined"]
    left, right = picture[6:10, 6:10, :3].mean(axis=(0, 1)), picture[6:10, 14:18, :3].mean(axis=(0, 1))
    assert left[0] > 5.0 * left[2] and right[2] > 5.0 * right[0]
