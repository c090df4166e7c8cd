# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The interior tree: boxes that are certainly empty or certainly full, and the list of what matters in the others.

A k-d tree over the shape's bounding box. If a field φ with Lipschitz bound L exceeds L·R at the centre of a box of half
diagonal R, it has one sign in all of it. For closed-form programs ``membership`` decides. The remaining boxes are
split. Each box has a list of the terms or instructions that matter in it, pruned from the list of its parent (see
``pruning``). So its cost does not depend on the number of parts of the whole shape.

*Tree space* is the shape's local space, shifted so that the centre of its bounding box is the origin. The tree is built
once per shape, and cached: moving a lamp or changing its power costs nothing.

A uniform point of the non-empty boxes is found by warping one point of the unit cube down the tree. At each node, the
coordinate of the node's axis chooses the side and is stretched back to [0, 1), which keeps stratified numbers
stratified. Points outside the shape are then drawn again, so the result is *exactly* uniform in the interior, whatever
the boxes are.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from ...graph.codegen_native import evaluate
from ...graph.interval_arithmetic import Arithmetic
from ...graph.interval_evaluation import Boxes, run
from ...graph.lipschitz import lipschitz
from ...interruption import SLICE, check
from ...jit import kernel, stack_array, table
from ...sdf.program import INSTRUCTION, NoClosedForm
from ...sdf.shapes.base import Shape
from .. import primitives
from ..hashing import bits, following
from ..intersection.fields import DEEPEST, LANES, LIST, STACK, TERM, VALUES, CompiledField, compile_terms
from ..intersection.intervals import rows_needed
from ..intersection.membership import place
from .pruning import prune_field, prune_program
from .slopes import fill_gradients

NODE = np.dtype(
    [  # 64 bytes: a cache line
        ("split", np.float64),  # where the two children meet, in tree space
        ("first", np.int32),  # index of the children, below the split and above it; −1 for a leaf
        ("row_first", np.int32),  # the list of what matters in this box; empty if the state is certain
        ("row_count", np.int32),
        ("axis", np.int8),  # of the split
        ("state", np.int8),
        ("lipschitz", np.float64),  # bound of the field of the list in this box; unused for programs
        ("gradient", np.float32, (2, 3)),  # bounds of the field's gradient in this box, see ``slopes``; as lipschitz
        ("mass", np.float64),  # m³ of the boxes below that are not certainly outside
    ],
    align=True,
)

OUTSIDE, INSIDE, BOUNDARY = 0, 1, 2  # state of a node: of all points of its box, or uncertain

TABLES = {"lamp_nodes": NODE}

MOST_NODES = 1 << 15  # of a tree …
NODES_A_PART = 128  # … or so many for each term or instruction, if that is more
FIELD_WORK = 1 << 30  # operations times nodes of a field without parts, about a second per core, but at least …
FEWEST_NODES = 1 << 12
MOST_ROWS = 1 << 21  # of all lists together
RESOLUTION = 1.0 / 32.0  # of the longest side of the root box: boxes on the boundary are not split below it …
ENOUGH = 0.85  # … once this fraction of the volume of the boxes is interior
MOST_LEVELS = 60  # maximum depth of nodes
SLOPES = 32  # samples in a box without a Lipschitz bound
# width of a box in which the field is partly undefined, over which the greatest of its values may fall to zero
STEPS = 64.0
SHORT_PROGRAM = 4  # rows of a list of instructions for which rays need no smaller boxes
PLANES = 7  # candidates along each axis for the cut of a box with more than that
FACE = 0.7  # factor on the remaining work of a cut along a flat face, because the face is then settled
CASES = 4  # parts that a box may be divided into for this
ROWS = 1 << 14  # lists of boxes split between two checks for a cancel: some hundredths of a second
BOUNDS_WORK = 150_000  # operations of formulas times boxes, for Lipschitz bounds of boxes
KEPT = 64  # trees of shapes, the most recently used ones; each takes some megabytes at most

lamp_nodes = table("lamp_nodes", NODE)


@kernel
def _volume(box):
    return (box[3] - box[0]) * (box[4] - box[1]) * (box[5] - box[2])


@kernel
def _area(box):
    """Half of the surface area of a box."""
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x


