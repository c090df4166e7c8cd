# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What interior trees claim of their boxes, at random points in each of them."""

import time
from dataclasses import dataclass

import numpy as np
import pytest

from sdf_lights.emitter.building import build, pack, remarks
from sdf_lights.emitter.intersection import fields
from sdf_lights.emitter.intersection.fields import LANES, NEGATED, STACK, VALUES
from sdf_lights.emitter.intersection.membership import contains
from sdf_lights.emitter.tree import interior
from sdf_lights.emitter.tree.interior import TreeError
from sdf_lights.emitter.tree.nodes import BOUNDARY, INSIDE, OUTSIDE
from sdf_lights.emitter.tree.points import tree_point
from sdf_lights.graph.formula import sqrt
from sdf_lights.jit import kernel, stack_array
from sdf_lights.sdf.expression import Expression
from sdf_lights.sdf.shapes import (
    Box,
    Capsule,
    Cylinder,
    Difference,
    Exclusive,
    Intersection,
    Shape,
    Sphere,
    Torus,
    Transformed,
    Union,
)
from sdf_lights.sdf.shapes.blends import SmoothDifference, SmoothUnion
from sdf_lights.sdf.shapes.layers import Onion
from sdf_lights.sdf.shapes.warps import Twist
from support.lamps.shapes_under_test import COMPOSITES, LAMPS, PLACEMENTS, FieldOf, moved, turned

SIGNED = {
    # Operands that win with their sign changed, nested so that signs cancel.
    "cut": Difference(Sphere(0.9), Difference(Box((0.7, 0.7, 0.7)), Difference(Sphere(0.8), Torus(0.5, 0.2)))),
    "xor": Exclusive(
        Sphere(0.6), Transformed(Box((0.5, 0.4, 0.3)), moved(0.3)), Transformed(Torus(0.6, 0.2), turned(1))
    ),
    "smooth_cut": SmoothDifference(
        Box((0.7, 0.7, 0.7)), Sphere(0.8), Transformed(Capsule(0.1, 2.0), turned(1.0, 1)), radius=0.05
    ),
}
WITH_TREE = {name: shape for name, shape in {**LAMPS, **SIGNED}.items() if not build._is_primitive(shape)}


@kernel
def field_values(terms, parameters, nodes, boxes, lists, numbers, points, pruned):
    """LANES random points of each box, and the value of the node's list there; NaN where the state is certain."""
    stack = stack_array(STACK)
    for index in range(len(nodes)):
        for lane in range(LANES):
            for k in range(3):
                low, high = boxes[index, k], boxes[index, 3 + k]
                points[index, lane, k] = low + numbers[index, lane, k] * (high - low)
                stack[k * LANES + lane] = points[index, lane, k]
        node = nodes[index]
        if node.row_count > 0:
            fields.run_terms(terms, parameters, lists, node.row_first, node.row_count, fields.LANES, stack)
        for lane in range(LANES):
            pruned[index, lane] = stack[VALUES + lane] if node.row_count > 0 else np.nan


@kernel
def program_values(program, nodes, boxes, lists, numbers, points, pruned, whole):
    """As ``field_values``: 1.0 inside and 0.0 outside, by the list of the node and by the whole program."""
    for index in range(len(nodes)):
        node = nodes[index]
        chosen = lists[node.row_first : node.row_first + node.row_count]
        for lane in range(LANES):
            for k in range(3):
                low, high = boxes[index, k], boxes[index, 3 + k]
                points[index, lane, k] = low + numbers[index, lane, k] * (high - low)
            p = (points[index, lane, 0], points[index, lane, 1], points[index, lane, 2])
            whole[index, lane] = 1.0 if contains(program, p) else 0.0
            pruned[index, lane] = (1.0 if contains(program, p, chosen) else 0.0) if node.row_count > 0 else np.nan


def at_random(tree, seed=0):
    """Points (nodes, LANES, 3) of every node's box in tree space, and the values of the node's list there."""
    numbers = np.random.default_rng(seed).random((len(tree.nodes), LANES, 3))
    points, pruned = np.empty(numbers.shape), np.empty(numbers.shape[:2])
    if tree.field is None:
        whole = np.empty(numbers.shape[:2])
        program_values(tree.program, tree.nodes, tree.boxes, tree.lists, numbers, points, pruned, whole)
        return points, pruned, whole
    field_values(*tree.arrays, tree.nodes, tree.boxes, tree.lists, numbers, points, pruned)
    return points, pruned, None


