# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""SDF lamps and Blender's lights, as sync reads them."""

import warnings

import bpy
import numpy as np
import pytest

from sdf_lights.blender.properties import PRIMITIVES
from sdf_lights.blender.viewport.lamp_data import collect
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.reference.nodes import Graph
from sdf_lights.render.scene import Ray
from sdf_lights.sdf.shapes import Sphere, Torus, Union


@pytest.fixture
def light(add):
    """Function: a new light object of a type; returns its data."""

    def run(kind: str, **changes):
        data = bpy.data.lights.new("Light", kind)
        for name, value in changes.items():
            setattr(data, name, value)
        add("Light", data)
        return data

    return run


def test_lamp(synced, add, lamp):
    data = lamp("Ring", "TORUS", 40.0, major_radius=1.5, minor_radius=0.25)
    data.color, data.exposure = (1.0, 0.5, 0.25), 1.0
    add("Ring", data, location=(1.0, 2.0, 3.0), scale=(2.0, 1.0, -1.0))
    scene = synced()
    [found] = scene.lamps
    assert scene.lights == [] and scene.warnings == []
    assert found.shape == Torus(1.5, 0.25)
    assert (found.name, found.power, found.density) == ("Ring", 80.0, None)
    assert found.color == pytest.approx((1.0, 0.5, 0.25))
    assert found.matrix == pytest.approx(np.array([[2, 0, 0, 1], [0, 1, 0, 2], [0, 0, -1, 3], [0, 0, 0, 1]]))


@pytest.mark.parametrize("name", sorted(PRIMITIVES))
def test_every_primitive_has_its_own_parameters(synced, add, lamp, name):
    shape = PRIMITIVES[name]
    changed = {}
    for about in shape.fields():  # a little smaller: within the limits, and none equal to its default
        if about.whole:
            changed[about.name] = int(about.default) + (-1 if about.default > about.minimum else 1)
        elif about.size == 3:
            changed[about.name] = tuple(0.9 * value for value in about.default)
        else:
            changed[about.name] = 0.9 * about.default
    data = lamp(shape=name.upper())
    for key, value in changed.items():
        setattr(getattr(data.sdf_lamp, name), key, value)
    add("Lamp", data)
    found = synced().lamps[0].shape
    assert type(found) is shape
    for key, value in changed.items():
        assert getattr(found, key) == pytest.approx(value, rel=1e-6)


def test_expression(synced, add, lamp):
    data = lamp()
    data.sdf_lamp.source = "EXPRESSION"
    data.sdf_lamp.expression = "union(torus(1, 0.25), sphere(0.5))"
    add("Lamp", data)
    assert synced().lamps[0].shape == Union(Torus(1.0, 0.25), Sphere(0.5))
    data.sdf_lamp.text = bpy.data.texts.new("Shape")
    data.sdf_lamp.text.write("r = 0.75\nsphere(r)\n")
    assert synced().lamps[0].shape == Sphere(0.75)


def test_density(synced, add, lamp):
    data = lamp()
    data.sdf_lamp.normalize, data.sdf_lamp.density, data.exposure = False, 3.0, -1.0
    add("Lamp", data)
    assert synced().lamps[0].density == pytest.approx(1.5)


def test_lamps_are_seen_by_the_camera_unless_told_otherwise(synced, add, lamp):
    data = lamp()
    obj = add("Lamp", data)
    assert not obj.visible_camera  # as Blender makes every light
    obj.visible_glossy = False
    assert synced().lamps[0].visibility == Ray.ALL & ~Ray.GLOSSY
    data.sdf_lamp.visible_camera = False
    assert synced().lamps[0].visibility == Ray.ALL & ~Ray.GLOSSY & ~Ray.CAMERA


@pytest.mark.parametrize("flag", ["indirect_only", "holdout"])
def test_collections_hide_lamps_from_the_camera(file, synced, add, lamp, flag):
    collection = bpy.data.collections.new("Hidden")
    file.scene.collection.children.link(collection)
    obj = add("Lamp", lamp())
    file.scene.collection.objects.unlink(obj)
    collection.objects.link(obj)
    assert synced().lamps[0].visibility & Ray.CAMERA
    setattr(file.layer.layer_collection.children["Hidden"], flag, True)
    assert synced().lamps[0].visibility == Ray.ALL & ~Ray.CAMERA


