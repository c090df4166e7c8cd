# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a lamp that replace rays towards it.

If no BSDF ray competes with them, points need no density of directions, so no intervals of the lamp either. A point y
drawn with the density q(y) by volume is a point light of intensity ρ(y) / q(y). For a uniform lamp, q is the density of
its cut. This is some percent noisier than the mean along the ray, and a fifth faster.

If the emission varies, q can follow it down to the thousands of leaves of the tree, because no sum over boxes along a
ray is needed. In a leaf the emission is evaluated at as many points as one evaluation takes, and one of them is drawn
in proportion to its light (resampled importance sampling: Talbot, Cline and Egbert 2005). Leaves may be chosen by any
probability, if it is known. For those on the boundary, the interior volume is an estimate, as in all clipped boxes of a
cut.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel, stack_array
from ...replaced import replaced_on_gpu
from ...vec import ZERO, add, average, dot, scale, sub, transform_point, transform_vector, vec
from ..emission.varying import COLOUR, COLOUR_STACK, LANES, WEIGHTS, colours, density, place_colour
from ..hashing import following, seeded, uniform, uniform_point
from ..intersection.fields import STACK, VALUES, evaluate
from ..lamps import FIELD, intensity, lamps, varies
from ..tree.moments import lamp_cells
from ..tree.nodes import INSIDE
from .cut import ATTEMPTS, POINT_MIS_SCALE, choose, chosen_box, draw, found_inside, project, resolved, slope_of
from .cut_boxes import corner, far_corner
from .cut_tables import lamp_steps, placements
from .projection import interior_offset
from .strategies import NO_BSDF_RAYS, POINTS, PROJECTION, UNIFORM_POINTS

EVEN = 0.5  # relative variance of the emission below which uniform points are enough, if light is scattered again
LATTICE = (1.0 / LANES, 0.7548776662466927, 0.5698402909980532)  # lattice step between points in a leaf (Roberts 2018)
NOTHING = (0.0, 0.0, 1.0), ZERO  # a point that gives no light


@replaced_on_gpu
@kernel
def project_afar(block, lamp, x, has_glossy, cut):
    """As ``cut.project``. If no glossy lobes compete, distant lamps whose emission varies are points, too."""
    project(block, lamp, x, has_glossy, cut)
    place = placements(block)[lamp]
    if cut.bsdf_mis_scale < POINT_MIS_SCALE and not has_glossy and varies(block, lamp) and resolved(place):
        even = lamp_steps(block)[place.first_cell].rough < EVEN
        cut.points, cut.bsdf_mis_scale = UNIFORM_POINTS if even else POINTS, NO_BSDF_RAYS


@replaced_on_gpu
@kernel
def sample_point(block, lamp, x, store, cut, u1, u2, u3):
    """The offset from x to a point of the lamp, and the radiant intensity (RGB, W/sr) with which it represents the
    whole lamp."""
    row, place = lamps(block)[lamp], placements(block)[lamp]
    if cut.strategy == PROJECTION and (row.glow < 0 or cut.points == UNIFORM_POINTS):
        way = interior_offset(block, lamp, x, u1, u2, u3)
        return way, uniform_intensity(block, lamp, sub(add(x, way), vec(row.center)))
    if row.glow < 0:
        boxes, cells = store[cut.slot], lamp_cells(block)[place.first_cell :]
        q, level, k = draw(block, lamp, place, boxes, cut, cells, (u1, u2, u3))
        cell = cells[boxes.cell[k]]
        if boxes.solid[k] and cell.state != INSIDE:
            if not found_inside(block, lamp, place, cell, add(q, add(vec(boxes.center), vec(cut.origin)))):
                return NOTHING
        return transform_vector(place.matrix, q), scale(vec(row.emission), cut.total / level)
    return _glowing_point(block, lamp, row, place, x, store, cut, (u1, u2, u3))


@kernel
def uniform_intensity(block, lamp, offset):
    """Radiant intensity (RGB, W/sr) with which a uniform point of a lamp, relative to its centre, stands for all of
    it."""
    row = lamps(block)[lamp]
    if row.glow < 0:
        return intensity(block, lamp)
    return scale(_emission_at(block, row, offset), row.volume)


