# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair curves and point clouds as arrays, in Cycles' form."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import bpy
import numpy as np

from ...render.material import Attribute
from ...render.scene import AttributeValues, Domain, Mesh, Primitive, Scene
from ...render.strands import strand_of
from .attributes import TYPES, hashed, read
from .mesh import Form, Readable

_RADIUS = {"CURVES": 0.005, "POINTCLOUD": 0.01}  # if there is no attribute of that name, as in Cycles
_SHAPES = {"RIBBONS": Primitive.RIBBONS, "THICK": Primitive.STRANDS, "THICK_LINEAR": Primitive.CONES}
_POLY = 1  # type of a curve
NORMAL = Attribute("strand", "normal")  # the major axis of elliptical hair
_DOMAINS = {"POINT": Domain.VERTEX, "CURVE": Domain.TRIANGLE}


class Strands:
    """Adds all hair curves and point clouds to the scene once, however many instances use them."""

    def __init__(self, scene: Scene, depsgraph: bpy.types.Depsgraph, forms: dict[int, Readable]):
        """``forms`` gets the readers of each of them."""
        self._scene, self._forms = scene, forms
        curves = getattr(depsgraph.scene, "cycles_curves", None)  # Cycles' settings do not tag evaluated copies
        self.shape = _SHAPES.get(getattr(curves, "shape", "RIBBONS"), Primitive.RIBBONS)
        self.subdivisions = getattr(curves, "subdivisions", 2)
        self._known: dict[int, tuple[int, np.ndarray] | None] = {}

    def index(self, data: bpy.types.Curves | bpy.types.PointCloud, attributes: Iterable[Attribute]) -> int | None:
        """Index of the data in the scene, with at least these attributes; None if nothing is visible."""
        key = data.as_pointer()
        if key not in self._known:
            self._known[key] = self._add(data)
        known = self._known[key]
        if known is None:
            return None
        index, kept = known
        mesh = self._scene.meshes[index]
        for attribute in attributes:
            if attribute not in mesh.attributes:
                found = _attribute(data, mesh, kept, attribute)
                if found is not None:
                    mesh.attributes[attribute] = found
        return index

    def _add(self, data: bpy.types.Curves | bpy.types.PointCloud) -> tuple[int, np.ndarray] | None:
        if not len(data.points):
            return None
        positions, radii = points_of(data)
        finite = np.isfinite(positions).all(1) & np.isfinite(radii)
        if isinstance(data, bpy.types.PointCloud):
            kept = points = np.flatnonzero(finite)
            rows = np.repeat(np.arange(len(kept), dtype=np.int32)[:, None], 3, 1)
            mesh = Mesh(data.name, positions[kept], rows, primitive=Primitive.SPHERES, radii=radii[kept])
        else:
            first = read(data.curve_offset_data, "value", np.int32)
            whole = np.logical_and.reduceat(finite, first[:-1]) & (np.diff(first) > 1)
            kept = np.flatnonzero(whole)
            mesh = strands(data.name, positions, radii, first, kept)
            mesh.primitive, mesh.subdivisions = self._shape_of(data), self.subdivisions
            points = keys_of(first, kept)
        if not len(mesh.triangles):
            return None
        self._scene.meshes.append(mesh)
        self._forms[len(self._scene.meshes) - 1] = PointForms(len(data.points), points)
        return len(self._scene.meshes) - 1, kept

    def _shape_of(self, data: bpy.types.Curves) -> Primitive:
        types = data.attributes.get("curve_type")
        # Cycles looks only at the first curve, in versions that draw straight lines.
        if types is not None and len(types.data) and types.data[0].value == _POLY and bpy.app.version >= (5, 0, 0):
            return Primitive.CONES
        return self.shape