@pytest.mark.parametrize("kind", ["POINT", "SUN", "AREA"])
def test_lights_are_read_without_warnings_of_python(synced, add, kind):
    """Of what Blender 6.0 does away with."""
    add("Light", bpy.data.lights.new("Light", kind))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        synced()


def test_camera_brightness(synced, add, lamp):
    data = lamp()
    add("Lamp", data)
    assert synced().lamps[0].camera_brightness == 1.0
    data.sdf_lamp.camera_brightness = 0.25
    assert synced().lamps[0].camera_brightness == 0.25


def test_a_lamp_that_cannot_be_used_is_named_and_the_rest_stays(synced, add, lamp):
    add("Good", lamp())
    add("Zero", lamp(), scale=(1.0, 0.0, 1.0))
    add("Nowhere", lamp(), location=(float("nan"), 0.0, 0.0))
    wrong = lamp()
    wrong.sdf_lamp.source, wrong.sdf_lamp.expression = "EXPRESSION", "sphere(1"
    add("Wrong", wrong)
    thick = lamp(shape="BOX_FRAME", thickness=3.0)
    add("Thick", thick)
    dark = lamp()
    dark.energy = float("nan")
    add("Dark", dark)
    scene = synced()
    assert [found.name for found in scene.lamps] == ["Good"]
    for name in ("Zero", "Nowhere", "Wrong", "Thick", "Dark"):
        [warning] = [warning for warning in scene.warnings if f"'{name}'" in warning]
        assert warning.endswith(".") and "left out" in warning


def test_viewports_keep_the_last_good_shape_and_renders_do_not(file, synced, add, lamp):
    data = lamp(shape="BOX_FRAME", thickness=0.1)
    add("Frame", data)
    (shown,) = collect(bpy.context.evaluated_depsgraph_get()).lamps
    assert not shown.problem
    data.sdf_lamp.box_frame.thickness = 50.0
    bpy.context.view_layer.update()
    found = collect(bpy.context.evaluated_depsgraph_get())
    assert found.lamps[0].lamp.shape == shown.lamp.shape
    assert "last good shape" in found.lamps[0].problem and found.errors[data.name_full] == found.lamps[0].problem
    scene = synced()
    assert not scene.lamps and "Lamp 'Frame' is left out." in scene.warnings[0]
    data.sdf_lamp.source, data.sdf_lamp.expression = "EXPRESSION", "sphere(0.5"  # half typed
    assert collect(bpy.context.evaluated_depsgraph_get()).lamps[0].lamp.shape == shown.lamp.shape
    data.sdf_lamp.expression += ")"
    (mended,) = collect(bpy.context.evaluated_depsgraph_get()).lamps
    assert mended.lamp.shape == Sphere(0.5) and not mended.problem


def test_instances_of_a_lamp(file, synced, add, lamp):
    """Of collections, also inside each other; the overlay finds the same."""
    source, outer = (bpy.data.collections.new(name) for name in ("Source", "Outer"))
    source.objects.link(bpy.data.objects.new("Lamp", lamp(radius=0.25)))
    within = bpy.data.objects.new("Within", None)
    within.location.x = 10.0
    within.instance_type, within.instance_collection = "COLLECTION", source
    outer.objects.link(within)
    for i, collection in enumerate((source, source, outer)):
        placed = add(f"Placed {i}", None, location=(i, 0.0, 0.0), scale=(2.0, 1.0, 1.0))
        placed.instance_type, placed.instance_collection = "COLLECTION", collection
    found = synced().lamps
    assert sorted(lamp.matrix[0, 3] for lamp in found) == [0.0, 1.0, 22.0]
    assert all(lamp.shape == Sphere(0.25) and lamp.matrix[0, 0] == 2.0 for lamp in found)
    shown = collect(bpy.context.evaluated_depsgraph_get()).lamps
    assert sorted((item.owner, item.lamp.matrix[0, 3]) for item in shown) == [
        ("Placed 0", 0.0),
        ("Placed 1", 1.0),
        ("Placed 2", 22.0),
    ]
    assert len({item.key for item in shown}) == 3


def test_animated_parameter(file, synced, add, lamp):
    data = lamp()
    sphere = data.sdf_lamp.sphere
    for frame, radius in ((1, 0.5), (11, 1.5)):
        sphere.radius = radius
        sphere.keyframe_insert("radius", frame=frame)
    add("Lamp", data)
    file.scene.frame_set(11)
    assert synced().lamps[0].shape == Sphere(1.5)
    file.scene.frame_set(1)
    assert synced().lamps[0].shape == Sphere(0.5)


