# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Displacement of meshes: the same shape and the same normals as in Cycles, whatever the mesh and how it is shown."""

import bpy
import numpy as np
import pytest

from sdf_lights.render.material import UNDISPLACED

pytest.importorskip("_cycles")


@pytest.fixture
def wavy(material):
    """Function: a material that shows its normal as light, and is displaced by waves along x by a ``method``.

    Waves are in generated coordinates: with those of the object, Cycles bumps what is displaced by other waves.
    """

    def run(method: str, space: str = "OBJECT"):
        made, tree, output = material("Wavy")
        made.displacement_method = method
        made.cycles.emission_sampling = "NONE"
        nodes, link = tree.nodes, tree.links.new
        geometry, half, emission = (
            nodes.new(f"ShaderNode{name}") for name in ("NewGeometry", "VectorMath", "Emission")
        )
        half.operation = "MULTIPLY_ADD"
        half.inputs[1].default_value = half.inputs[2].default_value = (0.5, 0.5, 0.5)
        link(geometry.outputs["Normal"], half.inputs[0])
        link(half.outputs[0], emission.inputs["Color"])
        link(emission.outputs[0], output)
        wave, place, height = (nodes.new(f"ShaderNode{name}") for name in ("TexWave", "TexCoord", "Displacement"))
        wave.inputs["Scale"].default_value = 0.8
        height.space, height.inputs["Scale"].default_value = space, 0.25
        link(place.outputs["Generated"], wave.inputs["Vector"])
        link(wave.outputs["Fac"], height.inputs["Height"])
        link(height.outputs[0], output.node.inputs["Displacement"])
        return made

    return run


def ball(shading: str) -> bpy.types.Mesh:
    """A ball that is smooth, flat, or smooth with a sharp equator, below which its faces are flat."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=40, ring_count=20)
    mesh = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    mesh.shade_smooth() if shading != "flat" else mesh.shade_flat()
    if shading == "sharp":
        lower = [polygon.center.z < 0.0 for polygon in mesh.polygons]
        mesh.attributes.new("sharp_face", "BOOLEAN", "FACE").data.foreach_set("value", lower)
        level = [all(abs(mesh.vertices[v].co.z) < 1e-4 for v in edge.vertices) for edge in mesh.edges]
        edges = mesh.attributes.get("sharp_edge") or mesh.attributes.new("sharp_edge", "BOOLEAN", "EDGE")
        edges.data.foreach_set("value", level)
    return mesh


@pytest.fixture
def both(file, pictures):
    """Function: pictures of the scene by Cycles and by this engine."""
    bpy.ops.preferences.addon_enable(module="cycles")

    def run():
        scene, found = file.scene, []
        scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
        scene.cycles.samples, scene.cycles.pixel_filter_type = 16, "BOX"
        scene.render.resolution_x, scene.render.resolution_y = 192, 128
        bpy.ops.sdf_lights.cycles_settings_copy()
        scene.sdf_lights.device = "CPU"
        file.camera.location, file.camera.data.lens = (0.0, -5.0, 0.4), 40.0
        for engine in ("CYCLES", "SDF_LIGHTS"):
            scene.render.engine = engine
            found.append(pictures()["ViewLayer"]["Combined"][..., :3].astype(float))
        return found

    return run


def compare(pair) -> None:
    theirs, ours = (picture.reshape(8, 16, 12, 16, 3).mean((1, 3)) for picture in pair)
    away = np.abs(ours - theirs)
    print(f"mean {away.mean():.5f}, at most {away.max():.5f}")
    assert theirs.std() > 0.1
    assert away.mean() < 0.002 and away.max() < 0.02


@pytest.mark.parametrize("method", ["DISPLACEMENT", "BOTH", "BUMP"])
@pytest.mark.parametrize("shading", ["smooth", "flat", "sharp"])
def test_meshes_are_displaced_as_in_cycles(both, add, wavy, shading, method):
    mesh = ball(shading)
    mesh.materials.append(wavy(method))
    add("Ball", mesh, (0.1, 0.0, 1.0), (0.3, 0.2, 0.5), (0.9, 1.2, 0.8))
    compare(both())


def test_objects_of_one_mesh_are_displaced_by_their_own_materials(both, add, wavy, synced):
    mesh = ball("smooth")
    mesh.materials.append(None)
    objects = [
        add(f"Ball {i}", mesh, (1.2 * i - 1.2, 0.0, 1.0), (0.0, 0.0, 0.4), (0.5, 0.5, -0.6 if i else 0.6))
        for i in range(3)
    ]
    for thing, made in zip(objects, (wavy("DISPLACEMENT"), wavy("BUMP"), wavy("BOTH", "WORLD"))):
        thing.material_slots[0].link, thing.material_slots[0].material = "OBJECT", made
    compare(both())
    scene = synced()
    assert scene.warnings == []
    moved, still, too = (scene.meshes[instance.mesh] for instance in scene.instances)
    assert not np.array_equal(moved.positions, still.positions) and not np.array_equal(too.positions, still.positions)
    assert np.array_equal(moved.attributes[UNDISPLACED].values, still.positions)
    assert np.array_equal(too.normals, still.normals) and not np.array_equal(moved.normals, still.normals)


def test_only_the_part_with_the_material_is_displaced(synced, add, wavy, material):
    mesh = ball("smooth")
    plain, _, _ = material("Plain")
    for made in (plain, wavy("DISPLACEMENT")):
        mesh.materials.append(made)
    mesh.polygons.foreach_set("material_index", [int(polygon.center.z > 0.0) for polygon in mesh.polygons])
    before = np.array([vertex.co for vertex in mesh.vertices])
    add("Ball", mesh)
    scene = synced()
    away = np.linalg.norm(scene.meshes[0].positions - before, axis=1)
    assert away[before[:, 2] < -0.01].max() == 0.0
    assert 0.0 < np.median(away[before[:, 2] > 0.01]) < 0.25
