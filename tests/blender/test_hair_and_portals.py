# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ray Portal and Principled Hair on meshes look as in Cycles."""

import bpy
import numpy as np
import pytest

pytest.importorskip("_cycles")


def shaded(material, mesh, build):
    """Give a mesh a material that ``build(tree)`` makes."""
    made, tree, output = material(mesh.name)
    tree.links.new(build(tree), output)
    mesh.materials.append(made)
    return mesh


def glowing(tree):
    """Colours that tell places apart."""
    node = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], node.inputs["Color"])
    return node.outputs[0]


def leading(tree, offset=(0.0, 0.0, 0.0), direction=None, clear=0.0):
    """A portal that leads to places moved by ``offset``; a part of it is clear."""
    node, add = tree.nodes.new("ShaderNodeBsdfRayPortal"), tree.nodes.new("ShaderNodeVectorMath")
    add.inputs[1].default_value = offset
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"], add.inputs[0])
    tree.links.new(add.outputs[0], node.inputs["Position"])
    node.inputs["Color"].default_value = (0.9, 0.6, 0.4, 1.0)
    if direction is not None:
        value = tree.nodes.new("ShaderNodeCombineXYZ")
        for socket, component in zip(value.inputs, direction):
            socket.default_value = component
        tree.links.new(value.outputs[0], node.inputs["Direction"])
    mix, other = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    mix.inputs[0].default_value = clear
    tree.links.new(node.outputs[0], mix.inputs[1])
    tree.links.new(other.outputs[0], mix.inputs[2])
    return mix.outputs[0]


@pytest.mark.parametrize("kind", ["straight", "elsewhere", "turned", "partly"])
def test_a_portal_shows_and_hides_what_it_does_in_cycles(file, add, quad, material, render, kind):
    """Through a portal above a floor the camera sees a glowing picture beside; the sun does not see through it."""
    offset, direction, clear = {
        "straight": ((0.0, 0.0, 0.0), None, 0.0),
        "elsewhere": ((6.0, 0.0, -0.5), None, 0.0),
        "turned": ((6.0, 0.0, 0.0), (0.2, 0.1, -1.0), 0.0),
        "partly": ((6.0, 0.0, -0.5), None, 0.4),
    }[kind]
    add("Picture", shaded(material, quad("Picture"), glowing), (6.0, 0.0, -1.0), scale=(1.5, 1.5, 1.0))
    diffuse = lambda tree: tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0]
    add("Floor", shaded(material, quad("Floor"), diffuse), (0.0, 0.0, -1.0), scale=(3.0, 3.0, 1.0))
    add(
        "Portal",
        shaded(material, quad("Portal"), lambda tree: leading(tree, offset, direction, clear)),
        scale=(0.7, 0.7, 1.0),
    )
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3.0, 0.0
    add("Sun", sun, rotation=(0.5, 0.3, 0.0))
    camera = file.camera
    camera.location, camera.rotation_euler = (0.0, -0.5, 4.0), (0.12, 0.0, 0.0)
    camera.data.lens = 30.0
    ours, theirs = render(2048 if clear else 64)
    difference = np.abs(ours - theirs)
    assert difference[..., 3].mean() < 0.005
    assert difference.mean() < 0.01 * theirs.mean() and np.quantile(difference, 0.99) < 0.1 * theirs.max()


@pytest.mark.slow
@pytest.mark.parametrize("model", ["CHIANG", "HUANG"])
def test_hair_on_a_ball_in_a_world_of_light(file, add, material, render, model):
    """Cycles has no light rays to a world of one colour, so nothing is cut there; here some percent of it are. Before
    Blender 5.0, neither cuts any."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    ball = bpy.context.object

    def hair(tree):
        node = tree.nodes.new("ShaderNodeBsdfHairPrincipled")
        node.model, node.parametrization = model, "COLOR"
        node.inputs["Color"].default_value = (0.5, 0.3, 0.1, 1.0)
        return node.outputs[0]

    shaded(material, ball.data, hair)
    world = bpy.data.worlds.new("World")
    file.scene.world = world
    world.use_nodes = True
    next(node for node in world.node_tree.nodes if node.type == "BACKGROUND").inputs["Color"].default_value = (
        1.0,
        1.0,
        1.0,
        1.0,
    )
    file.camera.location, file.camera.rotation_euler = (0.0, 0.0, 4.0), (0.0, 0.0, 0.0)
    ours, theirs = render(96)
    inside = theirs[..., 3] > 0.99
    assert inside.mean() > 0.1
    assert ours[inside][:, :3].mean(0) == pytest.approx(theirs[inside][:, :3].mean(0), rel=0.05)
