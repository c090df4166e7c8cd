# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cell-cut sampling: directions to a lamp in proportion to what its parts give the point that is lit.

What a point at offset v of a uniform lamp gives a surface with normal n is t(v) = max(0, n·v)/|v|³. Projection sampling
draws points without regard to it. Here a *cut* of the lamp's tree, the boxes that matter to the point that is lit, is
found anew for every such point; in each box the points' density is the linear function that fits t there,

    q(y) = Σ_k [y in box k] (α_k + b_k·y) / Z,

uniform lamps only. Linear functions keep all in closed form. Points of a box that is full are drawn without rejection.
The integral over what is inside a box follows from its volume and centroid, so Z does. The density of a direction is
the integral of r² q along its ray, a polynomial in each piece of the ray's intervals inside a box:

    p(ω) = ∫ r² q dr = Σ 2h [L c² + (L + 2cB) h²/3],      L = q at the middle c of the piece, B = its slope along the ray.

t is the field of a dipole, hence harmonic: its mean over a ball is its value at the centre. So the error of the linear
function is of second order in the size of a box, and hardly shifts the balance between boxes.

The cut starts as the whole lamp. The box that contributes most to the variance is replaced by its two parts until the
rest is small. Far away it stays a single box, and the density is all but that of projection sampling.

A *clipped* box accepts points of the interior only. One that is rejected is drawn again in the leaf that it fell into,
so that stratified numbers stay stratified in all larger boxes; the leaves are chosen by their volume inside, as it is
known. A *solid* box, full or one leaf on the boundary, accepts all its points: it is exact whatever the volumes are
known to be. Boxes next to the point that is lit are solid, so errors of volumes weigh in only where many average.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import kernel, stack_array, table
from ..sdf.program import INSTRUCTION
from ..vec import add, dot, madd, normalize, scale, sub, transform_normal, transform_point, transform_vector, vec
from . import interior, moments
from .fields import lamp_lists, value
from .hashing import following, seeded, uniform_point
from .interior import INSIDE
from .lamps import CLOSED, PRIMITIVE, BuiltLamp, direction_pdf, lamps, sample_direction
from .membership import contains
from .moments import CELL, lamp_cells

MOST_CELLS = 32  # in a cut
MOST_ENTRIES = 2 * MOST_CELLS

PLACEMENT = np.dtype([
    ("first_cell", np.int64),
    ("matrix", np.float64, (3, 4)),  # tree space -> world, relative to the lamp's centre
    ("inverse", np.float64, (3, 4)),  # back
    ("metric", np.float64, (3, 3)),  # scalar product of the world, in tree space
    ("factor", np.float64),  # volume in the world of a unit of tree space
    ("step", np.float64),  # m in the world, well below the thickness of the lamp
], align=True)

CUT = np.dtype([
    ("cells", np.int64),  # 0: projection sampling is as good
    ("entries", np.int64),
    ("total", np.float64),  # Z in the world
    ("variance", np.float64),  # relative, that is expected to be left
    ("beta", np.float64),  # what the density of the BSDF counts in the balance heuristic
    ("origin", np.float64, (3,)),  # the point that is lit, in tree space
    # Of each box: its corners, and the density α + b·(y − origin), up to Z.
    ("low", np.float64, (3, MOST_CELLS)),
    ("high", np.float64, (3, MOST_CELLS)),
    ("level", np.float64, MOST_CELLS),
    ("slope", np.float64, (3, MOST_CELLS)),
    ("weight", np.float64, MOST_CELLS),  # integral of the density over what is accepted
    ("priority", np.float64, MOST_CELLS),  # contribution to the variance, times Z²
    ("cell", np.int64, MOST_CELLS),  # index in the lamp's cells
    ("solid", np.int64, MOST_CELLS),
    ("entry", np.int64, MOST_CELLS),
    ("enter", np.float64, MOST_CELLS),
    ("leave", np.float64, MOST_CELLS),
    # The way down to the boxes.
    ("first", np.int64, MOST_ENTRIES),  # the two entries below; −1 for a box
    ("axis", np.int64, MOST_ENTRIES),
    ("box", np.int64, MOST_ENTRIES),
    ("mass", np.float64, MOST_ENTRIES),  # integral of the density over the boxes that points are drawn from
], align=True)

TABLES = {"lamp_placements": PLACEMENT, "lamp_cells": CELL}

