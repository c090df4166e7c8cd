# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of meshes and properties of objects that materials read."""

from __future__ import annotations

import re
from collections.abc import Callable

import bpy
import numpy as np

from ...jit import kernel
from ...render.scene import AttributeValues, Domain, Mesh

_DOMAINS = {"POINT": Domain.VERTEX, "CORNER": Domain.CORNER, "FACE": Domain.TRIANGLE}
# data_type -> name of the value property, kind of attribute, number of components
TYPES = {
    "FLOAT": ("value", np.float32, 1),
    "INT": ("value", np.int32, 1),
    "BOOLEAN": ("value", bool, 1),
    "INT8": ("value", np.int32, 1),
    "FLOAT_VECTOR": ("vector", np.float32, 3),
    "FLOAT2": ("vector", np.float32, 2),
    "FLOAT_COLOR": ("color", np.float32, 4),
    "BYTE_COLOR": ("color", np.float32, 4),
    "QUATERNION": ("value", np.float32, 4),
}


def read(collection, name: str, dtype, width: int = 1) -> np.ndarray:
    """Property ``name`` of every item of a bpy collection: (items,) or (items, width)."""
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values if width == 1 else values.reshape(-1, width)


def _generated(data: bpy.types.Mesh, mesh: Mesh, corners, faces, name: str) -> AttributeValues:
    """Position in the mesh's texture space: 0 to 1 over the box around it, before modifiers deform it."""
    positions = read(data.vertices, "undeformed_co", np.float32, 3)
    location, scale = _texture_space(data)
    return AttributeValues(Domain.VERTEX, ((positions - location) * scale + 0.5).astype(np.float32))


def _texture_space(data) -> tuple[np.ndarray, np.ndarray]:
    """The middle of a mesh's texture space, and the factor to its coordinates."""
    location, size = np.array(data.texspace_location), np.array(data.texspace_size)
    return location, np.divide(0.5, size, out=np.zeros(3), where=size != 0.0)


def texture_space(data, name: str) -> np.ndarray | None:
    """(1, 3) float32: the "scale" or the "offset" of the transform from object space to generated coordinates; None for
    data without a texture space. In Volume objects both are the same."""
    if isinstance(data, bpy.types.Volume):
        return np.full((1, 3), 1.0 if name == "scale" else 0.0, np.float32)
    if not hasattr(data, "texspace_location"):
        return None
    location, scale = _texture_space(data)
    values = scale if name == "scale" else 0.5 - location * scale
    return values.astype(np.float32)[None]


def _geometry(
    data: bpy.types.Mesh, mesh: Mesh, corners: np.ndarray, faces: np.ndarray, name: str
) -> AttributeValues | None:
    """An attribute by name; for an empty name, the colour attribute that is active for rendering."""
    if name:
        attribute = data.attributes.get(name)
    else:
        index = data.color_attributes.render_color_index
        attribute = data.color_attributes[index] if 0 <= index < len(data.color_attributes) else None
    if attribute is None or attribute.domain not in (*_DOMAINS, "EDGE") or attribute.data_type not in TYPES:
        return None
    field, dtype, width = TYPES[attribute.data_type]
    values = read(attribute.data, field, dtype, width).astype(np.float32).reshape(-1, width)
    if attribute.domain == "EDGE":
        return AttributeValues(Domain.VERTEX, _of_vertices(data, values, attribute.data_type))
    domain = _DOMAINS[attribute.domain]
    if domain == Domain.CORNER:
        values = values[corners.ravel()]
    elif domain == Domain.TRIANGLE:
        values = values[faces]
    return AttributeValues(domain, np.ascontiguousarray(values))


def _of_vertices(data: bpy.types.Mesh, values: np.ndarray, kind: str) -> np.ndarray:
    """Values of vertices from those of edges: the mean over a vertex's edges; for booleans, whether any is true."""
    ends = read(data.edges, "vertices", np.int32, 2)
    total, count = np.zeros((len(data.vertices), values.shape[1])), np.zeros((len(data.vertices), 1))
    for end in ends.T:
        np.add.at(total, end, values)
        np.add.at(count, end, 1.0)
    mean = total / np.maximum(count, 1.0)
    if kind == "BOOLEAN":
        mean = total > 0.0
    elif TYPES[kind][1] is np.int32:
        mean = np.copysign(np.floor(np.abs(mean) + 0.5), mean)
    return np.ascontiguousarray(mean, np.float32)


