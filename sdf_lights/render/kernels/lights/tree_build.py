# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The light tree: built here in NumPy, one level at a time.

Conty Estevez and Kulla 2018, "Importance sampling of many lights with adaptive tree splitting", PACMCGIT 1(2): a binary
tree over all emitters of finite extent. A node has the sum of their intensities, its mean position and the variance of
that, and bounds their directions of emission by a cone. Clusters are split where the metric of Walter et al. 2005,
"Lightcuts" (intensity × squared extent of positions and axes), is least.

Emitters that are larger than the whole cluster, by the positions of their middles, become one child of it. Among small
emitters, one long strip would make the mean position and the variance of every node above it meaningless.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .records import NODE

# An axis of emission spans up to 2. This factor makes opposite axes half as far apart as the ends of the cluster's box.
AXIS_SCALE = 0.25
CANDIDATES = 8
BRIGHTEST = 1e28  # maximum intensity of an emitter, so that sums of billions fit into single precision
# Variance along an axis of an emitter's light, relative to the square of half its box: that of a shell slightly thicker
# than a ball.
SPREAD = 0.25


@dataclass
class Bounds:
    """Data of m emitters for the tree."""

    emitter: np.ndarray  # (m,)
    lo: np.ndarray  # (m, 3)
    hi: np.ndarray  # (m, 3)
    axis: np.ndarray  # (m, 3) axis of the cone of normals, unit length; anything if cos_o is −1
    cos_o: np.ndarray  # (m,) of the half angle of that cone
    cos_e: np.ndarray  # (m,) of the angle around each normal within which light is emitted
    intensity: np.ndarray  # (m,) average of RGB, along the normal, W/sr
    two_sided: np.ndarray  # (m,) bool


def joined(parts: list[Bounds | None]) -> Bounds | None:
    """Bounds of emitters at several times, each emitter once, large enough for all of them."""
    known = [part for part in parts if part is not None and len(part.emitter)]
    if not known:
        return None
    every = Bounds(**{name: np.concatenate([getattr(part, name) for part in known]) for name in vars(known[0])})
    emitter, first, row = np.unique(every.emitter, return_index=True, return_inverse=True)
    row = row.ravel()
    wide = Bounds(emitter, *(getattr(every, name)[first].copy() for name in list(vars(every))[1:]))
    np.minimum.at(wide.lo, row, every.lo)
    np.maximum.at(wide.hi, row, every.hi)
    np.minimum.at(wide.cos_e, row, every.cos_e)
    np.maximum.at(wide.intensity, row, every.intensity)
    np.logical_or.at(wide.two_sided, row, every.two_sided)
    total = np.zeros((len(emitter), 3))
    np.add.at(total, row, every.axis)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    turns = (every.axis != wide.axis[row]).any(axis=1)
    turning = np.zeros(len(emitter), bool)
    np.logical_or.at(turning, row, turns)
    wide.axis[turning] = (total / np.where(length > 0.0, length, 1.0))[turning]
    away = np.arccos(np.clip((every.axis * wide.axis[row]).sum(axis=1), -1.0, 1.0)) * turning[row]
    reach = away + np.arccos(np.clip(every.cos_o, -1.0, 1.0))
    widest = np.zeros(len(emitter))
    np.maximum.at(widest, row, reach)
    wide.cos_o[:] = np.where(turning | (widest > np.arccos(wide.cos_o)), np.cos(np.minimum(widest, np.pi)), wide.cos_o)
    return wide


@dataclass
class Tree:
    """A binary tree over m emitters."""

    nodes: np.ndarray  # (2m − 1,) NODE: root first, children adjacent and after their parent
    leaf: np.ndarray  # (m,) node of each emitter, in the order of the bounds
    lo: np.ndarray  # (2m − 1, 3) corners of the box of each node
    hi: np.ndarray


