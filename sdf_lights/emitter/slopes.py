# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of a field's gradient in the boxes of its interior tree.

They tell how fast the field can fall and rise along a ray through a box, which is less than its Lipschitz bound wherever
the ray is not square to the surface; and in most boxes on the surface they tell that the field is monotonic along a
ray, so that the values at both ends are all that has to be known of it (see ``cover``).

Interval arithmetic, box by box: of the terms of a box's list in turn, on stacks that hold the operands of all boxes at
once. A join f(a, b) has the gradient f_a ∇a + f_b ∇b. Where the signs of f_a and f_b are certain, that is |f_a| + |f_b|
times an average of ±∇a and ±∇b, which is tighter where both may be anything from 0 to 1.
"""

from __future__ import annotations

import functools

import numpy as np

from ..jit import kernel
from ..sdf.formula import POINT, Formula, Vector, parameter, slots
from ..sdf.lipschitz import gradient_bounds
from ..sdf.read_interval import enclose
from ..sdf.substitution import substitute
from .fields import NEGATED, CompiledField

WORK = 120_000  # operations on boxes, about 30 ms: deeper boxes have the bounds of the box that they are part of
MOST_OPERATIONS = 300  # of a field whose bounds are worth it
OVERHEAD = 10.0  # operations that a box costs without any
SLACK = 1e-12  # relative: covers the rounding of the few operations here


@functools.lru_cache(maxsize=256)
def _coupled(formula: Formula, sign: float) -> Formula:
    """A join f(x, y) read at (x + z, y ± z): its derivative along z is f_x ± f_y, without what cancels in the sum."""
    numbers = [parameter(slot) for slot in range(slots(formula))]
    return substitute(formula, Vector(POINT.x + POINT.z, POINT.y + sign * POINT.z, POINT.z * 0.0), numbers)


def _product(a, b):
    """Of intervals (low, high); 0 · ∞ is unbounded."""
    corners = np.stack([u * v for u in a for v in b])
    unclear = np.isnan(corners).any(axis=0)
    return np.where(unclear, -np.inf, corners.min(axis=0)), np.where(unclear, np.inf, corners.max(axis=0))


def _scaled_hull(total, a, b):
    """An average of two intervals, times a factor that is not negative."""
    return _product(total, (np.minimum(a[0], b[0]), np.maximum(a[1], b[1])))


def _joined(term, values, gradients):
    """Bounds of the gradient of a term over the values (low, high) and gradients (low, high) of its operands."""
    low = np.zeros((len(values[0][0]), 3))
    high = low.copy()
    for axis, value in enumerate(values):
        low[:, axis], high[:, axis] = value
    with np.errstate(all="ignore"):
        slopes = gradient_bounds(term.formula, low, high, term.parameters)
        slopes = [(slopes[0][:, axis, None], slopes[1][:, axis, None]) for axis in range(term.arity)]
        parts = [_product(slope, gradient) for slope, gradient in zip(slopes, gradients)]
        if term.arity == 1:
            return parts[0]
        least, most = parts[0][0] + parts[1][0], parts[0][1] + parts[1][1]
        a, b = gradients
        for sign, other in ((1.0, b), (-1.0, (-b[1], -b[0]))):
            lowest = slopes[1][0] if sign > 0.0 else -slopes[1][1]
            known = (slopes[0][0] >= -SLACK) & (lowest >= -SLACK)
            if known.any():
                total = gradient_bounds(_coupled(term.formula, sign), low, high, term.parameters)
                averaged = _scaled_hull((np.maximum(total[0][:, 2:], 0.0), total[1][:, 2:]), a, other)
                least = np.where(known, np.fmax(least, averaged[0]), least)
                most = np.where(known, np.fmin(most, averaged[1]), most)
    return least, most


def gradients(field: CompiledField, boxes: np.ndarray, lists: np.ndarray, first: np.ndarray, count: np.ndarray):
    """Bounds (n, 3), (n, 3) of the gradient of the lists lists[first:first + count] in boxes (n, 6).

    They hold where the field is continuous, as those of ``sdf.lipschitz``.
    """
    n = len(boxes)
    low, high = boxes[:, :3], boxes[:, 3:]
    depth = np.zeros(n, np.int64)
    values = np.zeros((2, field.depth, n))
    found = np.zeros((2, field.depth, n, 3))
    for step in range(count.max(initial=0)):
        active = np.flatnonzero(count > step)
        entries = lists[first[active] + step]
        for number in np.unique(entries):
            at = active[entries == number]
            if number == NEGATED:
                top = depth[at] - 1
                values[:, top, at] = -values[::-1, top, at]
                found[:, top, at] = -found[::-1, top, at]
                continue
            term = field.source[number]
            needed = count[at] > 1
            bottom = depth[at] - term.arity
            if term.arity == 0:
                slope = gradient_bounds(term.formula, low[at], high[at], term.parameters)
                corners = low[at], high[at]
            else:
                operands = [values[:, bottom + k, at] for k in range(term.arity)]
                slope = _joined(term, operands, [found[:, bottom + k, at] for k in range(term.arity)])
                corners = [np.stack([*(operand[side] for operand in operands), *[np.zeros(len(at))] * (3 - term.arity)],
                                    axis=1) for side in range(2)]
            if needed.any():
                values[:, bottom, at] = enclose(term.formula, *corners, term.parameters)
            found[:, bottom, at] = slope
            depth[at] = bottom + 1
    result = found[:, 0]
    margin = SLACK * np.abs(result)
    return result[0] - margin[0], result[1] + margin[1]


def _selected(nodes: np.ndarray, boundary: np.ndarray, work: np.ndarray) -> np.ndarray:
    """Nodes of the deepest level whose work stays within ``WORK``, and leaves above it; all on the boundary."""
    level = np.zeros(1, np.int64)
    while True:
        leaf = nodes["first"][level] < 0
        below = (nodes["first"][level[~leaf]][:, None] + (0, 1)).ravel()
        below = np.concatenate([level[leaf], below[boundary[below]]])
        if leaf.all() or work[below].sum() > WORK:
            return level
        level = below


@kernel
def _spread(nodes, boundary, known):
    """Give the parts of boxes the bounds of the whole, and wholes those of all their parts on the boundary."""
    for index in range(len(nodes)):
        first = nodes[index].first
        if first >= 0 and known[index]:
            for side in range(2):
                known[first + side] = True
                nodes[first + side].gradient[:] = nodes[index].gradient
    for index in range(len(nodes) - 1, -1, -1):
        node = nodes[index]
        if node.first < 0 or known[index]:
            continue
        for axis in range(3):
            low, high = np.inf, -np.inf
            for part in range(node.first, node.first + 2):
                if boundary[part]:
                    low = min(low, nodes[part].gradient[0, axis])
                    high = max(high, nodes[part].gradient[1, axis])
            node.gradient[0, axis], node.gradient[1, axis] = low, high


def fill_gradients(field: CompiledField, nodes: np.ndarray, boundary: np.ndarray, boxes: np.ndarray,
                   lists: np.ndarray) -> None:
    """Write bounds of the gradient, as ``nodes["gradient"]``, to the nodes of a tree that are on its boundary.

    Of large boxes they are those of their parts on the boundary together, so they do not hold where the sign of the
    field is certain. Children come after their parents in ``nodes``; ``boundary`` (nodes,) tells which are on it.
    """
    if len(field.terms) > 1 or field.operations[0] > MOST_OPERATIONS:
        nodes["gradient"] = [[-np.inf], [np.inf]]
        return
    total = np.append(0.0, np.cumsum(np.append(field.operations, 0.0)[lists]))  # NEGATED is the last
    work = OVERHEAD + total[nodes["row_first"] + nodes["row_count"]] - total[nodes["row_first"]]
    chosen = _selected(nodes, boundary, work)
    rows = nodes[chosen]
    bounds = np.stack(gradients(field, boxes[chosen], lists, rows["row_first"], rows["row_count"]), axis=1)
    outward = np.array([[-np.inf], [np.inf]], np.float32)
    nodes["gradient"][chosen] = np.nextafter(bounds.astype(np.float32), outward)
    known = np.zeros(len(nodes), bool)
    known[chosen] = True
    _spread(nodes, boundary, known)
