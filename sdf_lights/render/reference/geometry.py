# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles in float64: nearest hits of many rays at once, and the surface at a hit.

The hierarchy is a complete binary tree, split at medians. So it needs no pointers, and is built and traversed level by
level over whole arrays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...affine import stretch
from ..scene import Primitive, Scene
from ..strands import baked_instances, without_strands
from .embree import EmbreeRays
from .hits import Hits
from .strands import NONE, Strands
from .vectors import dot, normalize

LEAF = 2
FAR_AWAY = 1e200
CHUNK = 8192
EMBREE_TRIANGLES = 200  # NumPy is 10 times slower than Embree from about here on


@dataclass
class Surface:
    """The surface at hits, in world space. ``ng`` and ``ns``, the geometric and the shading normal, are on the side of
    ``wo``; ``backfacing``: this is the inside of the mesh."""

    position: np.ndarray
    ng: np.ndarray
    ns: np.ndarray
    wo: np.ndarray
    backfacing: np.ndarray
    instance: np.ndarray
    triangle: np.ndarray
    barycentric: np.ndarray  # (N, 3)
    smooth: np.ndarray  # (N,) bool: ns is interpolated
    distance: np.ndarray
    # Of the incoming ray: scene.Ray, whether it left a mirror, bounces (N, 5) as in the variables of formulas.
    ray_kind: np.ndarray
    ray_singular: np.ndarray
    depth: np.ndarray
    ray_pdf: np.ndarray  # density of its scattering; 0: singular, or the camera
    # Of curves: which kind of scene.Primitive it is, else 0; and the tangent, of their parameter. Of curves and
    # spheres: their number, as in ``Strands``.
    strand: np.ndarray
    tangent: np.ndarray
    number: np.ndarray
    uncorrected: np.ndarray | None = None  # its material leaves bumps uncorrected: known once it is shaded

    def __post_init__(self):
        if self.uncorrected is None:
            self.uncorrected = np.zeros(len(self.distance), bool)

    def select(self, rows: np.ndarray) -> "Surface":
        """The hits of some rows, given as indices (n,) or as a mask (N,)."""
        return Surface(**{name: value[rows] for name, value in vars(self).items()})