class PointForms(NamedTuple):
    """Reads points again: those ``kept`` of so many."""

    count: int
    kept: np.ndarray

    def read(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Form | None:
        """See ``mesh.Readable``."""
        if len(obj.data.points) != self.count:
            return None
        positions, radii = (array[self.kept] for array in points_of(obj.data))
        if not (np.isfinite(positions).all() and np.isfinite(radii).all()):
            return None
        return Form(positions, None, np.maximum(radii, 0.0))


def points_of(data: bpy.types.Curves | bpy.types.PointCloud) -> tuple[np.ndarray, np.ndarray]:
    """Positions (V, 3) and radii (V,)."""
    positions = read(data.attributes["position"].data, "vector", np.float32, 3)
    found = data.attributes.get("radius")
    if found is None or found.data_type != "FLOAT" or found.domain != "POINT":
        kind = "POINTCLOUD" if isinstance(data, bpy.types.PointCloud) else "CURVES"
        return positions, np.full(len(positions), _RADIUS[kind], np.float32)
    return positions, read(found.data, "value", np.float32)


def keys_of(first: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Indices (points,) of the points of the curves
    ``kept`` (curves,). Curve i has the points from ``first[i]`` to before ``first[i + 1]``."""
    counts = (first[1:] - first[:-1])[kept]
    return np.repeat(first[kept] - (np.cumsum(counts) - counts), counts) + np.arange(counts.sum())


def strands(name: str, positions: np.ndarray, radii: np.ndarray, first: np.ndarray, kept: np.ndarray) -> Mesh:
    """The curves ``kept`` (n,) of all curves, with their starts and lengths (see ``keys_of``), each of two points or
    more."""
    counts = (first[1:] - first[:-1])[kept]
    keys = keys_of(first, kept)
    ends = np.cumsum(counts)
    begins = np.ones(len(keys), bool)
    begins[ends - 1] = False
    start = np.flatnonzero(begins).astype(np.int32)
    rows = np.stack([start, start + 1, start], 1)
    mesh = Mesh(name, positions[keys], rows, radii=np.maximum(radii[keys], 0.0).astype(np.float32))
    curve = np.repeat(np.arange(len(kept)), counts)
    way = np.zeros(len(keys))
    way[1:] = np.linalg.norm(np.diff(mesh.positions.astype(np.float64), axis=0), axis=1)
    way[ends - counts] = 0.0
    along = np.cumsum(way)
    along -= along[ends - counts][curve]
    length = along[ends - 1]
    share = along / np.where(length > 0.0, length, 1.0)[curve]
    segment = curve[start]
    mesh.attributes = {
        Attribute("strand", "intercept"): AttributeValues(Domain.VERTEX, share.astype(np.float32)[:, None]),
        Attribute("strand", "length"): AttributeValues(Domain.TRIANGLE, length.astype(np.float32)[segment, None]),
        Attribute("strand", "random"): AttributeValues(Domain.TRIANGLE, random_numbers(kept)[segment, None]),
    }
    return mesh


def random_numbers(indices: np.ndarray) -> np.ndarray:
    """(N,) random float32 from 0 to 1, of curves and points by their index."""
    return np.array(hashed(indices.astype(np.int64), 0) / 0xFFFFFFFF, np.float32)


def _attribute(data, mesh: Mesh, kept: np.ndarray, attribute: Attribute) -> AttributeValues | None:
    """Attribute of a curve object or a point cloud; the curves or points ``kept`` are in ``mesh``."""
    points = mesh.primitive == Primitive.SPHERES
    if attribute.kind == "point":
        return AttributeValues(Domain.TRIANGLE, random_numbers(kept)[:, None]) if points else None
    if attribute.kind == "generated" or points and attribute.kind == "strand":
        return None
    if attribute == NORMAL:
        first = read(data.curve_offset_data, "value", np.int32)
        normals = read(data.normals, "vector", np.float32, 3)
        return AttributeValues(Domain.VERTEX, np.ascontiguousarray(normals[keys_of(first, kept)]))
    found = None
    if attribute.kind == "geometry" and attribute.name or attribute.kind == "uv" and attribute.name:
        found = data.attributes.get(attribute.name)
    elif attribute.kind == "uv":
        found = next((item for item in data.attributes if item.data_type == "FLOAT2" and item.domain == "CURVE"), None)
    if found is None or found.data_type not in TYPES or found.domain not in _DOMAINS:
        return None
    field, dtype, width = TYPES[found.data_type]
    values = read(found.data, field, dtype, width).astype(np.float32).reshape(-1, width)
    if points:
        return AttributeValues(Domain.VERTEX, np.ascontiguousarray(values[kept]))
    if found.domain == "POINT":
        first = read(data.curve_offset_data, "value", np.int32)
        return AttributeValues(Domain.VERTEX, np.ascontiguousarray(values[keys_of(first, kept)]))
    return AttributeValues(Domain.TRIANGLE, np.ascontiguousarray(values[kept][strand_of(mesh)]))
