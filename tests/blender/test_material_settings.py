# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of materials, beside their nodes, do what they do in Cycles."""

import bpy
import numpy as np
import pytest

pytest.importorskip("_cycles")


@pytest.fixture
def agrees_with_cycles(file, render):
    """Function: the pictures of both engines have the same means, also in parts of the picture. Gives ours."""

    def run(samples: int) -> np.ndarray:
        scene = file.scene
        scene.cycles.caustics_reflective = False
        ours, theirs = render(samples)
        print(f"means {ours.mean((0, 1))}, those of Cycles {theirs.mean((0, 1))}")
        assert ours.mean((0, 1)) == pytest.approx(theirs.mean((0, 1)), rel=0.01, abs=1e-4)
        blocks = [picture.reshape(4, 4, 6, 4, 4).mean((1, 3)) for picture in (ours, theirs)]
        assert (np.abs(blocks[0] - blocks[1]).mean((0, 1)) <= 0.03 * theirs.mean((0, 1)) + 1e-4).all()
        return ours

    return run


@pytest.fixture
def sheet(file, add, quad, material):
    """A sheet above a floor and a mirror; its material and the node of its surface."""

    def painted(name: str, kind: str):
        made, tree, output = material(name)
        node = tree.nodes.new(f"ShaderNode{kind}")
        tree.links.new(node.outputs[0], output)
        mesh = quad(name)
        mesh.materials.append(made)
        return mesh, made, node

    add("Floor", painted("Floor", "BsdfDiffuse")[0], scale=(3.0, 3.0, 1.0))
    mesh, _, node = painted("Mirror", "BsdfGlossy")
    node.inputs["Roughness"].default_value = 0.0
    add("Mirror", mesh, (0.0, 2.0, 1.0), (np.pi / 2, 0.0, 0.0), (2.0, 1.0, 1.0))
    mesh, made, node = painted("Sheet", "BsdfPrincipled")
    add("Sheet", mesh, (0.0, 0.0, 1.0), (0.3, 0.2, 0.0))
    return made, node


def light(add, kind: str, location, power: float, **settings):
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy = power
    for name, value in settings.items():
        setattr(data, name, value)
    return add(data.name, data, location)


def sky(file, varies: bool):
    file.scene.world = world = bpy.data.worlds.new("World")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    color = nodes["Background"].inputs["Color"]
    color.default_value = (0.3, 0.4, 0.6, 1.0)
    if varies:
        place, gradient = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeTexGradient")
        links.new(place.outputs["Generated"], gradient.inputs[0])
        links.new(gradient.outputs[0], color)


@pytest.mark.parametrize("lit", ["small", "large", "sky", "bright side"])
def test_transparent_shadows(sheet, agrees_with_cycles, add, file, lit):
    """Without them a transparent sheet lets no light of lamps through, but the camera and mirrors see through it. What
    scattered rays find counts as in Cycles, too: all light of a sky of one colour, and a part of other light."""
    made, node = sheet
    node.inputs["Alpha"].default_value = 0.3
    if lit == "small":
        light(add, "POINT", (0.2, -0.2, 2.6), 60.0, shadow_soft_size=0.05)
        light(add, "AREA", (-1.0, -1.0, 2.5), 40.0, size=0.1, color=(0.2, 1.0, 0.4))
    elif lit == "large":
        light(add, "AREA", (0.0, 0.0, 2.2), 60.0, size=1.6)
    else:
        sky(file, lit != "sky")
    file.scene.cycles.max_bounces = 3
    clear = agrees_with_cycles(256)
    made.use_transparent_shadow = False
    assert (agrees_with_cycles(512).mean((0, 1)) < (1.01 if lit == "sky" else 0.97) * clear.mean((0, 1)))[:3].all()


@pytest.mark.parametrize("roughness", [0.5, 1.0])
def test_bump_map_correction(sheet, agrees_with_cycles, add, file, roughness):
    """Without it, bumps are brighter where light grazes the surface. Glossy ones keep normals that mirror the view into
    the surface."""
    made, node = sheet
    tree = made.node_tree
    place, noise = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeTexNoise")
    centred, tilted = (tree.nodes.new("ShaderNodeVectorMath") for _ in range(2))
    noise.inputs["Scale"].default_value = 1.5
    centred.operation, centred.inputs[1].default_value = "MULTIPLY_ADD", (4.0, 4.0, 2.0)
    centred.inputs[2].default_value = (-2.0, -2.0, -1.0)
    for source, socket in (
        (place.outputs["Position"], noise.inputs["Vector"]),
        (noise.outputs["Color"], centred.inputs[0]),
        (centred.outputs[0], tilted.inputs[0]),
        (place.outputs["Normal"], tilted.inputs[1]),
        (tilted.outputs[0], node.inputs["Normal"]),
    ):
        tree.links.new(source, socket)
    node.inputs["Roughness"].default_value = roughness
    if roughness < 1.0:
        node.inputs["Metallic"].default_value = 1.0
    else:
        node.inputs["Specular IOR Level"].default_value = 0.0
    bpy.data.objects["Floor"].data.materials[0] = made
    bpy.data.objects["Mirror"].hide_render = True
    file.scene.cycles.max_bounces = 1
    light(add, "AREA", (-2.0, -1.0, 2.6), 150.0, size=2.0)
    light(add, "AREA", (2.5, -2.5, 0.6), 150.0, size=0.5)
    bpy.data.objects["Area.001"].rotation_euler = 1.4, 0.0, 0.8
    samples = 4096 if roughness < 1.0 else 512  # Cycles' metal is noisy: 1.4 % with 512
    corrected = agrees_with_cycles(samples)
    made.cycles.use_bump_map_correction = False
    assert np.abs(agrees_with_cycles(samples).mean((0, 1)) / corrected.mean((0, 1)) - 1.0)[:3].min() > 0.02
