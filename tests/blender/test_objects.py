# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, instances and what else stands in a scene, as sync reads them."""

import bmesh
import bpy
import numpy as np
import pytest

from sdf_lights.render.scene import Ray


def instance(scene, name: str):
    return next(item for item in scene.instances if item.name == name)


def mesh_of(scene, name: str):
    return scene.meshes[instance(scene, name).mesh]


def world_positions(scene, item) -> np.ndarray:
    return scene.meshes[item.mesh].positions @ item.matrix[:3, :3].T + item.matrix[:3, 3]


def test_mesh(synced, add, quad):
    add("Quad", quad(), location=(1.0, 2.0, 3.0), scale=(2.0, 1.0, -1.0))
    scene = synced()
    item = instance(scene, "Quad")
    mesh = scene.meshes[item.mesh]
    assert mesh.positions.dtype == np.float32 and mesh.triangles.dtype == np.int32
    assert mesh.triangles.shape == (2, 3) and mesh.normals is None and mesh.slots is None
    a, b, c = mesh.positions[mesh.triangles].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a) @ [0, 0, 1] > 0).all()  # counter-clockwise seen from +z
    assert item.matrix == pytest.approx(np.array([[2, 0, 0, 1], [0, 1, 0, 2], [0, 0, -1, 3], [0, 0, 0, 1]]))
    assert item.visibility is Ray.ALL and not item.holdout
    assert scene.warnings == []


def test_modifiers_are_applied_but_do_not_join_objects(synced, add, quad):
    data = quad()
    add("Plain", data)
    add("Also plain", data, location=(3.0, 0.0, 0.0))
    thick = add("Thick", data)
    thick.modifiers.new("Solidify", "SOLIDIFY").thickness = 0.5
    scene = synced()
    assert instance(scene, "Plain").mesh == instance(scene, "Also plain").mesh
    assert len(mesh_of(scene, "Thick").triangles) == 12
    assert len(scene.meshes) == 2


def test_normals(synced, add):
    bpy.ops.mesh.primitive_cube_add()
    data = bpy.context.object.data
    bpy.context.object.name = "Flat"
    smooth = data.copy()
    smooth.shade_smooth()
    add("Smooth", smooth)
    sharp = data.copy()
    sharp.shade_smooth()
    for edge in sharp.edges:  # around the top
        edge.use_edge_sharp = all(sharp.vertices[i].co.z > 0.0 for i in edge.vertices)
    add("Sharp", sharp)
    custom = data.copy()
    custom.shade_smooth()
    custom.normals_split_custom_set([(0.0, 0.6, 0.8)] * len(custom.loops))
    add("Custom", custom)
    scene = synced()
    assert mesh_of(scene, "Flat").normals is None
    mesh = mesh_of(scene, "Smooth")
    corners = mesh.positions[mesh.triangles]
    assert mesh.normals == pytest.approx(corners / np.sqrt(3), abs=1e-6)
    mesh = mesh_of(scene, "Sharp")
    top = (mesh.positions[mesh.triangles][..., 2] > 0.0).all(axis=1)
    assert mesh.normals[top] == pytest.approx(np.broadcast_to([0.0, 0.0, 1.0], (2, 3, 3)), abs=1e-6)
    assert (np.abs(mesh.normals[~top]).max(axis=-1) < 0.9).all()
    assert mesh_of(scene, "Custom").normals == pytest.approx(np.broadcast_to([0.0, 0.6, 0.8], (12, 3, 3)), abs=2e-4)


@pytest.mark.parametrize("kind", ["curve", "text", "surface", "metaball"])
def test_what_becomes_a_mesh(synced, kind):
    if kind == "curve":
        bpy.ops.curve.primitive_bezier_circle_add()
        bpy.context.object.data.bevel_depth = 0.1
    elif kind == "text":
        bpy.ops.object.text_add()
    elif kind == "surface":
        bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    else:
        bpy.ops.object.metaball_add()
    bpy.context.object.name = "Thing"
    bpy.context.object.location = (0.0, 0.0, 2.0)
    bpy.context.object.data.materials.append(bpy.data.materials.new("Paint"))
    scene = synced()
    item = instance(scene, "Thing")
    assert len(scene.instances) == 1 and len(scene.meshes[item.mesh].triangles) > 50
    assert item.matrix[2, 3] == 2.0
    assert scene.materials[item.materials[0]].name == "Paint"