def _pointiness(data: bpy.types.Mesh, mesh: Mesh, corners, faces, name: str) -> AttributeValues:
    """Convexity of the mesh at each vertex: the angle from its normal to the mean direction of its edges, over π,
    averaged with its neighbours'. Vertices at one position count as one."""
    positions = read(data.vertices, "co", np.float32, 3)
    _, place = np.unique(positions, axis=0, return_inverse=True)
    place = place.ravel()
    count = int(place.max(initial=-1)) + 1
    normals = np.zeros((count, 3))
    np.add.at(normals, place, read(data.vertex_normals, "vector", np.float32, 3))
    point = np.zeros((count, 3))
    point[place] = positions
    edges = place[read(data.edges, "vertices", np.int32, 2)]
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    edges = edges[edges[:, 0] != edges[:, 1]]
    along = _normalized(point[edges[:, 1]] - point[edges[:, 0]])
    mean, degree = np.zeros((count, 3)), np.zeros(count)
    np.add.at(mean, edges[:, 0], along)
    np.add.at(mean, edges[:, 1], -along)
    np.add.at(degree, edges.ravel(), 1.0)
    cosine = (_normalized(normals) * mean).sum(1) / np.maximum(degree, 1.0)
    sharpness = np.where(degree > 0.0, np.arccos(np.clip(cosine, -1.0, 1.0)) / np.pi, 0.0)
    total = sharpness.copy()
    np.add.at(total, edges[:, 0], sharpness[edges[:, 1]])
    np.add.at(total, edges[:, 1], sharpness[edges[:, 0]])
    return AttributeValues(Domain.VERTEX, (total / (degree + 1.0))[place].astype(np.float32)[:, None])


