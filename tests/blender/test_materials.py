# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of materials and worlds, as sync reads them."""

import bpy
import mathutils
import numpy as np
import pytest

from sdf_lights.render.material import NODES


@pytest.fixture
def surface(synced, add, quad, material):
    """Function: builds a material with ``build(tree) -> output socket`` on a quad; returns (its surface, scene)."""

    def run(build):
        made, tree, output = material()
        socket = build(tree)
        if socket is not None:
            tree.links.new(socket, output)
        data = quad()
        data.materials.append(made)
        add("Quad", data)
        scene = synced()
        return scene.materials[scene.instances[0].materials[0]].surface, scene

    return run


def new(tree, kind: str, **values):
    """A node with values of its sockets by identifier (``_`` for a space), or with settings."""
    node = tree.nodes.new(kind)
    for name, value in values.items():
        socket = next((socket for socket in node.inputs if socket.identifier == name.replace("_", " ")), None)
        if socket is None:
            setattr(node, name, value)
        else:
            socket.default_value = value
    return node


def test_principled_has_every_input(surface):
    def build(tree):
        return new(
            tree, "ShaderNodeBsdfPrincipled", Base_Color=(0.1, 0.2, 0.3, 1.0), Metallic=0.25, Roughness=0.75, IOR=1.75,
            Alpha=0.5, Diffuse_Roughness=0.125, Specular_IOR_Level=0.625, Specular_Tint=(0.5, 1.0, 0.5, 1.0),
            Transmission_Weight=0.375,
            Coat_Weight=0.5, Coat_Roughness=0.25, Coat_IOR=1.25, Coat_Tint=(1.0, 0.5, 1.0, 1.0), Sheen_Weight=0.75,
            Sheen_Roughness=0.25, Sheen_Tint=(0.25, 0.5, 1.0, 1.0), Emission_Color=(1.0, 0.0, 0.5, 1.0),
            Emission_Strength=2.0,
        ).outputs["BSDF"]

    node, scene = surface(build)
    assert node.kind == "principled" and scene.warnings == []
    expected = dict(
        base_color=(0.1, 0.2, 0.3), metallic=0.25, roughness=0.75, ior=1.75, alpha=0.5, diffuse_roughness=0.125,
        specular_ior_level=0.625, specular_tint=(0.5, 1.0, 0.5), transmission_weight=0.375, coat_weight=0.5,
        coat_roughness=0.25,
        coat_ior=1.25, coat_tint=(1.0, 0.5, 1.0), sheen_weight=0.75, sheen_roughness=0.25, sheen_tint=(0.25, 0.5, 1.0),
        emission_color=(1.0, 0.0, 0.5), emission_strength=2.0)
    assert set(expected) | {"normal", "coat_normal"} == set(NODES["principled"])
    for name, value in expected.items():
        assert node[name] == pytest.approx(value), name
    assert node["normal"] is None and node["coat_normal"] is None


@pytest.mark.parametrize(("name", "kind"), [
    ("Diffuse", "diffuse"), ("Anisotropic", "glossy"), ("Glass", "glass"), ("Refraction", "refraction"),
    ("Transparent", "transparent"), ("Translucent", "translucent")])
def test_closures(surface, name, kind):
    node, scene = surface(
        lambda tree: new(tree, f"ShaderNodeBsdf{name}", Color=(0.5, 0.25, 0.125, 1.0)).outputs["BSDF"])
    assert node.kind == kind and node["color"] == (0.5, 0.25, 0.125) and scene.warnings == []


def test_mix_and_add(surface):
    def build(tree):
        emission = new(tree, "ShaderNodeEmission", Strength=3.0)
        mix = new(tree, "ShaderNodeMixShader", Fac=0.25)
        add = new(tree, "ShaderNodeAddShader")
        tree.links.new(new(tree, "ShaderNodeHoldout").outputs[0], mix.inputs[1])
        tree.links.new(emission.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], add.inputs[0])
        tree.links.new(emission.outputs[0], add.inputs[1])
        return add.outputs[0]

    node, scene = surface(build)
    assert node.kind == "add_closure" and node["a"].kind == "mix_closure" and scene.warnings == []
    assert node["a"]["factor"] == 0.25 and node["a"]["a"].kind == "holdout"
    assert node["a"]["b"] is node["b"]  # one node stays one
    assert node["b"]["strength"] == 3.0