def test_nothing_to_render_in_loose_or_empty_geometry(synced, add):
    add("Empty mesh", bpy.data.meshes.new("Empty"))
    loose = bpy.data.meshes.new("Loose")
    loose.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    add("Loose", loose)
    bpy.ops.curve.primitive_bezier_circle_add()
    add("Nothing", None)
    scene = synced()
    assert scene.instances == [] and scene.meshes == [] and scene.warnings == []


def test_material_slots(synced, add):
    first, second, own = (bpy.data.materials.new(name) for name in ("First", "Second", "Own"))
    bpy.ops.mesh.primitive_cube_add()
    obj = bpy.context.object
    data = obj.data
    data.materials.append(first)
    data.materials.append(second)
    data.materials.append(None)
    indices = np.array([0, 1, 2, 1, 0, 7], np.int32)  # 7: past the last slot
    data.polygons.foreach_set("material_index", indices)
    other = add("Other", data)
    other.material_slots[0].link = "OBJECT"
    other.material_slots[0].material = own
    scene = synced()
    names = [[scene.materials[i].name for i in instance(scene, name).materials] for name in (obj.name, "Other")]
    assert names == [["First", "Second", "default_surface"], ["Own", "Second", "default_surface"]]
    assert instance(scene, obj.name).mesh == instance(scene, "Other").mesh
    slots = mesh_of(scene, "Other").slots
    assert sorted(slots) == sorted(np.repeat(np.minimum(indices, 2), 2))