@kernel
def _longest(box):
    """Longest side of a box, and its axis."""
    axis = 0
    for k in range(1, 3):
        if box[3 + k] - box[k] > box[3 + axis] - box[axis]:
            axis = k
    return box[3 + axis] - box[axis], axis


@kernel
def _halve(boxes, index, axis, position, place):
    """Write the parts of a box, cut at ``position``, to rows ``place`` and ``place + 1``."""
    for side in range(2):
        for k in range(6):
            boxes[place + side, k] = boxes[index, k]
    boxes[place, 3 + axis] = position
    boxes[place + 1, axis] = position


@kernel
def _divide(nodes, boxes, levels, used, index, axis, position):
    """Give a node two children, still empty. Returns the index of the first."""
    place = used[0]
    used[0] += 2
    _halve(boxes, index, axis, position, place)
    levels[place] = levels[place + 1] = levels[index] + 1
    node = nodes[index]
    node.first, node.axis, node.split = place, axis, position
    for side in range(2):
        child = nodes[place + side]
        child.first, child.axis, child.split = -1, 0, 0.0
        child.state, child.lipschitz = BOUNDARY, node.lipschitz
        child.row_first, child.row_count = node.row_first, node.row_count
    return place


@kernel
def _store(nodes, index, lists, known, used, parts, count):
    """Give a node the list ``parts`` of ``count`` rows. Equal lists are stored once, so the position identifies a list.

    ``known`` is a hash table with open addressing: its size is a power of two, each slot −1 or a node that has a list.
    """
    node = nodes[index]
    node.row_count = count
    state = np.uint64(count)
    for row in range(count):
        state = following(state) ^ np.uint64(parts[row])
    place = np.int64(bits(state) & np.uint64(len(known) - 1))
    while known[place] >= 0:
        other = nodes[known[place]]
        same = other.row_count == count
        row = 0
        while same and row < count:
            same = lists[other.row_first + row] == parts[row]
            row += 1
        if same:
            node.row_first = other.row_first
            return
        place = (place + 1) & (len(known) - 1)
    known[place] = index
    node.row_first = used[1]
    lists[used[1] : used[1] + count] = parts[:count]
    used[1] += count


@kernel
def _settle(nodes, boxes, index, state, mass):
    """Set the state of a leaf; ``mass`` counts the volume of all full leaves and of all on the boundary."""
    node = nodes[index]
    node.state = state
    if state != BOUNDARY:
        node.row_count = 0
    if state != OUTSIDE:
        mass[state - 1] += _volume(boxes[index])


@kernel
def _small_enough(box, level, smallest, mass):
    """Whether a box on the boundary stays unsplit."""
    if level > MOST_LEVELS - 3:
        return True
    return _longest(box)[0] <= smallest and mass[0] + 0.5 * mass[1] >= ENOUGH * (mass[0] + mass[1])


@kernel
def _certainty(states, first, count):
    """The common state of ``count`` leaves from ``first``, or ``BOUNDARY``."""
    for index in range(first + 1, first + count):
        if states[index] != states[first]:
            return BOUNDARY
    return states[first]


@kernel
def _eighths(box, axes, position):
    """Centre of each of the eight parts that three halvings along ``axes`` make of a box, and their half diagonal."""
    size = np.empty(3)
    for k in range(3):
        size[k] = box[3 + k] - box[k]
    low = np.empty((LANES, 3))
    for lane in range(LANES):
        for k in range(3):
            low[lane, k] = box[k]
    for turn in range(3):
        axis = np.argmax(size)
        axes[turn] = axis
        size[axis] *= 0.5
        for lane in range(LANES):
            if lane >> (2 - turn) & 1:
                low[lane, axis] += size[axis]
    for lane in range(LANES):
        for k in range(3):
            position[k * LANES + lane] = low[lane, k] + 0.5 * size[k]
    return 0.5 * math.sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2])


