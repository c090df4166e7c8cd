# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Volume socket of materials and worlds, as sync reads it."""

import bpy
import numpy as np
import pytest

from sdf_lights.graph.formula import VARIABLE, order
from sdf_lights.render.scene import Ray
from tests.blender.node_trees import new


@pytest.fixture
def medium(file, synced):
    """Function: the medium that ``build(tree) -> output socket`` makes of the world, and the scene."""

    def run(build):
        world = bpy.data.worlds.new("Air")
        world.use_nodes = True
        output = world.node_tree.get_output_node("CYCLES")
        world.node_tree.links.new(build(world.node_tree), output.inputs["Volume"])
        file.scene.world = world
        scene = synced()
        return scene.world.medium, scene

    return run


def close(value, *numbers):
    np.testing.assert_allclose(value, numbers, rtol=1e-6, atol=1e-7)


def test_principled_volume(medium):
    found, scene = medium(
        lambda tree: new(
            tree,
            "ShaderNodeVolumePrincipled",
            Color=(0.5, 0.8, 1.0, 1.0),
            Density=0.2,
            Anisotropy=0.3,
            Absorption_Color=(0.25, 0.0, 0.0, 1.0),
            Emission_Strength=2.0,
            Emission_Color=(1.0, 0.5, 0.0, 1.0),
        ).outputs[0]
    )
    [part] = found.scattering
    close(part.coefficient, 0.1, 0.16, 0.2)
    assert part.g == pytest.approx(0.3) and part.alpha == 0.0
    close(found.absorption, 0.2 * 0.5 * 0.5, 0.2 * 0.2, 0.0)
    close(found.emission, 2.0, 1.0, 0.0)
    assert scene.warnings == []


def test_scatter_absorption_and_emission_add_up_through_groups_and_maths(medium):
    def build(tree):
        inner = bpy.data.node_groups.new("Fog", "ShaderNodeTree")
        inner.interface.new_socket("Density", in_out="INPUT", socket_type="NodeSocketFloat")
        inner.interface.new_socket("Volume", in_out="OUTPUT", socket_type="NodeSocketShader")
        start, end = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
        mix = inner.nodes.new("ShaderNodeMixShader")
        mix.inputs["Fac"].default_value = 0.25
        for place, kind in ((1, "ShaderNodeVolumeScatter"), (2, "ShaderNodeVolumeAbsorption")):
            node = new(inner, kind, Color=(0.5, 0.25, 1.0, 1.0))
            inner.links.new(start.outputs["Density"], node.inputs["Density"])
            inner.links.new(node.outputs[0], mix.inputs[place])
        inner.links.new(mix.outputs[0], end.inputs["Volume"])
        group, add = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeAddShader")
        group.node_tree, group.inputs["Density"].default_value = inner, 4.0
        emission = new(tree, "ShaderNodeEmission", Color=(1.0, 0.0, 0.5, 1.0), Strength=0.5)
        tree.links.new(group.outputs[0], add.inputs[0])
        tree.links.new(emission.outputs[0], add.inputs[1])
        return add.outputs[0]

    found, scene = medium(build)
    [part] = found.scattering
    close(part.coefficient, 0.75 * 2.0, 0.75, 0.75 * 4.0)
    close(found.absorption, 0.25 * 2.0, 0.25 * 3.0, 0.0)
    close(found.emission, 0.5, 0.0, 0.25)


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        (dict(phase="RAYLEIGH"), [(0.0, 1.0)]),
        (dict(phase="DRAINE", Anisotropy=0.4, Alpha=0.7), [(0.4, 0.7)]),
        (dict(Anisotropy=1.0), [(0.999, 0.0)]),
    ],
    ids=["Rayleigh", "Draine", "limit"],
)
def test_phase_functions(medium, settings, expected):
    found, scene = medium(lambda tree: new(tree, "ShaderNodeVolumeScatter", **settings).outputs[0])
    assert [(pytest.approx(g), pytest.approx(alpha)) for g, alpha in expected] == [
        (part.g, part.alpha) for part in found.scattering
    ]
    assert scene.warnings == []


def test_mie_is_a_mixture_and_fournier_forand_is_told(medium):
    found, scene = medium(lambda tree: new(tree, "ShaderNodeVolumeScatter", phase="MIE", Diameter=20.0).outputs[0])
    assert len(found.scattering) == 2 and scene.warnings == []
    close(sum(np.array(part.coefficient) for part in found.scattering), 0.8, 0.8, 0.8)
    found, scene = medium(lambda tree: new(tree, "ShaderNodeVolumeScatter", phase="FOURNIER_FORAND").outputs[0])
    [part] = found.scattering
    assert 0.7 < part.g < 0.95  # water sends light forward
    [warning] = scene.warnings
    assert "Fournier-Forand" in warning and "'Air" in warning


@pytest.mark.parametrize("kind", ["ShaderNodeValToRGB", "ShaderNodeRGBCurve", "ShaderNodeWavelength"])
def test_ramps_and_curves_of_constants_are_constants(medium, kind):
    def build(tree):
        node, volume = new(tree, kind), new(tree, "ShaderNodeVolumeScatter")
        for socket in node.inputs:
            value = {"Wavelength": 600.0}.get(socket.name, 0.25)
            socket.default_value = value if socket.type == "VALUE" else (value,) * 4
        tree.links.new(node.outputs["Color"], volume.inputs["Color"])
        return volume.outputs[0]

    found, scene = medium(build)
    [part] = found.scattering
    expected = (0.25, 0.25, 0.25)
    if kind == "ShaderNodeWavelength":
        assert part.coefficient[0] > part.coefficient[1] > part.coefficient[2]
    else:
        np.testing.assert_allclose(part.coefficient, expected, atol=1e-5)
    assert scene.warnings == []