@pytest.mark.parametrize("name", WITH_TREE)
def test_boxes_keep_their_promises(name):
    """Certain boxes have one sign. Pruned lists have that of the whole, and no slope exceeds the box's bound."""
    shape = WITH_TREE[name]
    tree = interior.tree(shape)
    points, pruned, whole = at_random(tree)
    distance = shape.distance(points + tree.center)
    state = tree.nodes["state"]
    assert (state[tree.nodes["first"] >= 0] == BOUNDARY).all()
    assert (distance[state == INSIDE] <= 1e-12).all() and (distance[state == OUTSIDE] >= -1e-12).all()
    listed = tree.nodes["row_count"] > 0
    assert np.array_equal(listed, state == BOUNDARY)
    if tree.field is None:
        assert np.array_equal(pruned[listed], whole[listed])
        assert np.array_equal(whole[listed] == 1.0, distance[listed] <= 0.0)
        return
    check_lists(tree, points, pruned, distance)


def check_lists(tree, points, pruned, distance):
    listed = np.flatnonzero(tree.nodes["row_count"] > 0)
    points, pruned, distance = points[listed], pruned[listed], distance[listed]
    clear = np.abs(distance) > 1e-12
    assert np.array_equal((pruned <= 0.0)[clear], (distance <= 0.0)[clear])
    assert (np.abs(pruned) >= np.abs(distance) - 1e-12).all()
    rise = np.abs(np.diff(pruned, axis=1))
    run = np.linalg.norm(np.diff(points, axis=1), axis=2)
    slope = tree.nodes["lipschitz"][listed, None]
    assert (rise <= slope * run * (1.0 + 1e-9) + 1e-12)[np.isfinite(slope[:, 0])].all()


@pytest.mark.parametrize("name", WITH_TREE)
def test_boxes_fill_their_parents(name):
    tree = interior.tree(WITH_TREE[name])
    nodes, boxes = tree.nodes, tree.boxes
    assert np.array_equal(boxes[0], [*-tree.half, *tree.half])
    inner = np.flatnonzero(nodes["first"] >= 0)
    first, axis = nodes["first"][inner], nodes["axis"][inner]
    for side in (0, 1):
        expected = boxes[inner].copy()
        expected[np.arange(len(inner)), axis + 3 * (1 - side)] = nodes["split"][inner]
        assert np.array_equal(boxes[first + side], expected)
    volume = np.prod(boxes[:, 3:] - boxes[:, :3], axis=1)
    leaf = nodes["first"] < 0
    assert np.allclose(nodes["mass"][leaf], np.where(nodes["state"][leaf] == OUTSIDE, 0.0, volume[leaf]))
    assert np.allclose(nodes["mass"][inner], nodes["mass"][first] + nodes["mass"][first + 1])
    children = np.concatenate([first, first + 1])
    assert len(np.unique(children)) == len(nodes) - 1 and (children > np.tile(inner, 2)).all()


@pytest.mark.parametrize("name", ["twenty", "twenty_as_field", "cut"])
def test_lists_become_short(name):
    """At the surface of twenty primitives one or two matter, whatever kind of lamp it is."""
    tree = interior.tree(WITH_TREE[name])
    assert tree.nodes["row_count"][tree.boundary].mean() < 0.25 * tree.nodes["row_count"][0]


def test_signs_of_operands_that_win():
    for shape in (SIGNED["cut"], FieldOf(SIGNED["cut"])):
        tree = interior.tree(shape)
        assert NEGATED in tree.lists
        signs = [
            tree.lists[row["row_first"] : row["row_first"] + row["row_count"]] for row in tree.nodes[tree.boundary]
        ]
        assert not any(np.any((row[1:] == NEGATED) & (row[:-1] == NEGATED)) for row in signs)


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_bounds_are_tightened(placement):
    """The box of an intersection and of a smooth difference, whose formulas bound them loosely, follows their boxes."""
    matrix = PLACEMENTS[placement]
    lens = Intersection(Sphere(1.0), Transformed(Sphere(1.0), moved(1.6)))
    for shape in (lens, FieldOf(lens)):
        tree = interior.tree(shape)
        low, high = tree.bounds(matrix)
        rng = np.random.default_rng(1)
        box_low, box_high = shape.bounds()
        points = box_low + rng.random((200_000, 3)) * (box_high - box_low)
        points = points[shape.distance(points) <= 0.0] @ matrix[:3, :3].T + matrix[:3, 3]
        assert len(points) > 1000
        assert (points >= low).all() and (points <= high).all()
        row = build.build_lamp("lens", shape, matrix).row
        assert np.all(2.0 * row["half"] <= np.subtract(*shape.bounds(matrix)[::-1]) * (1.0 + 1e-12))
    extent = np.subtract(*tree.bounds(np.eye(4))[::-1])
    assert extent[1] < 1.35 and extent[0] < 0.45  # of a lens 1.2 across, where the box of either ball is 2 across