TOLERANCE = 2e-3  # relative variance of a sample at which boxes are small enough
LIMIT = MOST_CELLS  # boxes
ATTEMPTS = 4096  # draws of a point in a box before giving up
LEAST_FILL = 0.02  # interior that a solid box counts as having at least: sampling may have missed it
FLAT = 0.05  # least density in a box, of that at its centroid
SOFT = 0.8  # makes the mean over a ball round the point that is lit right
SURROUNDED_BETA = 3.0
LEAST_BETA, BETA_RATE = 0.02, 4.0
STEP = 0.3  # of the thickness of the lamp

placements = table("lamp_placements", PLACEMENT)
instructions = table("lamp_instructions", INSTRUCTION)


def pack_cuts(built: list[BuiltLamp], shapes: list, matrices: list[np.ndarray]) -> dict[str, np.ndarray]:
    """Tables of ``TABLES`` for lamps that were built from ``shapes``, placed by ``matrices`` (4 × 4)."""
    placed, parts, used, first = np.zeros(len(built), PLACEMENT), [np.zeros(0, CELL)], 0, {}
    for row, lamp, shape, matrix in zip(placed, built, shapes, matrices):
        tree = interior.tree(shape)
        factor = abs(float(np.linalg.det(matrix[:3, :3])))
        if shape not in first:
            first[shape] = used
            parts.append(moments.cells(tree, float(lamp.row["volume"][0]) / factor))
            used += len(parts[-1])
        to_world = np.array(matrix, np.float64)
        to_world[:3, 3] += to_world[:3, :3] @ tree.center - lamp.row["center"][0]
        row["first_cell"], row["factor"] = first[shape], factor
        row["matrix"], row["inverse"] = to_world[:3], np.linalg.inv(to_world)[:3]
        row["metric"] = to_world[:3, :3].T @ to_world[:3, :3]
        own = parts[1 + list(first).index(shape)]
        leaves = own[own["first"] < 0]
        thickness = np.average((leaves["high"] - leaves["low"]).min(axis=1), weights=leaves["volume"] + 1e-300)
        row["step"] = STEP * thickness * factor ** (1.0 / 3.0)
    return {"lamp_placements": placed, "lamp_cells": np.concatenate(parts)}


@kernel
def _fit(cut, k, metric, normal, volume, centroid, spread, splits):
    """Fit the density of box k, whose corners are known, to what it gives: fills in its level, slope, weight, priority.

    ``centroid`` and ``volume`` are of what is accepted; ``splits`` tells whether the box can be divided.
    """
    low, high = (cut.low[0, k], cut.low[1, k], cut.low[2, k]), (cut.high[0, k], cut.high[1, k], cut.high[2, k])
    w = sub(centroid, vec(cut.origin))
    half = 0.5 * (abs(normal[0]) * (high[0] - low[0]) + abs(normal[1]) * (high[1] - low[1])
                  + abs(normal[2]) * (high[2] - low[2]))
    height = 0.5 * (dot(normal, low) + dot(normal, high)) - dot(normal, vec(cut.origin))
    if height + half <= 0.0:
        cut.weight[k] = cut.priority[k] = cut.level[k] = 0.0
        cut.slope[0, k] = cut.slope[1, k] = cut.slope[2, k] = 0.0
        return
    g = transform_vector(metric, w)
    square = max(dot(w, g), 1e-300)
    extent = metric[0, 0] * spread[0] + metric[1, 1] * spread[1] + metric[2, 2] * spread[2]
    ratio = extent / square
    inverse = 1.0 / (square + SOFT * extent * min(ratio, 1.0))
    rate, waste = 1.0, 0.0
    if height - half >= 0.0:
        height = dot(normal, w)
    else:  # the mean of max(0, ·), and its derivative, over heights that are spread evenly
        rate = (height + half) / (2.0 * half)
        height = 0.5 * (height + half) * rate
        waste = 1.0 - rate
    level = height * inverse * math.sqrt(inverse)
    rate, fall = rate / height, -3.0 * inverse
    a = (rate * normal[0] + fall * g[0], rate * normal[1] + fall * g[1], rate * normal[2] + fall * g[2])
    drop = -(min(a[0] * (low[0] - centroid[0]), a[0] * (high[0] - centroid[0]))
             + min(a[1] * (low[1] - centroid[1]), a[1] * (high[1] - centroid[1]))
             + min(a[2] * (low[2] - centroid[2]), a[2] * (high[2] - centroid[2])))
    if drop > 1.0 - FLAT:
        a = scale(a, (1.0 - FLAT) / drop)
    cut.level[k] = level * (1.0 - dot(a, w))
    cut.slope[0, k], cut.slope[1, k], cut.slope[2, k] = scale(a, level)
    cut.weight[k] = volume * level
    cut.priority[k] = volume * level * (min(1.2 * ratio * ratio, 1.5) + waste) if splits else 0.0


