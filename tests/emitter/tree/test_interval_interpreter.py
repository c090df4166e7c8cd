# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of values and gradients in boxes, by the interpreter: they contain, and are as tight as the reference's."""

import numpy as np
import pytest

from sdf_lights.emitter.tree import interior, slopes
from sdf_lights.graph import codegen_native, interval_tape, numpy_evaluation
from sdf_lights.graph.formula import POINT, apply, constant, parameter, select, sqrt
from sdf_lights.graph.gradient import gradient
from sdf_lights.graph.interval_interpreter import BOXES, DEEPEST_LOOP, SIZE, enclose
from sdf_lights.graph.interval_tape import tape
from sdf_lights.graph.lipschitz import gradient_bounds
from sdf_lights.graph.loops import iterate
from sdf_lights.graph.operations import CONDITIONS, OPERATIONS
from sdf_lights.jit import kernel
from support.lamps.hard_cases import HARD_CASES, SMOOTH, TWISTED
from support.shapes.samples import SHAPES_TO_TRY, window


@kernel
def _enclosed(instructions, parameters, result, boxes, registers):
    rounds = np.empty((DEEPEST_LOOP, 2), np.int64)
    out = np.empty((len(boxes), SIZE))
    for first in range(0, len(boxes), BOXES):
        registers[:3] = 0.0
        for axis in range(3):
            for box in range(BOXES):
                corners = boxes[min(first + box, len(boxes) - 1)]
                registers[axis, 0, box], registers[axis, 1, box] = corners[axis], corners[3 + axis]
                registers[axis, 2 + 2 * axis, box] = registers[axis, 3 + 2 * axis, box] = 1.0
        enclose(instructions, 0, len(instructions), parameters, 0, registers, rounds)
        for box in range(min(BOXES, len(boxes) - first)):
            out[first + box] = registers[result, :, box]
    return out


def enclosed(formula, parameters, low, high):
    """Bounds (n, 8): low and high of the value and of each component of the gradient."""
    written = tape(formula)
    # A copy: the kernel is compiled once more for an array that is read-only, as those of shapes are.
    return _enclosed(
        written.instructions,
        np.array(parameters, float),
        written.result,
        np.concatenate([low, high], axis=1),
        np.empty((written.registers, SIZE, BOXES)),
    )


def random_boxes(rng, low, high, n):
    size = high - low
    middle = low + rng.uniform(-0.1, 1.1, (n, 3)) * size
    half = 0.25 * size * rng.random((n, 3)) * 10.0 ** rng.uniform(-3.0, 0.0, (n, 1))
    return middle - half, middle + half


def check(formula, parameters, low, high, rng, draws=6):
    found = enclosed(formula, parameters, low, high)
    slope = gradient(formula)
    for _ in range(draws):
        points = low + rng.random(low.shape) * (high - low)
        with np.errstate(all="ignore"):
            values = [
                np.broadcast_to(numpy_evaluation.evaluate(part, points, parameters), len(points))
                for part in (formula, *slope)
            ]
        for column, value in enumerate(values):
            slack = 1e-8 * (1.0 + np.abs(value))
            outside = (value < found[:, 2 * column] - slack) | (value > found[:, 2 * column + 1] + slack)
            assert not (outside & np.isfinite(values[0])).any()
    return found


@pytest.mark.parametrize("name", SHAPES_TO_TRY)
def test_bounds_contain_values_and_gradients_of_shapes(name):
    shape, rng = SHAPES_TO_TRY[name], np.random.default_rng(2)
    low, high = random_boxes(rng, *window(shape), 64)
    check(shape.formula(), shape.parameters(), low, high, rng)


def test_every_operation():
    """Of x and y alone, over boxes that hold zero, are beside it or far from it, and over single points."""
    rng = np.random.default_rng(4)
    x, y = POINT.x, POINT.y
    middle = rng.choice([0.0, 0.3, -0.7, 2.0, -5.0, 40.0], (400, 3)) + 0.1 * rng.normal(size=(400, 3))
    half = rng.choice([0.0, 0.01, 0.5, 4.0], (400, 3))
    for kind, operation in OPERATIONS.items():
        if kind in CONDITIONS:
            formulas = [select(apply(kind, x, y), x, y * 2.0)]
        elif kind == "select":
            continue
        else:
            formulas = [apply(kind, *(x, y)[: operation.arity])]
        if kind == "power":
            formulas += [apply(kind, x, constant(exponent)) for exponent in (2.0, 3.0, 0.5, -1.0, -2.0, 1.5)]
        if kind == "floor":
            continue  # jumps: bounds are about what is beside them
        for formula in formulas:
            found = check(formula, (), middle - half, middle + half, rng, 20)
            point = (half == 0.0).all(axis=1) & np.isfinite(found).all(axis=1)
            assert np.allclose(found[point, 0], found[point, 1], rtol=1e-9, atol=1e-12)


def test_roots_without_poles():
    """Lengths, roots of the least of squares, and roots of one square have bounded gradients around their zeros."""
    x, y, z = POINT
    low, high = np.full((1, 3), -1.0), np.full((1, 3), 1.0)
    for formula in (POINT.length(), sqrt(x * x + y * y), sqrt(x * x), sqrt(apply("minimum", x * x + y * y, z * z))):
        found = enclosed(formula, (), low, high)
        assert np.abs(found[:, 2:]).max() <= 1.0