class Triangles:
    """Hierarchy over triangles ``corners`` (T, 3, 3) in world space with visibility ``masks`` (T,)."""

    def __init__(self, corners: np.ndarray, masks: np.ndarray):
        self.corners, self.masks = corners, masks
        lower, upper = corners.min(1), corners.max(1)
        depth = 0
        while LEAF << depth < len(corners):
            depth += 1
        # Split every node of a level at the median of the axis along which its triangles' centres spread most.
        self.order = np.concatenate([np.arange(len(corners)), np.full((LEAF << depth) - len(corners), -1)])
        centre = np.concatenate([0.5 * (lower + upper), np.full((1, 3), np.inf)])  # row −1: no triangle
        for level in range(depth):
            order = self.order.reshape(1 << level, -1)
            there = order >= 0
            spread = np.where(there[..., None], centre[order], -np.inf).max(1) - np.where(
                there[..., None], centre[order], np.inf
            ).min(1)
            key = np.take_along_axis(centre[order], spread.argmax(1)[:, None, None], 2)[..., 0]
            # Half of the triangles go to each side, and half of the empty slots with them.
            rank = np.argsort(key, 1, kind="stable")
            filled = there.sum(1, keepdims=True)
            place = np.arange(order.shape[1])[None]
            half = order.shape[1] // 2
            source = np.where(place < half, place, place - half + (filled + 1) // 2)
            valid = np.where(place < half, place < (filled + 1) // 2, source < filled)
            picked = np.take_along_axis(order, np.take_along_axis(rank, np.minimum(source, order.shape[1] - 1), 1), 1)
            self.order = np.where(valid, picked, -1).ravel()
        empty = np.array([[np.inf] * 3, [-np.inf] * 3])
        box = np.concatenate([np.stack([lower, upper], 1), empty[None]])[self.order]
        self.levels = []
        for group in [LEAF] + [2] * depth:
            box = box.reshape(-1, group, 2, 3)
            box = np.stack([box[:, :, 0].min(1), box[:, :, 1].max(1)], 1)
            # A box without triangles must be missed by every ray: put it far away.
            solid = np.where(box[:, :1] <= box[:, 1:], box, FAR_AWAY)
            self.levels.insert(0, np.ascontiguousarray(solid.transpose(1, 2, 0)))

    def nearest(self, origins, directions, far, masks):
        """(distance, triangle, u, v) of the nearest hit closer than ``far``; triangle −1 if there is none."""
        parts = [
            self._nearest(*(array[i : i + CHUNK] for array in (origins, directions, far, masks)))
            for i in range(0, len(origins), CHUNK)
        ]
        if not parts:
            return np.zeros(0), np.zeros(0, int), np.zeros(0), np.zeros(0)
        return tuple(np.concatenate(part) for part in zip(*parts))

    def _nearest(self, origins, directions, far, masks):
        inverse = 1.0 / np.where(directions == 0.0, 1e-30, directions).T
        scaled = origins.T * inverse
        ray = np.arange(len(origins))
        node = np.zeros(len(origins), int)
        for depth, box in enumerate(self.levels):
            if depth:
                node = (node[:, None] * 2 + np.arange(2)).ravel()
                ray = np.repeat(ray, 2)
            enter, leave = np.zeros(len(ray)), far[ray]
            for axis in range(3):
                factor, offset = inverse[axis][ray], scaled[axis][ray]
                a, b = (box[side, axis][node] * factor - offset for side in (0, 1))
                enter, leave = np.maximum(enter, np.minimum(a, b)), np.minimum(leave, np.maximum(a, b))
            # Rounding may not lose a ray that runs within a flat box.
            keep = enter <= leave * (1.0 + 1e-9) + 1e-9
            ray, node = ray[keep], node[keep]
        triangle = self.order[(node[:, None] * LEAF + np.arange(LEAF)).ravel()]
        ray = np.repeat(ray, LEAF)
        ray, triangle = ray[triangle >= 0], triangle[triangle >= 0]
        keep = (self.masks[triangle] & masks[ray]) != 0
        ray, triangle = ray[keep], triangle[keep]
        t, u, v = moller_trumbore(origins[ray], directions[ray], self.corners[triangle])
        keep = (t > 0.0) & (t < far[ray])
        ray, triangle, t, u, v = ray[keep], triangle[keep], t[keep], u[keep], v[keep]
        last = np.lexsort((-t, ray))  # the nearest hit of each ray is written last
        ray, triangle, t, u, v = ray[last], triangle[last], t[last], u[last], v[last]
        count = len(origins)
        result = np.full(count, np.inf), np.full(count, -1), np.zeros(count), np.zeros(count)
        for target, value in zip(result, (t, triangle, u, v)):
            target[ray] = value
        return result


def moller_trumbore(o: np.ndarray, d: np.ndarray, corners: np.ndarray):
    """(t, u, v) of rays with triangles (N, 3, 3), t = inf if they miss. Möller and Trumbore 1997."""
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(d, e2)
    determinant = dot(e1, p)
    inverse = 1.0 / np.where(determinant == 0.0, 1.0, determinant)
    s = o - corners[:, 0]
    u = dot(s, p) * inverse
    q = np.cross(s, e1)
    v = dot(d, q) * inverse
    hit = (determinant != 0.0) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    return np.where(hit, dot(e2, q) * inverse, np.inf), u, v


def _points(origins: np.ndarray, directions: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Points (N, 3) of rays; their origins where the ``distance`` is infinite."""
    return origins + np.where(np.isfinite(distance), distance, 0.0)[:, None] * directions


class Placed:
    """All instances of a scene: the surface at a hit."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.matrices = np.array([i.matrix for i in scene.instances], float).reshape(-1, 4, 4)
        linear = self.matrices[:, :3, :3]
        regular = np.abs(np.linalg.det(linear)) > 0.0
        self.normal_matrices = np.zeros_like(linear)
        self.normal_matrices[regular] = np.linalg.inv(linear[regular]).transpose(0, 2, 1)
        self.uneven = baked_instances(scene) & stretch(self.matrices)
        self.mesh_of = np.array([i.mesh for i in scene.instances], int)
        counts = np.array([len(m.triangles) for m in scene.meshes] + [0])
        self.first = np.concatenate([[0], np.cumsum(counts)[:-1]])  # of each mesh in the arrays that follow
        empty = np.zeros((0, 3, 3))
        self.corners = np.concatenate(
            [empty] + [np.asarray(m.positions, float)[m.triangles].reshape(-1, 3, 3) for m in scene.meshes]
        )
        self.normals = np.concatenate(
            [empty]
            + [
                np.zeros((len(m.triangles), 3, 3)) if m.normals is None else np.asarray(m.normals, float)
                for m in scene.meshes
            ]
        )
        self.smooth = np.concatenate(
            [np.zeros(0, bool)] + [np.full(len(m.triangles), m.normals is not None) for m in scene.meshes]
        )
        self.slots = np.concatenate(
            [np.zeros(0, int)] + [np.zeros(len(m.triangles), int) if m.slots is None else m.slots for m in scene.meshes]
        )
        width = max([len(i.materials) for i in scene.instances], default=1)
        # A missing slot shows the last material, as in Blender.
        self.materials = np.array(
            [[i.materials[min(slot, len(i.materials) - 1)] for slot in range(width)] for i in scene.instances], int
        ).reshape(-1, width)
        self.strands = Strands(scene)
        self.triangle_count = int(counts[self.mesh_of].sum()) if len(self.mesh_of) else 0

    def material(self, instance: np.ndarray, triangle: np.ndarray) -> np.ndarray:
        """Index (N,) of the material of triangles (N,) of instances (N,)."""
        slot = self.slots[self.first[self.mesh_of[instance]] + triangle]
        return self.materials[instance, slot.clip(0, self.materials.shape[1] - 1)]

    def surface(self, hits: Hits, directions: np.ndarray) -> Surface:
        """The surface at ``hits``, all of which exist, of rays along ``directions`` (N, 3)."""
        row = self.first[self.mesh_of[hits.instance]] + hits.triangle
        matrix = self.matrices[hits.instance]
        barycentric = np.stack([1.0 - hits.u - hits.v, hits.u, hits.v], -1)
        corners = self.corners[row]
        local = np.einsum("nk,nkj->nj", barycentric, corners)
        position = np.einsum("nij,nj->ni", matrix[:, :3, :3], local) + matrix[:, :3, 3]
        # Normals use the inverse transpose, which keeps the outside outside under mirroring.
        to_world = self.normal_matrices[hits.instance]
        ng = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        ng = normalize(np.einsum("nij,nj->ni", to_world, ng))
        smooth = self.smooth[row]
        ns = np.einsum("nij,nj->ni", to_world, np.einsum("nk,nkj->nj", barycentric, self.normals[row]))
        even = self.uneven[hits.instance]
        in_world = normalize(np.einsum("nij,nkj->nki", to_world[even], self.normals[row[even]]))
        ns[even] = np.einsum("nk,nkj->nj", barycentric[even], in_world)
        ns = np.where(smooth[:, None], normalize(ns), ng)
        wo = -directions
        backfacing = dot(ng, wo) < 0.0
        side = np.where(backfacing, -1.0, 1.0)[:, None]
        surface = Surface(
            position,
            ng * side,
            ns * side,
            wo,
            backfacing,
            hits.instance,
            hits.triangle,
            barycentric,
            smooth,
            hits.distance,
            np.zeros(len(wo), int),
            np.zeros(len(wo), bool),
            np.zeros((len(wo), 5), int),
            np.zeros(len(wo)),
            np.zeros(len(wo), int),
            np.zeros((len(wo), 3)),
            np.full(len(wo), NONE),
        )
        if self.strands.there:
            curved = np.flatnonzero(self.strands.kinds[hits.instance] != Primitive.TRIANGLES)
            for name, values in self.strands.surface(hits.select(curved), wo[curved]).items():
                getattr(surface, name)[curved] = values
        return surface


class Geometry(Placed):
    """All instances of a scene: intersection, and the surface at a hit."""

    def __init__(self, scene: Scene, use_embree: bool | None = None):
        """``use_embree``: None uses Embree for more than ``EMBREE_TRIANGLES`` triangles, if it is found. Only Embree
        finds curves and spheres."""
        super().__init__(scene)
        if use_embree is None or self.strands.there:
            use_embree = self.strands.there or self.triangle_count > EMBREE_TRIANGLES
        self.rays = self._embree() if use_embree else None
        if self.rays is None:
            if self.strands.there:
                scene = without_strands(scene, "The NumPy reference")
                super().__init__(scene)
            self._expand()
        self.size = self._size()
        # Origins are moved off their surface by this fraction of the scene's size: a few roundings of the ray caster.
        self.epsilon = (1e-6 if self.rays else 1e-11) * self.size

    def _embree(self):
        try:
            return EmbreeRays(self.scene)
        except Exception as error:
            self.scene.warnings.append(f"Embree could not be used ({error}); NumPy traces the rays, slowly.")
            return None

    def _expand(self) -> None:
        """Every instance's triangles in world space, with their origin."""
        rows = [np.arange(len(self.scene.meshes[m].triangles)) for m in self.mesh_of]
        self._instance = np.repeat(np.arange(len(rows)), [len(r) for r in rows]) if rows else np.zeros(0, int)
        self._triangle = np.concatenate([np.zeros(0, int)] + rows)
        matrix = self.matrices[self._instance]
        local = self.corners[self.first[self.mesh_of[self._instance]] + self._triangle] if rows else self.corners[:0]
        world = np.einsum("tij,tkj->tki", matrix[:, :3, :3], local) + matrix[:, None, :3, 3]
        masks = np.array([int(i.visibility) for i in self.scene.instances], int)
        self._hierarchy = Triangles(world, masks[self._instance] if rows else np.zeros(0, int))

    def _size(self) -> float:
        """Largest absolute coordinate of the scene's triangles, by the corners of the meshes' boxes."""
        largest = 1e-3
        for matrix, mesh in zip(self.matrices, self.mesh_of):
            positions = self.scene.meshes[mesh].positions
            if len(positions):
                bound = np.abs(positions).max(0)
                largest = max(largest, float((np.abs(matrix[:3, :3]) @ bound + np.abs(matrix[:3, 3])).max()))
        return largest

    def intersect(self, origins, directions, far, masks, refused=None) -> Hits:
        """Nearest hits closer than ``far`` with instances visible to any of the kinds of ray in ``masks`` (N,), but not
        with the curves and spheres whose numbers are ``refused`` (N, K)."""
        if self.rays is None:
            distance, index, u, v = self._hierarchy.nearest(origins, directions, far, masks)
            if len(self._instance) == 0:
                return Hits.none(len(origins))
            found = index >= 0
            instance, triangle = (np.where(found, of[index], -1) for of in (self._instance, self._triangle))
            return Hits(distance, instance, triangle, u, v, _points(origins, directions, distance))
        hits = self.rays.intersect(origins, directions, far, masks)
        if self.strands.there and refused is not None:
            self._pass(hits, origins, directions, far, masks, refused)
        hits.point = _points(origins, directions, hits.distance)
        return hits

    def _pass(self, hits: Hits, origins, directions, far, masks, refused: np.ndarray) -> None:
        """Replace hits with what is ``refused`` by those behind them."""
        going, begin, step = np.arange(len(origins)), np.zeros(len(origins)), self.epsilon
        while True:
            number = self.strands.number(hits.instance[going], hits.triangle[going])
            going = going[(number != NONE) & (number[:, None] == refused[going]).any(1)]
            if not len(going):
                return
            begin[going] = hits.distance[going] + step
            step *= 2.0  # from inside, Embree finds the same curve again at once
            start = origins[going] + begin[going, None] * directions[going]
            next_ = self.rays.intersect(start, directions[going], far[going] - begin[going], masks[going])
            next_.distance += begin[going]
            for target, values in zip(vars(hits).values(), vars(next_).values()):
                target[going] = values

    def offset(self, position: np.ndarray, ng: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Origins (N, 3), in world space, for rays that leave a surface, moved to the side on which they leave."""
        return position + self.epsilon * np.where(dot(ng, direction) < 0.0, -1.0, 1.0)[:, None] * ng

    def light_start(self, surface: Surface, wi: np.ndarray) -> np.ndarray:
        """Origins (N, 3) of light rays along ``wi``, as ``kernels/terminator.py`` has them."""
        start = self.offset(surface.position, surface.ng, wi)
        cutoffs = np.array([instance.terminator for instance in self.scene.instances])
        cutoff = np.where(surface.smooth, cutoffs[surface.instance], 0.0) if len(cutoffs) else np.zeros(len(wi))
        cosine, flat = dot(surface.ns, wi), dot(surface.ng, wi)
        side = np.where(cosine < 0.0, -1.0, 1.0)
        cosine, flat, width = side * cosine, side * flat, np.where(cutoff > 0.0, cutoff, 1.0)
        amount = np.where(cosine < cutoff, 2.0 - (flat + cosine) / width, 1.0 - flat / width)
        amount = np.clip(np.where(cutoff > 0.0, amount, 0.0), 0.0, 1.0)
        near = amount > 0.0
        start[near] += amount[near, None] * self._lift(surface.select(near), side[near])
        return start

    def _lift(self, surface: Surface, side: np.ndarray) -> np.ndarray:
        """The way (N, 3) from points of triangles to the curved surfaces that their normals stand for."""
        row = self.first[self.mesh_of[surface.instance]] + surface.triangle
        matrix = self.matrices[surface.instance]
        p = np.einsum("nij,nkj->nki", matrix[:, :3, :3], self.corners[row]) + matrix[:, None, :3, 3]
        n = normalize(np.einsum("nij,nkj->nki", self.normal_matrices[surface.instance], self.normals[row]))
        u, v, _ = weights = surface.barycentric.T
        a, b, c = (
            ((n[:, i] - n[:, j]) * (p[:, k] - p[:, m])).sum(-1)
            for i, j, k, m in ((2, 0, 0, 2), (2, 1, 1, 2), (1, 0, 1, 0))
        )
        height = a * u * (u - 1.0) + (a + b + c) * u * v + b * v * (v - 1.0)
        mean = np.einsum("kn,nkj->nj", weights, n)
        above = np.where(side * dot(mean, surface.ng) > 0.0, 1.0, -1.0)
        bound = np.full(len(above), np.inf)
        for corner in range(3):
            own, normal = p[:, corner], n[:, corner]
            others = [above * dot(p[:, (corner + step) % 3] - own, normal) for step in (1, 2)]
            reach = np.maximum(np.maximum(*others), 0.0)
            bound = np.minimum(bound, np.maximum(above * dot(own - surface.position, normal) + reach, 0.0))
        return (above * np.maximum(bound, above * 0.5 * height))[:, None] * mean