def _normalized(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


@kernel
def _join_islands(edges, parents, ranks):
    """Sets of vertices connected by edges (union by rank): the parent of each vertex."""
    for row in range(len(edges)):
        a, b = edges[row, 0], edges[row, 1]
        while parents[a] != a:
            a = parents[a]
        while parents[b] != b:
            b = parents[b]
        if a != b:
            if ranks[a] < ranks[b]:
                a, b = b, a
            parents[b] = a
            if ranks[a] == ranks[b]:
                ranks[a] += 1


def _island(data: bpy.types.Mesh, mesh: Mesh, corners: np.ndarray, faces: np.ndarray, name: str) -> AttributeValues:
    """A random number from 0 to 1 for each connected part of the mesh."""
    parents = np.arange(len(data.vertices))
    _join_islands(read(data.edges, "vertices", np.int32, 2).astype(np.int64), parents, np.zeros(len(parents), np.int64))
    while (parents[parents] != parents).any():
        parents = parents[parents]
    first = read(data.polygons, "loop_start", np.int32)[faces]
    vertices = read(data.attributes[".corner_vert"].data, "value", np.int32)
    islands = np.unique(parents)
    numbers = [hashed(int(root)) / 0xFFFFFFFF for root in islands]
    values = np.array(numbers, np.float32)[np.searchsorted(islands, parents[vertices[first]])]
    return AttributeValues(Domain.TRIANGLE, values[:, None])


READERS: dict[str, Callable] = {
    "generated": _generated,
    "geometry": _geometry,
    "pointiness": _pointiness,
    "island": _island,
}
"""Kinds of mesh attributes, except UV maps and tangents."""


def property_of(owner, name: str) -> np.ndarray | None:
    """(1, 1 to 4) float32 of a property of Blender's data, custom or built in; None if there is none."""
    if owner is None or not name or re.search(r"\[\d+\]$", name):  # Blender's renderers read whole properties
        return None
    try:
        value = owner[name] if name in owner.keys() else owner.path_resolve(name)
        values = np.atleast_1d(np.array(value, np.float32))
    except (TypeError, ValueError, KeyError, AttributeError):
        return None
    if values.ndim != 1 or not 1 <= len(values) <= 4 or not np.isfinite(values).all():
        return None
    return values.reshape(1, -1)


class InstanceAttributes:
    """Attributes that geometry nodes give to their instances. Valid as long as the evaluated objects live."""

    def __init__(self):
        self._found: dict[tuple[int, str], tuple] = {}
        self._places: dict[int, dict[int, int]] = {}
        self._sets: dict[int, object] = {}  # their point clouds belong to them

    def of(self, item: bpy.types.DepsgraphObjectInstance, name: str) -> np.ndarray | None:
        """(1, numbers) float32 of an instance. For nested instances, the innermost one with the attribute counts."""
        if not item.is_instance or item.parent is None or not name:
            return None
        numbers = [number for number in item.persistent_id if number != _NO_NUMBER]
        owner = item.parent.as_pointer()
        if owner not in self._sets:
            self._sets[owner] = item.parent.evaluated_geometry()
        return self._within(self._sets[owner], numbers, name)

    def _within(self, geometry, numbers: list[int], name: str) -> np.ndarray | None:
        if not numbers or not hasattr(geometry, "instances_pointcloud"):  # a reference may be an object or a collection
            return None
        points = geometry.instances_pointcloud()
        number = None if points is None else self._place(points, numbers[-1])  # index of the outermost instances
        if number is None:
            return None
        inner = None
        if len(numbers) > 1:
            which = self._values(points, ".reference_index")
            references = geometry.instance_references()
            if which is not None and int(which[number, 0]) < len(references):
                inner = self._within(references[int(which[number, 0])], numbers[:-1], name)
        if inner is not None:
            return inner
        values = self._values(points, name)
        return None if values is None else values[number : number + 1]

    def _place(self, points, number: int) -> int | None:
        """Index of the instance for Blender's number: by the attribute ``id`` if the instances have it, else by
        position."""
        key = points.as_pointer()
        if key not in self._places:
            ids = points.attributes.get("id")
            numbers = read(ids.data, "value", np.int32).tolist() if ids and ids.data_type == "INT" else None
            self._places[key] = {} if numbers is None else dict(zip(reversed(numbers), reversed(range(len(numbers)))))
        places = self._places[key]
        return places.get(number) if places else number if 0 <= number < len(points.points) else None

    def _values(self, points, name: str) -> np.ndarray | None:
        key = points.as_pointer(), name
        if key not in self._found:
            attribute, values = points.attributes.get(name), None
            if attribute is not None and attribute.data_type in TYPES:
                field, dtype, width = TYPES[attribute.data_type]
                values = read(attribute.data, field, dtype, width).astype(np.float32).reshape(-1, width)
            self._found[key] = points, values
        return self._found[key][1]


_NO_NUMBER = 2**31 - 1  # instances are not nested that deep


def random_number(item: bpy.types.DepsgraphObjectInstance) -> float:
    """The random number from 0 to 1 of Object Info: from the name of an object, or Blender's own for an instance."""
    if item.is_instance:
        number = item.random_id & 0xFFFFFFFF
    else:
        number = 0
        for byte in item.object.name.encode():
            number = (number * 37 + byte) & 0xFFFFFFFF
        number = hashed(number, 0)
    return number / 0xFFFFFFFF


def _rotated(x: int, bits: int) -> int:
    return (x << bits | x >> (32 - bits)) & 0xFFFFFFFF


def hashed(*words: int) -> int:
    """Hash of one or two integers: the last round of Bob Jenkins' lookup3 (2006)."""
    mask = 0xFFFFFFFF
    a = b = c = (0xDEADBEEF + (len(words) << 2) + 13) & mask
    a = (a + words[0]) & mask
    b = (b + words[1]) & mask if len(words) > 1 else b
    c = ((c ^ b) - _rotated(b, 14)) & mask
    a = ((a ^ c) - _rotated(c, 11)) & mask
    b = ((b ^ a) - _rotated(a, 25)) & mask
    c = ((c ^ b) - _rotated(b, 16)) & mask
    a = ((a ^ c) - _rotated(c, 4)) & mask
    b = ((b ^ a) - _rotated(a, 14)) & mask
    return ((c ^ b) - _rotated(b, 24)) & mask
