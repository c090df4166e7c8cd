# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair curves, particle hair and point clouds look as in Cycles."""

import bpy
import numpy as np
import pytest

pytest.importorskip("_cycles")

SHAPES = ["RIBBONS", "THICK", *(["THICK_LINEAR"] if bpy.app.version >= (5, 0, 0) else [])]


@pytest.fixture
def render(render, file):
    file.scene.render.resolution_x, file.scene.render.resolution_y = 48, 32
    file.camera.location = (0.0, -3.0, 0.5)
    return render


@pytest.fixture
def lit(file, add):
    """A sun, and a grey world."""
    world = bpy.data.worlds.new("World")
    file.scene.world, world.use_nodes = world, True
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.5, 0.6, 0.8, 1.0)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3.0, 0.05
    return add("Sun", sun, rotation=(0.6, 0.3, 0.0))


@pytest.fixture
def shaded(material):
    """Function: give data a material that ``build(tree)`` makes."""

    def run(data, build):
        made, tree, output = material(data.name)
        tree.links.new(build(tree), output)
        data.materials.append(made)
        return data

    return run


def hair(count: int = 150, points: int = 6, radius: float = 0.025) -> bpy.types.Curves:
    """Wavy strands that stand on the ground, thinner towards their tips."""
    random = np.random.default_rng(1)
    t = np.linspace(0.0, 1.0, points)[None, :, None]
    root = np.concatenate([random.uniform(-1.0, 1.0, (count, 2)) * (1.0, 0.4), np.zeros((count, 1))], 1)[:, None]
    bend = random.normal(0.0, 0.25, (count, 1, 3))
    wave = 0.06 * np.sin(6.0 * t + random.uniform(0.0, 6.0, (count, 1, 3))) * (1.0, 1.0, 0.0)
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([points] * count)
    data.points.foreach_set("position", (root + t * (0.0, 0.0, 1.0) + bend * t * t + wave).astype(np.float32).ravel())
    radii = np.broadcast_to(radius * (1.0 - 0.8 * t[..., 0]), (count, points))
    data.points.foreach_set("radius", radii.astype(np.float32).ravel())
    return data


def cloud(count: int = 60) -> bpy.types.PointCloud:
    random = np.random.default_rng(2)
    data = bpy.data.pointclouds.new("Cloud")
    if not hasattr(data, "resize"):
        pytest.skip("this Blender makes no point clouds from Python but by nodes")
    data.resize(count)
    places = random.uniform(-1.0, 1.0, (count, 3)) * (1.0, 0.5, 0.5) + (0.0, 0.0, 0.5)
    data.attributes["position"].data.foreach_set("vector", places.astype(np.float32).ravel())
    radii = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    radii.data.foreach_set("value", random.uniform(0.03, 0.15, count).astype(np.float32))
    return data


def diffuse(tree):
    return tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0]


def half_clear(tree):
    """Clearer towards the tips."""
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(tree.nodes.new("ShaderNodeHairInfo").outputs["Intercept"], mix.inputs[0])
    tree.links.new(diffuse(tree), mix.inputs[1])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[2])
    return mix.outputs[0]


def shown(*outputs: tuple[str, str], factor: float = 1.0):
    """Emission of three numbers, of outputs of nodes of these types; the same for a single one."""

    def build(tree):
        emission = tree.nodes.new("ShaderNodeEmission")
        emission.inputs["Strength"].default_value = factor
        if len(outputs) == 1:
            tree.links.new(tree.nodes.new(outputs[0][0]).outputs[outputs[0][1]], emission.inputs["Color"])
            return emission.outputs[0]
        together = tree.nodes.new("ShaderNodeCombineXYZ")
        for (kind, name), socket in zip(outputs, together.inputs):
            tree.links.new(tree.nodes.new(kind).outputs[name], socket)
        tree.links.new(together.outputs[0], emission.inputs["Color"])
        return emission.outputs[0]

    return build


