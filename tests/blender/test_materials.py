# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of materials and worlds, as sync reads them."""

import bpy
import mathutils
import numpy as np
import pytest

from sdf_lights.graph.formula import CALL, Vector, order
from sdf_lights.render.material import NODES, Attribute
from sdf_lights.render.reference.nodes import Graph
from tests.blender.node_trees import new


@pytest.fixture
def surface(synced, add, quad, material):
    """Function: builds a material with ``build(tree) -> output socket`` on a quad; returns (its surface, with numbers
    for what is constant, and the scene)."""

    def run(build):
        made, tree, output = material()
        socket = build(tree)
        if socket is not None:
            tree.links.new(socket, output)
        data = quad()
        data.materials.append(made)
        add("Quad", data)
        scene = synced()
        return Graph(scene.materials[scene.instances[0].materials[0]]).surface, scene

    return run


def test_principled_has_every_input(surface):
    def build(tree):
        return new(
            tree,
            "ShaderNodeBsdfPrincipled",
            Base_Color=(0.1, 0.2, 0.3, 1.0),
            Metallic=0.25,
            Roughness=0.75,
            IOR=1.75,
            Alpha=0.5,
            Diffuse_Roughness=0.125,
            Specular_IOR_Level=0.625,
            Specular_Tint=(0.5, 1.0, 0.5, 1.0),
            Transmission_Weight=0.375,
            Coat_Weight=0.5,
            Coat_Roughness=0.25,
            Coat_IOR=1.25,
            Coat_Tint=(1.0, 0.5, 1.0, 1.0),
            Sheen_Weight=0.75,
            Sheen_Roughness=0.25,
            Sheen_Tint=(0.25, 0.5, 1.0, 1.0),
            Emission_Color=(1.0, 0.0, 0.5, 1.0),
            Emission_Strength=2.0,
            Anisotropic=0.5,
            Anisotropic_Rotation=0.25,
            Thin_Film_Thickness=300.0,
            Thin_Film_IOR=1.5,
            Subsurface_Weight=0.625,
            Subsurface_Radius=(0.5, 0.25, 1.0),
            Subsurface_Scale=0.75,
            Subsurface_IOR=1.5,
            Subsurface_Anisotropy=0.125,
        ).outputs["BSDF"]

    node, scene = surface(build)
    assert node.kind == "principled" and scene.warnings == []
    expected = dict(
        base_color=(0.1, 0.2, 0.3),
        metallic=0.25,
        roughness=0.75,
        ior=1.75,
        alpha=0.5,
        diffuse_roughness=0.125,
        specular_ior_level=0.625,
        specular_tint=(0.5, 1.0, 0.5),
        transmission_weight=0.375,
        coat_weight=0.5,
        coat_roughness=0.25,
        coat_ior=1.25,
        coat_tint=(1.0, 0.5, 1.0),
        sheen_weight=0.75,
        sheen_roughness=0.25,
        sheen_tint=(0.25, 0.5, 1.0),
        emission_color=(1.0, 0.0, 0.5),
        emission_strength=2.0,
        anisotropic=0.5,
        anisotropic_rotation=0.25,
        thin_film_thickness=300.0,
        thin_film_ior=1.5,
        subsurface_weight=0.625,
        subsurface_radius=(0.5, 0.25, 1.0),
        subsurface_scale=0.75,
        subsurface_ior=1.5,
        subsurface_anisotropy=0.125,
    )
    others = {"normal", "coat_normal", "tangent", "thin_wall"}  # thin_wall: since Blender 5.2
    assert set(expected) | others == set(NODES["principled"])
    for name, value in expected.items():
        assert node[name] == pytest.approx(value), name
    assert node["normal"] is None and node["coat_normal"] is None
    assert node.settings["film_on_metal"] == (bpy.app.version >= (5, 0))


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("Diffuse", "diffuse"),
        ("Anisotropic", "glossy"),
        ("Glass", "glass"),
        ("Refraction", "refraction"),
        ("Transparent", "transparent"),
        ("Translucent", "translucent"),
    ],
)
def test_closures(surface, name, kind):
    node, scene = surface(
        lambda tree: new(tree, f"ShaderNodeBsdf{name}", Color=(0.5, 0.25, 0.125, 1.0)).outputs["BSDF"]
    )
    assert node.kind == kind and node["color"] == (0.5, 0.25, 0.125) and scene.warnings == []


def test_principled_hair(surface):
    def build(tree):
        return new(
            tree,
            "ShaderNodeBsdfHairPrincipled",
            model="HUANG",
            parametrization="MELANIN",
            Melanin=0.5,
            Aspect_Ratio=0.75,
            Roughness=0.25,
            TRT_lobe=0.5,
            Offset=0.125,
        ).outputs[0]

    node, scene = surface(build)
    assert node.kind == "principled_hair" and scene.warnings == []
    cut = {} if bpy.app.version >= (5, 0) else {"light_rays": "ALL"}
    assert node.settings == {"model": "HUANG", "parametrization": "MELANIN"} | cut
    expected = dict(melanin=0.5, aspect_ratio=0.75, roughness=0.25, trt_lobe=0.5, offset=0.125, r_lobe=1.0)
    assert {name: node[name] for name in expected} == pytest.approx(expected)
    assert set(node.inputs) | {"axis"} == set(NODES["principled_hair"])  # every one has a socket