def test_constants_convert_as_between_sockets(surface):
    def build(tree):
        bsdf = new(tree, "ShaderNodeBsdfDiffuse")
        value, color = tree.nodes.new("ShaderNodeValue"), tree.nodes.new("ShaderNodeRGB")
        value.outputs[0].default_value, color.outputs[0].default_value = 0.25, (0.0, 1.0, 0.0, 1.0)
        tree.links.new(value.outputs[0], bsdf.inputs["Color"])
        tree.links.new(color.outputs[0], bsdf.inputs["Roughness"])
        return bsdf.outputs[0]

    node, _ = surface(build)
    assert node["color"] == (0.25, 0.25, 0.25)
    assert node["roughness"] == pytest.approx(0.7152)


def test_groups_reroutes_and_muted_nodes_dissolve(surface):
    def build(tree):
        inner = bpy.data.node_groups.new("Paint", "ShaderNodeTree")
        inner.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
        inner.interface.new_socket("Other", in_out="INPUT", socket_type="NodeSocketFloat")
        inner.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        start, end = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
        bsdf, reroute = inner.nodes.new("ShaderNodeBsdfDiffuse"), inner.nodes.new("NodeReroute")
        inner.links.new(start.outputs["Tint"], reroute.inputs[0])
        inner.links.new(reroute.outputs[0], bsdf.inputs["Color"])
        inner.links.new(start.outputs["Other"], bsdf.inputs["Roughness"])
        inner.links.new(bsdf.outputs[0], end.inputs["Shader"])
        groups = []
        for tint in ((1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)):
            group = tree.nodes.new("ShaderNodeGroup")
            group.node_tree = inner
            group.inputs["Other"].default_value = 0.5
            group.inputs["Tint"].default_value = tint
            groups.append(group)
        color, muted = tree.nodes.new("ShaderNodeRGB"), tree.nodes.new("ShaderNodeGamma")
        color.outputs[0].default_value = (0.0, 1.0, 0.0, 1.0)
        muted.mute = True
        tree.links.new(color.outputs[0], muted.inputs["Color"])
        tree.links.new(muted.outputs[0], groups[0].inputs["Tint"])
        add = tree.nodes.new("ShaderNodeAddShader")
        for i, group in enumerate(groups):
            tree.links.new(group.outputs[0], add.inputs[i])
        return add.outputs[0]

    node, scene = surface(build)
    assert scene.warnings == []
    assert node["a"]["color"] == (0.0, 1.0, 0.0) and node["b"]["color"] == (0.0, 0.0, 1.0)
    assert node["a"]["roughness"] == 0.5


def test_an_unsupported_node_is_reported_once_and_replaced(surface):
    def build(tree):
        bsdf = new(tree, "ShaderNodeBsdfDiffuse", Color=(0.5, 0.25, 0.125, 1.0), Roughness=0.75)
        noise = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(noise.outputs["Color"], bsdf.inputs["Color"])
        tree.links.new(noise.outputs["Color"], bsdf.inputs["Roughness"])
        hair = new(tree, "ShaderNodeSubsurfaceScattering", Color=(0.1, 0.2, 0.3, 1.0))
        mix = tree.nodes.new("ShaderNodeMixShader")
        tree.links.new(bsdf.outputs[0], mix.inputs[1])
        tree.links.new(hair.outputs[0], mix.inputs[2])
        tree.links.new(noise.outputs[0], mix.inputs[0])
        return mix.outputs[0]

    node, scene = surface(build)
    assert node["a"]["color"] == (0.5, 0.25, 0.125) and node["a"]["roughness"] == 0.75 and node["factor"] == 0.5
    assert node["b"].kind == "diffuse" and node["b"]["color"] == pytest.approx((0.1, 0.2, 0.3))
    assert len(scene.warnings) == 2 and all("Material 'Material'" in warning for warning in scene.warnings)
    assert sum("'Noise Texture'" in warning for warning in scene.warnings) == 1
    assert sum("'Subsurface Scattering'" in warning for warning in scene.warnings) == 1