def test_colours_and_numbers_glow_where_a_shader_is_expected(medium):
    def build(tree):
        color, number = tree.nodes.new("ShaderNodeRGB"), tree.nodes.new("ShaderNodeValue")
        color.outputs[0].default_value, number.outputs[0].default_value = (0.25, 0.5, -1.0, 1.0), 2.0
        mix, add = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeAddShader")
        mix.inputs[0].default_value = 0.25
        tree.links.new(color.outputs[0], mix.inputs[1])
        tree.links.new(number.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], add.inputs[0])
        tree.links.new(new(tree, "ShaderNodeVolumeAbsorption", Color=(0.0, 0.0, 0.0, 1.0)).outputs[0], add.inputs[1])
        return add.outputs[0]

    found, scene = medium(build)
    close(found.emission, 0.25 * 0.75 + 0.5, 0.5 * 0.75 + 0.5, 0.5)
    assert scene.warnings == []


def test_coefficients(medium):
    if not hasattr(bpy.types, "ShaderNodeVolumeCoefficients"):
        pytest.skip("this Blender has no such node")
    found, _ = medium(
        lambda tree: new(
            tree,
            "ShaderNodeVolumeCoefficients",
            Absorption_Coefficients=(0.1, 0.2, 0.3),
            Scatter_Coefficients=(0.4, 0.5, 0.6),
            Emission_Coefficients=(0.7, 0.8, 0.9),
            Anisotropy=-0.5,
        ).outputs[0]
    )
    close(found.absorption, 0.1, 0.2, 0.3)
    [part] = found.scattering
    close(part.coefficient, 0.4, 0.5, 0.6)
    assert part.g == -0.5
    close(found.emission, 0.7, 0.8, 0.9)


def test_what_varies_has_formulas_and_a_mean(medium):
    def build(tree):
        node, geometry = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeNewGeometry")
        tree.links.new(geometry.outputs["Position"], node.inputs["Density"])
        return node.outputs[0]

    found, scene = medium(build)
    np.testing.assert_allclose(found.scattering[0].coefficient, 0.8 * 0.5, rtol=0.02)  # of a cube of one metre
    [color] = found.varying.scattering
    assert all(node.value[0] == "position" for node in order(*color) if node.kind == VARIABLE)
    assert scene.warnings == []


def test_a_phase_function_that_varies_is_its_mean(medium):
    def build(tree):
        node, geometry = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeNewGeometry")
        tree.links.new(geometry.outputs["Position"], node.inputs["Anisotropy"])
        return node.outputs[0]

    found, scene = medium(build)
    assert found.varying is None and found.scattering[0].g == pytest.approx(0.5, rel=0.02)
    [warning] = scene.warnings
    assert "Anisotropy of its phase function" in warning and "'Air'" in warning and "mix two nodes" in warning


def test_a_world_that_glows_without_end_is_told(medium):
    found, scene = medium(lambda tree: new(tree, "ShaderNodeEmission").outputs[0])
    assert found is None and any("would be infinite" in warning for warning in scene.warnings)


def test_a_material_with_only_a_volume_is_transparent(synced, add, quad, material):
    made, tree, output = material()
    node = new(tree, "ShaderNodeVolumeAbsorption", Color=(0.0, 0.5, 1.0, 1.0), Density=2.0)
    tree.links.new(node.outputs[0], output.node.inputs["Volume"])
    data = quad()
    data.materials.append(made)
    add("Quad", data)
    scene = synced()
    found = scene.materials[scene.instances[0].materials[0]]
    assert found.surface.kind == "transparent" and scene.warnings == []
    close(found.medium.absorption, 2.0, 1.0, 0.0)


def test_lights_may_leave_volumes_dark(synced, add):
    light = bpy.data.lights.new("Light", "POINT")
    obj = add("Light", light)
    obj.visible_volume_scatter, obj.visible_camera = False, True
    assert synced().lights[0].visibility == Ray.ALL & ~Ray.VOLUME


def test_bounces_reach_the_settings(file, synced):
    assert synced().settings.volume_bounces == 0
    file.scene.sdf_lights.volume_bounces = 3
    assert synced().settings.volume_bounces == 3


@pytest.mark.parametrize("temperature", [700.0, 1500.0, 9000.0])
def test_a_black_body_takes_away_what_is_out_of_gamut_as_in_cycles(file, render, material, temperature):
    made, tree, surface = material()
    node = tree.nodes.new("ShaderNodeVolumePrincipled")
    for key, value in {"Density": 0.0, "Blackbody Intensity": 1.0, "Temperature": temperature}.items():
        node.inputs[key].default_value = value
    tree.links.new(node.outputs[0], surface.node.inputs["Volume"])
    bpy.ops.mesh.primitive_cube_add(size=2.0, scale=(9.0, 1.0, 9.0))
    bpy.context.object.data.materials.append(made)
    world = bpy.data.worlds.new("Grey")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = 0.1, 0.1, 0.1, 1.0
    file.scene.world, file.scene.render.film_transparent = world, False
    ours, theirs = (picture[6:10, 10:14, :3].mean((0, 1)) for picture in render(16))
    assert (theirs[2] < 0.1) == (temperature < 2000.0)  # blue is out of gamut
    assert ours == pytest.approx(theirs, rel=1e-3)
