# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Adding lamps, presets, and converting lamps to meshes."""

import json
import math

import bpy
import numpy as np
import pytest

from sdf_lights.blender import operators, parameters
from sdf_lights.blender.lamp import pattern_of, shape_of
from sdf_lights.blender.presets import presets
from sdf_lights.blender.sources import FileResolver
from sdf_lights.sdf import emission_presets
from sdf_lights.sdf.expression import evaluate
from sdf_lights.sdf.functions import CONSTANTS, FUNCTIONS


def added():
    return bpy.context.object


@pytest.mark.parametrize("name", presets())
def test_presets(file, name):
    preset = presets()[name]
    assert bpy.ops.sdf_lights.lamp_add(source="PRESET", preset=name.upper()) == {"FINISHED"}
    light = added().data
    assert added().name.startswith(preset.title) and light.energy == preset.power
    points = np.random.default_rng(3).uniform(-0.7, 0.7, (200, 3))
    # Angles are radians in Blender, so their last digit may differ.
    wanted = evaluate(preset.expression, resolver=FileResolver(light.sdf_lamp))
    assert shape_of(light.sdf_lamp).distance(points) == pytest.approx(wanted.distance(points), abs=1e-12)
    assert light.use_temperature == (preset.temperature > 0.0)
    shape, found = shape_of(light.sdf_lamp), pattern_of(light.sdf_lamp)
    points = np.random.default_rng(4).uniform(-0.1, 0.1, (20, 3))
    assert (found is None) == (preset.emission == "uniform")
    assert found is None or found.placed(shape).evaluate(points).max() > 0.0
    for parameter, value in preset.emission_values.items():
        held = light[f"sdf_emission.{parameter}"]
        assert (list(held) if isinstance(value, list) else held) == value
    assert light.sdf_lamp.camera_brightness == pytest.approx(preset.camera_brightness)
    assert parameters.declarations(light.sdf_lamp)  # sliders for the shape
    assert not parameters.unused(light) and not parameters.missing(light.sdf_lamp)
    names = {declaration.name for declaration in parameters.declarations(light.sdf_lamp)}
    assert not names & (FUNCTIONS.keys() | CONSTANTS.keys())  # or nodes could not have them
    assert preset.picture.is_file() and preset.picture.stat().st_size < 30_000
    low, high = shape_of(light.sdf_lamp).bounds()
    assert 0.1 < max(high - low) < 1.5


WITH_SOURCES = [name for name, preset in presets().items() if preset.sources]


@pytest.mark.parametrize("name", WITH_SOURCES)
def test_presets_bring_their_own_sources_and_can_be_added_again(file, name, tmp_path):
    """Their sources are children of the lamp, to be edited, and come along with files, copies and undo."""
    lamps = []
    for _ in range(2):
        bpy.ops.sdf_lights.lamp_add(source="PRESET", preset=name.upper(), location=(1.0, 0.0, 0.0))
        lamps.append(added())
    first, second = (parameters.things_of(lamp.data) for lamp in lamps)
    assert len(first) == len(second) == len(presets()[name].sources) and not first & second
    for lamp, things in zip(lamps, (first, second)):
        for thing in things:
            if isinstance(thing, bpy.types.Object):
                assert thing.parent == lamp and thing.hide_render and thing.display_type == "WIRE"
                assert thing.users_collection == lamp.users_collection
    points = np.random.default_rng(5).uniform(-0.7, 0.7, (200, 3))
    before = [shape_of(lamp.data.sdf_lamp).distance(points) for lamp in lamps]
    np.testing.assert_array_equal(before[0], before[1])
    bpy.ops.sdf_lights.preset_load(preset="PEARL")
    assert parameters.things_of(lamps[1].data) == set()
    bpy.ops.sdf_lights.preset_load(preset=name.upper())
    np.testing.assert_array_equal(shape_of(lamps[1].data.sdf_lamp).distance(points), before[1])
    copy = lamps[0].data.copy()
    np.testing.assert_array_equal(shape_of(copy.sdf_lamp).distance(points), before[0])
    title = lamps[0].name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "lamps.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "lamps.blend")) as (_, wanted):
        wanted.objects = [title]
    light = wanted.objects[0].data
    np.testing.assert_array_equal(shape_of(light.sdf_lamp).distance(points), before[0])
    assert pattern_of(light.sdf_lamp) is None or pattern_of(light.sdf_lamp).placed(shape_of(light.sdf_lamp))