def agree(ours: np.ndarray, theirs: np.ndarray, limit: float = 0.01) -> None:
    """Of the whole picture, and of its halves."""
    for part in (np.s_[:, :], np.s_[:, :24], np.s_[:, 24:]):
        assert ours[part].mean((0, 1)) == pytest.approx(theirs[part].mean((0, 1)), rel=limit, abs=1e-4)
    assert theirs[..., 3].mean() > 0.05


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (1.4, 0.8, 1.0)])
def test_hair_curves(file, add, lit, shaded, render, shape, scale):
    add("Hair", shaded(hair(), diffuse), rotation=(0.1, 0.2, 0.3), scale=scale)
    file.scene.cycles_curves.shape = shape
    agree(*render(64))


def test_ribbons_that_are_clear(file, add, lit, shaded, render):
    add("Hair", shaded(hair(), half_clear))
    file.scene.cycles_curves.shape = "RIBBONS"
    agree(*render(128))


@pytest.mark.parametrize("shape", SHAPES[:2])
def test_hair_info(file, add, shaded, render, shape):
    kind = "ShaderNodeHairInfo"
    data = shaded(hair(), shown((kind, "Intercept"), (kind, "Length"), (kind, "Random")))
    add("Hair", data, scale=(1.0, 0.7, 1.2))
    file.scene.cycles_curves.shape = shape
    agree(*render(64))
    data.materials.clear()
    shaded(data, shown((kind, "Is Strand"), (kind, "Thickness")))
    agree(*render(64))
    data.materials.clear()
    shaded(data, shown((kind, "Tangent Normal"), factor=-1.0))
    agree(*(np.abs(picture) for picture in render(64)), 0.02)


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (1.4, 0.8, 1.0)])
def test_point_clouds(file, add, lit, shaded, render, scale):
    add("Cloud", shaded(cloud(), diffuse), rotation=(0.1, 0.2, 0.3), scale=scale)
    agree(*render(96))