@kernel
def _glowing_point(block, lamp, row, place, x, store, cut, u):
    """``sample_point`` by the emission of the tree's leaves."""
    part, points, stack = stack_array(3), stack_array(COLOUR), stack_array(COLOUR_STACK)
    part[0], part[1], part[2] = u
    index, low, high, probability, level, slope, clipped = _leaf(block, place, store, cut, part)
    cell, size = lamp_cells(block)[place.first_cell + index], sub(high, low)
    volume, count, state = size[0] * size[1] * size[2], LANES, seeded(u[0], u[1], u[2])
    for _ in range(ATTEMPTS):
        for lane in range(LANES):
            state = following(state)
            within = uniform_point(state)
            if cell.state == INSIDE:
                within = _shifted(part, lane)
            q = (low[0] + size[0] * within[0], low[1] + size[1] * within[1], low[2] + size[2] * within[2])
            points[lane], points[LANES + lane], points[2 * LANES + lane] = q
            stack[WEIGHTS + lane] = level + dot(slope, q)
        if cell.state == INSIDE:
            break
        found = _keep_inside(block, lamp, row, place, cell, points, stack)
        if not clipped:
            break
        if found > 0:
            # The points inside are uniform there.
            volume, count = cell.volume, found
            break
    for lane in range(LANES):
        place_colour(block, row.glow, transform_point(place.matrix, _lane(points, lane)), lane, stack)
    colours(block, row.glow, stack)
    total = 0.0
    for lane in range(LANES):
        stack[WEIGHTS + lane] *= average(density(block, row.glow, stack, lane))
        total += stack[WEIGHTS + lane]
    left, chosen = uniform(following(state)) * total, 0
    while chosen < LANES - 1 and left >= stack[WEIGHTS + chosen]:
        left -= stack[WEIGHTS + chosen]
        chosen += 1
    weight = stack[WEIGHTS + chosen]
    if not weight > 0.0:
        return NOTHING
    way = add(sub(vec(row.center), x), transform_point(place.matrix, _lane(points, chosen)))
    return way, scale(
        density(block, row.glow, stack, chosen), total * place.factor * volume / (count * weight * probability)
    )


@kernel
def _leaf(block, place, store, cut, part):
    """The leaf of the tree, or the solid box, that the numbers ``part`` choose; they are stretched back to [0, 1).

    Returns its index, its corners in tree space and the probability of the choice; α and b, where the point y of tree
    space has the weight α + b·y; and whether the interior volume is known, so that only interior points have to count.
    """
    cells, steps = lamp_cells(block)[place.first_cell :], lamp_steps(block)[place.first_cell :]
    index, level, slope, probability = 0, 1.0, ZERO, 1.0
    if cut.strategy != PROJECTION:
        boxes = store[cut.slot]
        k = chosen_box(boxes, cut, part)
        index, slope, probability = np.int64(boxes.cell[k]), slope_of(cut, k), cut.weight[k] / cut.mass[0]
        level = np.float64(cut.level[k]) - dot(slope, add(vec(boxes.center), vec(cut.origin)))
        if boxes.solid[k]:
            low, high = add(vec(boxes.center), corner(boxes, k)), add(vec(boxes.center), far_corner(boxes, k))
            return index, low, high, probability, level, slope, False
    first = steps[index].first
    while first >= 0:
        a, b = steps[first], steps[first + 1]
        one = a.light * (level + dot(slope, vec(a.centroid)))
        two = b.light * (level + dot(slope, vec(b.centroid)))
        side = choose(part, steps[index].axis, one, two)
        probability *= (two if side else one) / (one + two)
        index = first + side
        first = steps[index].first
    return index, vec(cells[index].low), vec(cells[index].high), probability, level, slope, True


@kernel
def _shifted(part, lane):
    """Points of a lattice in the unit cube, with one common shift."""
    return (
        (part[0] + LATTICE[0] * lane) % 1.0,
        (part[1] + LATTICE[1] * lane) % 1.0,
        (part[2] + LATTICE[2] * lane) % 1.0,
    )


@kernel
def _emission_at(block, row, offset):
    """ρ (RGB) at a point of the world relative to the lamp's centre."""
    stack = stack_array(COLOUR_STACK)
    for lane in range(LANES):
        place_colour(block, row.glow, offset, lane, stack)
    colours(block, row.glow, stack)
    return density(block, row.glow, stack, 0)


@kernel
def _keep_inside(block, lamp, row, place, cell, points, stack):
    """Set the weight of outside points of tree space, in a leaf on the boundary, to zero. Returns how many are
    inside."""
    count = LANES
    values = stack_array(STACK)
    if row.kind == FIELD:
        for at in range(COLOUR):
            values[at] = points[at]
        evaluate(block, row, cell.row_first, cell.row_count, LANES, values)
    for lane in range(LANES):
        if row.kind == FIELD:
            inside = values[VALUES + lane] <= 0.0
        else:
            inside = found_inside(block, lamp, place, cell, _lane(points, lane))
        if not inside:
            stack[WEIGHTS + lane] = 0.0
            count -= 1
    return count


@kernel
def _lane(points, lane):
    return points[lane], points[LANES + lane], points[2 * LANES + lane]