def test_a_preset_of_sources_is_undone_by_one_step(file):
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    count = len(bpy.data.objects), len(bpy.data.curves)
    bpy.ops.sdf_lights.lamp_add(source="PRESET", preset="NEON_ARROW")
    bpy.ops.ed.undo_push(message="added")
    assert len(bpy.data.objects) == count[0] + 2
    bpy.ops.ed.undo()
    assert (len(bpy.data.objects), len(bpy.data.curves)) == count
    bpy.ops.ed.redo()
    light = next(obj for obj in bpy.data.objects if obj.type == "LIGHT").data
    assert shape_of(light.sdf_lamp).validate() == ""


def test_there_are_at_least_twenty_presets_and_every_emission_is_in_one():
    assert len(presets()) >= 20
    assert {preset.emission for preset in presets().values()} >= set(emission_presets.presets())


def test_a_preset_on_a_lamp_of_another_emission(file, add, lamp):
    data = lamp()
    bpy.context.view_layer.objects.active = add("Lamp", data)
    bpy.ops.sdf_lights.preset_load(preset="NEBULA")
    assert data.sdf_lamp.emission.source == "EXPRESSION" and pattern_of(data.sdf_lamp) is not None
    bpy.ops.sdf_lights.preset_load(preset="PEARL")
    assert data.sdf_lamp.emission.source == "UNIFORM" and pattern_of(data.sdf_lamp) is None


def test_texts_of_presets_go_with_their_last_lamp(file, add, lamp):
    data = lamp()
    bpy.context.view_layer.objects.active = add("Lamp", data)
    bpy.ops.sdf_lights.preset_load(preset="NEBULA")
    bpy.ops.sdf_lights.preset_load(preset="RING_LIGHT")
    assert {text.name: text.users for text in bpy.data.texts if text.users} == {"Ring Light": 1}
    assert sorted(key for key in data.keys() if key.startswith("sdf_") and key != "sdf_lamp") == [
        "sdf_radius",
        "sdf_thickness",
    ]


@pytest.mark.parametrize("source", ["PRESET", "PRIMITIVE", "NODES"])
def test_lamps_saved_as_presets_come_back(file, add, lamp, source, tmp_path, monkeypatch):
    """By Blender's own operators, from a file in the user's folder."""
    monkeypatch.setattr(bpy.utils, "user_resource", lambda kind, path="", create=False: str(tmp_path))
    data = lamp(shape="TORUS", major_radius=0.7, minor_radius=0.1, power=33.0)
    bpy.context.view_layer.objects.active = add("Lamp", data)
    if source == "PRESET":
        bpy.ops.sdf_lights.preset_load(preset="CAMPFIRE")
        data["sdf_unrest"], data["sdf_emission.wisps"] = 0.03, 0.4
    elif source == "NODES":
        bpy.ops.sdf_lights.preset_load(preset="STAR")
        data["sdf_points"] = 7
        bpy.ops.sdf_lights.nodes_new()
    data.color, data.sdf_lamp.camera_brightness = (1.0, 0.5, 0.25), 0.125
    data.energy, data.exposure = 10.0, 1.0
    shape, pattern = shape_of(data.sdf_lamp), pattern_of(data.sdf_lamp)
    assert bpy.ops.sdf_lights.lamp_preset_add(name="Mine") == {"FINISHED"}
    (saved,) = tmp_path.iterdir()
    other = lamp(shape="SPHERE")
    bpy.context.view_layer.objects.active = add("Other", other)
    assert bpy.ops.script.execute_preset(filepath=str(saved), menu_idname="SDFLIGHTS_PT_lamp_presets") == {"FINISHED"}
    points = np.random.default_rng(5).uniform(-1.0, 1.0, (500, 3))
    assert shape_of(other.sdf_lamp).distance(points) == pytest.approx(shape.distance(points), abs=1e-6)
    assert (pattern_of(other.sdf_lamp) is None) == (pattern is None)
    if pattern is not None:
        assert pattern_of(other.sdf_lamp) == pattern
    assert tuple(other.color) == (1.0, 0.5, 0.25) and other.sdf_lamp.camera_brightness == 0.125
    assert other.energy == pytest.approx(20.0) and other.exposure == 0.0
    assert (other.sdf_lamp.source == "PRIMITIVE") == (source == "PRIMITIVE")