@kernel
def _fit_solid(cut, k, metric, normal, fill, splits):
    """Fit box k of the cut, all of which is accepted, to what it gives when the part ``fill`` of it is interior."""
    low, high = (cut.low[0, k], cut.low[1, k], cut.low[2, k]), (cut.high[0, k], cut.high[1, k], cut.high[2, k])
    size = sub(high, low)
    volume = size[0] * size[1] * size[2]
    third = 1.0 / 12.0
    _fit(cut, k, metric, normal, volume, scale(add(low, high), 0.5),
         (third * size[0] * size[0], third * size[1] * size[1], third * size[2] * size[2]), splits)
    if fill < 1.0:
        cut.level[k] *= fill
        cut.weight[k] *= fill
        cut.priority[k] *= fill
        cut.slope[0, k], cut.slope[1, k], cut.slope[2, k] = (
            fill * cut.slope[0, k], fill * cut.slope[1, k], fill * cut.slope[2, k])


@kernel
def _add(cut, k, entry, metric, normal, cells, index):
    """Put a cell of the tree in box k of the cut, below ``entry``."""
    cell = cells[index]
    cut.cell[k], cut.entry[k] = index, entry
    cut.first[entry], cut.box[entry] = -1, k
    cut.low[0, k], cut.low[1, k], cut.low[2, k] = vec(cell.low)
    cut.high[0, k], cut.high[1, k], cut.high[2, k] = vec(cell.high)
    if cell.first < 0:
        size = (cell.high[0] - cell.low[0]) * (cell.high[1] - cell.low[1]) * (cell.high[2] - cell.low[2])
        cut.solid[k] = 1
        _fit_solid(cut, k, metric, normal, max(cell.volume / size, LEAST_FILL), cell.state == INSIDE)
    else:
        cut.solid[k] = 0
        _fit(cut, k, metric, normal, cell.volume, vec(cell.centroid), vec(cell.spread), True)


@kernel
def _halve(cut, k, other, entry, metric, normal):
    """Divide box k, part of a full leaf, along its longest side."""
    axis, longest = 0, -1.0
    for m in range(3):
        size = metric[m, m] * (cut.high[m, k] - cut.low[m, k]) ** 2
        if size > longest:
            axis, longest = m, size
    for m in range(3):
        cut.low[m, other], cut.high[m, other] = cut.low[m, k], cut.high[m, k]
    middle = 0.5 * (cut.low[axis, k] + cut.high[axis, k])
    cut.high[axis, k] = cut.low[axis, other] = middle
    cut.axis[cut.entry[k]] = axis
    cut.solid[other], cut.cell[other] = 1, cut.cell[k]
    cut.first[entry] = cut.first[entry + 1] = -1
    cut.box[entry], cut.box[entry + 1] = k, other
    cut.entry[k], cut.entry[other] = entry, entry + 1
    _fit_solid(cut, k, metric, normal, 1.0, True)
    _fit_solid(cut, other, metric, normal, 1.0, True)


@kernel
def _open(cut, k, metric, normal, cells, limit):
    """Replace box k by the parts of its parts, or its parts where there is no room for more."""
    entry, first = cut.entry[k], cut.entries
    cell = cells[cut.cell[k]]
    cut.first[entry] = first
    cut.entries += 2
    if cell.first < 0:
        _halve(cut, k, cut.cells, first, metric, normal)
        cut.cells += 1
        return
    cut.axis[entry] = cell.axis
    place = k
    for side in range(2):
        index = cell.first + side
        part = cells[index]
        if part.first < 0 or cut.cells + 3 > limit:
            _add(cut, place, first + side, metric, normal, cells, index)
        else:
            below = cut.entries
            cut.first[first + side], cut.axis[first + side] = below, part.axis
            cut.entries += 2
            _add(cut, place, below, metric, normal, cells, part.first)
            place = cut.cells
            cut.cells += 1
            _add(cut, place, below + 1, metric, normal, cells, part.first + 1)
        if side == 0:
            place = cut.cells
            cut.cells += 1