def test_loops():
    """Loops that some points of a box leave early, loops in loops, and a number of rounds in a parameter."""
    x, y, z = POINT

    def escape(u, v, n):
        return (u * u - v * v + x, 2.0 * u * v + y, n + 1.0), u * u + v * v < 4.0

    def outer(a, b):
        (inner,) = iterate(3.0, (a,), lambda c: ((c * 0.5 + b * x,), None), 10)
        return (inner, b + y), None

    rng = np.random.default_rng(8)
    low, high = random_boxes(rng, np.full(3, -1.5), np.full(3, 1.5), 300)
    low, high = np.clip(low, -2.0, 2.0), np.clip(high, -2.0, 2.0)
    for formula in (*iterate(parameter(0), (x, y, z), escape, 12)[:2], *iterate(4.0, (x, z), outer, 8)):
        for rounds in (0.0, 1.0, 3.7, 9.0):
            found = enclosed(formula, (rounds,), low, high)
            for _ in range(10):
                points = low + rng.random(low.shape) * (high - low)
                values = numpy_evaluation.evaluate(formula, points, (rounds,))
                slack = 1e-8 * (1.0 + np.abs(values))
                assert np.all((values >= found[:, 0] - slack) & (values <= found[:, 1] + slack))


@pytest.mark.parametrize("name", ["torus", "box_frame", "cone", "rounded_cylinder", "link", "twisted", "wavy"])
def test_bounds_are_as_tight_as_the_reference(name):
    shape, rng = SHAPES_TO_TRY[name], np.random.default_rng(3)
    low, high = random_boxes(rng, *window(shape), 200)
    found = enclosed(shape.formula(), shape.parameters(), low, high)
    least, most = gradient_bounds(shape.formula(), low, high, shape.parameters())
    width, reference = found[:, 3::2] - found[:, 2::2], most - least
    assert np.median(width) <= 1.02 * np.median(reference)
    assert np.mean(width) <= 2.0 * np.mean(reference)  # which also bounds norms: that tells in large boxes


@pytest.mark.parametrize(
    "shape",
    [SMOOTH, TWISTED, HARD_CASES["round and chamfered seams"].shape, HARD_CASES["smooth combination of 10"].shape],
    ids=["smooth", "twisted", "seams", "ten"],
)
def test_gradients_of_lists_in_trees(shape):
    """What nodes claim of the field of their own list, by differences between points of their boxes."""
    tree = interior.tree(shape)
    nodes, boundary = tree.nodes, tree.boundary
    rng = np.random.default_rng(1)
    chosen = rng.choice(boundary, 400, replace=False)
    low, high = tree.boxes[chosen, :3], tree.boxes[chosen, 3:]
    a, b = (low + rng.random((40, 400, 3)) * (high - low) for _ in range(2))
    change = listed(tree, chosen, b) - listed(tree, chosen, a)
    bounds = nodes["gradient"][chosen].astype(float)
    with np.errstate(invalid="ignore"):
        products = (b - a)[:, :, None, :] * bounds
    least, most = products.min(axis=2).sum(axis=-1), products.max(axis=2).sum(axis=-1)
    known = np.isfinite(bounds).all(axis=(1, 2))
    assert known.mean() > 0.9
    assert np.all((change >= least - 1e-9) & (change <= most + 1e-9) | ~known)
    # Where a smooth union may be of either operand, the bounds are about those of the two, not of their sum.
    assert np.median(bounds[known, 1] - bounds[known, 0]) < 0.8


def listed(tree, chosen, points):
    """Values (…, nodes) of the lists of nodes at points (…, nodes, 3) of their boxes."""
    found = np.empty(points.shape[:-1])
    for column, row in enumerate(tree.nodes[chosen]):
        stack = []
        for number in tree.lists[row["row_first"] : row["row_first"] + row["row_count"]]:
            if number < 0:
                stack[-1] = -stack[-1]
                continue
            term = tree.field.source[number]
            at = points[:, column]
            if term.arity:
                operands = [stack.pop() for _ in range(term.arity)][::-1]
                at = np.stack([*operands, *[np.zeros(len(at))] * (3 - term.arity)], axis=1)
            stack.append(codegen_native.evaluate(term.formula, at, term.parameters))
        found[:, column] = stack[0]
    return found


def test_inner_boxes_have_the_bounds_of_their_parts():
    tree = interior.tree(TWISTED)
    nodes = tree.nodes
    for index in np.flatnonzero(nodes["first"] >= 0):
        parts = nodes[nodes["first"][index] : nodes["first"][index] + 2]
        parts = parts[parts["state"] == interior.BOUNDARY]
        if not len(parts):
            continue
        assert np.all(nodes["gradient"][index, 0] <= parts["gradient"][:, 0] + 1e-6)
        assert np.all(nodes["gradient"][index, 1] >= parts["gradient"][:, 1] - 1e-6)


def test_work_is_bounded(monkeypatch):
    """A tree with more boxes than the work allows leaves the smaller ones without bounds, not with wrong ones."""
    shape = HARD_CASES["smooth combination of 10"].shape
    tree = interior.tree(shape)
    nodes = tree.nodes.copy()
    monkeypatch.setattr(slopes, "WORK", 20_000)
    slopes.fill_gradients(tree.field, nodes, nodes["state"] == interior.BOUNDARY, tree.boxes.copy(), tree.lists.copy())
    found, full = nodes["gradient"][tree.boundary], tree.nodes["gradient"][tree.boundary]
    assert np.isinf(found).all(axis=(1, 2)).any() and np.isfinite(found).all(axis=(1, 2)).any()
    assert np.all((found[:, 0] <= full[:, 0]) | (found[:, 1] >= full[:, 1]))


def test_tapes_have_no_unknown_operation():
    assert set(OPERATIONS) <= set(interval_tape.NAMES)