@pytest.mark.parametrize(
    "change",
    [
        "",
        "no JSON",
        "[1]",
        "[" * 100_000,
        '{"name": "", "title": ""}',
        '{"shape": "blob", "power": "x"}',
        {"shape": "sphere", "values": {"no such": 1.0}},
        {"shape": "sphere", "values": {"radius": "wide"}},
        {"values": 3},
        {"values": {"major_radius": [1.0, 2.0]}},
        {"emission": 5},
        {"power": [1.0]},
        {"density": "dense"},
        {"camera_brightness": 1e400},
    ],
)
def test_a_preset_that_cannot_be_read_leaves_the_lamp(file, lamp, change, capfd):
    data = lamp(shape="TORUS")
    before = data.sdf_lamp.as_text
    text = change if isinstance(change, str) else json.dumps(json.loads(before) | change)
    data.sdf_lamp.as_text = text
    assert data.sdf_lamp.as_text == before
    assert "The preset" in capfd.readouterr().out


@pytest.mark.parametrize("sweep", ["extrusion", "revolution", "partial_revolution"])
@pytest.mark.parametrize("name", [item[0] for item in operators.profile_items()])
def test_profiles(file, name, sweep):
    assert bpy.ops.sdf_lights.lamp_add(source="PROFILE", profile=name, sweep=sweep.upper()) == {"FINISHED"}
    light = added().data
    shape = shape_of(light.sdf_lamp)
    assert type(shape).name() == sweep and type(shape.profile).name() == name.lower()
    about = type(shape.profile).fields()[0]
    assert light.id_properties_ui(f"sdf_{about.name}").as_dict()["description"] == about.description


def test_lamps_from_nodes(file):
    file.scene.cursor.location = (1.0, 2.0, 3.0)
    assert bpy.ops.sdf_lights.lamp_add(source="NODES") == {"FINISHED"}
    tree = added().data.sdf_lamp.nodes
    assert tuple(added().location) == (1.0, 2.0, 3.0) and shape_of(added().data.sdf_lamp) == evaluate("sphere(0.5)")
    assert bpy.ops.sdf_lights.lamp_add(source="NODES", tree=tree.name) == {"FINISHED"}
    assert added().data.sdf_lamp.nodes == tree and len(bpy.data.node_groups) == 1


def test_undo_and_redo_of_adding(file):
    bpy.ops.ed.undo_push(message="Before")
    bpy.ops.sdf_lights.lamp_add(source="PRESET", preset="LAVA")
    bpy.ops.ed.undo_push(message="After")
    bpy.ops.ed.undo()
    assert not bpy.data.lights and not bpy.data.texts
    bpy.ops.ed.redo()
    assert len(bpy.data.lights) == 1 and shape_of(bpy.data.lights[0].sdf_lamp) == evaluate(presets()["lava"].expression)


def test_duplicates_share_or_copy_the_lamp_as_blender_does(file):
    bpy.ops.sdf_lights.lamp_add(shape="TORUS")
    first = added()
    bpy.ops.object.duplicate(linked=True)
    assert added() != first and added().data == first.data
    bpy.ops.object.duplicate(linked=False)
    assert added().data != first.data
    added().data.sdf_lamp.torus.major_radius = 2.0
    assert first.data.sdf_lamp.torus.major_radius == 0.5