def test_unsupported_inputs_are_reported_only_where_they_matter(surface):
    node, scene = surface(
        lambda tree: new(tree, "ShaderNodeBsdfPrincipled", Subsurface_Weight=0.5).outputs["BSDF"])
    [warning] = scene.warnings
    assert "Subsurface Weight" in warning and "'Principled BSDF'" in warning


def test_without_nodes(synced, add, quad):
    made = bpy.data.materials.new("Plain")
    made.use_nodes, made.diffuse_color = False, (0.1, 0.2, 0.3, 1.0)
    data = quad()
    data.materials.append(made)
    if made.use_nodes:
        pytest.skip("this Blender has no materials without nodes")
    add("Quad", data)
    node = synced().materials[0].surface
    assert node.kind == "diffuse" and node["color"] == pytest.approx((0.1, 0.2, 0.3))


def test_nothing_linked_and_no_output(surface, synced):
    node, scene = surface(lambda tree: None)
    assert node is None and scene.warnings == []
    bpy.data.materials[0].node_tree.nodes.clear()
    scene = synced()
    assert scene.materials[0].surface is None
    assert "no Material Output" in scene.warnings[0] and "'Material'" in scene.warnings[0]


def test_displacement_and_volume_are_named(synced, add, quad, material):
    made, tree, _ = material("Deep")
    output = tree.nodes["Material Output"]
    tree.links.new(tree.nodes.new("ShaderNodeVolumeScatter").outputs[0], output.inputs["Volume"])
    tree.links.new(tree.nodes.new("ShaderNodeDisplacement").outputs[0], output.inputs["Displacement"])
    data = quad()
    data.materials.append(made)
    add("Quad", data)
    warnings = synced().warnings
    assert len(warnings) == 2 and all("'Deep'" in warning for warning in warnings)