def test_material_of_geometry_nodes(synced, add, quad):
    """Set Material adds a slot that the object itself does not have."""
    tree = bpy.data.node_groups.new("Paint", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    paint = tree.nodes.new("GeometryNodeSetMaterial")
    paint.inputs["Material"].default_value = bpy.data.materials.new("Painted")
    tree.links.new(start.outputs[0], paint.inputs["Geometry"])
    tree.links.new(paint.outputs["Geometry"], end.inputs[0])
    add("Quad", quad()).modifiers.new("Nodes", "NODES").node_group = tree
    scene = synced()
    item = instance(scene, "Quad")
    slots = scene.meshes[item.mesh].slots
    used = {item.materials[slot] for slot in (slots if slots is not None else [0])}
    assert {scene.materials[i].name for i in used} == {"Painted"}


def test_collection_instances_share_a_mesh(file, synced, add, quad):
    source = bpy.data.collections.new("Source")
    source.objects.link(bpy.data.objects.new("Part", quad()))
    for i in range(5):
        placed = add(f"Placed {i}", None, location=(i, 0.0, 0.0))
        placed.instance_type, placed.instance_collection = "COLLECTION", source
    scene = synced()
    assert len(scene.meshes) == 1 and len(scene.instances) == 5
    assert sorted(item.matrix[0, 3] for item in scene.instances) == [0, 1, 2, 3, 4]


def test_geometry_nodes_instances_share_a_mesh(synced, add, quad):
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    end = tree.nodes.new("NodeGroupOutput")
    points = tree.nodes.new("GeometryNodeMeshLine")
    points.inputs["Count"].default_value = 40
    points.inputs["Offset"].default_value = (0.5, 0.0, 0.0)
    cube = tree.nodes.new("GeometryNodeMeshCube")
    scatter = tree.nodes.new("GeometryNodeInstanceOnPoints")
    tree.links.new(points.outputs["Mesh"], scatter.inputs["Points"])
    tree.links.new(cube.outputs["Mesh"], scatter.inputs["Instance"])
    tree.links.new(scatter.outputs["Instances"], end.inputs[0])
    add("Scatter", quad()).modifiers.new("Nodes", "NODES").node_group = tree
    scene = synced()
    assert len(scene.meshes) == 1 and len(scene.instances) == 40
    assert max(item.matrix[0, 3] for item in scene.instances) == pytest.approx(19.5)


def test_particles_are_instances(file, synced, add, quad):
    part = add("Part", quad("Part"))
    ground = add("Ground", quad("Ground"))
    bpy.context.view_layer.objects.active = ground
    bpy.ops.object.particle_system_add()
    settings = ground.particle_systems[0].settings
    settings.type, settings.count, settings.render_type, settings.instance_object = "HAIR", 30, "OBJECT", part
    scene = synced()
    assert len(scene.meshes) == 2
    assert len([item for item in scene.instances if item.mesh == instance(scene, "Part").mesh]) == 31


def test_visibility(file, synced, add, quad):
    obj = add("Quad", quad())
    obj.visible_camera = obj.visible_shadow = False
    assert instance(synced(), "Quad").visibility == Ray.DIFFUSE | Ray.GLOSSY | Ray.TRANSMISSION | Ray.VOLUME
    obj.hide_render = True
    assert synced().instances == []


def test_an_instance_is_as_visible_as_its_instancer(synced, add, quad):
    source = bpy.data.collections.new("Source")
    part = bpy.data.objects.new("Part", quad())
    part.visible_glossy = False
    source.objects.link(part)
    placed = add("Placed", None)
    placed.instance_type, placed.instance_collection = "COLLECTION", source
    placed.visible_camera = False
    [item] = synced().instances
    assert item.visibility == Ray.DIFFUSE | Ray.TRANSMISSION | Ray.SHADOW | Ray.VOLUME


def test_view_layers(file, synced, add, quad):
    hidden = bpy.data.collections.new("Hidden")
    file.scene.collection.children.link(hidden)
    add("Kept", quad())
    hidden.objects.link(bpy.data.objects.new("Left out", quad()))
    other = file.scene.view_layers.new("Other")
    other.layer_collection.children["Hidden"].exclude = True
    assert {item.name for item in synced().instances} == {"Kept", "Left out"}
    assert {item.name for item in synced("Other").instances} == {"Kept"}
    other.layer_collection.children["Hidden"].exclude = False
    other.layer_collection.children["Hidden"].holdout = True
    assert {item.name: item.holdout for item in synced("Other").instances} == {"Kept": False, "Left out": True}
    other.layer_collection.children["Hidden"].holdout = False
    other.layer_collection.children["Hidden"].indirect_only = True
    assert instance(synced("Other"), "Left out").visibility == Ray.ALL & ~Ray.CAMERA
    assert instance(synced(), "Left out").visibility == Ray.ALL


def test_holdout(synced, add, quad):
    add("Quad", quad()).is_holdout = True
    assert instance(synced(), "Quad").holdout


def test_material_override(file, synced, add, quad):
    data = quad()
    data.materials.append(bpy.data.materials.new("Own"))
    add("Quad", data)
    file.layer.material_override = bpy.data.materials.new("Clay")
    scene = synced()
    assert [scene.materials[i].name for i in instance(scene, "Quad").materials] == ["Clay"]


def test_not_a_number(synced, add, quad):
    add("Broken", quad(), location=(float("nan"), 0.0, 0.0))
    add("Whole", quad())
    bad = bpy.data.meshes.new("Bad")
    bad.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0), (float("inf"), 0, 0)], [], [(0, 1, 2), (1, 3, 2)])
    add("Half", bad)
    scene = synced()
    assert {item.name for item in scene.instances} == {"Whole", "Half"}
    assert len(mesh_of(scene, "Half").triangles) == 1
    assert sum("'Broken'" in warning for warning in scene.warnings) == 1
    assert sum("'Bad'" in warning for warning in scene.warnings) == 1
    assert all(np.isfinite(mesh.positions).all() for mesh in scene.meshes)