@kernel
def _holds(cell, q):
    return (cell.low[0] <= q[0] <= cell.high[0] and cell.low[1] <= q[1] <= cell.high[1]
            and cell.low[2] <= q[2] <= cell.high[2])


@kernel
def _surrounded(cells, q):
    """Whether the point q of tree space is in a box that is full, or nearly so."""
    if not _holds(cells[0], q):
        return False
    index = 0
    while cells[index].direct == 0:
        index = cells[index].first
        if not _holds(cells[index], q):
            index += 1
            if not _holds(cells[index], q):
                return False
    return True


@kernel
def build(block, lamp, x, n, cut, tolerance, limit):
    """Find the cut for the point x with the normal n, of at most ``limit`` boxes.

    Boxes are divided until the relative variance that is expected is below ``tolerance``.

    ``cut.beta`` is for the balance heuristic p / (p + β p_bsdf): any positive number is unbiased. Where the lamp fills
    what is close to the surface, directions of the BSDF are almost all that is needed, and no cut is made. Elsewhere
    they make up for what the boxes next to the point do not follow, and only cost variance where nothing is close.
    """
    place = placements(block)[lamp]
    cells = lamp_cells(block)[place.first_cell:]
    metric = place.metric
    normal = transform_normal(place.matrix, n)
    offset = sub(x, vec(lamps(block)[lamp].center))
    cut.cells, cut.beta = 0, SURROUNDED_BETA
    if _surrounded(cells, transform_point(place.inverse, madd(offset, place.step, n))):
        return
    cut.origin[0], cut.origin[1], cut.origin[2] = transform_point(place.inverse, offset)
    cut.cells = cut.entries = 1
    _add(cut, 0, 0, metric, normal, cells, 0)
    total, left = 0.0, 0.0
    while True:
        total, left, worst, most = 0.0, 0.0, 0, -1.0
        for k in range(cut.cells):
            total += cut.weight[k]
            left += cut.priority[k]
            if cut.priority[k] > most:
                worst, most = k, cut.priority[k]
        if left <= tolerance * total or cut.cells >= limit:
            break
        _open(cut, worst, metric, normal, cells, limit)
    cut.total, cut.variance = total * place.factor, left / total if total > 0.0 else 0.0
    cut.beta = min(max(BETA_RATE * cut.variance, LEAST_BETA), 1.0)
    for entry in range(cut.entries - 1, -1, -1):
        first = cut.first[entry]
        cut.mass[entry] = cut.mass[first] + cut.mass[first + 1] if first >= 0 else cut.weight[cut.box[entry]]


@kernel
def _place_in(low, high, level, slope, u):
    """Where u puts a point in [low, high] by a density that is ``level`` in the middle and has a slope."""
    tilt = 0.5 * slope * (high - low) / level
    part = 2.0 * u / (1.0 - tilt + math.sqrt(max((1.0 - tilt) * (1.0 - tilt) + 4.0 * tilt * u, 0.0)))
    return low + min(part, 1.0) * (high - low)


@kernel
def _choose(part, axis, first, second):
    """The side, of two of the masses given, that the number ``part[axis]`` chooses; it is stretched back to [0, 1)."""
    share = first / (first + second)
    u = part[axis]
    side = 1 if u >= share else 0
    part[axis] = (u - share) / (1.0 - share) if side else u / share
    return side


@kernel
def _point(low, high, base, slope, u1, u2, u3):
    """The point of a box that three numbers give by the density base + slope·y."""
    middle = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))
    level = base + dot(slope, middle)
    x = _place_in(low[0], high[0], level, slope[0], u1)
    level += slope[0] * (x - middle[0])
    y = _place_in(low[1], high[1], level, slope[1], u2)
    level += slope[1] * (y - middle[1])
    return (x, y, _place_in(low[2], high[2], level, slope[2], u3))


@kernel
def found_inside(block, lamp, place, cell, q):
    """Whether the point q of tree space, in a leaf on the boundary, is inside."""
    row = lamps(block)[lamp]
    program = instructions(block)[row.first_instruction:row.first_instruction + row.instruction_count]
    if row.kind == PRIMITIVE:
        return contains(program, transform_point(place.matrix, q))
    if row.kind == CLOSED:
        first = row.first_list + cell.row_first
        return contains(program, q, lamp_lists(block)[first:first + cell.row_count])
    return value(block, row, cell.row_first, cell.row_count, q) <= 0.0