def test_textures_bring_their_coordinates(surface):
    def build(tree):
        image = bpy.data.images.new("Image", 2, 2, alpha=True)
        bsdf = new(tree, "ShaderNodeBsdfPrincipled")
        texture = new(tree, "ShaderNodeTexImage", image=image, interpolation="Closest", extension="CLIP")
        mapping = new(tree, "ShaderNodeMapping", vector_type="TEXTURE", Scale=(2.0, 3.0, 4.0))
        tree.links.new(new(tree, "ShaderNodeUVMap", uv_map="UVMap").outputs[0], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
        tree.links.new(texture.outputs["Color"], bsdf.inputs["Base Color"])
        tree.links.new(texture.outputs["Alpha"], bsdf.inputs["Alpha"])
        plain = new(tree, "ShaderNodeTexImage", image=image)
        normal = new(tree, "ShaderNodeNormalMap", Strength=0.5)
        bump = new(tree, "ShaderNodeBump", invert=True, Distance=0.25)
        tree.links.new(plain.outputs["Color"], normal.inputs["Color"])
        tree.links.new(normal.outputs[0], bump.inputs["Normal"])
        tree.links.new(plain.outputs["Color"], bump.inputs["Height"])
        tree.links.new(bump.outputs[0], bsdf.inputs["Normal"])
        return bsdf.outputs[0]

    node, scene = surface(build)
    assert scene.warnings == [] and len(scene.images) == 2
    color, alpha, bump = node["base_color"], node["alpha"], node["normal"]
    assert color.settings == dict(
        image=0, interpolation="Closest", extension="CLIP", projection="FLAT", output="color")
    assert alpha.settings["output"] == "alpha" and alpha.settings["image"] == 0
    assert bump["normal"]["color"].settings["image"] == 1  # nothing asks for its alpha: colour comes multiplied by it
    assert color["vector"].kind == "mapping" and color["vector"].settings["type"] == "TEXTURE"
    assert color["vector"]["scale"] == (2.0, 3.0, 4.0)
    assert color["vector"]["vector"].settings["uv_map"] == "UVMap"
    assert bump.kind == "bump" and bump.settings["invert"] and bump["distance"] == 0.25
    assert bump["normal"].kind == "normal_map" and bump["normal"]["strength"] == 0.5
    mesh = scene.meshes[0]
    corners = mesh.positions[mesh.triangles][..., :2]
    for name in ("", "UVMap"):
        assert mesh.uvs[name] == pytest.approx(0.5 * corners + 0.5)
    assert mesh.tangents[""] == pytest.approx(np.broadcast_to([1.0, 0.0, 0.0, 1.0], (2, 3, 4)), abs=1e-6)


def test_tangents_of_faces_with_many_corners(synced, add, material):
    made, tree, output = material()
    bsdf, normal = new(tree, "ShaderNodeBsdfDiffuse"), new(tree, "ShaderNodeNormalMap")
    tree.links.new(normal.outputs[0], bsdf.inputs["Normal"])
    tree.links.new(bsdf.outputs[0], output)
    angles = np.linspace(0, 2 * np.pi, 5, endpoint=False)
    corners = np.stack([np.cos(angles), np.sin(angles)], -1)
    mesh = bpy.data.meshes.new("Pentagon")
    mesh.from_pydata([(x, y, 0.0) for x, y in corners], [], [range(5)])
    mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", (corners * [-1.0, 1.0]).ravel())  # mirrored in u
    mesh.materials.append(made)
    add("Pentagon", mesh)
    tangents = synced().meshes[0].tangents[""]
    assert tangents == pytest.approx(np.broadcast_to([-1.0, 0.0, 0.0, -1.0], (3, 3, 4)), abs=1e-6)


def test_meshes_without_uv_maps(synced, add, quad, material):
    made, tree, output = material()
    tree.links.new(new(tree, "ShaderNodeTexImage", image=bpy.data.images.new("Image", 1, 1)).outputs[0], output)
    data = quad()
    data.uv_layers.remove(data.uv_layers[0])
    data.materials.append(made)
    add("Quad", data)
    scene = synced()
    assert scene.meshes[0].uvs == {} and scene.materials[0].surface.kind == "image" and scene.warnings == []


# -- world -------------------------------------------------------------------------------------------------------------


@pytest.fixture
def world(file, synced):
    """Function: a world with ``build(tree, background)``; returns the synced scene."""

    def run(build):
        made = bpy.data.worlds.new("World")
        made.use_nodes = True
        made.node_tree.nodes.clear()
        output = made.node_tree.nodes.new("ShaderNodeOutputWorld")
        background = new(made.node_tree, "ShaderNodeBackground", Color=(0.5, 0.25, 0.125, 1.0), Strength=2.0)
        made.node_tree.links.new(background.outputs[0], output.inputs["Surface"])
        file.scene.world = made
        build(made.node_tree, background)
        return synced()

    return run


def test_no_world_is_black(synced):
    assert synced().world.color == (0.0, 0.0, 0.0)


def test_world_colour(world):
    found = world(lambda tree, background: None).world
    assert (found.color, found.strength, found.image) == ((0.5, 0.25, 0.125), 2.0, None)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE"])
def test_environment_texture(world, kind):
    angles = (0.1, 0.2, 0.7)

    def build(tree, background):
        texture = new(tree, "ShaderNodeTexEnvironment", image=bpy.data.images.new("Sky", 4, 2, float_buffer=True))
        mapping = new(tree, "ShaderNodeMapping", vector_type=kind, Rotation=angles)
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
        tree.links.new(texture.outputs[0], background.inputs["Color"])

    scene = world(build)
    assert scene.warnings == []
    assert scene.images[scene.world.image].name == "Sky" and scene.world.strength == 2.0
    expected = np.array(mathutils.Euler(angles).to_matrix())
    assert scene.world.rotation == pytest.approx(expected.T if kind == "TEXTURE" else expected, abs=1e-6)


def test_world_that_is_not_understood(world):
    def build(tree, background):
        tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], background.inputs["Color"])

    scene = world(build)
    assert scene.world.color == (0.5, 0.25, 0.125)
    assert len(scene.warnings) == 1 and "World 'World'" in scene.warnings[0]
