# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bounding volume hierarchy over all triangles, curves and spheres of a scene, for shaders that traverse it
(``shaders_glsl/rays.glsl``).

A binary tree, split where the surface area heuristic is least over ``BINS`` bins of each axis (Wald 2007, "On fast
construction of SAH-based bounding volume hierarchies"). A mesh that is used once is in the tree of the world, in world
space. A mesh that is used more often has a separate tree, and the tree of the world has an item for each of its
instances. All trees are concatenated in the same arrays.
"""

from __future__ import annotations

import numpy as np

from ...affine import inverse
from ...jit import kernel
from ..kernels.rays import world_positions
from ..scene import Instance, Mesh, Primitive, Scene
from ..strands import Buffers, baked_instances, buffers, strand_of, tessellation

BINS = 16
LEAF = 4  # maximum number of items in a leaf
STEP_COST = 1.0  # cost of a node, in tests of an item
DEEPEST = 60  # levels of one tree; below, nodes become leaves of any size
MOST_IN_LEAF = 16  # maximum number of items in a reference to a leaf
CATCHER = -(1 << 31)  # the sign of a mask: of shadow catchers

# Boxes of the two children of a node, and their references: index of a node, or the complement of MOST_IN_LEAF × first
# item + (number of items − 1).
NODE = np.dtype(
    [
        ("left_low", np.float32, 3),
        ("left", np.int32),
        ("left_high", np.float32, 3),
        ("right", np.int32),
        ("right_low", np.float32, 3),
        ("unused", np.int32),
        ("right_high", np.float32, 3),
        ("unused_too", np.int32),
    ]
)

# A triangle, or an instance of a mesh with its own tree. For an instance, the primitive is −1, and the first two
# numbers of ``b`` are, bit by bit, its tree's first node and the index of its transform. A transform is an item, too,
# outside of all trees: the three rows of the matrix from the world to the mesh. For a segment of a curve, or a sphere,
# the primitive is −2 − its number, and the numbers of ``a`` are, bit by bit, the place of its first control point in
# words of four numbers, the number of its curve, and ``Primitive`` + ``KINDS`` × the pieces that a ribbon is divided
# into. Control points, with their radii, are outside of all trees, too, three to an item.
ITEM = np.dtype(
    [
        ("a", np.float32, 3),
        ("instance", np.int32),
        ("b", np.float32, 3),
        ("primitive", np.int32),
        ("c", np.float32, 3),
        ("mask", np.int32),
    ]
)

KINDS = 8
_POINTS = {Primitive.SPHERES: 1, Primitive.CONES: 2, Primitive.STRANDS: 4, Primitive.RIBBONS: 4}  # of a segment

_ROUNDING = np.float32(2.0**-22)  # relative growth of an instance's box, by its distance from the origin


@kernel
def _area(box):
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x if x >= 0.0 else 0.0


@kernel
def _grow(box, other):
    for k in range(3):
        box[k] = min(box[k], other[k])
        box[3 + k] = max(box[3 + k], other[3 + k])


@kernel
def _clear(box):
    for k in range(3):
        box[k], box[3 + k] = np.inf, -np.inf


@kernel
def _split(boxes, order, first, last, bins, counts, sweep, box):
    """Where to split the items first … last − 1: (axis, bin, cost); axis −1 if their centres coincide. ``box`` gets the
    box of the centres' doubled coordinates."""
    _clear(box)
    for i in range(first, last):
        item = boxes[order[i]]
        for k in range(3):
            center = item[k] + item[3 + k]
            box[k], box[3 + k] = min(box[k], center), max(box[3 + k], center)
    best_axis, best_bin, best = -1, 0, np.inf
    for axis in range(3):
        extent = box[3 + axis] - box[axis]
        if not extent > 0.0:
            continue
        scale = BINS * (1.0 - 1e-6) / extent
        for b in range(BINS):
            counts[b] = 0
            _clear(bins[b])
        for i in range(first, last):
            item = boxes[order[i]]
            b = int((item[axis] + item[3 + axis] - box[axis]) * scale)
            counts[b] += 1
            _grow(bins[b], item)
        _clear(sweep[0])
        count = 0
        for b in range(BINS - 1, 0, -1):  # bins b and above
            _grow(sweep[0], bins[b])
            count += counts[b]
            sweep[b, 6] = _area(sweep[0]) * count if count > 0 else 0.0
        _clear(sweep[0])
        count = 0
        for b in range(BINS - 1):
            _grow(sweep[0], bins[b])
            count += counts[b]
            cost = (_area(sweep[0]) * count if count > 0 else 0.0) + sweep[b + 1, 6]
            if cost < best and 0 < count < last - first:
                best_axis, best_bin, best = axis, b + 1, cost
    return best_axis, best_bin, best


@kernel
def _partition(boxes, order, first, last, axis, where, box):
    """Move the items whose centre is in a bin below ``where`` to the front. Returns the first index of the others."""
    scale = BINS * (1.0 - 1e-6) / (box[3 + axis] - box[axis])
    i, j = first, last - 1
    while i <= j:
        item = boxes[order[i]]
        if int((item[axis] + item[3 + axis] - box[axis]) * scale) < where:
            i += 1
        else:
            order[i], order[j] = order[j], order[i]
            j -= 1
    return i


@kernel
def grow(boxes, order, nodes, offset, base):
    """Build a tree over ``boxes`` (n, 6: low and high corner), n ≥ 1, into ``nodes``.

    Returns the number of nodes, and the maximum depth.

    ``order`` (n,), initially 0 … n − 1, becomes the order of the items. ``offset`` is the index of the first node,
    ``base`` that of the first item, among those of all trees.
    """
    bins, counts, sweep = np.empty((BINS, 6)), np.empty(BINS, np.int64), np.empty((BINS, 7))
    box, whole = np.empty(6), np.empty(6)
    # Waiting ranges: first item, last, parent node and side, level.
    waiting = np.empty((2 * DEEPEST + 4, 5), np.int64)
    waiting[0, 0], waiting[0, 1], waiting[0, 2], waiting[0, 3], waiting[0, 4] = 0, len(order), 0, 0, 0
    used, depth, deepest = 1, 1, 1
    nodes[0].right_low[:], nodes[0].right_high[:] = np.inf, -np.inf
    nodes[0].right = ~(MOST_IN_LEAF * base)
    while depth > 0:
        depth -= 1
        first, last, parent, side, level = waiting[depth]
        _clear(whole)
        for i in range(first, last):
            _grow(whole, boxes[order[i]])
        count = last - first
        axis, where, cost = -1, 0, np.inf
        if count > 1 and level < DEEPEST:
            axis, where, cost = _split(boxes, order, first, last, bins, counts, sweep, box)
        area = _area(whole)
        leaf = count <= MOST_IN_LEAF and (axis < 0 or (count <= LEAF and cost + STEP_COST * area >= area * count))
        if leaf:
            reference = ~(MOST_IN_LEAF * (base + first) + count - 1)
        else:
            middle = (first + last) // 2
            if axis >= 0:
                middle = _partition(boxes, order, first, last, axis, where, box)
            reference = offset + used
            for part in range(2):
                row = waiting[depth + part]
                row[0], row[1] = (first, middle) if part == 0 else (middle, last)
                row[2], row[3], row[4] = used, part, level + 1
            depth += 2
            used += 1
            deepest = max(deepest, level + 2)
        node = nodes[parent]
        if side == 0:
            node.left_low[:], node.left_high[:], node.left = whole[:3], whole[3:], reference
        else:
            node.right_low[:], node.right_high[:], node.right = whole[:3], whole[3:], reference
    return used, deepest


class Hierarchy:
    """The trees of a scene:
    ``nodes`` (``NODE``), of which the world's begin at ``root``, ``items`` (``ITEM``) and ``baked`` (instances,), True
    if their triangles are in the world’s tree. ``depth`` bounds the stack of a ray. ``strands``: kinds of curves and
    spheres that are there."""

    def __init__(self, scene: Scene, masks: list[int]):
        """``masks``: kinds of rays (``rays.Ray`` bits) that see each instance."""
        self.baked = baked_instances(scene)
        self._nodes, self._items, self._points, self._point_count = [], [], [np.zeros((0, 4), np.float32)], 0
        self._node_count = self._item_count = 0
        self._deepest = 0
        items, boxes, roots = [], [], {}
        for index, instance in enumerate(scene.instances):
            mesh = scene.meshes[instance.mesh]
            if not len(mesh.triangles):
                continue
            if self.baked[index]:
                part, own = self._parts(mesh, instance.matrix)
                part["instance"], part["mask"] = index, masks[index]
                items.append(part)
                boxes.append(own)
                continue
            if instance.mesh not in roots:
                part, own = self._parts(mesh)
                roots[instance.mesh] = self._add(part, own), own
            root, own = roots[instance.mesh]
            items.append(_instance(index, root, masks[index]))
            boxes.append(_placed(own, instance))
        if not items:  # an empty node
            self._nodes.append(np.zeros(1, NODE))
            self._nodes[0]["left_low"] = self._nodes[0]["right_low"] = np.inf
            self._nodes[0]["left_high"] = self._nodes[0]["right_high"] = -np.inf
            self._nodes[0]["left"] = self._nodes[0]["right"] = -1
            self._items.append(np.zeros(1, ITEM))
            self.root, own = 0, 0
        else:
            own, self._deepest = self._deepest, 0
            self.root = self._add(np.concatenate(items), np.concatenate(boxes))
        self.depth = own + self._deepest + 4  # and the rest of a leaf, the end of an instance and that of all
        self.nodes, self.items = np.concatenate(self._nodes), np.concatenate(self._items)
        self.instanced = bool(roots)
        if self.instanced:
            self._add_places(scene)
        used = {scene.meshes[instance.mesh].primitive for instance in scene.instances}
        self.strands = sorted(used - {Primitive.TRIANGLES})
        if self.strands:
            self._add_points()

    def _parts(self, mesh: Mesh, matrix: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """The items of a mesh and their boxes, in world space by ``matrix``, or in local space."""
        if mesh.primitive == Primitive.TRIANGLES:
            positions = mesh.positions if matrix is None else world_positions(mesh.positions, matrix)
            part = _triangles(positions, mesh.triangles)
            return part, _boxes(part)
        given = buffers(mesh, matrix)
        part = _strands(mesh, given, self._point_count)
        self._points.append(given.vertices[0])
        self._point_count += len(given.vertices[0])
        return part, _boxes_of_strands(mesh, given)

    def _add(self, items: np.ndarray, boxes: np.ndarray) -> int:
        """Build a tree. Returns the index of its first node."""
        order, nodes = np.arange(len(items)), np.zeros(max(len(items), 1), NODE)
        count, deepest = grow(boxes, order, nodes, self._node_count, self._item_count)
        root, self._deepest = self._node_count, max(self._deepest, deepest)
        self._nodes.append(nodes[:count])
        self._items.append(items[order])
        self._node_count += count
        self._item_count += len(items)
        return root

    def _add_places(self, scene: Scene) -> None:
        """Write the indices of transforms, which come after all other items, into the items of instances."""
        rows = np.flatnonzero(self.items["primitive"] < 0)
        inverses = np.array([inverse(scene.instances[index].matrix) for index in self.items["instance"][rows]])
        self.items["b"][rows, 1] = (
            (len(self.items) + np.arange(len(rows), dtype=np.int32)).astype(np.int32).view(np.float32)
        )
        places = np.ascontiguousarray(inverses[:, :3, :], np.float32).reshape(-1, 12).view(ITEM)
        self.items = np.concatenate([self.items, places[:, 0]])

    def _add_points(self) -> None:
        """Append the control points, and place the items that refer to them."""
        rows = np.flatnonzero(self.items["primitive"] < -1)
        numbers = self.items["a"].view(np.int32)
        numbers[rows, 0] += 3 * len(self.items)
        points = np.concatenate([*self._points, np.zeros((-self._point_count % 3, 4), np.float32)])
        self.items = np.concatenate([self.items, points.reshape(-1, 12).view(ITEM)[:, 0]])


def _strands(mesh: Mesh, given: Buffers, first: int) -> np.ndarray:
    """Items of curves or spheres, whose control points begin at the number ``first``."""
    rows = np.zeros(len(mesh.triangles), ITEM)
    numbers = rows["a"].view(np.int32)
    numbers[:, 0] = first + _first_points(mesh, given)
    numbers[:, 1] = strand_of(mesh)
    numbers[:, 2] = int(mesh.primitive) + KINDS * int(tessellation(mesh))
    rows["primitive"] = -2 - np.arange(len(rows))
    return rows


def _first_points(mesh: Mesh, given: Buffers) -> np.ndarray:
    """Numbers of the first control points of segments, or of spheres, among those of a mesh."""
    return mesh.triangles[:, 0].astype(np.int64) if given.indices is None else given.indices.astype(np.int64)


def _boxes_of_strands(mesh: Mesh, given: Buffers) -> np.ndarray:
    """(segments, 6) boxes around curves, or spheres, with their radii."""
    count = _POINTS[mesh.primitive]
    points = given.vertices[0].astype(np.float64)[_first_points(mesh, given)[:, None] + np.arange(count)]
    if count == 4:  # the curve is in the hull of its control points by Bézier
        before, start, end, after = points.swapaxes(0, 1)
        points = np.stack([start, start + (end - before) / 6.0, end - (after - start) / 6.0, end], 1)
    places, radius = points[..., :3], np.abs(points[..., 3:]).max(1)
    size = radius + _ROUNDING * np.abs(places).max((1, 2))[:, None]
    return np.concatenate([places.min(1) - size, places.max(1) + size], 1)


def _triangles(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    rows = np.zeros(len(triangles), ITEM)
    corners = np.asarray(positions, np.float32)[triangles]
    rows["a"], rows["b"], rows["c"] = corners[:, 0], corners[:, 1], corners[:, 2]
    rows["primitive"] = np.arange(len(triangles))
    return rows


def _boxes(rows: np.ndarray) -> np.ndarray:
    corners = np.stack([rows["a"], rows["b"], rows["c"]])
    return np.concatenate([corners.min(axis=0), corners.max(axis=0)], axis=1).astype(np.float64)


def _instance(index: int, root: int, mask: int) -> np.ndarray:
    row = np.zeros(1, ITEM)
    row["instance"], row["primitive"], row["mask"] = index, -1, mask
    row["b"][0, 0] = np.array(root, np.int32).view(np.float32)
    return row


def _placed(boxes: np.ndarray, instance: Instance) -> np.ndarray:
    """Box in the world of all boxes of a mesh."""
    low, high = boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)
    middle = instance.matrix[:3, :3] @ (0.5 * (low + high)) + instance.matrix[:3, 3]
    half = np.abs(instance.matrix[:3, :3]) @ (0.5 * (high - low))
    half += _ROUNDING * (np.abs(middle) + half)
    return np.concatenate([middle - half, middle + half])[None]
