# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels for SDF lamps that replace those of the CPU.

Fields are translated to GLSL as a whole, not term by term; ``crossings`` traces rays through them. The boxes of a cut
are the same for all points: a thread has no memory for those of regions, and no time to find them.
"""

from __future__ import annotations

import math

import numpy as np

from ...emitter.emission.varying import COLOUR, GOLDEN, lamp_glows, place_point, point_count
from ...emitter.lamps import intensity, lamps
from ...emitter.primitives.box import box_span
from ...emitter.sampling import cut as cuts
from ...emitter.sampling.cut_boxes import BOXES, MOST_BOXES, MOST_ENTRIES, part_in_two, put, spread_variance
from ...emitter.sampling.cut_tables import placements
from ...emitter.sampling.projection import direction_pdf, interior_offset, sample_direction
from ...emitter.sampling.strategies import BOXES as BY_BOXES
from ...graph.codegen_native import LANES
from ...graph.formula import Formula, order
from ...jit import kernel
from ...vec import ZERO, dot, length, madd, mul, sub, transform_point, transform_vector, vec
from ..kernels import lights
from ..kernels.lamp_tree import found_table, tree_table
from ..kernels.lights.records import LIGHT_CUT
from ..kernels.lights.records import MOST_NODES as MOST_NODES_IN_CUT
from ..kernels.lights.tree import estimate
from ..kernels.media.beams import attenuation
from ..kernels.path import path_table
from ..kernels.workspace import cut_of

LIMIT = 16  # boxes of a lamp

# A ``LIGHT_CUT`` of one node, which replaces the CPU's table of the workspace, and a cut for programs without cuts.
ROWS = {
    "light_cut": np.dtype(
        [
            (name, LIGHT_CUT[name].base, 2 if LIGHT_CUT[name].shape == (MOST_NODES_IN_CUT,) else LIGHT_CUT[name].shape)
            for name in LIGHT_CUT.names
        ]
    )
}
WITHOUT_BOXES = np.dtype([("lamp", "i8"), ("strategy", "i8"), ("points", "i8"), ("bsdf_mis_scale", "f8")])


def _fewer(dtype: np.dtype) -> np.dtype:
    """A record with room for ``LIMIT`` boxes."""
    counts = {MOST_BOXES: LIMIT, MOST_BOXES + 1: LIMIT + 1, MOST_ENTRIES: 2 * LIMIT}
    return np.dtype(
        [
            (name, dtype[name].base, tuple(counts.get(count, count) for count in dtype[name].shape))
            for name in dtype.names
        ]
    )


FLAT_BOXES, FLAT_CUT = _fewer(BOXES), _fewer(cuts.CUT)

FEW = 8  # lamps that a ray tests in turn
ROUNDING = 1.0 + 2.0**-21  # of the distances to the sides of a box in float32, doubled
MOST_NODES = 20_000  # of all formulas together, for the sake of compilers


@kernel
def divide(place, cells, steps, limit, boxes):
    """Split a lamp into at most ``limit`` boxes for all points: large boxes with much content are split."""
    size = math.sqrt(place.extent)
    boxes.unit = 1.0 / size
    for axis in range(3):
        boxes.center[axis] = 0.0
        for other in range(3):
            boxes.metric[axis, other] = place.metric[axis, other] / place.extent
    urgent = np.empty(limit)
    boxes.count = boxes.entries = 1
    urgent[0] = 1.0 if put(boxes, 0, 0, cells, 0) else 0.0
    while boxes.count < limit:
        worst = 0
        for k in range(boxes.count):
            if urgent[k] > urgent[worst]:
                worst = k
        if urgent[worst] <= 0.0:
            break
        other = boxes.count
        first, second = part_in_two(boxes, worst, cells)
        urgent[worst] = boxes.volume[worst] * boxes.fill[worst] * boxes.extent[worst] if first else 0.0
        urgent[other] = boxes.volume[other] * boxes.fill[other] * boxes.extent[other] if second else 0.0
    total, rough = 0.0, 0.0
    for k in range(boxes.count):
        weight = boxes.volume[k] * boxes.fill[k]
        total += weight
        rough += weight * steps[boxes.cell[k]].rough
    boxes.rough = rough / total


def flat_boxes(tables: dict[str, np.ndarray]) -> np.ndarray:
    """(lamps,) ``FLAT_BOXES`` of the tables of ``cut_tables``."""
    found = np.zeros(len(tables["lamp_placements"]), FLAT_BOXES)
    for place, boxes in zip(tables["lamp_placements"], found):
        first = place["first_cell"]
        divide(place, tables["lamp_cells"][first:], tables["lamp_steps"][first:], LIMIT, boxes)
    return found


@kernel
def prepare(block, lamp, x, n, two_sided, has_glossy, tolerance, limit, keys, store, cut):
    """Replaces ``cut.prepare``: the boxes of the lamp are the same for every point."""
    place = placements(block)[lamp]
    if cuts.needs_no_boxes(block, lamp, place, x, n, 1, tolerance, cut):
        return
    boxes = store[lamp]
    if boxes.rough > cuts.MOST_ROUGH:
        cuts.project(block, lamp, x, has_glossy, cut)
        return
    origin, normal = cuts.local(block, lamp, place, x, n)
    cuts.fit(block, place, boxes, lamp, origin, normal, two_sided, cut)
    if cut.strategy == BY_BOXES:
        left = 0.0
        for k in range(boxes.count):
            way = sub((boxes.centroid[0, k], boxes.centroid[1, k], boxes.centroid[2, k]), vec(cut.origin))
            square = dot(way, transform_vector(boxes.metric, way))
            left += cut.weight[k] * spread_variance(boxes.extent[k] / max(square, 1e-30))
        cut.bsdf_mis_scale = cuts.mis_scale_for(left / cut.mass[0])


@kernel
def prepare_lamp_cut(block, workspace, lamp, pmf, x, n):
    """Replaces ``next_event.prepare_lamp_cut`` if cuts are used but do not pay."""
    cuts.project(block, lamp, x, path_table(workspace)[0].has_glossy, cut_of(workspace))


@kernel
def sample_point(block, lamp, x, store, cut, u1, u2, u3):
    """Replaces ``cut_points.sample_point``: only uniform lamps use points."""
    return interior_offset(block, lamp, x, u1, u2, u3), intensity(block, lamp)


@kernel
def keep_only_lamp(block, workspace, lamp):
    """Replaces ``next_event.restore_lamp_cut`` if one emitter gives all the light and no ray passes a scattering
    surface: the cut is that of the last light ray."""


@kernel
def sample(block, lamp, x, store, cut, u1, u2, u3):
    """Replaces ``cut.sample``."""
    return sample_direction(block, lamp, x, ZERO, u1, u2, u3)


@kernel
def density(block, lamp, d, store, cut, spans, count):
    """Replaces ``cut.density``."""
    return direction_pdf(block, lamp, ZERO, ZERO, d, spans, count)


@kernel
def no_light(block, workspace, lamp, pmf, u, u1, u2, u3):
    """Replaces ``next_event.sample_lamp_light`` if there is no lamp."""


@kernel
def no_lamp_exit(block, workspace, path):
    """Replaces ``gather.last_lamp_exit`` if there is no lamp."""
    return 0.0


@kernel
def select_only(block, number, x, n, u, cut):
    """Replaces ``tree.select`` if one emitter gives all the light: programs are then half as large."""
    return block.only_emitter, 1.0, u


@kernel
def single_light_probability(block, number, x, n, emitter, cut):
    """Replaces ``tree.selection_probability``, likewise."""
    return 1.0 if emitter == block.only_emitter else 0.0


@kernel
def fit_light_cut(nodes, tree, x, n, cut):
    """Replaces ``tree.fit_cut``: only the root, from which ``select`` goes down."""
    value, _ = estimate(nodes[tree.root], x, n)
    if not 0.0 < value < math.inf:
        value = 1.0
    cut.count, cut.node[0], cut.order[0], cut.weight[0], cut.total = 1, tree.root, 0, value, value


@kernel
def lamps_along(block, workspace, o, d, t_max, kind):
    """Replaces ``lamp_tree.lamps_along``: a few lamps are tested in turn, and so are the boxes of a node."""
    found = found_table(workspace)
    count = 0
    if block.few_lamps:
        for lamp in range(block.lamp_count):
            if lights.visibility(block, lamp) & kind and _crosses(lamps(block)[lamp], o, d, t_max):
                found[count] = lamp
                count += 1
        return count
    nodes = tree_table(block)
    waiting = len(found) - 1
    found[waiting] = 0
    while waiting < len(found):
        node = nodes[found[waiting]]
        waiting += 1
        for k in range(node.count):
            if node.visibility[k] & kind and _meets(node, k, o, d, t_max):
                child = node.child[k]
                if child < 0:
                    found[count] = ~child
                    count += 1
                else:
                    waiting -= 1
                    found[waiting] = child
    return count


@kernel
def _crosses(row, o, d, t_max):
    start, end = box_span(sub(o, vec(row.center)), d, row.half[0], row.half[1], row.half[2])
    return start <= end * ROUNDING and end > 0.0 and start < t_max


@kernel
def _slab(low, high, o, d):
    """The interval of o + t·d between low and high, for scalars."""
    inverse = 1.0 / d if abs(d) > 1e-30 else 1e30
    a, b = (low - o) * inverse, (high - o) * inverse
    return min(a, b), max(a, b)


@kernel
def _meets(node, k, o, d, t_max):
    x0, x1 = _slab(node.low[0, k], node.high[0, k], o[0], d[0])
    y0, y1 = _slab(node.low[1, k], node.high[1, k], o[1], d[1])
    z0, z1 = _slab(node.low[2, k], node.high[2, k], o[2], d[2])
    enter = max(max(x0, y0), max(z0, 0.0))
    return enter <= min(min(x1, y1), z1) * ROUNDING and enter < t_max


@kernel
def colour(block, formula, first, p):
    """Colour of an emission at a point in the shape's local space; written as GLSL for each scene."""