@kernel
def many_points(nodes, low, high, numbers, points, leaves):
    for i in range(len(numbers)):
        q, leaf = tree_point(nodes, low, high, numbers[i, 0], numbers[i, 1], numbers[i, 2])
        points[i, 0], points[i, 1], points[i, 2] = q
        leaves[i] = leaf


@pytest.mark.parametrize("name", ["nested", "blob"])
def test_points_of_the_boxes(name):
    """They lie in the leaf that they are said to lie in, and leaves are hit in proportion to their volumes."""
    tree = interior.tree(WITH_TREE[name])
    n = 200_000
    points, leaves = np.empty((n, 3)), np.empty(n, np.int64)
    many_points(tree.nodes, -tree.half, tree.half, np.random.default_rng(2).random((n, 3)), points, leaves)
    assert (tree.nodes["first"][leaves] < 0).all()
    assert (points >= tree.boxes[leaves, :3]).all() and (points <= tree.boxes[leaves, 3:]).all()
    counts = np.bincount(leaves, minlength=len(tree.nodes))
    leaf = tree.nodes["first"] < 0
    expected = n * tree.nodes["mass"][leaf] / tree.nodes["mass"][0]
    counts = counts[leaf]
    assert (counts[expected == 0.0] == 0).all()
    order = np.argsort(expected)
    pooled = [np.add.reduceat(values[order], np.arange(0, len(order), 50)) for values in (counts, expected)]
    keep = pooled[1] > 20.0
    statistic = np.sum((pooled[0] - pooled[1])[keep] ** 2 / pooled[1][keep])
    assert abs(statistic - keep.sum()) < 5.0 * np.sqrt(2.0 * keep.sum())


def test_trees_are_kept():
    """A lamp that moves, or whose power changes, keeps the tree of its shape; equal shapes have one tree."""
    shape = Difference(Box((0.3, 0.4, 0.5)), Sphere(0.45))
    same = Difference(Box((0.3, 0.4, 0.5)), Sphere(0.45))
    built = [
        build.build_lamp("lamp", s, matrix, power)
        for s, matrix, power in (
            (shape, np.eye(4), 1.0),
            (same, PLACEMENTS["turned"], 5.0),
            (shape, PLACEMENTS["sheared"], 2.0),
        )
    ]
    assert built[0].tree is built[1].tree is built[2].tree
    other = build.build_lamp("other", Difference(Box((0.3, 0.4, 0.5)), Sphere(0.46)), np.eye(4))
    assert other.tree is not built[0].tree
    tables = pack.pack_lamps(built)
    assert len(tables["lamp_nodes"]) == len(built[0].tree.nodes)
    assert not any(array.flags.writeable for array in (built[0].tree.nodes, built[0].tree.lists, built[0].tree.boxes))


EXPRESSIONS = {
    "gyroid": "field(max(abs(sin(6*p.x)*cos(6*p.y) + sin(6*p.y)*cos(6*p.z) + sin(6*p.z)*cos(6*p.x)) - 0.3, "
    "length(p) - 0.8))",
    "quartic": "field(p.x**4 + p.y**4 + p.z**4 - 0.3)",
    "joined": "union(field(p.x**4 + p.y**4 + p.z**4 - 0.1), translate(torus(0.5, 0.1), (0.3, 0, 0)))",
}


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_bounds_found_box_by_box(name):
    """Formulas without a bound for all of space, alone and as a part of something."""
    shape = Expression(EXPRESSIONS[name]).shape({})
    assert shape.lipschitz == np.inf
    tree = interior.tree(shape)
    assert tree.certified
    assert np.isfinite(tree.nodes["lipschitz"][tree.boundary]).all()
    points, pruned, _ = at_random(tree)
    distance = shape.distance(points + tree.center)
    assert (distance[tree.nodes["state"] == INSIDE] <= 0.0).all()
    assert (distance[tree.nodes["state"] == OUTSIDE] >= 0.0).all()
    check_lists(tree, points, pruned, distance)