@kernel
def grow_field(
    terms,
    parameters,
    cares,
    gains,
    columns,
    bounds,
    nodes,
    boxes,
    levels,
    lists,
    known,
    used,
    mass,
    first,
    last,
    smallest,
):
    """Split the leaves on the boundary among the nodes from ``first`` to ``last`` into eight parts each.

    ``levels`` holds the depth of each node, ``known`` the lists (see ``_store``), ``used`` the numbers of nodes and of
    rows of lists in use, ``mass`` the volumes of all leaves that are full and of those on the boundary. ``cares``,
    ``gains``, ``columns`` and the rows of ``bounds``, one for each node, are those of ``pruning.prune_field``.
    """
    stack = stack_array(STACK)
    axes = np.empty(3, np.int64)
    states = np.empty(LANES, np.int64)
    lengths = np.empty(LANES, np.int64)
    slopes = np.empty(LANES)
    out = np.empty((LANES, len(terms)), LIST)
    starts, steepness = np.empty((LANES, DEEPEST), np.int64), np.empty((LANES, DEEPEST))
    for index in range(first, last):
        node = nodes[index]
        if node.state != BOUNDARY or node.first >= 0 or _small_enough(boxes[index], levels[index], smallest, mass):
            continue
        if used[0] + 14 > len(nodes) or used[1] + LANES * node.row_count > len(lists):
            return
        radius = _eighths(boxes[index], axes, stack)
        prune_field(
            terms,
            parameters,
            cares,
            gains,
            columns,
            bounds[index],
            lists,
            node.row_first,
            node.row_count,
            radius,
            stack,
            out,
            lengths,
            slopes,
            starts,
            steepness,
        )
        for lane in range(LANES):
            value = stack[VALUES + lane]
            margin = slopes[lane] * radius
            states[lane] = OUTSIDE if value > margin else INSIDE if value < -margin else BOUNDARY
        mass[1] -= _volume(boxes[index])
        common = _certainty(states, 0, LANES)
        if common != BOUNDARY:
            node.lipschitz = max(slopes.max(), 0.0)
            _settle(nodes, boxes, index, common, mass)
            continue
        begin = used[0]
        half = _divide(nodes, boxes, levels, used, index, axes[0], _middle(boxes[index], axes[0]))
        for lane in range(0, LANES, 4):
            part = half + lane // 4
            common = _certainty(states, lane, 4)
            if common != BOUNDARY:
                _settle(nodes, boxes, part, common, mass)
                continue
            quarter = _divide(nodes, boxes, levels, used, part, axes[1], _middle(boxes[part], axes[1]))
            for pair in range(lane, lane + 4, 2):
                part = quarter + (pair - lane) // 2
                common = _certainty(states, pair, 2)
                if common != BOUNDARY:
                    _settle(nodes, boxes, part, common, mass)
                    continue
                eighth = _divide(nodes, boxes, levels, used, part, axes[2], _middle(boxes[part], axes[2]))
                for side in range(2):
                    leaf = eighth + side
                    _settle(nodes, boxes, leaf, states[pair + side], mass)
                    nodes[leaf].lipschitz = slopes[pair + side]
                    if states[pair + side] == BOUNDARY:
                        _store(nodes, leaf, lists, known, used, out[pair + side], lengths[pair + side])
        for child in range(begin, used[0]):
            bounds[child] = bounds[index]


@kernel
def _middle(box, axis):
    return 0.5 * (box[axis] + box[3 + axis])


@kernel
def _center_and_half(box):
    c = (0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4]), 0.5 * (box[2] + box[5]))
    return c, (0.5 * (box[3] - box[0]), 0.5 * (box[4] - box[1]), 0.5 * (box[5] - box[2]))


@kernel
def _flat_face(program, lists, node, box):
    """Axis and position of a flat face, perpendicular to an axis, of a primitive whose surface crosses the box; axis
    −1: none.

    Boxes cut along such faces become certain at once, while halving would approach the face for ever. Among several
    faces, the one closest to the middle of the box is used.
    """
    best, best_axis, best_position = 0.5 - 1e-6, -1, 0.0
    for entry in range(node.row_first, node.row_first + node.row_count):
        if lists[entry] < 0:
            continue
        row = program[lists[entry]]
        c, h = _center_and_half(box)
        c, h = place(row, c, h)
        for local in range(3):
            size = primitives.face(row.op, row.parameters, local, c, h)
            if size == math.inf:
                continue
            m = row.inverse[local]
            for axis in range(3):
                slope = m[axis]
                if slope == 0.0 or m[(axis + 1) % 3] != 0.0 or m[(axis + 2) % 3] != 0.0:
                    continue
                for sign in range(2):
                    position = ((size if sign else -size) - m[3]) / slope
                    aside = abs(position - _middle(box, axis)) / (box[3 + axis] - box[axis])
                    if aside < best:
                        best, best_axis, best_position = aside, axis, position
    return best_axis, best_position