def test_points_that_nodes_make(file, add, lit, shaded, render):
    """Of the vertices of a mesh, which is gone then."""
    random = np.random.default_rng(3)
    mesh = bpy.data.meshes.new("Places")
    mesh.from_pydata(random.uniform(-0.8, 0.8, (40, 3)) + (0.0, 0.0, 0.5), [], [])
    shaded(mesh, diffuse)
    obj = add("Points", mesh)
    tree = bpy.data.node_groups.new("Points", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    first, last = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    points, painted = tree.nodes.new("GeometryNodeMeshToPoints"), tree.nodes.new("GeometryNodeSetMaterial")
    points.inputs["Radius"].default_value = 0.12
    painted.inputs["Material"].default_value = mesh.materials[0]
    tree.links.new(first.outputs[0], points.inputs[0])
    tree.links.new(points.outputs[0], painted.inputs[0])
    tree.links.new(painted.outputs[0], last.inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = tree
    agree(*render(96))


def test_point_info(file, add, shaded, render):
    kind = "ShaderNodePointInfo"
    data = shaded(cloud(), shown((kind, "Radius"), (kind, "Random")))
    add("Cloud", data, scale=(1.4, 0.8, 1.0))
    agree(*render(64))
    data.materials.clear()
    shaded(data, shown((kind, "Position")))
    agree(*(np.abs(picture) for picture in render(64)))


def test_glowing_hair_lights_a_floor(file, add, quad, shaded, render):
    add("Hair", shaded(hair(60, radius=0.05), shown(("ShaderNodeHairInfo", "Is Strand"), factor=4.0)))
    add("Floor", shaded(quad("Floor"), diffuse), scale=(3.0, 3.0, 1.0))
    agree(*render(128))


def test_instances_of_hair(file, add, lit, shaded, render):
    """Each is an object of its own; the curves are there once."""
    data = shaded(hair(60), diffuse)
    for place in (-0.8, 0.8):
        add("Hair", data, (place, 0.0, 0.0), scale=(0.5, 0.5, 0.8))
    agree(*render(64))


def test_the_filter_of_the_view_layer(file, add, shaded, synced):
    add("Hair", shaded(hair(3), diffuse))
    assert len(synced().instances) == 1 and synced().warnings == []
    file.layer.use_strand = False
    assert synced().instances == []


@pytest.fixture
def furry(add, quad):
    """A floor with a particle system on it."""
    floor = add("Floor", quad("Floor"), scale=(1.2, 0.6, 1.0))
    system = floor.modifiers.new("Fur", "PARTICLE_SYSTEM").particle_system
    settings = system.settings
    settings.type, settings.count, settings.hair_length, settings.hair_step = "HAIR", 60, 1.2, 4
    settings.render_step, settings.root_radius, settings.tip_radius, settings.shape = 3, 3.0, 0.5, 0.3
    settings.brownian_factor = 0.1
    return floor


def strand_colors(tree):
    kind = "ShaderNodeHairInfo"
    return shown((kind, "Intercept"), (kind, "Random"), (kind, "Thickness"))(tree)


@pytest.mark.parametrize("children", ["NONE", "SIMPLE", "INTERPOLATED"])
def test_particle_hair(file, lit, furry, shaded, render, children):
    """Its material is that of the second slot."""
    shaded(furry.data, diffuse)
    shaded(furry.data, strand_colors)
    settings = furry.particle_systems[0].settings
    settings.material, settings.child_type, settings.rendered_child_count = 2, children, 3
    if hasattr(settings, "child_percent"):
        settings.child_percent = 2
    agree(*render(256))


def test_particle_hair_has_the_coordinates_of_its_roots(file, furry, shaded, render):
    shaded(furry.data, shown(("ShaderNodeTexCoord", "UV")))
    furry.data.materials.clear()
    shaded(furry.data, shown(("ShaderNodeTexCoord", "UV")))
    furry.show_instancer_for_render = False
    agree(*render(64))
    furry.data.materials.clear()
    shaded(furry.data, shown(("ShaderNodeTexCoord", "Generated")))
    agree(*render(64))


@pytest.mark.parametrize("way", ["goes", "bends"])
def test_hair_that_moves(file, lit, furry, shaded, render, synced, way):
    """Hair and its floor go to the right, or the floor bends and takes its hair along."""
    shaded(furry.data, diffuse)
    if way == "bends":
        bend = furry.modifiers.new("Bend", "SIMPLE_DEFORM")
        bend.deform_method, bend.deform_axis = "TWIST", "X"
        furry.modifiers.move(1, 0)
    for frame, x in ((1, -0.4), (2, 0.4)):
        if way == "bends":
            bend.angle = x
            bend.keyframe_insert("angle", frame=frame)
        else:
            furry.location = (x, 0.0, 0.0)
            furry.keyframe_insert("location", frame=frame)
    file.scene.render.use_motion_blur = True
    file.scene.frame_set(1)
    assert (way == "bends") == any(mesh.motion_radii is not None for mesh in synced().meshes)
    agree(*render(128))


@pytest.mark.parametrize("model", ["CHIANG", "HUANG"])
def test_principled_hair(file, add, lit, shaded, render, model):
    """Brown hair under a sky and a sun; the fibers of Huang's model are flat, and so hide less."""

    def fibers(tree):
        node = tree.nodes.new("ShaderNodeBsdfHairPrincipled")
        node.model, node.parametrization = model, "COLOR"
        node.inputs["Color"].default_value = (0.4, 0.25, 0.1, 1.0)
        return node.outputs[0]

    add("Hair", shaded(hair(), fibers))
    ours, theirs = render(128 if model == "CHIANG" else 32)  # of Huang's, only what it hides is compared
    assert ours[..., 3].mean() == pytest.approx(theirs[..., 3].mean(), rel=0.01)
    if model == "CHIANG":  # docs/cycles.md says what Huang's lacks
        assert ours.mean((0, 1)) == pytest.approx(theirs.mean((0, 1)), rel=0.02)