@kernel
def line_integral(block, index, center, x, d, spans, count, t_min, t_max, u):
    """Replaces ``emission.line_integral``."""
    return attenuated_integral(block, index, center, x, d, spans, count, t_min, t_max, u, None)


@kernel
def attenuated_integral(block, index, center, x, d, spans, count, t_min, t_max, u, extinction):
    """Replaces ``emission.attenuated_integral``: one point at a time. ``extinction`` may be None."""
    glow = lamp_glows(block)[index]
    p, way = transform_point(glow.inverse, sub(x, center)), transform_vector(glow.inverse, d)
    rate = glow.rate * length(way)
    formula, first = glow.address, glow.parameters
    total = (0.0, 0.0, 0.0)
    for span in range(count):
        c, h = spans[span, 0], spans[span, 1]
        start, end = max(c - h, t_min), min(c + h, t_max)
        size = end - start
        if size > 0.0:
            points = point_count(rate * size)
            shift = (u + span * GOLDEN) % 1.0
            for point in range(points):
                t, weight = place_point((point + shift) / points)
                value = colour(block, formula, first, madd(p, start + size * t, way))
                if extinction is not None:
                    value = mul(value, attenuation(extinction, start + size * t - t_min))
                total = madd(total, size * weight / points, value)
    return mul(total, vec(glow.scale))


@kernel
def colours(block, index, stack):
    """Replaces ``emission.colours``: likewise."""
    glow = lamp_glows(block)[index]
    for lane in range(block.lanes):
        p = (stack[lane], stack[LANES + lane], stack[2 * LANES + lane])
        value = colour(block, glow.address, glow.parameters, p)
        stack[COLOUR + lane], stack[COLOUR + LANES + lane], stack[COLOUR + 2 * LANES + lane] = value


class Formulas:
    """The distinct formulas of a scene's lamps, each written once: ``fields`` return a value, ``colours`` three."""

    def __init__(self):
        self.fields: list[tuple[Formula, ...]] = []
        self.colours: list[tuple[Formula, ...]] = []

    def add(self, formulas: list, formula: tuple[Formula, ...]) -> int:
        """Index of a formula in one of the two lists."""
        if formula not in formulas:
            formulas.append(formula)
        return formulas.index(formula)

    @property
    def nodes(self) -> int:
        """Number of nodes of all formulas together."""
        return sum(len(order(*formula)) for formula in self.fields + self.colours)