@kernel(forceinline=True)
def _pruned(program, lists, node, box, out, starts):
    """``pruning.prune_program`` for a box."""
    c, h = _center_and_half(box)
    return prune_program(program, lists, node.row_first, node.row_count, c, h, out, starts)


@kernel
def _work(program, lists, nodes, boxes, index, axis, position, place, out, starts):
    """Remaining work of a ray that meets the box, after a cut: the sum over both parts of area times what matters
    there. Rows of ``boxes`` from ``place`` are scratch."""
    _halve(boxes, index, axis, position, place)
    work = 0.0
    for side in range(2):
        count, _, _ = _pruned(program, lists, nodes[index], boxes[place + side], out, starts)
        work += count * _area(boxes[place + side])
    return work


@kernel
def _best_plane(program, lists, nodes, boxes, index, place, shortest, axis, position, out, starts):
    """Axis and position of the plane that cuts a box in which much matters. Sides below ``shortest`` are not cut; if
    all are, the axis is −1. ``axis`` and ``position`` are those of a flat face, if there is one.

    A ray that meets a box meets a part of it with a probability proportional to its area, and then works on what
    matters in it (J. D. MacDonald and K. S. Booth, "Heuristics for ray tracing using space subdivision", 1990).
    """
    best, best_axis, best_position = math.inf, axis, position
    if axis >= 0:
        best = FACE * _work(program, lists, nodes, boxes, index, axis, position, place, out, starts)
    for k in range(3):
        low, size = boxes[index, k], boxes[index, 3 + k] - boxes[index, k]
        if size < shortest:
            continue
        for step in range(1, PLANES + 1):
            cut = low + size * step / (PLANES + 1)
            work = _work(program, lists, nodes, boxes, index, k, cut, place, out, starts)
            if work < best:
                best, best_axis, best_position = work, k, cut
    return best_axis, best_position


@kernel
def _best_axis(program, lists, nodes, boxes, index, place, out, starts):
    """Axis whose halves are certain, or else the longest one. Rows of ``boxes`` from ``place`` are scratch."""
    longest = _longest(boxes[index])[0]
    best, axis = -1.0, 0
    for k in range(3):
        _halve(boxes, index, k, _middle(boxes[index], k), place)
        score = (boxes[index, 3 + k] - boxes[index, k]) / longest
        for side in range(2):
            _, inside, outside = _pruned(program, lists, nodes[index], boxes[place + side], out, starts)
            score += inside | outside
        if score > best:
            best, axis = score, k
    return axis


@kernel
def grow_program(program, nodes, boxes, levels, lists, known, used, mass, index, rows, smallest):
    """Split the boxes of a program's tree in two, in turn from ``index`` on. If much matters in a box, the cut leaves
    the least work for rays. Otherwise it follows a flat face, if there is one, or the middle of the axis that makes the
    most volume certain. Returns the index to continue from once the lists of the split boxes have so many ``rows``, −1
    at the end. Other arguments are those of ``grow_field``."""
    out, starts = np.empty(len(program), LIST), np.empty(DEEPEST, np.int64)
    while index < used[0] and used[0] + 2 <= len(nodes):
        if rows <= 0:
            return index
        node, box = nodes[index], boxes[index]
        parent = index
        index += 1
        if node.state != BOUNDARY or _small_enough(box, levels[parent], smallest, mass):
            continue
        if used[1] + 2 * node.row_count > len(lists):
            return -1
        rows -= node.row_count
        axis, position = _flat_face(program, lists, node, box)
        if node.row_count > SHORT_PROGRAM:
            axis, position = _best_plane(
                program, lists, nodes, boxes, parent, used[0], smallest / PLANES, axis, position, out, starts
            )
        if axis < 0:
            axis = _best_axis(program, lists, nodes, boxes, parent, used[0], out, starts)
            position = _middle(box, axis)
        mass[1] -= _volume(box)
        place = _divide(nodes, boxes, levels, used, parent, axis, position)
        for side in range(2):
            child = place + side
            count, inside, outside = _pruned(program, lists, node, boxes[child], out, starts)
            _settle(nodes, boxes, child, INSIDE if inside else OUTSIDE if outside else BOUNDARY, mass)
            if nodes[child].state == BOUNDARY:
                _store(nodes, child, lists, known, used, out, count)
    return -1