def test_a_portal_without_links_leads_on(surface):
    node, scene = surface(lambda tree: new(tree, "ShaderNodeBsdfRayPortal", Color=(0.5, 0.25, 0.125, 1.0)).outputs[0])
    assert node.kind == "ray_portal" and node["color"] == (0.5, 0.25, 0.125) and scene.warnings == []
    assert node["position"] is None and node["direction"] is None


def test_shader_to_rgb_is_refused_by_name(surface):
    def build(tree):
        bsdf, shade = (
            new(tree, "ShaderNodeBsdfDiffuse", Color=(0.5, 0.25, 0.125, 1.0)),
            new(tree, "ShaderNodeShaderToRGB"),
        )
        tree.links.new(shade.outputs["Color"], bsdf.inputs["Color"])
        return bsdf.outputs[0]

    node, scene = surface(build)
    assert node["color"] == (0.5, 0.25, 0.125)
    (told,) = scene.warnings
    assert "'Shader to RGB'" in told and "EEVEE" in told


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
    assert node["roughness"] == pytest.approx(0.7152, rel=1e-4)


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
        stroke = tree.nodes.new("ShaderNodeUVAlongStroke")
        tree.links.new(stroke.outputs[0], bsdf.inputs["Color"])
        tree.links.new(stroke.outputs[0], bsdf.inputs["Roughness"])
        other = new(tree, "ShaderNodeEeveeSpecular", Base_Color=(0.1, 0.2, 0.3, 1.0))
        mix = tree.nodes.new("ShaderNodeMixShader")
        tree.links.new(bsdf.outputs[0], mix.inputs[1])
        tree.links.new(other.outputs[0], mix.inputs[2])
        tree.links.new(stroke.outputs[0], mix.inputs[0])
        return mix.outputs[0]

    node, scene = surface(build)
    assert node["a"]["color"] == (0.5, 0.25, 0.125) and node["a"]["roughness"] == 0.75 and node["factor"] == 0.5
    assert node["b"].kind == "diffuse" and node["b"]["color"] == pytest.approx((0.1, 0.2, 0.3))
    assert len(scene.warnings) == 2 and all("Material 'Material'" in warning for warning in scene.warnings)
    assert sum("'UV Along Stroke'" in warning for warning in scene.warnings) == 1
    assert sum("'Specular BSDF'" in warning for warning in scene.warnings) == 1


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


def test_links_in_a_circle(surface):
    """Not even beside what is shown, since Blender 5.0."""

    def build(tree):
        first, second = tree.nodes.new("ShaderNodeGamma"), tree.nodes.new("ShaderNodeGamma")
        tree.links.new(first.outputs[0], second.inputs[0])
        tree.links.new(second.outputs[0], first.inputs[0])
        return tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0]

    node, scene = surface(build)
    if bpy.app.version < (5, 0, 0):
        assert node.kind == "diffuse" and scene.warnings == []
    else:
        assert node is None
        assert scene.warnings == ["Material 'Material': its links form a circle, so it is black: remove one of them."]


def test_displacement_bumps_moves_vertices_or_both(synced, add, quad, material):
    made, tree, shown = material("Deep")
    output = shown.node
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], shown)
    tree.links.new(tree.nodes.new("ShaderNodeDisplacement").outputs[0], output.inputs["Displacement"])
    data = quad()
    data.materials.append(made)
    add("Quad", data)
    for method, moves, bumps in (("BUMP", False, True), ("DISPLACEMENT", True, False), ("BOTH", True, True)):
        made.displacement_method = method
        scene = synced()
        found = scene.materials[0]
        assert scene.warnings == []
        assert (found.displacement is not None, found.normal is not None) == (moves, bumps)


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
    assert scene.warnings == []
    assert isinstance(node["base_color"], Vector) and isinstance(node["normal"], Vector)
    calls = [formula.value.name for formula in order(*node["base_color"], node["alpha"]) if formula.kind == CALL]
    assert calls == ["attribute", "image"]  # colour and alpha are of one look-up
    wanted = {value for value in scene.materials[0].parameters if isinstance(value, Attribute)}
    assert wanted == {Attribute("uv", "UVMap"), Attribute("uv"), Attribute("tangent")}
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
    surface = scene.materials[0].surface
    assert scene.meshes[0].uvs == {} and surface.kind == "emission" and isinstance(surface["color"], Vector)
    assert scene.warnings == []


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
    assert (found.color, found.strength, found.image) == ((1.0, 0.5, 0.25), 1.0, None)


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


def test_nodes_of_the_world_that_vary_are_formulas(world):
    def build(tree, background):
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], background.inputs["Color"])

    scene = world(build)
    assert scene.warnings == [] and scene.world.color == (1.0, 1.0, 1.0)
    assert Graph(scene.world.emission).surface["strength"] == 2.0
