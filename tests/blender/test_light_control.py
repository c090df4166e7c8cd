# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights do what Cycles lets them do: light linking, shadow linking, visibility to kinds of rays, limits of bounces.

Each colour of a picture is another light, so one picture tells of three.
"""

import math

import bpy
import numpy as np
import pytest

pytest.importorskip("_cycles")

RED, GREEN, BLUE = np.eye(3)


@pytest.fixture
def room(file, add, quad, material):
    """A floor, a wall of rough metal, a translucent pane, a block and a screen, lit by a red, a green and a blue
    light."""
    bpy.ops.preferences.addon_enable(module="cycles")

    def surface(name: str, kind: str, roughness=None):
        made, tree, output = material(name)
        node = tree.nodes.new(f"ShaderNode{kind}")
        node.inputs["Color"].default_value = (0.8, 0.8, 0.8, 1.0)
        if roughness is not None:
            node.inputs["Roughness"].default_value = roughness
        tree.links.new(node.outputs[0], output)
        mesh = quad(name)
        mesh.materials.append(made)
        return mesh

    half = math.pi / 2
    add("Floor", surface("Floor", "BsdfDiffuse"), scale=(3.0, 3.0, 1.0))
    add("Wall", surface("Wall", "BsdfGlossy", 0.5), (0.0, 2.0, 1.0), (half, 0.0, 0.0), (3.0, 2.0, 1.0))
    add("Pane", surface("Pane", "BsdfTranslucent"), (-1.2, -1.0, 0.8), (half, 0.0, 0.0), (0.6, 0.6, 1.0))
    add("Block", surface("Block", "BsdfDiffuse"), (0.4, 0.0, 0.7), (0.5, 0.2, 0.0), (0.5, 0.5, 1.0))
    add("Screen", surface("Screen", "BsdfDiffuse"), (1.0, 0.5, 1.2), (0.0, 0.9, 0.3), (0.5, 0.5, 1.0))
    cycles = file.scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.samples, cycles.blur_glossy, cycles.light_sampling_threshold = 1024, 0.0, 0.0
    cycles.sample_clamp_indirect, cycles.pixel_filter_type, cycles.max_bounces = 0.0, "BOX", 3
    return file.scene


@pytest.fixture
def light(add):
    """Function: a new light."""

    def run(kind: str, color, location, power: float = 60.0, **settings):
        data = bpy.data.lights.new(kind.title(), kind)
        data.energy, data.color = power, color
        for name, value in settings.items():
            setattr(data, name, value)
        return add(data.name, data, location, (0.3, 0.2, 0.0))

    return run


@pytest.fixture
def collection():
    """Function: a collection for linking, with objects that it includes or excludes."""

    def run(included=(), excluded=()):
        made = bpy.data.collections.new("Linked")
        for name in (*included, *excluded):
            made.objects.link(bpy.data.objects[name])
        for obj, link in zip(made.objects, made.collection_objects):
            link.light_linking.link_state = "INCLUDE" if obj.name in included else "EXCLUDE"
        return made

    return run


@pytest.fixture
def compare(room, pictures):
    """Function: render with both engines; means of each colour agree, and parts of the picture too. Gives ours."""

    def run(samples: int = 1024, tolerance: float = 0.01) -> np.ndarray:
        found = {}
        room.cycles.samples = samples
        for room.render.engine in ("CYCLES", "SDF_LIGHTS"):
            bpy.ops.sdf_lights.cycles_settings_copy()
            room.sdf_lights.device, room.sdf_lights.guided_samples = "CPU", False
            found[room.render.engine] = pictures()["ViewLayer"]["Combined"][..., :3].astype(float)
        ours, theirs = found["SDF_LIGHTS"], found["CYCLES"]
        print(f"means {ours.mean((0, 1))}, those of Cycles {theirs.mean((0, 1))}")
        assert ours.mean((0, 1)) == pytest.approx(theirs.mean((0, 1)), rel=tolerance, abs=1e-4)
        blocks = [picture.reshape(4, 4, 6, 4, 3).mean((1, 3)) for picture in (ours, theirs)]
        assert (np.abs(blocks[0] - blocks[1]).mean((0, 1)) <= 0.03 * theirs.mean((0, 1)) + 1e-4).all()
        return ours

    return run


@pytest.fixture
def three_lights(room, light):
    """Three lights of one colour each: a large square, a point and a glowing mesh."""
    area = light("AREA", RED, (0.0, -0.5, 2.5), size=0.8)
    point = light("POINT", GREEN, (-1.0, 0.5, 1.5), shadow_soft_size=0.2)
    bulb = bpy.data.objects["Screen"].copy()
    bulb.name, bulb.data = "Bulb", bulb.data.copy()
    node = bpy.data.materials.new("Bulb")
    node.use_nodes = True
    node.node_tree.nodes.clear()
    emission = node.node_tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value, emission.inputs["Strength"].default_value = (*BLUE, 1.0), 15.0
    output = node.node_tree.nodes.new("ShaderNodeOutputMaterial")
    node.node_tree.links.new(emission.outputs[0], output.inputs["Surface"])
    bulb.data.materials[0] = node
    bulb.location, bulb.scale = (1.6, -0.6, 2.0), (0.3, 0.3, 1.0)
    room.collection.objects.link(bulb)
    return area, point, bulb


def test_light_linking(three_lights, collection, compare):
    area, point, bulb = three_lights
    plain = compare()
    area.light_linking.receiver_collection = collection(["Floor", "Pane"])
    point.light_linking.receiver_collection = collection(excluded=["Floor"])
    bulb.light_linking.receiver_collection = collection(["Wall", "Block"], ["Floor"])
    assert (compare().mean((0, 1)) < 0.9 * plain.mean((0, 1))).all()


def test_shadow_linking(three_lights, collection, compare):
    area, point, bulb = three_lights
    plain = compare(256, 0.03)
    area.light_linking.blocker_collection = collection(["Screen", "Floor"])
    point.light_linking.blocker_collection = collection(["Wall"])
    bulb.light_linking.blocker_collection = collection(["Floor"])
    assert (compare().mean((0, 1)) > 1.005 * plain.mean((0, 1))).all()


@pytest.mark.slow
def test_sun_and_empty_and_nested_collections(room, light, collection, compare):
    sun = light("SUN", RED, (0.0, 0.0, 3.0), 2.0, angle=0.2)
    sun.light_linking.receiver_collection = collection(["Floor", "Wall"])
    sun.light_linking.blocker_collection = collection(["Screen"])
    outer = collection(excluded=["Wall"])
    outer.children.link(collection(["Wall", "Floor", "Pane"]))
    spot = light("SPOT", GREEN, (0.0, -0.5, 2.5), 200.0, shadow_soft_size=0.1, spot_size=2.6)
    spot.light_linking.receiver_collection = outer
    point = light("POINT", BLUE, (0.5, -0.5, 1.8))
    point.light_linking.receiver_collection = collection()
    compare()


@pytest.mark.slow
def test_instances_have_the_linking_of_cycles(room, light, collection, compare, add):
    part = bpy.data.objects["Block"]
    group = bpy.data.collections.new("Group")
    group.objects.link(part)
    room.collection.objects.unlink(part)
    empty = add("Instancer", None, (-0.6, 0.3, 0.2))
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    by_part = light("POINT", RED, (0.0, -1.0, 2.0))
    by_part.light_linking.receiver_collection = collection(excluded=["Block"])
    by_part.light_linking.blocker_collection = collection(excluded=["Block"])
    by_instancer = light("POINT", GREEN, (0.3, -1.0, 2.0))
    by_instancer.light_linking.receiver_collection = collection(excluded=["Instancer"])
    by_instancer.light_linking.blocker_collection = collection(excluded=["Instancer"])
    compare()


def test_visibility_to_kinds_of_rays(three_lights, compare):
    area, point, bulb = three_lights
    plain = compare(256, 0.03)
    area.visible_diffuse = point.visible_glossy = bulb.visible_glossy = bulb.visible_camera = False
    assert (compare().mean((0, 1)) < 0.99 * plain.mean((0, 1))).all()


@pytest.mark.slow
def test_visibility_to_transmission(room, light, compare):
    nodes = bpy.data.objects["Pane"].data.materials[0].node_tree
    glass = nodes.nodes.new("ShaderNodeBsdfRefraction")
    glass.inputs["Roughness"].default_value, glass.inputs["IOR"].default_value = 1.0, 1.2
    nodes.links.new(glass.outputs[0], next(node for node in nodes.nodes if node.type == "OUTPUT_MATERIAL").inputs[0])
    light("POINT", RED, (-1.0, 0.5, 1.5), shadow_soft_size=0.2)
    hidden = light("POINT", GREEN, (-1.0, 0.5, 1.5), shadow_soft_size=0.2)
    hidden.visible_transmission = False
    found = compare()
    assert found[..., 1].mean() < 0.9 * found[..., 0].mean()


def test_bounces_of_lights(room, light, compare):
    once = light("POINT", RED, (0.0, -0.5, 1.5), shadow_soft_size=0.02)
    twice = light("AREA", GREEN, (0.0, -0.5, 2.5), size=0.05)
    free = light("POINT", BLUE, (0.5, -0.5, 1.5), shadow_soft_size=0.02)
    plain = compare(256, 0.03)
    once.data.cycles.max_bounces, twice.data.cycles.max_bounces = 0, 1
    assert free.data.cycles.max_bounces >= 3
    found = compare()
    assert found[..., 0].mean() < 0.9 * plain[..., 0].mean() and found[..., 1].mean() < plain[..., 1].mean()


@pytest.mark.slow
def test_rays_hit_lights_after_their_bounces(room, light, compare):
    """As in Cycles, only light rays count the bounces of a light: rough metal shows it, seen in rough metal."""
    floor = bpy.data.objects["Floor"].data.materials[0].node_tree
    metal = floor.nodes.new("ShaderNodeBsdfAnisotropic")
    metal.inputs["Roughness"].default_value = 0.3
    end = next(node for node in floor.nodes if node.type == "OUTPUT_MATERIAL")
    floor.links.new(metal.outputs[0], end.inputs[0])
    limited = light("POINT", RED, (0.0, 0.5, 1.5), shadow_soft_size=0.4)
    wide = light("AREA", GREEN, (0.0, -0.5, 2.5), size=1.5)
    limited.data.cycles.max_bounces, wide.data.cycles.max_bounces = 0, 1
    compare()


@pytest.mark.slow
def test_lights_without_multiple_importance_sampling(room, light, compare):
    metal = bpy.data.objects["Wall"].data.materials[0].node_tree.nodes
    next(node for node in metal if node.type == "BSDF_GLOSSY").inputs["Roughness"].default_value = 0.0
    large = light("POINT", RED, (0.0, 0.5, 1.5), shadow_soft_size=0.4)
    square = light("AREA", GREEN, (0.0, -0.5, 2.5), size=1.5)
    kept = light("POINT", BLUE, (0.8, 0.5, 1.5), shadow_soft_size=0.4)
    plain = compare(256, 0.03)
    large.data.cycles.use_multiple_importance_sampling = False
    square.data.cycles.use_multiple_importance_sampling = False
    found = compare()
    assert (found.mean((0, 1)) < 0.99 * plain.mean((0, 1)))[:2].all() and kept.data.cycles is not None


def test_filters_of_a_view_layer(room, light, compare, file):
    light("POINT", GREEN, (0.0, -0.5, 1.5))
    room.world = bpy.data.worlds.new("World")
    room.world.use_nodes = True
    room.world.node_tree.nodes["Background"].inputs["Color"].default_value = (*RED, 1.0)
    file.layer.use_sky = False
    assert compare(64, 0.1)[..., 0].max() == 0.0
    file.layer.use_sky, file.layer.use_solid = True, False
    assert compare(64, 0.1)[..., 0].min() > 0.0


@pytest.mark.slow
def test_portals_guide_light_of_the_world(room, light, compare):
    """A window in a wall beside the camera: the same picture with a portal there, and less noise in it."""
    for name in ("Block", "Screen", "Pane"):
        bpy.data.objects.remove(bpy.data.objects[name])
    half = math.pi / 2
    floor, wall = bpy.data.objects["Floor"], bpy.data.objects["Wall"]
    floor.scale = (2.0, 2.0, 1.0)
    for location, rotation, scale in (
        ((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), (2.0, 2.0, 1.0)),
        ((-2.0, 0.0, 1.0), (0.0, half, 0.0), (1.0, 2.0, 1.0)),
        ((2.0, 1.2, 1.0), (0.0, half, 0.0), (1.0, 0.8, 1.0)),
        ((2.0, -1.4, 1.0), (0.0, half, 0.0), (1.0, 0.6, 1.0)),
        ((0.0, -2.0, 0.4), (half, 0.0, 0.0), (2.0, 0.4, 1.0)),
        ((0.0, -2.0, 1.8), (half, 0.0, 0.0), (2.0, 0.2, 1.0)),
    ):
        side = floor.copy()
        side.location, side.rotation_euler, side.scale = location, rotation, scale
        room.collection.objects.link(side)
    wall.scale = (2.0, 1.0, 1.0)
    room.world = bpy.data.worlds.new("World")
    room.world.color = (1.0, 1.0, 1.0)
    if room.world.node_tree is not None:
        room.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    room.cycles.max_bounces, room.world.cycles.sampling_method = 1, "AUTOMATIC"
    room.sdf_lights.path_reuse = "NEVER"  # it takes noise of what portals do not guide, and more without them
    exact = compare(1024, 0.01)
    portal = light("AREA", RED, (2.0, -0.2, 1.0), shape="RECTANGLE", size=2.0, size_y=1.2)
    portal.rotation_euler, portal.data.cycles.is_portal = (0.0, half, 0.0), True
    assert compare(1024, 0.01) == pytest.approx(exact, rel=0.2)
    few = {}
    for has_portal in (False, True):
        portal.hide_render = not has_portal
        few[has_portal] = ((compare(16, 0.2) / exact - 1.0) ** 2)[..., 0].mean()
    assert few[True] < 0.5 * few[False]