def test_flattened_objects_stay_visible_and_points_vanish(synced, add, quad):
    add("Flat", quad(), scale=(2.0, 3.0, 0.0))
    add("Line", quad(), scale=(2.0, 0.0, 0.0))
    add("Point", quad(), scale=(0.0, 0.0, 0.0))
    scene = synced()
    assert [item.name for item in scene.instances] == ["Flat"]
    item = scene.instances[0]
    assert np.isfinite(np.linalg.inv(item.matrix)).all()
    assert np.ptp(world_positions(scene, item), axis=0) == pytest.approx([4.0, 6.0, 0.0], abs=1e-5)


def test_meshes_in_edit_mode_are_rendered_as_they_are_edited(synced, add, quad, material):
    """A file may be saved, and a frame rendered, while a mesh is edited."""
    red, _, _ = material("Red")
    data = quad()
    data.materials.append(None)
    data.materials.append(red)
    data.polygons[0].material_index = 1
    edited = add("Edited", data)
    edited.modifiers.new("Solidify", "SOLIDIFY").thickness = 0.5
    add("Linked", data, location=(3.0, 0.0, 0.0))
    bpy.context.view_layer.objects.active = edited
    bpy.ops.object.mode_set(mode="EDIT")
    work = bmesh.from_edit_mesh(data)
    bmesh.ops.translate(work, verts=work.verts, vec=(0.0, 0.0, 2.0))
    bmesh.update_edit_mesh(data)
    scene = synced()
    assert len(mesh_of(scene, "Edited").triangles) == 12 and len(mesh_of(scene, "Linked").triangles) == 2
    assert world_positions(scene, instance(scene, "Edited"))[:, 2].max() == pytest.approx(2.0, abs=0.3)
    assert world_positions(scene, instance(scene, "Linked"))[:, 2] == pytest.approx(2.0)
    assert set(mesh_of(scene, "Linked").slots) == {1}
    assert scene.materials[instance(scene, "Linked").materials[1]].name == "Red"


@pytest.mark.parametrize("kind", ["text", "curve"])
def test_text_and_curves_in_edit_mode_are_rendered(synced, add, kind):
    if kind == "text":
        bpy.ops.object.text_add()
    else:
        bpy.ops.curve.primitive_bezier_circle_add()
        bpy.context.object.data.bevel_depth = 0.1
    bpy.context.object.name = "Edited"
    bpy.ops.object.mode_set(mode="EDIT")
    assert len(mesh_of(synced(), "Edited").triangles) > 10


def test_a_volume_without_a_file_is_named(synced, add):
    add("Cloud", bpy.data.volumes.new("Volume"))
    warnings = synced().warnings
    assert len(warnings) == 1 and "'Cloud'" in warnings[0] and "volume without a file" in warnings[0]


def test_blender_draws_grease_pencil_over_the_picture(synced, add):
    """As over that of Cycles, so there is nothing to say."""
    data = (bpy.data.grease_pencils_v3 if hasattr(bpy.data, "grease_pencils_v3") else bpy.data.grease_pencils).new(
        "Note"
    )
    add("Note", data)
    assert synced().warnings == [] and synced().instances == []


def test_nothing_refers_to_blender(synced, add, quad, lamp):
    add("Quad", quad())
    add("Lamp", lamp())
    pending, seen = [synced()], set()
    while pending:
        value = pending.pop()
        if id(value) in seen:
            continue
        seen.add(id(value))
        assert not isinstance(value, bpy.types.bpy_struct), value
        assert type(value).__module__ != "mathutils", value
        if isinstance(value, (list, tuple)):
            pending.extend(value)
        elif isinstance(value, dict):
            pending.extend(value.values())
        elif hasattr(value, "__dict__"):
            pending.extend(vars(value).values())


def test_a_large_mesh_is_read_in_bulk(synced, add):
    """A million triangles in a time that one visit to every vertex in Python (0.1 µs at least) could not keep to."""
    import time

    bpy.ops.mesh.primitive_grid_add(x_subdivisions=250, y_subdivisions=250)
    bpy.context.object.data.shade_smooth()
    synced()
    started = time.process_time()
    scene = synced()
    assert len(scene.meshes[0].triangles) == 2 * 250 * 250
    assert time.process_time() - started < 2.0