def build_tree(bounds: Bounds) -> Tree:
    """The tree over all emitters in ``bounds``."""
    count = len(bounds.emitter)
    size = max(2 * count - 1, 0)
    nodes, leaf = np.zeros(size, NODE), np.zeros(count, np.int32)
    tree = Tree(nodes, leaf, np.zeros((size, 3)), np.zeros((size, 3)))
    low = np.concatenate((bounds.lo, np.where(bounds.cos_o[:, None] > -1.0, bounds.axis, 0.0)), axis=1)
    high = np.concatenate((bounds.hi, low[:, 3:]), axis=1)
    middle = 0.5 * (low + high)
    square = np.sum((bounds.hi - bounds.lo) ** 2, axis=1)  # of the diagonals of the boxes

    items, sizes = np.arange(count), np.array([count])
    levels, first = [], 0
    while len(items):
        ids = first + np.arange(len(sizes))
        first += len(sizes)
        starts = np.cumsum(sizes) - sizes
        is_leaf = sizes == 1
        members = items[starts[is_leaf]]
        leaf[members] = ids[is_leaf]
        nodes["child"][ids[is_leaf]] = ~bounds.emitter[members]

        inner, inner_sizes = ids[~is_leaf], sizes[~is_leaf]
        items = items[np.repeat(~is_leaf, sizes)]
        levels.append((ids[is_leaf], members, inner))
        if not len(items):
            break
        items, left = _split(items, inner_sizes, low, high, middle, square, bounds.intensity)
        children = first + 2 * np.arange(len(inner))
        nodes["child"][inner] = children
        sizes = np.stack((left, inner_sizes - left), axis=1).ravel()

    below = np.ones(size, np.int64)  # leaves
    place = np.zeros((size, 6))  # centroid and spread
    for leaves, members, inner in reversed(levels):
        _fill_leaves(tree, place, leaves, members, bounds)
        _fill_inner(tree, place, inner)
        first = nodes["child"][inner]
        below[inner] = below[first] + below[first + 1]
    for _, _, inner in levels:
        first = nodes["child"][inner]
        nodes["order"][first] = nodes["order"][inner]
        nodes["order"][first + 1] = nodes["order"][inner] + below[first]
    nodes["centroid"], nodes["spread"] = place[:, :3], place[:, 3:]
    reach = np.maximum(tree.hi - nodes["centroid"], nodes["centroid"] - tree.lo)
    nodes["radius"] = np.nextafter(np.linalg.norm(reach, axis=1).astype(np.float32), np.float32(np.inf))
    return tree


