# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangents of triangles along their texture coordinates, as in tools that bake normal maps.

M. S. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (2008), chapter 5: at a vertex, the tangents of triangles
that are joined by edges and whose texture has the same orientation are averaged, weighted by their angles there.
"""

from __future__ import annotations

import numpy as np

from ..graph.formula import POINT
from ..graph.numpy_evaluation import evaluate_all
from .nodes.projections import sphere_place

_TINY = np.finfo(np.float32).tiny
_MIX = np.uint64(0x9E3779B97F4A7C15)  # 2^64 over the golden ratio


def tangents(positions: np.ndarray, triangles: np.ndarray, normals: np.ndarray | None, uvs: np.ndarray) -> np.ndarray:
    """(T, 3, 4) float32: unit tangents of the corners, and the sign of the bitangent, which is normal × tangent × sign.

    ``positions`` (V, 3), ``triangles`` (T, 3) indices of vertices, ``uvs`` (T, 3, 2), ``normals`` (T, 3, 3), or None
    for flat triangles. Corners without a triangle of nonzero texture area have the tangent x.
    """
    count = len(triangles)
    points = positions[triangles].astype(np.float32)
    if normals is None:
        flat = _unit(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]))
        normals = np.broadcast_to(flat[:, None], points.shape)
    vertices = _welded(np.concatenate([points, normals, uvs], axis=2).reshape(3 * count, 8)).reshape(count, 3)
    along, forward, proper = _of_triangles(points, uvs)
    groups = _groups(vertices, forward, proper)

    # The tangent of each triangle in the plane of each corner's normal, weighted by the angle of the triangle in that
    # plane.
    around = [np.roll(points, -step, axis=1) - points for step in (1, 2)]
    cosine = np.einsum("tca,tca->tc", *(_projected(normals, edge) for edge in around))
    weight = np.where(proper[:, None], np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
    parts = _projected(normals, np.broadcast_to(along[:, None], points.shape)) * weight[..., None]
    sums = np.stack([np.bincount(groups, parts[..., axis].ravel(), 3 * count) for axis in range(3)], axis=1)

    result = np.empty((3 * count, 4), np.float32)
    result[:, :3] = _unit(sums)[groups]
    result[:, 3] = np.where(forward, 1.0, -1.0).repeat(3)
    _lend(result, vertices.ravel(), proper.repeat(3))
    return result.reshape(count, 3, 4)


def on_sphere(positions: np.ndarray) -> np.ndarray:
    """(V, 2) texture coordinates of meshes without any: from the directions (V, 3) from the origin of the object."""
    return np.stack(evaluate_all(sphere_place(*POINT), positions), axis=-1).astype(np.float32)


def _welded(corners: np.ndarray) -> np.ndarray:
    """(N,) a number for each row of float32, the same for equal rows. A 64-bit hash: the probability that two of a
    million million pairs of different rows count as equal is below one in ten million."""
    words = np.ascontiguousarray(corners + np.float32(0.0), np.float32).view(np.uint32).astype(np.uint64)  # −0 is 0
    found = np.zeros(len(words), np.uint64)
    for column in words.T:
        found = (found ^ column) * _MIX
        found ^= found >> np.uint64(29)
    return np.unique(found, return_inverse=True)[1].ravel()


def _of_triangles(points: np.ndarray, uvs: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit directions (T, 3) in which u grows, whether the texture is not mirrored, and whether it has nonzero area."""
    first, second = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    (u1, v1), (u2, v2) = (uvs[:, 1] - uvs[:, 0]).T, (uvs[:, 2] - uvs[:, 0]).T
    area = u1 * v2 - u2 * v1
    along = first * v2[:, None] - second * v1[:, None]
    across = second * u1[:, None] - first * u2[:, None]
    proper = (np.abs(area) > _TINY) & ((along * along).sum(1) > _TINY) & ((across * across).sum(1) > _TINY)
    for corner in range(3):
        proper &= (points[:, corner] != points[:, corner - 1]).any(1)
    return _unit(along) * np.sign(area)[:, None], area > 0.0, proper


def _groups(vertices: np.ndarray, forward: np.ndarray, proper: np.ndarray) -> np.ndarray:
    """(3 T,) one of the corners that share a tangent with each corner."""
    corners = np.arange(vertices.size).reshape(vertices.shape)
    start, end = vertices, np.roll(vertices, -1, axis=1)
    # An edge, and the same edge in opposite direction in a neighbour; several are used in the order of triangles.
    key = (np.minimum(start, end) * np.int64(vertices.size) + np.maximum(start, end)).ravel()
    here, there = np.flatnonzero((start < end).ravel()), np.flatnonzero((start > end).ravel())
    _, a, b = np.intersect1d(_numbered(key[here]), _numbered(key[there]), assume_unique=True, return_indices=True)
    a, b = here[a], there[b]
    same = (forward[a // 3] == forward[b // 3]) & proper[a // 3] & proper[b // 3]
    a, b = a[same], b[same]
    following = corners.ravel().copy()  # the next corner around the vertex at an edge's start
    following[a], following[b] = _next(b), _next(a)
    return _orbits(following, int(np.bincount(vertices.ravel()).max(initial=1)))


def _numbered(keys: np.ndarray) -> np.ndarray:
    """Keys with a number appended that separates equal ones: the number of equal keys before it."""
    order = np.argsort(keys, kind="stable")
    index, ordered = np.arange(len(keys)), keys[order]
    starts = np.concatenate([[True], ordered[1:] != ordered[:-1]])[: len(keys)]
    result = np.empty_like(keys)
    result[order] = ordered * 1024 + np.minimum(index - np.maximum.accumulate(np.where(starts, index, 0)), 1023)
    return result


def _next(corner: np.ndarray) -> np.ndarray:
    """The following corner of the same triangle."""
    return corner - corner % 3 + (corner + 1) % 3


def _orbits(following: np.ndarray, longest: int) -> np.ndarray:
    """One member of the chain or ring of each entry: the end of a chain, the least of a ring."""
    least, onward = np.minimum(np.arange(len(following)), following), following
    for _ in range(longest.bit_length()):
        least, onward = np.minimum(least, least[onward]), onward[onward]
    return np.where(following[onward] == onward, onward, least)


def _lend(result: np.ndarray, vertices: np.ndarray, proper: np.ndarray) -> None:
    """Give corners of triangles with zero texture area the tangent of another corner at the same vertex."""
    lacking = np.flatnonzero(~proper)
    if not len(lacking):
        return
    given = np.flatnonzero(proper)
    known, first = np.unique(vertices[given], return_index=True)
    place = np.searchsorted(known, vertices[lacking])
    found = (
        known[np.minimum(place, len(known) - 1)] == vertices[lacking] if len(known) else np.zeros(len(lacking), bool)
    )
    result[lacking] = (1.0, 0.0, 0.0, -1.0)
    result[lacking[found]] = result[given[first[place[found]]]]


def _projected(normals: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return _unit(vectors - normals * (normals * vectors).sum(-1, keepdims=True))


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)