@kernel
def finish(nodes, boxes, count, kept_nodes, kept_boxes):
    """Join children that are both empty or both full, sum the masses, and copy the reachable nodes depth first: so the
    nodes that a ray visits in sequence are close in memory. Returns the number of nodes."""
    for index in range(count - 1, -1, -1):
        node = nodes[index]
        if node.first < 0:
            node.mass = 0.0 if node.state == OUTSIDE else _volume(boxes[index])
            continue
        left, right = nodes[node.first], nodes[node.first + 1]
        node.mass = left.mass + right.mass
        node.lipschitz = min(node.lipschitz, max(left.lipschitz, right.lipschitz))
        if left.first < 0 and right.first < 0 and left.state == right.state and left.state != BOUNDARY:
            node.first, node.state, node.row_count = -1, left.state, 0
    waiting = np.empty(MOST_LEVELS + 2, np.int64)
    kept_nodes[0], kept_boxes[0] = nodes[0], boxes[0]
    waiting[0] = 0
    kept, depth = 1, 1
    while depth > 0:
        depth -= 1
        node = kept_nodes[waiting[depth]]
        if node.first < 0:
            continue
        for side in range(2):
            kept_nodes[kept + side], kept_boxes[kept + side] = nodes[node.first + side], boxes[node.first + side]
            waiting[depth + side] = kept + 1 - side
        node.first = kept
        kept += 2
        depth += 2
    return kept


@kernel
def _warp(u, share):
    """Side that u chooses, and u stretched back to the unit interval."""
    if u < share:
        return 0, u / share
    return 1, (u - share) / (1.0 - share)


@kernel
def tree_point(nodes, low, high, u1, u2, u3):
    """Uniform point in the boxes that are not empty, and its leaf; low and high are the root's corners."""
    x0, y0, z0 = low[0], low[1], low[2]
    x1, y1, z1 = high[0], high[1], high[2]
    index = 0
    while nodes[index].first >= 0:
        node = nodes[index]
        share = nodes[node.first].mass / node.mass
        if node.axis == 0:
            side, u1 = _warp(u1, share)
            x0, x1 = (node.split, x1) if side else (x0, node.split)
        elif node.axis == 1:
            side, u2 = _warp(u2, share)
            y0, y1 = (node.split, y1) if side else (y0, node.split)
        else:
            side, u3 = _warp(u3, share)
            z0, z1 = (node.split, z1) if side else (z0, node.split)
        index = node.first + side
    return (x0 + u1 * (x1 - x0), y0 + u2 * (y1 - y0), z0 + u3 * (z1 - z0)), index


class TreeError(ValueError):
    """A shape cannot have a tree: the rest of a sentence that names its lamp."""


