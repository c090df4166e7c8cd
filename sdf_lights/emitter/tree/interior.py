# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The interior tree: boxes that are certainly empty or certainly full, and the list of what matters in the others.

A k-d tree over the shape's bounding box. If a field φ with Lipschitz bound L exceeds L·R at the centre of a box of half
diagonal R, it has one sign in all of it. For closed-form programs ``membership`` decides. The remaining boxes are
split (``splitting_fields``, ``splitting_programs``). Each box has a list of the terms or instructions that matter in
it, pruned from the list of its parent (see ``pruning``). So its cost does not depend on the number of parts of the
whole shape.

*Tree space* is the shape's local space, shifted so that the centre of its bounding box is the origin. The tree is built
once per shape, and cached: moving a lamp or changing its power costs nothing.
"""

from __future__ import annotations

import functools

import numpy as np

from ...frozen import frozen
from ...graph.codegen_native import evaluate
from ...graph.formula import CALL, order
from ...graph.interval_arithmetic import Arithmetic
from ...graph.interval_evaluation import Boxes, run
from ...graph.lipschitz import lipschitz
from ...interruption import SLICE, check
from ...sdf.program import INSTRUCTION, NoClosedForm
from ...sdf.shapes.base import Shape
from ..intersection.fields import DEEPEST, LIST, TERM, CompiledField, compile_terms
from ..intersection.intervals import rows_needed
from .nodes import BOUNDARY, INSIDE, NODE, OUTSIDE, finish
from .slopes import bounds_of, fill_gradients
from .splitting_fields import grow_field
from .splitting_programs import grow_program

MOST_NODES = 1 << 15  # of a tree …
NODES_A_PART = 128  # … or so many for each term or instruction, if that is more
FIELD_WORK = 1 << 30  # operations times nodes of a field without parts, about a second per core, but at least …
FEWEST_NODES = 1 << 12
MOST_ROWS = 1 << 21  # of all lists together
RESOLUTION = 1.0 / 32.0  # of the longest side of the root box: boxes on the boundary are not split below it
SLOPES = 32  # samples in a box without a Lipschitz bound
# width of a box in which the field is partly undefined, over which the greatest of its values may fall to zero
STEPS = 64.0
CASES = 4  # parts that a box may be divided into for this
ROWS = 1 << 14  # lists of boxes split between two checks for a cancel: some hundredths of a second
BOUNDS_WORK = 150_000  # operations of formulas times boxes, for Lipschitz bounds of boxes
KEPT = 64  # trees of shapes, the most recently used ones; each takes some megabytes at most


class TreeError(ValueError):
    """A shape cannot have a tree: the rest of a sentence that names its lamp."""


@frozen
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
        """Corners (3,) of a world box around all non-empty boxes; ``matrix`` (4 × 4) maps the shape to the world."""
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
    spent, parts inherit the bound of their box. Bounds of tables are closer than the Lipschitz bound, as they see the
    numbers in a box: they settle boxes, too.
    """
    terms = field.terms
    data = any(node.kind == CALL for term in field.source for node in order(term.formula))
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
                field.near_fields,
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
        if data:
            _settle_by_bounds(field, nodes, boxes, lists, np.arange(first, last), mass)


def _settle_by_bounds(field: CompiledField, nodes, boxes, lists, places, mass) -> None:
    """Settle the unsplit boxes among ``places`` in which the bounds of the field have one sign."""
    check()
    places = places[(nodes["state"][places] == BOUNDARY) & (nodes["first"][places] < 0)]
    if not len(places):
        return
    rows = nodes[places]
    _, values = bounds_of(field, boxes[places], lists, rows["row_first"], rows["row_count"])
    _set_states(nodes, boxes, places, values[:, 0] > 0.0, values[:, 1] < 0.0, mass)


def _set_states(nodes, boxes, places, outside, inside, mass) -> None:
    """Settle leaves on the boundary, those of which ``outside`` or ``inside`` is true."""
    volumes = np.prod(boxes[places, 3:] - boxes[places, :3], axis=1)
    for certain, state in ((outside, OUTSIDE), (inside, INSIDE)):
        nodes["state"][places[certain]], nodes["row_count"][places[certain]] = state, 0
        mass[1] -= volumes[certain].sum()
        mass[0] += volumes[certain].sum() if state == INSIDE else 0.0


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
        outside, inside = (np.broadcast_to(found, len(chosen)) for found in (values.low > 0.0, values.high < 0.0))
        _set_states(nodes, boxes, chosen, outside, inside & ~undefined, mass)
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
    if field is not None:
        limit *= field.boxes
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
    nodes["turns"] = (nodes["gradient"][:, 0] < 0.0).all(axis=1) & (nodes["gradient"][:, 1] > 0.0).all(axis=1)
    for array in (nodes, lists, boxes):
        array.flags.writeable = False
    return Tree(center, half, nodes, lists, boxes, program, field, shape.certified and not guessed)
