# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes that materials look up: of geometry nodes' instances, of edges, of kinds that are no colours."""

import bpy
import numpy as np
import pytest

from sdf_lights.render.material import Attribute
from sdf_lights.render.scene import Domain


@pytest.fixture
def looks_up(material):
    """Function: a material that glows by an attribute."""

    def run(name: str, kind: str = "GEOMETRY"):
        made, tree, output = material(f"{kind} {name}")
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_type, node.attribute_name = kind, name
        tree.links.new(node.outputs["Color"], output)
        return made

    return run


def _stored(tree, geometry, name: str, numbers: tuple):
    """A colour at each instance: its index times ``numbers``."""
    node = tree.nodes.new("GeometryNodeStoreNamedAttribute")
    node.domain, node.data_type, node.inputs["Name"].default_value = "INSTANCE", "FLOAT_VECTOR", name
    scaled = tree.nodes.new("ShaderNodeVectorMath")
    scaled.operation, scaled.inputs[1].default_value = "MULTIPLY", numbers
    tree.links.new(tree.nodes.new("GeometryNodeInputIndex").outputs[0], scaled.inputs[0])
    tree.links.new(scaled.outputs[0], node.inputs["Value"])
    tree.links.new(geometry, node.inputs["Geometry"])
    return node.outputs[0]


def _on_row(tree, geometry, count: int):
    """Instances on ``count`` points in a row."""
    row, node = tree.nodes.new("GeometryNodeMeshLine"), tree.nodes.new("GeometryNodeInstanceOnPoints")
    row.inputs["Count"].default_value = count
    tree.links.new(row.outputs[0], node.inputs["Points"])
    tree.links.new(geometry, node.inputs["Instance"])
    return node.outputs[0]


def _scattering(add, quad, looks_up):
    """The tree of an object with geometry nodes, and the output of a tile whose material looks ``tint`` up."""
    obj = add("Scattered", quad())
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    tile, dressed = tree.nodes.new("GeometryNodeMeshGrid"), tree.nodes.new("GeometryNodeSetMaterial")
    dressed.inputs["Material"].default_value = looks_up("tint", "INSTANCER")
    tree.links.new(tile.outputs["Mesh"], dressed.inputs[0])
    obj.modifiers.new("Scatter", "NODES").node_group = tree
    return tree, dressed.outputs[0]


def test_instances_of_geometry_nodes_have_their_attributes(synced, add, quad, looks_up):
    tree, tile = _scattering(add, quad, looks_up)
    inner = _stored(tree, _on_row(tree, tile, 3), "tint", (1.0, 10.0, 0.5))
    outer = _stored(tree, _on_row(tree, inner, 2), "tint", (-1.0, -1.0, -1.0))
    tree.links.new(outer, tree.nodes.new("NodeGroupOutput").inputs[0])
    attribute = Attribute("instancer", "tint")
    found = sorted(instance.attributes[attribute].values[0].tolist() for instance in synced().instances)
    assert found == [[float(i), 10.0 * i, 0.5 * i] for i in (0, 0, 1, 1, 2, 2)]  # the innermost counts


def test_instances_with_ids_have_their_own_attributes(synced, add, quad, looks_up):
    """Blender tells instances apart by their attribute ``id``, of any sign, where they have one."""
    tree, tile = _scattering(add, quad, looks_up)
    row = _stored(tree, _on_row(tree, tile, 3), "tint", (1.0, 10.0, 0.5))
    named, number = tree.nodes.new("GeometryNodeSetID"), tree.nodes.new("ShaderNodeMath")
    number.operation, number.inputs[1].default_value, number.inputs[2].default_value = "MULTIPLY_ADD", -1e6, -7.0
    tree.links.new(tree.nodes.new("GeometryNodeInputIndex").outputs[0], number.inputs[0])
    tree.links.new(number.outputs[0], named.inputs["ID"])
    tree.links.new(row, named.inputs[0])
    tree.links.new(named.outputs[0], tree.nodes.new("NodeGroupOutput").inputs[0])
    attribute = Attribute("instancer", "tint")
    found = sorted(instance.attributes[attribute].values[0].tolist() for instance in synced().instances)
    assert found == [[float(i), 10.0 * i, 0.5 * i] for i in range(3)]


def _values(synced, add, quad, looks_up, kind: str, domain: str, field: str, numbers):
    mesh = quad()
    mesh.attributes.new("wear", kind, domain).data.foreach_set(field, np.ravel(numbers))
    mesh.materials.append(looks_up("wear"))
    add("Worn", mesh)
    found = synced().meshes[0].attributes[Attribute("geometry", "wear")]
    assert found.domain == Domain.VERTEX
    ends = np.array([edge.vertices[:] for edge in mesh.edges])
    return found.values, ends


@pytest.mark.parametrize(
    "kind, numbers, joined",
    [
        ("FLOAT", np.array([1.0, 2.0, 4.0, 8.0], np.float32), np.mean),
        ("INT", np.array([1, 2, 4, 7], np.int32), lambda values: np.floor(np.mean(values) + 0.5)),
        ("BOOLEAN", np.array([True, False, False, True]), np.any),
    ],
)
def test_attributes_of_edges_are_those_of_vertices(synced, add, quad, looks_up, kind, numbers, joined):
    values, ends = _values(synced, add, quad, looks_up, kind, "EDGE", "value", numbers)
    expected = [float(joined(numbers[(ends == vertex).any(axis=1)])) for vertex in range(4)]
    assert values[:, 0].tolist() == expected


def test_rotations_are_four_numbers(synced, add, quad, looks_up):
    numbers = np.arange(16, dtype=np.float32).reshape(4, 4) / 16
    values, _ = _values(synced, add, quad, looks_up, "QUATERNION", "POINT", "value", numbers)
    np.testing.assert_array_equal(values, numbers)


def test_a_part_of_a_property_is_not_looked_up(synced, add, quad, looks_up):
    mesh = quad()
    mesh.materials.append(looks_up("location", "OBJECT"))
    mesh.materials.append(looks_up("location[0]", "OBJECT"))
    add("Placed", mesh, location=(1.0, 2.0, 3.0))
    found = synced().instances[0].attributes
    assert set(found) == {Attribute("object", "location")}
    assert found[Attribute("object", "location")].values.tolist() == [[1.0, 2.0, 3.0]]