def _split(items, sizes, low, high, middle, square, intensity) -> tuple[np.ndarray, np.ndarray]:
    """Order the items of every cluster along its longest axis, those that are larger than it last. Returns how many of
    them go to the first child."""
    starts = np.cumsum(sizes) - sizes
    cluster = np.repeat(np.arange(len(sizes)), sizes)
    places = middle[items]
    least, extent = np.minimum.reduceat(places, starts), np.maximum.reduceat(places, starts)
    extent -= least
    scaled = extent.copy()
    scaled[:, 3:] *= AXIS_SCALE * np.linalg.norm(extent[:, :3], axis=1, keepdims=True)
    longest = np.argmax(scaled, axis=1)
    rows = np.arange(len(sizes))
    offset, span = least[rows, longest], extent[rows, longest]
    # One sort for all clusters: the cluster before the point, and the position in it after.
    along = places[np.arange(len(items)), longest[cluster]] - offset[cluster]
    along /= np.where(span > 0.0, 2.0 * span, 1.0)[cluster]
    is_large = square[items] > np.sum(extent[:, :3] ** 2, axis=1)[cluster]
    large_ones = np.add.reduceat(is_large.astype(np.int64), starts)
    mixed = (large_ones > 0) & (large_ones < sizes)
    along = np.where(mixed[cluster], 0.5 * along + 0.5 * is_large, along)
    items = items[np.argsort(cluster + along, kind="stable")]

    left = np.where(mixed, sizes - large_ones, sizes // 2)
    large = np.flatnonzero((sizes >= 2 * CANDIDATES) & ~mixed)  # clusters
    if len(large):
        cuts = starts[large, None] + sizes[large, None] * np.arange(CANDIDATES) // CANDIDATES
        ends = np.empty(2 * len(large), np.int64)
        ends[0::2], ends[1::2] = starts[large], starts[large] + sizes[large]
        # Small clusters in between fall into separate groups, which are dropped.
        groups = np.unique(np.concatenate((cuts.ravel(), ends[ends < len(items)])))
        keep = np.searchsorted(groups, cuts)
        lo = np.minimum.reduceat(low[items], groups)[keep]
        hi = np.maximum.reduceat(high[items], groups)[keep]
        power = np.add.reduceat(intensity[items], groups)[keep]
        cost = _cost(lo, hi, power)[:, :-1] + _cost(lo[:, ::-1], hi[:, ::-1], power[:, ::-1])[:, -2::-1]
        left[large] = cuts[np.arange(len(large)), np.argmin(cost, axis=1) + 1] - starts[large]
    return items, left


def _cost(lo, hi, power) -> np.ndarray:
    """Intensity × squared extent of the first 1, 2, … groups of each cluster: (k, groups, 6) -> (k, groups)."""
    extent = np.maximum.accumulate(hi, axis=1) - np.minimum.accumulate(lo, axis=1)
    space = np.sum(extent[..., :3] ** 2, axis=2)
    axes = np.sum(extent[..., 3:] ** 2, axis=2) * AXIS_SCALE**2
    return np.cumsum(power, axis=1) * space * (1.0 + axes)


def _fill_leaves(tree, place, leaves, members, bounds) -> None:
    for name in ("axis", "cos_o", "cos_e", "two_sided"):
        tree.nodes[name][leaves] = getattr(bounds, name)[members]
    tree.nodes["intensity"][leaves] = np.minimum(bounds.intensity[members], BRIGHTEST)
    tree.lo[leaves], tree.hi[leaves] = bounds.lo[members], bounds.hi[members]
    place[leaves, :3] = 0.5 * (bounds.lo[members] + bounds.hi[members])
    place[leaves, 3:] = SPREAD * (0.5 * (bounds.hi[members] - bounds.lo[members])) ** 2


def _fill_inner(tree, place, inner) -> None:
    nodes, first = tree.nodes, tree.nodes["child"][inner]
    a, b = nodes[first], nodes[first + 1]
    tree.lo[inner] = np.minimum(tree.lo[first], tree.lo[first + 1])
    tree.hi[inner] = np.maximum(tree.hi[first], tree.hi[first + 1])
    total = a["intensity"].astype(float) + b["intensity"]
    share = (b["intensity"] / np.where(total > 0.0, total, 1.0))[:, None]
    apart = place[first + 1, :3] - place[first, :3]
    place[inner] = (1.0 - share) * place[first] + share * place[first + 1]
    place[inner, 3:] += share * (1.0 - share) * apart**2
    nodes["cos_e"][inner] = np.minimum(a["cos_e"], b["cos_e"])
    nodes["intensity"][inner] = a["intensity"] + b["intensity"]
    nodes["two_sided"][inner] = a["two_sided"] | b["two_sided"]
    axis, cos_o = _union(a, b)
    nodes["axis"][inner] = axis
    nodes["cos_o"][inner] = cos_o


def _union(a, b) -> tuple[np.ndarray, np.ndarray]:
    """Cone around two cones of normals (Conty Estevez and Kulla 2018, algorithm 1)."""
    axis_a, axis_b = a["axis"].astype(float), b["axis"].astype(float)
    cosine = np.sum(axis_a * axis_b, axis=1)
    flip = (a["two_sided"] & b["two_sided"] & (cosine < 0.0)).astype(bool)
    axis_b[flip] *= -1.0
    between = np.arccos(np.clip(np.where(flip, -cosine, cosine), -1.0, 1.0))
    half_a = np.arccos(np.clip(a["cos_o"].astype(float), -1.0, 1.0))
    half_b = np.arccos(np.clip(b["cos_o"].astype(float), -1.0, 1.0))
    half = np.minimum(0.5 * (half_a + between + half_b), np.pi)
    turn = half - half_a
    normal = np.cross(axis_a, axis_b)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    side = np.cross(normal / np.where(length > 0.0, length, 1.0), axis_a)
    axis = axis_a * np.cos(turn)[:, None] + side * np.sin(turn)[:, None]
    # Opposite or equal axes leave the side undefined: use all directions, unless one cone contains the other.
    half = np.where((length[:, 0] < 1e-6) & (between > 1.0), np.pi, half)
    a_holds, b_holds = between + half_b <= half_a, between + half_a <= half_b
    axis = np.where(a_holds[:, None], axis_a, np.where(b_holds[:, None], axis_b, axis))
    half = np.where(a_holds, half_a, np.where(b_holds, half_b, half))
    norm = np.linalg.norm(axis, axis=1, keepdims=True)
    axis /= np.where(norm > 0.0, norm, 1.0)
    return axis, np.cos(np.minimum(half + 1e-6, np.pi))
