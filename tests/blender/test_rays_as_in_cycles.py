# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes, holdouts and volumes see of rays that are not the camera's: the same as in Cycles."""

import bpy
import pytest

from sdf_lights.blender.shader_trees import node_tree_of, use_nodes

from .test_faces_as_in_cycles import assert_means_agree

pytest.importorskip("_cycles")


@pytest.fixture
def corner(file, add, quad, material):
    """Function: a floor and a wall, grey and diffuse."""

    def run():
        made, tree, output = material()
        tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], output)
        mesh = quad()
        mesh.materials.append(made)
        add("Floor", mesh, scale=(4.0, 4.0, 1.0), location=(0.0, 0.0, -0.8))
        add("Wall", mesh, scale=(4.0, 4.0, 1.0), location=(0.0, 1.5, 0.0), rotation=(1.5708, 0.0, 0.0))

    return run


def cube(size: float = 1.6) -> bpy.types.Mesh:
    bpy.ops.mesh.primitive_cube_add(size=size)
    mesh = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    return mesh


def area(add, **settings) -> bpy.types.AreaLight:
    light = bpy.data.lights.new("Area", "AREA")
    light.energy, light.size = 120.0, 1.5
    for name, value in settings.items():
        setattr(light, name, value)
    add("Area", light, location=(0.5, -1.0, 3.0), rotation=(0.3, 0.2, 0.5), scale=(1.0, 1.4, 0.7))
    return light


@pytest.mark.parametrize("linked", [True, False])
def test_generated_coordinates_of_lights_are_those_of_their_object(render, corner, add, linked):
    corner()
    light = area(add)
    use_nodes(light)
    tree = node_tree_of(light)
    emission = next(node for node in tree.nodes if node.type == "EMISSION")
    texture = tree.nodes.new("ShaderNodeTexMagic")
    texture.inputs["Scale"].default_value = 3.0
    if linked:
        coordinates = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(coordinates.outputs["Generated"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    ours, theirs = render(256)
    assert_means_agree(ours, theirs)
    assert ours[..., :3].mean((0, 1)) == pytest.approx(theirs[..., :3].mean((0, 1)), rel=0.02)


def test_other_objects_see_a_holdout(render, corner, add, material):
    corner()
    area(add)
    made, tree, output = material()
    bsdf = tree.nodes.new("ShaderNodeBsdfDiffuse")
    bsdf.inputs["Color"].default_value = (1.0, 0.0, 0.0, 1.0)
    tree.links.new(bsdf.outputs[0], output)
    mesh = cube()
    mesh.materials.append(made)
    add("Held out", mesh, rotation=(0.0, 0.0, 0.6)).is_holdout = True
    ours, theirs = render(512)
    assert_means_agree(ours, theirs)
    red, green = ours[..., 0].mean(), ours[..., 1].mean()
    assert red > 1.05 * green  # the red of the box reaches the floor
    assert (ours[..., 3] == 0.0).any()


def test_sampled_light_knows_how_often_its_path_has_scattered(render, corner, add, material):
    corner()
    made, tree, surface = material()
    path, emission = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    tree.links.new(path.outputs["Ray Depth"], emission.inputs["Strength"])
    tree.links.new(emission.outputs[0], surface)
    mesh = cube(1.0)
    mesh.materials.append(made)
    add("Box", mesh, rotation=(0.0, 0.0, 0.6))
    assert_means_agree(*render(512), most=0.02)


def test_a_volume_in_a_smooth_opaque_box_is_not_seen(render, corner, add, material):
    area(add)
    made, tree, surface = material()
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], surface)
    mesh = cube()
    mesh.shade_smooth()
    mesh.materials.append(made)
    add("Box", mesh, rotation=(0.5, 0.0, 0.6))
    plain, _ = render(64)
    volume = tree.nodes.new("ShaderNodeVolumeAbsorption")
    volume.inputs["Density"].default_value = 5.0
    tree.links.new(volume.outputs[0], surface.node.inputs["Volume"])
    ours, theirs = render(64)
    assert_means_agree(ours, theirs)
    assert_means_agree(ours, plain)


def test_a_sun_without_shadows_shines_through_fog(file, render, corner, add):
    corner()
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.use_shadow = 3.0, False
    add("Sun", sun, rotation=(0.5, 0.3, 0.0))
    world = file.scene.world = bpy.data.worlds.new("World")
    use_nodes(world)
    tree = node_tree_of(world)
    tree.nodes.clear()
    volume, output = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputWorld")
    volume.inputs["Density"].default_value = 0.05
    tree.links.new(volume.outputs[0], output.inputs["Volume"])
    assert_means_agree(*render(256))


@pytest.mark.parametrize("seen", ["visible_diffuse", "visible_glossy"])
def test_velvet_is_glossy_to_lights(render, corner, add, material, seen):
    light = area(add)
    made, tree, surface = material()
    sheen = tree.nodes.new("ShaderNodeBsdfSheen")
    sheen.distribution = "ASHIKHMIN"
    tree.links.new(sheen.outputs[0], surface)
    mesh = cube()
    mesh.materials.append(made)
    add("Box", mesh, rotation=(0.5, 0.0, 0.6))
    obj = next(each for each in bpy.data.objects if each.data == light)
    obj.visible_camera = False
    setattr(obj, seen, False)
    ours, theirs = render(4096)  # directions are drawn uniformly, which is noisy
    if seen == "visible_diffuse":
        assert_means_agree(ours, theirs, most=0.02)
    else:
        assert ours[..., :3].max() < 1e-2
