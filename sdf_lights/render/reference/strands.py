# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves of hair and spheres: which of them was hit, and the surface there. Embree finds the hits."""

from __future__ import annotations

import numpy as np

from ..scene import Primitive, Scene
from ..strands import baked_instances, has_strands, strand_of
from .hits import Hits
from .vectors import dot, normalize

# Catmull and Rom 1974: the weights of four control points in 1, u, u², u³.
_CATMULL_ROM = 0.5 * np.array([(0, 2, 0, 0), (-1, 0, 1, 0), (2, -5, 4, -1), (-1, 3, -3, 1)], float)
NONE = -1


class Strands:
    """The curves and spheres of a scene. ``there``: whether it has any. A *number* tells them apart in the whole scene;
    that of a triangle is ``NONE``."""

    def __init__(self, scene: Scene):
        self.scene, self.there = scene, has_strands(scene)
        meshes = [scene.meshes[instance.mesh] for instance in scene.instances]
        self.kinds = np.array([int(mesh.primitive) for mesh in meshes], int)
        matrices = np.array([instance.matrix for instance in scene.instances], float).reshape(-1, 4, 4)
        self._flipped = baked_instances(scene) & (np.linalg.det(matrices[:, :3, :3]) < 0.0)
        if not self.there:
            return
        owns = {
            index: strand_of(scene.meshes[index]).astype(int)
            for index in {instance.mesh for instance in scene.instances}
            if scene.meshes[index].primitive != Primitive.TRIANGLES
        }
        self._numbers, used = [], 0
        for instance, mesh in zip(scene.instances, meshes):
            own = owns.get(instance.mesh)
            self._numbers.append(np.full(len(mesh.triangles), NONE) if own is None else used + own)
            used += 0 if own is None else int(own.max(initial=-1)) + 1

    def number(self, instance: np.ndarray, segment: np.ndarray) -> np.ndarray:
        """(N,) numbers of what was hit; an instance −1: nothing."""
        result = np.full(len(instance), NONE)
        for index in np.unique(instance) if self.there else ():
            if index >= 0 and self.kinds[index] != Primitive.TRIANGLES:
                rows = instance == index
                result[rows] = self._numbers[index][segment[rows]]
        return result

    def surface(self, hits: Hits, wo: np.ndarray) -> dict[str, np.ndarray]:
        """Fields (N, ...) of ``geometry.Surface`` at hits of curves and spheres, seen along ``wo`` (N, 3), with normals
        that do not face the viewer yet."""
        count = len(wo)
        position, tangent, normal = hits.point, np.zeros((count, 3)), np.zeros((count, 3))
        u, v = hits.u.copy(), np.zeros(count)
        for index in np.unique(hits.instance):
            rows = np.flatnonzero(hits.instance == index)
            instance = self.scene.instances[index]
            mesh, matrix = self.scene.meshes[instance.mesh], np.asarray(instance.matrix, float)
            linear, kind = matrix[:3, :3], mesh.primitive
            back = np.linalg.inv(linear)
            if kind == Primitive.SPHERES:
                u[rows] = 0.0
                middle = np.asarray(mesh.positions, float)[mesh.triangles[hits.triangle[rows], 0]]
                normal[rows] = normalize(position[rows] - (middle @ linear.T + matrix[:3, 3]))
                continue
            middle, along = _curve(mesh, hits.triangle[rows], u[rows])
            seen = wo[rows] @ back.T
            if kind == Primitive.RIBBONS:
                across = hits.v[rows]
                v[rows] = -across if self._flipped[index] else across
                side = normalize(np.cross(normalize(along), seen))
                depth = np.sqrt(np.maximum(1.0 - across * across, 0.0))
                own = across[:, None] * side - depth[:, None] * normalize(np.cross(normalize(along), side))
            else:
                own = normalize((position[rows] - matrix[:3, 3]) @ back.T - middle)
            normal[rows], tangent[rows] = normalize(own @ back), along @ linear.T
        kinds = self.kinds[hits.instance]
        behind = (dot(normal, wo) < 0.0) & (kinds != Primitive.RIBBONS)
        side = np.where(behind, -1.0, 1.0)[:, None]
        return {
            "position": position,
            "ng": normal * side,
            "ns": normal * side,
            "backfacing": behind,
            "barycentric": np.stack([1.0 - u - v, u, v], -1),
            "smooth": np.zeros(count, bool),
            "strand": np.where(kinds == Primitive.SPHERES, 0, kinds),
            "number": self.number(hits.instance, hits.triangle),
            "tangent": tangent * side,
        }


def _curve(mesh, segment: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and tangents of curves in local space; a curve's end points count twice."""
    p, rows = np.asarray(mesh.positions, float), mesh.triangles
    first, last = rows[segment, 0], rows[segment, 1]
    if mesh.primitive == Primitive.CONES:
        way = p[last] - p[first]
        return p[first] + u[:, None] * way, way
    strand, end = strand_of(mesh), len(rows) - 1
    before, after = np.maximum(segment - 1, 0), np.minimum(segment + 1, end)
    begins = (segment == 0) | (strand[before] != strand[segment])
    ends = (segment == end) | (strand[after] != strand[segment])
    points = np.stack(
        [p[np.where(begins, first, rows[before, 0])], p[first], p[last], p[np.where(ends, last, rows[after, 1])]], 1
    )
    powers = u[:, None] ** np.arange(4)
    slopes = np.stack([0.0 * u, 1.0 + 0.0 * u, 2.0 * u, 3.0 * u * u], -1)
    return tuple(np.einsum("nk,nkj->nj", weights @ _CATMULL_ROM, points) for weights in (powers, slopes))