def test_point(synced, light):
    light("POINT", energy=30.0, shadow_soft_size=0.25, use_soft_falloff=False, use_shadow=False)
    [found] = synced().lights
    assert type(found) is PointLight
    assert (found.power, found.radius, found.soft_falloff, found.cast_shadow) == (30.0, 0.25, False, False)


def test_spot(synced, light):
    light("SPOT", energy=30.0, spot_size=1.0, spot_blend=0.5)
    [found] = synced().lights
    assert type(found) is SpotLight and (found.angle, found.blend) == pytest.approx((1.0, 0.5))


def test_sun(synced, light):
    light("SUN", energy=3.0, angle=0.1)
    [found] = synced().lights
    assert type(found) is SunLight and (found.strength, found.angle) == pytest.approx((3.0, 0.1))


@pytest.mark.parametrize(
    ("shape", "ellipse", "size"),
    [
        ("SQUARE", False, (2.0, 2.0)),
        ("RECTANGLE", False, (2.0, 0.5)),
        ("DISK", True, (2.0, 2.0)),
        ("ELLIPSE", True, (2.0, 0.5)),
    ],
)
def test_area(synced, light, shape, ellipse, size):
    light("AREA", shape=shape, size=2.0, size_y=0.5, spread=1.0)
    [found] = synced().lights
    assert type(found) is AreaLight
    assert (found.ellipse, found.size, found.spread) == (ellipse, size, pytest.approx(1.0))


def test_colour_of_temperature_and_nodes(synced, light):
    data = light("POINT", color=(1.0, 0.5, 1.0), use_temperature=True, temperature=3000.0)
    warm = np.array(data.temperature_color)
    assert synced().lights[0].color == pytest.approx(warm * [1.0, 0.5, 1.0])
    data.use_temperature, data.use_nodes = False, True
    emission = next(node for node in data.node_tree.nodes if node.bl_idname == "ShaderNodeEmission")
    emission.inputs["Color"].default_value = (0.5, 0.5, 1.0, 1.0)
    emission.inputs["Strength"].default_value = 4.0
    scene = synced()
    assert scene.lights[0].color == pytest.approx((2.0, 1.0, 4.0)) and scene.warnings == []
    data.node_tree.links.new(data.node_tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], emission.inputs["Color"])
    scene = synced()
    assert scene.lights[0].color == pytest.approx((1.0, 0.5, 1.0)) and scene.warnings == []
    assert Graph(scene.lights[0].emission).surface["strength"] == 4.0  # what varies is a graph


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("POINT", dict(shadow_soft_size=0.0)),
        ("POINT", dict(shadow_soft_size=0.5)),
        ("SPOT", dict(shadow_soft_size=0.25)),
        ("SUN", dict(angle=0.0)),
        ("SUN", dict(angle=1.5)),
        ("AREA", dict(shape="ELLIPSE", size=1.0, size_y=2.0)),
    ],
)
def test_power_without_normalize_is_that_of_cycles(file, synced, light, add, quad, pictures, kind, changes):
    """What the switch changes in a render of Cycles is what it changes in the power that sync reads."""
    pytest.importorskip("_cycles")
    bpy.ops.preferences.addon_enable(module="cycles")
    data = light(kind, energy=100.0, **changes)
    bpy.data.objects["Light"].location, bpy.data.objects["Light"].scale = (0.0, 0.0, 20.0), (1.0, 3.0, 1.0)
    add("Floor", quad(), scale=(20.0, 20.0, 1.0))
    powers, means = [], []
    for data.normalize in (True, False):
        [found] = synced().lights
        powers.append(found.strength if kind == "SUN" else found.power)
        file.scene.render.engine = "CYCLES"
        file.scene.cycles.samples, file.scene.cycles.seed, file.scene.cycles.use_denoising = 4, 1, False
        means.append(pictures()["ViewLayer"]["Combined"][..., :3].mean())
    assert means[0] > 0.0
    assert powers[1] / powers[0] == pytest.approx(means[1] / means[0], rel=1e-4)


def test_lights_without_extent_in_space(synced, add):
    area = bpy.data.lights.new("Area", "AREA")
    add("Folded", area, scale=(0.0, 1.0, 1.0))
    scene = synced()
    assert scene.lights == [] and any("'Folded'" in warning for warning in scene.warnings)