def test_where_no_bound_exists():
    """A slope without limit at x = 0: the tree works with what it measures, and says so."""
    shape = Expression("field(length(p) - 1 + abs(p.x) ** 0.5)").shape({})
    tree = interior.tree(shape)
    assert not tree.certified
    assert np.isfinite(tree.nodes["lipschitz"][tree.boundary]).all()
    lamp = build.build_lamp("Spindle", shape, np.eye(4))
    (sentence,) = remarks.doubts([lamp])
    assert sentence.startswith("Lamp “Spindle”: ") and sentence.endswith(".")
    # The slice at x is a disk of the radius √((1 − √|x|)² − x²).
    x = (np.arange(1_000_000) + 0.5) * 0.5e-6
    exact = 2.0 * np.pi * np.maximum((1.0 - np.sqrt(x)) ** 2 - x**2, 0.0).sum() * 0.5e-6
    assert abs(lamp.row["volume"][0] / exact - 1.0) < 2e-3


@dataclass(frozen=True)
class Torn(Shape, abstract=True):
    """A ball of which the field is undefined where x < 0.2."""

    lipschitz = np.inf

    def build(self, p, slot):
        return p.length() - 1.0 + 0.001 * sqrt(p.x - 0.2)

    def bounds(self, matrix=None):
        return Sphere(1.0).bounds(matrix)


def test_undefined_is_outside():
    """There is no light, and no error."""
    shape = Torn()
    tree = interior.tree(shape)
    points, pruned, _ = at_random(tree)
    assert not (np.isnan(shape.distance(points + tree.center)) & (tree.nodes["state"] == INSIDE)[:, None]).any()
    lamp = build.build_lamp("half", shape, np.eye(4))
    cap = np.pi * 0.8**2 * (3.0 - 0.8) / 3.0
    assert abs(lamp.row["volume"][0] / cap - 1.0) < 5e-3  # the term under the root moves the surface a little


def test_empty_and_too_deep():
    apart = Intersection(Sphere(0.5), Transformed(Box((0.1, 0.1, 0.1)), moved(0.5, 0.5, 0.0)))
    for shape in (apart, FieldOf(apart)):
        assert interior.tree(shape).nodes["mass"][0] == 0.0
    deep = Sphere(0.5)
    for k in range(70):
        deep = Difference(Sphere(0.5 + 0.01 * k), deep)
    for shape in (deep, FieldOf(deep)):
        with pytest.raises(TreeError, match="too many nested parts: nest fewer"):
            interior.tree(shape)


LARGE = {
    "twenty": COMPOSITES["twenty"],
    "twenty, smooth": SmoothUnion(
        *(Transformed(Capsule(0.1, 0.8), turned(k) @ moved(0.3 * np.sin(k), 0.2, 0.1 * k)) for k in range(10)),
        radius=0.05,
    ),
    "twisted": Twist(Onion(Box((0.3, 0.2, 0.7)), 0.05), 1.0),
    "ball": FieldOf(Sphere(0.7)),
}


@pytest.mark.parametrize("name", LARGE)
def test_building_is_quick(name):
    """At most 0.1 s on a quiet machine; three times that where others run. Compiling comes before."""
    seconds = []
    for _ in range(3):
        interior.tree.cache_clear()
        build.volume_of.cache_clear()
        start = time.thread_time()
        build.build_lamp(name, LARGE[name], np.eye(4))
        seconds.append(time.thread_time() - start)
    assert min(seconds) < 0.3


def test_a_thousand_parts():
    """Lists of a box do not grow with the number of parts that are elsewhere."""
    rng = np.random.default_rng(3)
    parts = [
        Transformed(shape, moved(*rng.uniform(-1, 1, 3)) @ turned(*rng.uniform(0, 3, 1)))
        for shape in (Sphere(0.06), Box((0.05, 0.04, 0.06)), Torus(0.05, 0.02), Cylinder(0.03, 0.1))
        for _ in range(250)
    ]
    for shape in (Union(*parts), FieldOf(Union(*parts))):
        tree = interior.tree(shape)
        assert tree.nodes["row_count"][0] == 1999
        assert tree.nodes["row_count"][tree.boundary].mean() < 16.0