@kernel
def _draw(block, lamp, place, cut, cells, u):
    """A point of the interior, or of a solid box, by the density of the cut."""
    part = stack_array(3)
    part[0], part[1], part[2] = u
    entry = 0
    while cut.first[entry] >= 0:
        first = cut.first[entry]
        entry = first + _choose(part, cut.axis[entry], cut.mass[first], cut.mass[first + 1])
    k = cut.box[entry]
    slope = (cut.slope[0, k], cut.slope[1, k], cut.slope[2, k])
    base = cut.level[k] - dot(slope, vec(cut.origin))
    index = cut.cell[k]
    low, high = (cut.low[0, k], cut.low[1, k], cut.low[2, k]), (cut.high[0, k], cut.high[1, k], cut.high[2, k])
    if cells[index].direct == 0:
        while cells[index].direct == 0:
            first = cells[index].first
            a, b = cells[first], cells[first + 1]
            index = first + _choose(part, cells[index].axis, a.volume * (base + dot(slope, vec(a.centroid))),
                                    b.volume * (base + dot(slope, vec(b.centroid))))
        low, high = vec(cells[index].low), vec(cells[index].high)
    u1, u2, u3 = part[0], part[1], part[2]
    state = seeded(u[0], u[1], u[2])
    q = (0.0, 0.0, 0.0)
    for _ in range(ATTEMPTS):
        q = _point(low, high, base, slope, u1, u2, u3)
        if cut.solid[k] or cells[index].state == INSIDE or found_inside(block, lamp, place, cells[index], q):
            return q
        state = following(state)
        u1, u2, u3 = uniform_point(state)
    return q


@kernel
def sample(block, lamp, x, cut, u1, u2, u3):
    """Unit direction from x by the cut; its density is ``density``."""
    if cut.cells == 0:
        return sample_direction(block, lamp, x, (0.0, 0.0, 0.0), u1, u2, u3)
    place = placements(block)[lamp]
    cells = lamp_cells(block)[place.first_cell:]
    q = _draw(block, lamp, place, cut, cells, (u1, u2, u3))
    return normalize(transform_vector(place.matrix, sub(q, vec(cut.origin))))


@kernel
def _piece(level, slope, start, end):
    """∫ r² (level + slope·r) dr."""
    c, h = 0.5 * (start + end), 0.5 * (end - start)
    middle = level + slope * c
    return 2.0 * h * (middle * c * c + (middle + 2.0 * c * slope) * h * h / 3.0)


@kernel
def _direction(v):
    """1/v, finite for zero."""
    return 1.0 / v if abs(v) > 1e-30 else 1e30


@kernel
def density(block, lamp, d, cut, spans, count):
    """Density per solid angle of ``sample`` giving d, from the intervals that ``trace`` found."""
    if cut.cells == 0:
        return direction_pdf(block, lamp, vec(cut.origin), (0.0, 0.0, 0.0), d, spans, count)
    place = placements(block)[lamp]
    way = transform_vector(place.inverse, d)
    total = 0.0
    over = (_direction(way[0]), _direction(way[1]), _direction(way[2]))
    o = vec(cut.origin)
    for k in range(cut.cells):
        ax, bx = (cut.low[0, k] - o[0]) * over[0], (cut.high[0, k] - o[0]) * over[0]
        ay, by = (cut.low[1, k] - o[1]) * over[1], (cut.high[1, k] - o[1]) * over[1]
        az, bz = (cut.low[2, k] - o[2]) * over[2], (cut.high[2, k] - o[2]) * over[2]
        cut.enter[k] = max(min(ax, bx), min(ay, by), min(az, bz), 0.0)
        cut.leave[k] = min(max(ax, bx), max(ay, by), max(az, bz))
    for k in range(cut.cells):
        start, end = cut.enter[k], cut.leave[k]
        if start >= end:
            continue
        level = cut.level[k]
        slope = cut.slope[0, k] * way[0] + cut.slope[1, k] * way[1] + cut.slope[2, k] * way[2]
        if cut.solid[k]:
            total += _piece(level, slope, start, end)
            continue
        for index in range(count):
            c, h = spans[index, 0], spans[index, 1]
            a, b = max(start, c - h), min(end, c + h)
            if a < b:
                total += _piece(level, slope, a, b)
    return total / cut.total if cut.total > 0.0 else 0.0