def test_presets_on_a_lamp_that_is_there(file, add, lamp):
    data = lamp()
    bpy.context.view_layer.objects.active = add("Lamp", data)
    assert bpy.ops.sdf_lights.preset_load(preset="GYROID") == {"FINISHED"}
    assert data.energy == presets()["gyroid"].power
    assert shape_of(data.sdf_lamp) == evaluate(presets()["gyroid"].expression)


@pytest.mark.parametrize(
    "text", ["sphere(0.5)", "box(0.5, 0.3, 0.2)", "torus(0.5, 0.15) - box(0.3)", "menger_sponge(0.5, 1)"]
)
def test_lamps_become_meshes_of_the_same_volume(file, add, lamp, text):
    data = lamp(power=50.0)
    data.sdf_lamp.source, data.sdf_lamp.expression = "EXPRESSION", text
    parent = add("Parent", None, location=(0.0, 1.0, 0.0), scale=(2.0, 2.0, 2.0))
    obj = add("Glow", data, location=(1.0, 2.0, 3.0), rotation=(0.3, 0.0, 0.0))
    obj.parent = parent
    bpy.context.view_layer.update()
    place = obj.matrix_world.copy()
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    assert bpy.ops.sdf_lights.lamp_to_mesh(resolution=48) == {"FINISHED"}
    made = added()
    bpy.context.view_layer.update()
    assert made.type == "MESH" and made.name == "Glow" and made.parent == parent
    assert np.allclose(np.array(made.matrix_world), np.array(place))
    assert not [o for o in file.scene.objects if o.type == "LIGHT"]
    import bmesh

    solid = bmesh.new()
    solid.from_mesh(made.data)
    assert all(edge.is_manifold for edge in solid.edges)
    shape = evaluate(text)
    points = np.random.default_rng(2).uniform(*shape.bounds(), (40_000, 3))
    volume = (shape.distance(points) < 0.0).mean() * np.prod(np.subtract(*shape.bounds()[::-1]))
    assert solid.calc_volume(signed=True) == pytest.approx(shape.volume() or volume, rel=0.02)
    solid.free()
    emission = made.data.materials[0].node_tree.nodes["Emission"]
    area = 4.0 * sum(face.area for face in made.data.polygons)  # of the parent's scale
    assert emission.inputs["Strength"].default_value * math.pi * area == pytest.approx(50.0, rel=1e-4)


@pytest.mark.parametrize("pattern, mean", [("UNIFORM", 1.0), ("height", 0.5)])
def test_a_lamp_of_fixed_density_becomes_a_mesh_of_its_power(file, add, lamp, pattern, mean):
    data = lamp(radius=0.5)
    data.sdf_lamp.normalize, data.sdf_lamp.density, data.exposure = False, 3.0, 1.0
    if pattern != "UNIFORM":
        data.sdf_lamp.emission.source, data.sdf_lamp.emission.expression = "EXPRESSION", pattern
    obj = add("Glow", data, scale=(2.0, 2.0, 2.0))
    bpy.context.view_layer.update()
    obj.select_set(True)
    bpy.ops.sdf_lights.lamp_to_mesh(resolution=32)
    made = bpy.data.objects["Glow"]
    strength = made.data.materials[0].node_tree.nodes["Emission"].inputs["Strength"].default_value
    area = 4.0 * sum(face.area for face in made.data.polygons)
    power = 4.0 * math.pi * 2.0 * 3.0 * mean * 4.0 / 3.0 * math.pi  # a ball of 1 m
    assert strength * math.pi * area == pytest.approx(power, rel=0.02)


def test_what_is_too_thin_for_a_mesh_says_so(file, add, lamp):
    data = lamp(shape="TORUS", major_radius=1.0, minor_radius=0.001)
    obj = add("Thin", data)
    obj.select_set(True)
    with pytest.raises(RuntimeError, match="too thin"):
        bpy.ops.sdf_lights.lamp_to_mesh(resolution=4)
    assert obj.name in file.scene.objects