@dataclass(frozen=True)
class Tree:
    """The interior tree of a shape, and the data of its lists: a closed-form program or a field."""

    center: np.ndarray  # (3,) the origin of tree space, in the shape's local space
    half: np.ndarray  # (3,) half sizes of the root's box
    nodes: np.ndarray  # NODE
    lists: np.ndarray  # LIST
    boxes: np.ndarray  # (nodes, 6) low and high corners
    program: np.ndarray  # INSTRUCTION, in tree space; none for a field
    field: CompiledField | None
    certified: bool  # that the states and the bounds hold everywhere

    @property
    def boundary(self) -> np.ndarray:
        """Indices of the leaves on the boundary."""
        return np.flatnonzero((self.nodes["first"] < 0) & (self.nodes["state"] == BOUNDARY))

    @property
    def inside(self) -> np.ndarray:
        """Indices of the leaves that are full."""
        return np.flatnonzero((self.nodes["first"] < 0) & (self.nodes["state"] == INSIDE))

    @property
    def arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """Terms and parameters of the field; none for a program."""
        if self.field is None:
            return np.zeros(0, TERM), np.zeros(0)
        return self.field.terms, self.field.parameters

    def bounds(self, matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Corners of a world box around all non-empty boxes; ``matrix`` maps the shape to the world."""
        if self.nodes["mass"][0] == 0.0:
            return self.center, self.center
        occupied = self.boxes[(self.nodes["first"] < 0) & (self.nodes["state"] != OUTSIDE)]
        middle = 0.5 * (occupied[:, :3] + occupied[:, 3:]) + self.center
        extent = 0.5 * (occupied[:, 3:] - occupied[:, :3])
        middle = middle @ matrix[:3, :3].T + matrix[:3, 3]
        extent = extent @ np.abs(matrix[:3, :3].T)
        return (middle - extent).min(axis=0), (middle + extent).max(axis=0)


def _grow_levels(field: CompiledField, nodes, boxes, levels, lists, known, used, mass, smallest: float) -> None:
    """Grow the tree of a field, from its root.

    If no Lipschitz bound is known for all of space, bounds are found for boxes, the largest first. When the budget is
    spent, parts inherit the bound of their box.
    """
    terms = field.terms
    nodes["lipschitz"][0] = terms["lipschitz"][-1]
    unknown = np.flatnonzero(~np.isfinite(terms["lipschitz"]) & (terms["arity"] == 0))
    columns = np.full(len(terms), -1)
    columns[unknown] = np.arange(len(unknown))
    bounds = np.full((len(nodes), len(unknown)), np.inf)
    first, last, work = 0, 1, BOUNDS_WORK
    together = max(int(SLICE / field.costs.sum()), 1)  # boxes, if the list of the first matters in each
    while first < last:
        if len(unknown) and work > 0:
            work -= _find_bounds(field, unknown, nodes, boxes, lists, np.arange(first, last), mass, bounds, work)
        for start in range(first, last, together):
            check()
            grow_field(
                terms,
                field.parameters,
                field.cares,
                field.gains,
                columns,
                bounds,
                nodes,
                boxes,
                levels,
                lists,
                known,
                used,
                mass,
                start,
                min(start + together, last),
                smallest,
            )
        first, last = last, int(used[0])


def _find_bounds(field: CompiledField, unknown, nodes, boxes, lists, places, mass, bounds, work: float) -> float:
    """Write bounds of the terms ``unknown`` to ``bounds`` (nodes, unknown), for the unsplit boxes among ``places``.
    Boxes in which a single term matters, with one sign, are settled. Returns the work done, at most about ``work``:
    operations times boxes."""
    places = places[(nodes["state"][places] == BOUNDARY) & (nodes["first"][places] < 0)]
    done = 0
    for column, number in enumerate(unknown):
        term = field.source[number]
        matters = [number in lists[row["row_first"] : row["row_first"] + row["row_count"]] for row in nodes[places]]
        chosen = places[matters][: int(max(work - done, 0) / field.operations[number]) + 1]
        done += len(chosen) * field.operations[number]
        corners = boxes[chosen]
        slopes = lipschitz(term.formula, corners[:, :3], corners[:, 3:], term.parameters, CASES)
        with np.errstate(all="ignore"):
            values = run((term.formula,), Boxes(Arithmetic(), corners[:, :3], corners[:, 3:], term.parameters))[0]
        # An undefined field counts as outside, and no bound of the slope elsewhere shows that.
        undefined = np.zeros(len(chosen), bool) if values.undefined is None else values.undefined
        slopes = np.where(undefined, np.inf, slopes)
        bounds[chosen, column] = np.where(undefined, np.inf, np.minimum(bounds[chosen, column], slopes))
        if len(field.terms) > 1:
            continue
        nodes["lipschitz"][chosen] = bounds[chosen, 0]
        volumes = np.prod(corners[:, 3:] - corners[:, :3], axis=1)
        for certain, state in ((values.low > 0.0, OUTSIDE), ((values.high < 0.0) & ~undefined, INSIDE)):
            certain = np.broadcast_to(certain, len(chosen))
            nodes["state"][chosen[certain]], nodes["row_count"][chosen[certain]] = state, 0
            mass[1] -= volumes[certain].sum()
            mass[0] += volumes[certain].sum() if state == INSIDE else 0.0
    return done


def _guess(shape: Shape, center: np.ndarray, nodes, boxes) -> bool:
    """Guess the bound of the leaves on the boundary that have none: twice the steepest of some measured slopes.

    Returns whether there are such leaves.
    """
    places = np.flatnonzero((nodes["state"] == BOUNDARY) & (nodes["first"] < 0) & ~np.isfinite(nodes["lipschitz"]))
    if not len(places):
        return False
    rng = np.random.default_rng(1)
    size = boxes[places, None, 3:] - boxes[places, None, :3]
    points = boxes[places, None, :3] + rng.random((len(places), SLOPES, 3)) * size
    step = 1e-4 * size * rng.standard_normal((len(places), SLOPES, 3))
    ahead, behind = (evaluate(shape.formula(), points + sign * step + center, shape.parameters()) for sign in (1, -1))
    with np.errstate(invalid="ignore"):
        slopes = np.abs(ahead - behind) / (2.0 * np.linalg.norm(step, axis=2))
    # A random direction sees the projection of the steepest slope: in many samples, rarely less than half of it.
    slopes = 2.0 * np.where(np.isfinite(slopes), slopes, 0.0).max(axis=1) + 1e-9
    # The border of an undefined region is unknown, so no value may say much about its surroundings.
    torn = ~np.isfinite(ahead).all(axis=1)
    values = np.where(np.isfinite(ahead), np.abs(ahead), 0.0).max(axis=1)
    nodes["lipschitz"][places] = np.where(torn, np.maximum(slopes, STEPS * values / size.max(axis=(1, 2))), slopes)
    return True


@functools.lru_cache(maxsize=KEPT)
def tree(shape: Shape) -> Tree:
    """The interior tree of a valid shape with a bounding box that is finite and not flat. Raises ``TreeError``."""
    low, high = shape.bounds()
    center, half = 0.5 * (low + high), 0.5 * (high - low)
    matrix = np.eye(4)
    matrix[:3, 3] = -center
    program, field = np.zeros(0, INSTRUCTION), None
    try:
        program = shape.program(matrix)
    except NoClosedForm:
        field = compile_terms(shape.terms(matrix, 1.0))
    check()
    if (rows_needed(program)[1] if field is None else field.depth) > DEEPEST:
        raise TreeError("its shape has too many nested parts: nest fewer.")
    size = len(program) or len(field.terms)
    limit = 1 << max(MOST_NODES, NODES_A_PART * size).bit_length() - 1
    if size == 1 and field is not None:
        limit = min(limit, max(FEWEST_NODES, 1 << int(FIELD_WORK / field.operations[0]).bit_length() - 1))
    nodes = np.zeros(limit, NODE)
    boxes = np.empty((limit, 6))
    levels = np.zeros(limit, np.int64)
    lists = np.empty(MOST_ROWS, LIST)
    known = np.full(2 * limit, -1)
    used, mass = np.array([1, size]), np.array([0.0, np.prod(2.0 * half)])
    boxes[0] = [*-half, *half]
    nodes["first"] = -1
    nodes["state"][0], nodes["row_count"][0] = BOUNDARY, size
    lists[:size] = np.arange(size)
    smallest = RESOLUTION * 2.0 * half.max()
    guessed = False
    if field is None:
        index = 0
        while index >= 0:
            check()
            index = grow_program(program, nodes, boxes, levels, lists, known, used, mass, index, ROWS, smallest)
    else:
        _grow_levels(field, nodes, boxes, levels, lists, known, used, mass, smallest)
        guessed = _guess(shape, center, nodes[: used[0]], boxes)
    check()
    kept, kept_boxes = np.empty_like(nodes), np.empty_like(boxes)
    count = finish(nodes, boxes, int(used[0]), kept, kept_boxes)
    nodes, boxes, lists = kept[:count].copy(), kept_boxes[:count].copy(), lists[: used[1]].copy()
    check()
    if field is not None and shape.certified and not guessed:
        fill_gradients(field, nodes, nodes["state"] == BOUNDARY, boxes, lists)
    else:
        nodes["gradient"] = [[-np.inf], [np.inf]]
    for array in (nodes, lists, boxes):
        array.flags.writeable = False
    return Tree(center, half, nodes, lists, boxes, program, field, shape.certified and not guessed)
