# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Value nodes of a material's graph over arrays of points, evaluated by recursion."""

from __future__ import annotations

import numpy as np

from ..material import NODES, Node
from .geometry import Geometry, Surface
from .images import lookup
from .vectors import dot, luminance, normalize

# Bump mapping takes differences over this part of a pixel, as Blender does, or over this many metres where a pixel's
# width is unknown.
BUMP_FILTER, BUMP_DISTANCE = 0.1, 1e-4
COLOR, VECTOR, NUMBER = "color", "vector", "number"


class Points:
    """Points on surfaces that share a material, and the values of its nodes there.

    ``shift`` 1 and 2 evaluate a graph a step along the first or the second edge of the triangle: bump mapping's
    differences.
    """

    def __init__(self, surface: Surface, geometry: Geometry, images: list, footprint: np.ndarray):
        self.surface, self.geometry, self.images = surface, geometry, images
        self.count = len(surface.distance)
        self.mesh = geometry.mesh_of[surface.instance]
        self.step = np.where(footprint > 0.0, BUMP_FILTER * footprint, BUMP_DISTANCE)
        self._values: dict[tuple[int, int], tuple[str, np.ndarray]] = {}

    # --- inputs -------------------------------------------------------------------------------------------------------

    def input(self, node: Node, name: str, shift: int = 0) -> np.ndarray:
        """Values of an input, (N,) or (N, 3) as its default is."""
        default = NODES[node.kind][name]
        return self.value(node[name], 1 if isinstance(default, float) else 3, shift)

    def value(self, value, width: int, shift: int = 0) -> np.ndarray:
        if not isinstance(value, Node):
            array = np.asarray(value, float)
            if width == 1:
                return np.full(self.count, float(array.mean()))
            return np.broadcast_to(array, (self.count, 3))
        kind, array = self._node(value, shift)
        if width == 3:
            return np.repeat(array[:, None], 3, 1) if kind == NUMBER else array
        return array if kind == NUMBER else luminance(array) if kind == COLOR else array.mean(1)

    def normal(self, node: Node, name: str = "normal") -> np.ndarray:
        """Unit normals of an input; the shading normal where it has none."""
        if node[name] is None:
            return self.surface.ns
        given = normalize(self.value(node[name], 3))
        return np.where((dot(given, given) > 0.5)[:, None], given, self.surface.ns)

    def _node(self, node: Node, shift: int) -> tuple[str, np.ndarray]:
        key = id(node), shift
        if key not in self._values:
            method = getattr(self, "_" + node.kind, None)
            # A closure where a value is wanted has none: black.
            self._values[key] = method(node, shift) if method else (COLOR, np.zeros((self.count, 3)))
        return self._values[key]

    # --- attributes of the mesh ---------------------------------------------------------------------------------------

    def _corners(self, attribute: str, name: str, width: int) -> np.ndarray:
        """Corner values (N, 3, width) of "uvs" or "tangents"; the active map where ``name`` is missing, or zeros."""
        result = np.zeros((self.count, 3, width))
        for mesh in np.unique(self.mesh):
            maps = getattr(self.geometry.scene.meshes[mesh], attribute)
            values = maps.get(name, maps.get(""))
            if values is not None:
                rows = self.mesh == mesh
                result[rows] = values[self.surface.triangle[rows]]
        return result

    def _edges(self) -> np.ndarray:
        """World edges (N, 2, 3) of the triangles from their first vertex."""
        corners = self.geometry.corners[self.geometry.first[self.mesh] + self.surface.triangle]
        matrix = self.geometry.matrices[self.surface.instance][:, :3, :3]
        return np.einsum("nij,nkj->nki", matrix, corners[:, 1:] - corners[:, :1])

    def uv(self, name: str, shift: int) -> np.ndarray:
        corners = self._corners("uvs", name, 2)
        uv = np.einsum("nk,nkj->nj", self.surface.barycentric, corners)
        if shift:
            length = np.linalg.norm(self._edges()[:, shift - 1], axis=1)
            share = self.step / np.maximum(length, 1e-30)
            uv = uv + share[:, None] * (corners[:, shift] - corners[:, 0])
        return np.concatenate([uv, np.zeros((self.count, 1))], 1)

    # --- nodes --------------------------------------------------------------------------------------------------------

    def _uv(self, node, shift):
        return VECTOR, self.uv(str(node.settings.get("uv_map") or ""), shift)

    def _coordinates(self, node, shift):
        return self.uv("", shift) if node["vector"] is None else self.value(node["vector"], 3, shift)

    def _mapping(self, node, shift):
        kind = node.settings.get("type", "POINT")
        vector = self._coordinates(node, shift)
        location, angles, size = (self.input(node, name, shift) for name in ("location", "rotation", "scale"))
        turn = euler(angles)
        inverse = np.divide(1.0, size, out=np.zeros(size.shape), where=size != 0.0)
        if kind == "TEXTURE":
            return VECTOR, np.einsum("nji,nj->ni", turn, vector - location) * inverse
        vector = np.einsum("nij,nj->ni", turn, vector * (inverse if kind == "NORMAL" else size))
        if kind == "NORMAL":
            return VECTOR, normalize(vector)
        return VECTOR, vector + location if kind == "POINT" else vector

    def _image(self, node, shift):
        settings = node.settings
        index = settings.get("image")
        alpha = settings.get("output", "color") == "alpha"
        known = isinstance(index, int) and 0 <= index < len(self.images) and self.images[index].pixels.size > 0
        if known:
            u, v = project(self._coordinates(node, shift), settings.get("projection", "FLAT"))
            rgba = lookup(self.images[index].pixels, u, v, settings.get("interpolation", "Linear"),
                          settings.get("extension", "REPEAT"))
        else:
            rgba = np.broadcast_to([1.0, 0.0, 1.0, 1.0], (self.count, 4))
        if alpha:
            return NUMBER, rgba[:, 3]
        if settings.get("associated", False):
            a = rgba[:, 3:]
            return COLOR, rgba[:, :3] / np.where((a > 0.0) & (a < 1.0), a, 1.0)
        return COLOR, rgba[:, :3]

    def _normal_map(self, node, shift):
        surface, geometry = self.surface, self.geometry
        x = 2.0 * self.input(node, "color", shift) - 1.0
        strength = np.maximum(self.input(node, "strength", shift), 0.0)[:, None]
        to_world = geometry.normal_matrices[surface.instance]
        space = node.settings.get("space", "TANGENT")
        usable = np.ones(self.count, bool)
        if space == "TANGENT":
            tangent = np.einsum("nk,nkj->nj", surface.barycentric,
                                self._corners("tangents", str(node.settings.get("uv_map") or ""), 4))
            usable = tangent[:, 3] != 0.0
            row = geometry.first[self.mesh] + surface.triangle
            smooth = np.einsum("nk,nkj->nj", surface.barycentric, geometry.normals[row])
            corners = geometry.corners[row]
            flat = normalize(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
            base = np.where(surface.smooth[:, None], smooth, flat)
            # MikkTSpace: interpolated vectors are used as they are, unnormalised, where the map was baked.
            side = tangent[:, 3:] * np.cross(base, tangent[:, :3])
            local = (x[:, :1] * tangent[:, :3] + x[:, 1:2] * side) * strength
            local = local + (1.0 + (x[:, 2:] - 1.0) * np.minimum(strength, 1.0)) * base
            mapped = normalize(np.einsum("nij,nj->ni", to_world, local))
            strength = 1.0
        elif space == "OBJECT":
            mapped = normalize(np.einsum("nij,nj->ni", to_world, x))
        else:
            mapped = normalize(x)
        usable &= dot(mapped, mapped) > 0.5
        mapped = mapped * np.where(surface.backfacing, -1.0, 1.0)[:, None]
        return VECTOR, np.where(usable[:, None], normalize(surface.ns + strength * (mapped - surface.ns)), surface.ns)

    def _bump(self, node, shift):
        """The normal of the surface that is ``distance`` · height higher. Mikkelsen 2010, equation 4."""
        n = self.normal(node)
        height, up, right = (self.input(node, "height", i) for i in range(3))
        strength = np.maximum(self.input(node, "strength", shift), 0.0)[:, None]
        distance = self.input(node, "distance", shift) * (-1.0 if node.settings.get("invert", False) else 1.0)
        edges = normalize(self._edges())
        a, b = np.cross(edges[:, 1], n), np.cross(n, edges[:, 0])
        determinant = dot(edges[:, 0], a)
        gradient = (a * (up - height)[:, None] + b * (right - height)[:, None]) / self.step[:, None]
        bumped = normalize(np.abs(determinant)[:, None] * n - (np.sign(determinant) * distance)[:, None] * gradient)
        return VECTOR, np.where((dot(bumped, bumped) > 0.5)[:, None], normalize(n + strength * (bumped - n)), n)


def euler(angles: np.ndarray) -> np.ndarray:
    """Rotations (N, 3, 3) about x, then y, then z."""
    result = np.broadcast_to(np.eye(3), (len(angles), 3, 3))
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = np.zeros((len(angles), 3, 3))
        c, s = np.cos(angles[:, axis]), np.sin(angles[:, axis])
        turn[:, axis, axis], turn[:, i, i], turn[:, j, j], turn[:, i, j], turn[:, j, i] = 1.0, c, c, -s, s
        result = turn @ result
    return result


def project(vector: np.ndarray, projection: str) -> tuple[np.ndarray, np.ndarray]:
    """Image coordinates; a sphere and a tube stand about the middle of the unit cube."""
    if projection not in ("SPHERE", "TUBE"):
        return vector[:, 0], vector[:, 1]
    x, y, z = (2.0 * vector - 1.0).T
    u = np.where((x != 0.0) | (y != 0.0), 0.5 - np.arctan2(x, y) / (2.0 * np.pi), 0.0)
    if projection == "TUBE":
        return u, 0.5 * (z + 1.0)
    length = np.sqrt(x * x + y * y + z * z)
    polar = np.arccos(np.clip(z / np.where(length > 0.0, length, 1.0), -1.0, 1.0))
    return u, np.where(length > 0.0, 1.0 - polar / np.pi, 0.0)
