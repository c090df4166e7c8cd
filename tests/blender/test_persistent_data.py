# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""With Blender's Persistent Data, frames are the same bits as without, whatever has changed between them; what has not
changed is not read again."""

import math
import os

import bpy
import numpy as np
import pytest

from sdf_lights.blender.sync import Kept, sync_views

pytest.importorskip("_cycles")


def write_image(path, color) -> None:
    openimageio = pytest.importorskip("OpenImageIO")
    pixels = np.empty((8, 8, 3), np.uint8)
    pixels[:] = color
    pixels[::2, 1::2] //= 2
    out = openimageio.ImageOutput.create(str(path))
    out.open(str(path), openimageio.ImageSpec(8, 8, 3, "uint8"))
    out.write_image(pixels)
    out.close()


def key(owner, path: str, *values, first: int = 1) -> None:
    for frame, value in enumerate(values, first):
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)


@pytest.fixture
def build(file, add, quad, lamp, material, tmp_path):
    """Function: a file with a textured floor, a ball that bends, a ball that moves, instances, hair, and a lamp."""

    def run(persistent: bool):
        kinds = ("objects", "meshes", "materials", "images", "lights", "hair_curves", "collections", "worlds")
        for collection in (getattr(bpy.data, kind) for kind in kinds):
            for block in [block for block in collection if block is not file.camera]:
                collection.remove(block)
        picture = tmp_path / "floor.png"
        write_image(picture, (200, 120, 40))
        made, tree, output = material("Floor")
        bsdf, texture = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeTexImage")
        texture.image = bpy.data.images.load(str(picture))
        tree.links.new(texture.outputs["Color"], bsdf.inputs["Color"])
        tree.links.new(bsdf.outputs[0], output)
        mesh = quad("Floor")
        mesh.materials.append(made)
        add("Floor", mesh, scale=(4.0, 4.0, 1.0))
        bending = add("Bending", quad("Bending"), (-1.0, 0.0, 1.0), (math.pi / 2, 0.0, 0.0), (0.5, 0.5, 1.0))
        bending.shape_key_add(name="Basis")
        shape = bending.shape_key_add(name="Lean")
        shape.data[2].co.x += 2.0
        key(shape, "value", 0.0, 0.5, 1.0)
        moving = add("Moving", quad("Moving"), (0.0, 0.0, 1.0), (math.pi / 2, 0.3, 0.0), (0.4, 0.4, 1.0))
        key(moving, "location", (0.0, 0.0, 1.0), (0.5, 0.0, 1.2), (0.8, 0.3, 1.0))
        shared = quad("Shared")
        for index in range(3):
            add(f"Shared {index}", shared, (index - 1.0, 1.0, 0.6), (1.2, 0.0, 0.4 * index), (0.3, 0.3, 1.0))
        hair = bpy.data.hair_curves.new("Hair")
        hair.add_curves([3] * 20)
        for index, point in enumerate(hair.points):
            curve, place = divmod(index, 3)
            point.position, point.radius = (0.15 * curve - 1.5, -0.5, 0.25 * place), 0.02
        add("Hair", hair)
        add("Lamp", lamp(radius=0.3), (0.5, -1.0, 2.0))
        file.scene.world = sky = bpy.data.worlds.new("Sky")
        sky.use_nodes = True
        nodes, links = sky.node_tree.nodes, sky.node_tree.links
        place, turn, picture_of_sky, gamma = (
            nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "Mapping", "TexEnvironment", "Gamma")
        )
        gamma.inputs["Gamma"].default_value = 3.0  # with this, the world is a graph
        turn.inputs["Rotation"].default_value = (0.2, 0.3, 0.4)
        picture_of_sky.image = texture.image
        links.new(place.outputs["Generated"], turn.inputs["Vector"])
        links.new(turn.outputs["Vector"], picture_of_sky.inputs["Vector"])
        background = next(node for node in nodes if node.type == "BACKGROUND")
        background.inputs["Strength"].default_value = 2.0
        links.new(picture_of_sky.outputs["Color"], gamma.inputs["Color"])
        links.new(gamma.outputs["Color"], background.inputs["Color"])
        file.scene.render.use_persistent_data = persistent
        file.scene.sdf_lights.device, file.scene.sdf_lights.samples = "CPU", 4
        return file.scene

    return run


def edit_vertices():
    bpy.data.meshes["Shared"].vertices[0].co.x = -3.0
    bpy.data.meshes["Shared"].update()


def edit_material():
    made = bpy.data.materials["Floor"]
    node = next(node for node in made.node_tree.nodes if node.type == "BSDF_DIFFUSE")
    for link in list(node.inputs["Color"].links):
        made.node_tree.links.remove(link)
    node.inputs["Color"].default_value = (0.1, 0.8, 0.2, 1.0)


def edit_image():
    path = bpy.data.images[0].filepath
    write_image(bpy.path.abspath(path), (20, 220, 40))
    os.utime(bpy.path.abspath(path), ns=(1, 1))
    bpy.data.images[0].reload()


def edit_world():
    turn = next(node for node in bpy.context.scene.world.node_tree.nodes if node.type == "MAPPING")
    turn.inputs["Rotation"].default_value = (1.2, 0.3, 0.4)


def other_data():
    mesh = bpy.data.meshes.new("Other")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (0, 2, 0)], [], [(0, 1, 2)])
    bpy.data.objects["Moving"].data = mesh


def other_object():
    """What is new may get the memory of what is gone."""
    bpy.data.objects.remove(bpy.data.objects["Shared 1"])
    bpy.data.meshes.remove(bpy.data.meshes["Moving"])
    for index in range(4):
        mesh = bpy.data.meshes.new(f"New {index}")
        mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (0, 1, 0.2 * index)], [], [(0, 1, 2)])
        obj = bpy.data.objects.new(f"New {index}", mesh)
        obj.location, obj.scale = (index - 1.5, 0.0, 1.0), (0.3, 0.3, 0.3)
        obj.rotation_euler.x = 1.0
        bpy.context.scene.collection.objects.link(obj)


def modifier():
    made = bpy.data.objects["Shared 0"].modifiers.new("Array", "ARRAY")
    made.count = 3


def hidden():
    bpy.data.objects["Floor"].hide_render = True


def hair():
    bpy.data.hair_curves["Hair"].points[1].position = (1.0, -1.0, 1.0)
    bpy.data.objects["Hair"].data.update_tag()


def uv_maps():
    bpy.data.meshes["Floor"].uv_layers[0].uv[0].vector = (3.0, 2.0)
    bpy.data.meshes["Floor"].update()


def blurred():
    bpy.context.scene.render.use_motion_blur = True


EDITS = [
    edit_vertices,
    edit_material,
    edit_image,
    edit_world,
    other_data,
    other_object,
    modifier,
    hidden,
    hair,
    uv_maps,
    blurred,
]


QUICK = edit_vertices, edit_material, edit_image, edit_world, other_object, hidden


@pytest.mark.parametrize(
    "edit",
    [pytest.param(edit, marks=[pytest.mark.slow] * (edit not in QUICK)) for edit in EDITS],
    ids=[edit.__name__ for edit in EDITS],
)
def test_frames_are_the_same_bits(build, file, pictures, edit):
    def frames(persistent: bool):
        scene = build(persistent)
        scene.render.use_motion_blur = False
        found = []
        for frame in (1, 2, 2):
            scene.frame_set(frame)
            found.append(pictures()["ViewLayer"]["Combined"])
        edit()
        for frame in (2, 3):
            scene.frame_set(frame)
            found.append(pictures()["ViewLayer"]["Combined"])
        return found

    plain, kept = frames(False), frames(True)
    for expected, found in zip(plain, kept):
        np.testing.assert_array_equal(found, expected)
    assert not np.array_equal(plain[2], plain[3])  # the edit is to be seen


def test_view_layers_do_not_mix(build, file, pictures):
    def frames(persistent: bool):
        scene = build(persistent)
        group = bpy.data.collections.new("Group")
        scene.collection.children.link(group)
        for name in ("Bending", "Shared 1"):
            obj = bpy.data.objects[name]
            scene.collection.objects.unlink(obj)
            group.objects.link(obj)
        other = scene.view_layers.new("Other")
        other.layer_collection.children["Group"].exclude = True
        found = []
        for frame in (1, 2, 3):
            scene.frame_set(frame)
            found.append(pictures())
        scene.view_layers.remove(other)
        bpy.data.collections.remove(group)
        return found

    for expected, found in zip(frames(False), frames(True)):
        for layer in ("ViewLayer", "Other"):
            np.testing.assert_array_equal(found[layer]["Combined"], expected[layer]["Combined"])
        assert not np.array_equal(expected["ViewLayer"]["Combined"], expected["Other"]["Combined"])


class _Keeper(bpy.types.RenderEngine):
    """Keeps the scenes of its renders, which persist."""

    bl_idname = "SDF_LIGHTS_TEST_KEEPER"
    bl_label = "Keeper"
    scenes: list = []

    def render(self, depsgraph):
        self.kept = getattr(self, "kept", None) or Kept()
        self.scenes.append(sync_views(depsgraph, self, kept=self.kept)[0])


def test_only_what_has_changed_is_read_again(build, file):
    bpy.utils.register_class(_Keeper)
    try:
        scene = build(True)
        scene.render.engine = _Keeper.bl_idname
        for frame in (1, 2):
            scene.frame_set(frame)
            bpy.ops.render.render()
        first, second = _Keeper.scenes
    finally:
        _Keeper.scenes.clear()
        bpy.utils.unregister_class(_Keeper)
    meshes = [{mesh.name: mesh for mesh in found.meshes} for found in (first, second)]
    same = {name for name, mesh in meshes[0].items() if mesh.positions is meshes[1][name].positions}
    assert same == {"Floor", "Moving", "Shared"}
    assert first.images[0].pixels is second.images[0].pixels
    assert meshes[0]["Floor"].uvs and all(mesh is not meshes[1][name] for name, mesh in meshes[0].items())
