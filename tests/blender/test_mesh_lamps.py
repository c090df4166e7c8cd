# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as lamps: what they enclose, that they follow modifiers and armatures, and what they say where they cannot be
lamps."""

import bpy
import numpy as np
import pytest

from sdf_lights.blender.lamp import shape_of
from sdf_lights.render.errors import RenderError


@pytest.fixture
def lamp_of(lamp):
    """Function: a lamp's shape, that of an object."""

    def make(obj, voxel_size=0.05):
        light = lamp()
        light.sdf_lamp.source, light.sdf_lamp.object, light.sdf_lamp.voxel_size = "OBJECT", obj, voxel_size
        bpy.context.view_layer.update()
        return light, shape_of(light.sdf_lamp)

    return make


def _inside(shape) -> float:
    points = np.random.default_rng(1).uniform(*shape.bounds(), (100_000, 3))
    return float((shape.distance(points) < 0.0).mean() * np.prod(np.diff(shape.bounds(), axis=0)))


def test_suzanne_is_a_lamp(file, lamp_of):
    bpy.ops.mesh.primitive_monkey_add()
    _, shape = lamp_of(bpy.context.object)
    assert shape.validate() == "" and shape.certified
    assert _inside(shape) == pytest.approx(2.18, rel=0.05)
    assert shape.distance(np.array([0.0, 0.0, 0.0])) < 0.0 < shape.distance(np.array([0.0, -2.0, 0.0]))


def test_a_mesh_follows_its_modifiers_frame_by_frame(file, lamp_of):
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    obj = bpy.context.object
    light, shape = lamp_of(obj)
    assert _inside(shape) == pytest.approx(1.0, rel=0.05)
    copies = obj.modifiers.new("Row", "ARRAY")
    copies.use_relative_offset, copies.use_constant_offset = False, True
    copies.constant_offset_displace = 2.0, 0.0, 0.0
    key = obj.shape_key_add(name="Basis") and obj.shape_key_add(name="Wide")
    for point in key.data:
        point.co.z *= 2.0
    key.value = 0.0
    key.keyframe_insert("value", frame=1)
    key.value = 1.0
    key.keyframe_insert("value", frame=11)
    for frame, size in ((1, 2.0), (11, 4.0)):
        bpy.context.scene.frame_set(frame)
        assert _inside(shape_of(light.sdf_lamp)) == pytest.approx(size, rel=0.05)


@pytest.mark.parametrize("hidden", [False, True])
def test_renders_have_the_modifiers_of_a_mesh_that_is_hidden(file, synced, hidden):
    """As *Convert > To SDF Lamp* hides it: Blender then evaluates no more than its place."""
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    copies = bpy.context.object.modifiers.new("Row", "ARRAY")
    copies.use_relative_offset, copies.use_constant_offset = False, True
    copies.constant_offset_displace = 2.0, 0.0, 0.0
    mesh = bpy.context.object
    bpy.ops.sdf_lights.object_to_lamp()
    assert mesh.hide_render
    mesh.hide_viewport = hidden
    bpy.context.scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(bpy.context.scene.camera)
    (lamp,) = synced().lamps
    assert _inside(lamp.shape) == pytest.approx(2.0, rel=0.05)


def test_an_armature_moves_a_lamp(file, lamp_of):
    bpy.ops.object.armature_add()
    armature = bpy.context.object
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    obj = bpy.context.object
    group = obj.vertex_groups.new(name="Bone")
    group.add(range(8), 1.0, "REPLACE")
    obj.modifiers.new("Armature", "ARMATURE").object = armature
    light, before = lamp_of(obj)
    armature.pose.bones["Bone"].location = 3.0, 0.0, 0.0
    bpy.context.view_layer.update()
    after = shape_of(light.sdf_lamp)
    np.testing.assert_allclose(np.add(*after.bounds()) - np.add(*before.bounds()), (6.0, 0.0, 0.0), atol=0.1)


def test_a_metaball_is_a_lamp(file, lamp_of):
    bpy.ops.object.metaball_add()
    _, shape = lamp_of(bpy.context.object)
    assert _inside(shape) > 1.0


def test_renders_have_a_metaball_as_a_lamp_and_nothing_else_of_it(file, pictures):
    bpy.ops.object.metaball_add(location=(0.0, 0.0, -5.0))
    bpy.ops.sdf_lights.object_to_lamp()
    (lamp,) = [light for light in bpy.data.lights if light.sdf_lamp.use]
    lamp.energy = 0.0
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    bpy.context.scene.world = world = bpy.data.worlds.new("World")
    world.color = (0.5, 0.5, 0.5)
    dark = pictures()["ViewLayer"]["Combined"][..., :3]
    np.testing.assert_allclose(dark, dark[0, 0, 0], rtol=1e-5)  # the world alone
    lamp.energy = 100.0
    assert pictures()["ViewLayer"]["Combined"].max() > 2.0 * dark.max()


def test_an_open_mesh_is_a_lamp(file, lamp_of):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
    mesh = bpy.context.object.data
    vertices = np.array([vertex.co for vertex in mesh.vertices])
    faces = [tuple(face.vertices) for face in mesh.polygons if vertices[face.vertices[0], 2] < 0.8]
    cut = bpy.data.meshes.new("Cut")
    cut.from_pydata(vertices.tolist(), [], faces)
    bpy.context.object.data = cut
    _, shape = lamp_of(bpy.context.object)
    assert shape.certified and 3.3 < _inside(shape) < 4.19


@pytest.mark.parametrize(
    "vertices, faces, sentence",
    [
        ([(0, 0, 0), (1, 0, 0)], [], "Mesh 'Bare' has no faces.*give it faces"),
        ([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)], "Mesh 'Bare' has no inside.*Solidify"),
    ],
)
def test_meshes_that_are_no_lamps_say_so_in_a_sentence(file, lamp_of, add, vertices, faces, sentence):
    mesh = bpy.data.meshes.new("Bare")
    mesh.from_pydata(vertices, [], faces)
    with pytest.raises(RenderError, match=sentence):
        lamp_of(add("Bare", mesh))
