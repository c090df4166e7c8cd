# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cell-cut sampling: directions to a lamp in proportion to what its parts give the point that is lit.

What a point at offset v of a uniform lamp gives a surface with normal n is t(v) = max(0, n·v)/|v|³. Projection sampling
draws points without regard to it. Here a *cut* of the lamp's tree, the boxes that matter to the point that is lit, is
found; in each box the points' density is the linear function that fits t there,

    q(y) = Σ_k [y in box k] (α_k + b_k·y) / Z.

Linear functions keep all in closed form. Points of a box that is full are drawn without rejection. The integral over
what is inside a box follows from its volume and centroid, so Z does. The density of a direction is the integral of r² q
along its ray, a polynomial in each piece of the ray's intervals inside a box:

    p(ω) = ∫ r² q dr = Σ 2h [L c² + (L + 2cB) h²/3],      L = q at the middle c of the piece, B = its slope along the ray.

t is the field of a dipole, hence harmonic: its mean over a ball is its value at the centre. So the error of the linear
function is of second order in the size of a box, and hardly shifts the balance between boxes.

*Which* boxes changes slowly, and any choice is unbiased. They are found once for all points of a region (a cube whose size
goes with its distance from the lamp) with similar normals, starting from the whole lamp: the box that contributes most
to the variance is replaced by its parts until the rest is small. Each thread keeps the boxes of the regions that it
has met; they depend on nothing but the region, so the picture does not depend on who met it first. *How much* each box
counts is fitted to the very point and normal that are lit, for all boxes at once, which the compiler turns into vector
instructions.

A *clipped* box accepts points of the interior only. One that is rejected is drawn again in the leaf that it fell into,
so that stratified numbers stay stratified in all larger boxes; the leaves are chosen by their volume inside, as it is
known. A *solid* box, full or one leaf on the boundary, accepts all its points: it is exact whatever the volumes are
known to be. Boxes next to the point that is lit are solid, so errors of volumes weigh in only where many average.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from ..jit import kernel, stack_array, table
from ..sdf.program import INSTRUCTION
from ..vec import (
    add, dot, length, madd, mul, normalize, scale, sub, transform_normal, transform_point, transform_vector, vec)
from . import interior, moments
from .fields import lamp_lists, value
from .hashing import bits, following, seeded, uniform_point
from .interior import INSIDE
from .lamps import CLOSED, PRIMITIVE, BuiltLamp, direction_pdf, lamps, sample_direction, volume_of
from .membership import contains
from .moments import CELL, lamp_cells

MOST_BOXES = 32  # in a cut
MOST_ENTRIES = 2 * MOST_BOXES
REGIONS = 512  # whose boxes a thread keeps: a power of two

PLACEMENT = np.dtype([
    ("first_cell", np.int64),
    ("matrix", np.float64, (3, 4)),  # tree space -> world, relative to the lamp's centre
    ("inverse", np.float64, (3, 4)),  # back
    ("metric", np.float64, (3, 3)),  # scalar product of the world, in tree space
    ("factor", np.float64),  # volume in the world of a unit of tree space
    ("unit", np.float64, (3,)),  # tree space, for a metre of the world along each of its axes
    ("extent", np.float64),  # m², mean square distance of the interior from its centroid, in the world
    ("centroid", np.float64, (3,)),  # in the world, relative to the lamp's centre
    ("thickness", np.float64),  # m in the world: mean of the boxes' least sides
], align=True)

STEP_DOWN = np.dtype([  # what it takes of a cell to choose between it and its sibling, in little memory
    ("first", np.int32),  # as in CELL; −1 where points are drawn from the cell itself
    ("axis", np.int32),
    ("volume", np.float32),
    ("centroid", np.float32, (3,)),
    ("rough", np.float32),  # relative variance of the emission in the cell
], align=True)

BOXES = np.dtype([  # of a region
    ("key", np.uint64),  # hash of lamp, region and normal; 0: nothing is here
    ("count", np.int64),
    ("entries", np.int64),
    ("variance", np.float64),  # relative, that is expected to be left
    # Tree space; the first axis is the coordinate.
    ("low", np.float64, (3, MOST_BOXES)),
    ("high", np.float64, (3, MOST_BOXES)),
    ("centroid", np.float64, (3, MOST_BOXES)),  # of what is accepted
    ("extent", np.float64, MOST_BOXES),  # m² in the world: mean square distance from the centroid
    ("volume", np.float64, MOST_BOXES),  # of what is accepted
    ("fill", np.float64, MOST_BOXES),  # light that a unit of the accepted volume gives
    ("rough", np.float64, MOST_BOXES),  # relative variance of the emission in the box
    ("priority", np.float64, MOST_BOXES),  # contribution to the variance
    ("cell", np.int64, MOST_BOXES),  # index in the lamp's cells
    ("solid", np.int64, MOST_BOXES),
    ("entry", np.int64, MOST_BOXES),
    # The way down to the boxes.
    ("first", np.int64, MOST_ENTRIES),  # the two entries below; −1 for a box
    ("axis", np.int64, MOST_ENTRIES),
    ("box", np.int64, MOST_ENTRIES),
], align=True)

CUT = np.dtype([
    ("lamp", np.int64),
    ("slot", np.int64),  # of the region's boxes; −1: projection sampling is as good
    ("total", np.float64),  # Z in the world
    ("beta", np.float64),  # what the density of the BSDF counts in the balance heuristic
    ("origin", np.float64, (3,)),  # the point that is lit, in tree space
    # The density α + b·(y − origin) in each box, up to Z.
    ("level", np.float64, MOST_BOXES),
    ("slope", np.float64, (3, MOST_BOXES)),
    ("weight", np.float64, MOST_BOXES),  # integral of the density over what is accepted
    ("enter", np.float64, MOST_BOXES),
    ("leave", np.float64, MOST_BOXES),
    ("mass", np.float64, MOST_ENTRIES),  # integral of the density over the boxes that points are drawn from
], align=True)

TABLES = {"lamp_placements": PLACEMENT, "lamp_cells": CELL, "lamp_steps": STEP_DOWN}
WORKSPACE_TABLES = {"lamp_boxes": BOXES, "lamp_cuts": CUT}
WORKSPACE_COUNTS = {"lamp_boxes": REGIONS, "lamp_cuts": 1}

TOLERANCE = 2e-3  # relative variance of a sample at which boxes are small enough
LIMIT = MOST_BOXES
ATTEMPTS = 4096  # draws of a point in a box before giving up
LEAST_FILL = 0.02  # interior that a solid box counts as having at least: sampling may have missed it
LEAST_BRIGHT = 0.02  # emission that a box counts as having at least, of the mean: it was estimated
FLAT = 0.05  # least density in a box, of that at its centroid
SOFT = 0.8  # makes the mean over a ball round the point that is lit right
SURROUNDED_BETA = 3.0
LEAST_BETA, BETA_RATE = 0.02, 4.0
STEP = 0.3  # of the thickness of the lamp
PROJECTION_RATE = 4.0  # relative variance of projection sampling, of extent over square distance, far away
REGION = 0.25  # size of a region, of its distance from the lamp
NEAR = 0.5  # the distance that a region counts as having at least, of the thickness of the lamp
SHIFT = 0.381966  # of the grid of regions, in its cells
AMBIENT = 0.2  # added to cosines where boxes are chosen: the normals of a region differ

BELOW_ONE = 1.0 - 2.0**-53

# Odd numbers of 64 random bits, to hash what regions are told apart by.
_PRIMES = tuple(np.uint64(number) for number in (
    0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0xD6E8FEB86659FD93, 0xA0761D6478BD642F,
    0xE7037ED1A0B428DB))

placements = table("lamp_placements", PLACEMENT)
lamp_steps = table("lamp_steps", STEP_DOWN)
instructions = table("lamp_instructions", INSTRUCTION)


@functools.lru_cache(maxsize=32)
def uniform_cells(shape) -> np.ndarray:
    """``moments.cells`` of a shape."""
    return moments.cells(interior.tree(shape), volume_of(shape)[0])


@kernel
def roughness(cells, out):
    """Relative variance of the emission in each cell, as far as it differs between the leaves below."""
    second = np.zeros(len(cells))
    for index in range(len(cells) - 1, -1, -1):
        cell = cells[index]
        if cell.first < 0:
            second[index] = cell.mass * cell.mass / cell.volume if cell.volume > 0.0 else 0.0
        else:
            second[index] = second[cell.first] + second[cell.first + 1]
        square = cell.mass * cell.mass
        out[index] = max(second[index] * cell.volume / square - 1.0, 0.0) if square > 0.0 else 0.0


def pack_cuts(built: list[BuiltLamp], sources: list) -> dict[str, np.ndarray]:
    """Tables of ``TABLES`` for lamps that were built from ``sources``: anything with a ``shape`` and a ``matrix``."""
    placed, parts, used, first, thickness = np.zeros(len(built), PLACEMENT), [np.zeros(0, CELL)], 0, {}, {}
    for row, lamp, source in zip(placed, built, sources):
        shape, matrix = source.shape, np.asarray(source.matrix, np.float64)
        tree = interior.tree(shape)
        factor = abs(float(np.linalg.det(matrix[:3, :3])))
        own = uniform_cells(shape) if lamp.emission is None else lamp.emission.weighed.cells
        if id(own) not in first:
            first[id(own)], thickness[id(own)] = used, _thickness(own)
            parts.append(own)
            used += len(own)
        to_world = matrix.copy()
        to_world[:3, 3] += to_world[:3, :3] @ tree.center - lamp.row["center"][0]
        row["first_cell"], row["factor"] = first[id(own)], factor
        row["matrix"], row["inverse"] = to_world[:3], np.linalg.inv(to_world)[:3]
        row["metric"] = to_world[:3, :3].T @ to_world[:3, :3]
        row["unit"] = 1.0 / np.sqrt(row["metric"].diagonal())
        row["extent"] = row["metric"].diagonal() @ own["spread"][0]
        row["centroid"] = to_world[:3, :3] @ own["centroid"][0] + to_world[:3, 3]
        row["thickness"] = thickness[id(own)] * factor ** (1.0 / 3.0)
    cells = np.concatenate(parts)
    steps = np.zeros(len(cells), STEP_DOWN)
    for name in ("axis", "volume", "centroid"):
        steps[name] = cells[name]
    steps["first"] = np.where(cells["direct"] != 0, -1, cells["first"])
    for part, start in zip(parts[1:], first.values()):
        roughness(part, steps["rough"][start:start + len(part)])
    return {"lamp_placements": placed, "lamp_cells": cells, "lamp_steps": steps}


def _thickness(cells: np.ndarray) -> float:
    """Mean over the volume of the least side of the box that a point is in, in tree space."""
    leaves = cells[cells["first"] < 0]
    return np.average((leaves["high"] - leaves["low"]).min(axis=1), weights=leaves["volume"] + 1e-300)


@kernel
def _corner(boxes, k):
    return (boxes.low[0, k], boxes.low[1, k], boxes.low[2, k])


@kernel
def _far_corner(boxes, k):
    return (boxes.high[0, k], boxes.high[1, k], boxes.high[2, k])


@kernel
def _rank(boxes, k, metric, origin, normal, blur, splits):
    """Estimate for box k what it gives a region, and how much of that is variance: ``weight`` and ``priority``."""
    low, high = _corner(boxes, k), _far_corner(boxes, k)
    w = sub((boxes.centroid[0, k], boxes.centroid[1, k], boxes.centroid[2, k]), origin)
    square = dot(w, transform_vector(metric, w)) + blur
    half = 0.5 * (abs(normal[0]) * (high[0] - low[0]) + abs(normal[1]) * (high[1] - low[1])
                  + abs(normal[2]) * (high[2] - low[2]))
    height = 0.5 * (dot(normal, low) + dot(normal, high)) - dot(normal, origin)
    waste = 0.0
    if height <= -half:
        height = 0.0
    elif height < half:
        waste = 0.5 * (half - height) / half
        height = 0.5 * (height + half) * (1.0 - waste)
    ratio = boxes.extent[k] / max(square, 1e-300)
    inverse = 1.0 / max(square + SOFT * boxes.extent[k] * min(ratio, 1.0), 1e-300)
    weight = boxes.volume[k] * boxes.fill[k] * (height * math.sqrt(inverse) + AMBIENT) * inverse
    boxes.priority[k] = weight * (min(1.2 * ratio * ratio, 1.5) + waste + boxes.rough[k]) if splits else 0.0
    return weight


@kernel
def _solid(boxes, k, metric, fill):
    """All of box k, whose corners are known, is accepted."""
    boxes.solid[k], boxes.fill[k] = 1, fill
    volume, extent = 1.0, 0.0
    for axis in range(3):
        size = boxes.high[axis, k] - boxes.low[axis, k]
        volume *= size
        extent += metric[axis, axis] * size * size / 12.0
        boxes.centroid[axis, k] = 0.5 * (boxes.low[axis, k] + boxes.high[axis, k])
    boxes.volume[k], boxes.extent[k] = volume, extent


@kernel
def _put(boxes, k, entry, metric, cells, steps, index):
    """Make a cell of the tree box k, below ``entry``. Returns whether it can be divided."""
    cell = cells[index]
    boxes.cell[k], boxes.entry[k] = index, entry
    boxes.first[entry], boxes.box[entry] = -1, k
    size = 1.0
    for axis in range(3):
        boxes.low[axis, k], boxes.high[axis, k] = cell.low[axis], cell.high[axis]
        size *= cell.high[axis] - cell.low[axis]
    bright = max(cell.mass / cell.volume, LEAST_BRIGHT) if cell.volume > 0.0 else 1.0
    boxes.rough[k] = steps[index].rough
    if cell.first < 0:
        _solid(boxes, k, metric, bright * max(cell.volume / size, LEAST_FILL))
        return cell.state == INSIDE
    boxes.solid[k], boxes.fill[k], boxes.volume[k] = 0, bright, cell.volume
    boxes.extent[k] = 0.0
    for axis in range(3):
        boxes.centroid[axis, k] = cell.centroid[axis]
        boxes.extent[k] += metric[axis, axis] * cell.spread[axis]
    return True


@kernel
def _halve(boxes, k, other, entry, metric):
    """Divide box k, part of a full leaf, along its longest side."""
    axis, longest = 0, -1.0
    for m in range(3):
        size = metric[m, m] * (boxes.high[m, k] - boxes.low[m, k]) ** 2
        if size > longest:
            axis, longest = m, size
    for m in range(3):
        boxes.low[m, other], boxes.high[m, other] = boxes.low[m, k], boxes.high[m, k]
    middle = 0.5 * (boxes.low[axis, k] + boxes.high[axis, k])
    boxes.high[axis, k] = boxes.low[axis, other] = middle
    boxes.axis[boxes.entry[k]] = axis
    boxes.cell[other], boxes.rough[other] = boxes.cell[k], boxes.rough[k]
    boxes.first[entry] = boxes.first[entry + 1] = -1
    boxes.box[entry], boxes.box[entry + 1] = k, other
    boxes.entry[k], boxes.entry[other] = entry, entry + 1
    _solid(boxes, k, metric, boxes.fill[k])
    _solid(boxes, other, metric, boxes.fill[k])


@kernel
def _divide(block, place, origin, normal, blur, tolerance, limit, boxes):
    """Find the boxes for a region round ``origin`` (tree space), of at most ``limit``.

    Boxes are divided until the relative variance that is expected is below ``tolerance``.
    """
    cells, steps = lamp_cells(block)[place.first_cell:], lamp_steps(block)[place.first_cell:]
    metric = place.metric
    weight = stack_array(MOST_BOXES)
    boxes.count = boxes.entries = 1
    splits = _put(boxes, 0, 0, metric, cells, steps, 0)
    weight[0] = _rank(boxes, 0, metric, origin, normal, blur, splits)
    while True:
        total, left, worst, most = 0.0, 0.0, 0, -1.0
        for k in range(boxes.count):
            total += weight[k]
            left += boxes.priority[k]
            if boxes.priority[k] > most:
                worst, most = k, boxes.priority[k]
        boxes.variance = left / total if total > 0.0 else 0.0
        if left <= tolerance * total or boxes.count >= limit:
            return
        other, entry = boxes.count, boxes.entries
        boxes.count += 1
        boxes.entries += 2
        boxes.first[boxes.entry[worst]] = entry
        cell = cells[boxes.cell[worst]]
        if cell.first < 0:
            _halve(boxes, worst, other, entry, metric)
            first = second = True
        else:
            boxes.axis[boxes.entry[worst]] = cell.axis
            first = _put(boxes, worst, entry, metric, cells, steps, cell.first)
            second = _put(boxes, other, entry + 1, metric, cells, steps, cell.first + 1)
        weight[worst] = _rank(boxes, worst, metric, origin, normal, blur, first)
        weight[other] = _rank(boxes, other, metric, origin, normal, blur, second)


@kernel
def _fit(boxes, place, origin, normal, both, cut):
    """Fit the density of every box to what it gives. ``both``: light counts that falls on either side.

    One loop without branches: the compiler runs it on several boxes at once.
    """
    m = place.metric
    m00, m01, m02, m11, m12, m22 = m[0, 0], m[0, 1], m[0, 2], m[1, 1], m[1, 2], m[2, 2]
    nx, ny, nz = normal
    ax, ay, az = abs(nx), abs(ny), abs(nz)
    ox, oy, oz = origin
    low_x, low_y, low_z = boxes.low[0], boxes.low[1], boxes.low[2]
    high_x, high_y, high_z = boxes.high[0], boxes.high[1], boxes.high[2]
    middle_x, middle_y, middle_z = boxes.centroid[0], boxes.centroid[1], boxes.centroid[2]
    extents, fills, volumes = boxes.extent, boxes.fill, boxes.volume
    level, weight = cut.level, cut.weight
    slope_x, slope_y, slope_z = cut.slope[0], cut.slope[1], cut.slope[2]
    for k in range(np.uint64(boxes.count)):  # unsigned: Numba would test signed indices for being negative
        lx, ly, lz = low_x[k] - ox, low_y[k] - oy, low_z[k] - oz
        hx, hy, hz = high_x[k] - ox, high_y[k] - oy, high_z[k] - oz
        wx, wy, wz = middle_x[k] - ox, middle_y[k] - oy, middle_z[k] - oz
        half = 0.5 * (ax * (hx - lx) + ay * (hy - ly) + az * (hz - lz))
        middle = 0.5 * (nx * (hx + lx) + ny * (hy + ly) + nz * (hz + lz))
        gx, gy, gz = m00 * wx + m01 * wy + m02 * wz, m01 * wx + m11 * wy + m12 * wz, m02 * wx + m12 * wy + m22 * wz
        square = max(wx * gx + wy * gy + wz * gz, 1e-300)
        extent = extents[k]
        inverse = 1.0 / (square + SOFT * extent * min(extent / square, 1.0))
        side = -1.0 if both and middle < 0.0 else 1.0
        middle *= side
        # Where the horizon crosses the box: the mean of max(0, ·), or |·|, and its slope, over evenly spread heights.
        above = middle >= half
        upper = max(middle + half, 0.0)
        lower = half - middle if both else 0.0
        across = 0.5 / max(half, 1e-300)
        rate = 1.0 if above else (upper - lower) * across
        height = side * (nx * wx + ny * wy + nz * wz) if above else 0.5 * (upper * upper + lower * lower) * across
        amount = fills[k] * height * inverse * math.sqrt(inverse)
        share = side * rate / max(height, 1e-300)
        fall = -3.0 * inverse
        bx, by, bz = share * nx + fall * gx, share * ny + fall * gy, share * nz + fall * gz
        drop = -(min(bx * (lx - wx), bx * (hx - wx)) + min(by * (ly - wy), by * (hy - wy))
                 + min(bz * (lz - wz), bz * (hz - wz)))
        keep = amount * ((1.0 - FLAT) / drop if drop > 1.0 - FLAT else 1.0)
        bx, by, bz = keep * bx, keep * by, keep * bz
        level[k] = amount - (bx * wx + by * wy + bz * wz)
        slope_x[k], slope_y[k], slope_z[k] = bx, by, bz
        weight[k] = volumes[k] * amount


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
def _whole(value):
    return np.uint64(np.int64(math.floor(value)))


@kernel
def _region(block, lamp, place, origin, normal, both, tolerance, limit, store):
    """Slot of the boxes for the region of a point of tree space; ``normal`` is that of the surface, in tree space.

    Regions are aligned with the tree, so they move with the lamp; their sizes are those of the world.
    """
    root, unit = lamp_cells(block)[place.first_cell], vec(place.unit)
    low, high = vec(root.low), vec(root.high)
    away = (max(low[0] - origin[0], origin[0] - high[0], 0.0) / unit[0],
            max(low[1] - origin[1], origin[1] - high[1], 0.0) / unit[1],
            max(low[2] - origin[2], origin[2] - high[2], 0.0) / unit[2])
    target = REGION * max(length(away), NEAR * place.thickness)
    size = 0.5 * target / math.frexp(target)[0]  # a power of two
    step = scale(unit, size)
    # The grid is shifted, so that neither the middle of a lamp nor round numbers lie on its borders.
    at = (math.floor(origin[0] / step[0] + SHIFT), math.floor(origin[1] / step[1] + SHIFT),
          math.floor(origin[2] / step[2] + SHIFT))
    turn = (math.floor(2.0 * normal[0] * unit[0] + 0.5), math.floor(2.0 * normal[1] * unit[1] + 0.5),
            math.floor(2.0 * normal[2] * unit[2] + 0.5))
    side = np.uint64(turn[0] + 8.0 * turn[1] + 64.0 * turn[2] + 512.0) * np.uint64(4 * MOST_BOXES) + np.uint64(
        2 * limit + both)
    key = bits(_whole(at[0]) * _PRIMES[0] + _whole(at[1]) * _PRIMES[1] + _whole(at[2]) * _PRIMES[2]
               + _whole(size * 2.0**40) * _PRIMES[3] + side * _PRIMES[4] + np.uint64(lamp) * _PRIMES[5]) | np.uint64(1)
    slot = np.int64(key >> np.uint64(1)) & (len(store) - 1)
    boxes = store[slot]
    if boxes.key != key:
        boxes.key = key
        center = mul((at[0] + 0.5 - SHIFT, at[1] + 0.5 - SHIFT, at[2] + 0.5 - SHIFT), step)
        facing = (0.5 * turn[0] / unit[0], 0.5 * turn[1] / unit[1], 0.5 * turn[2] / unit[2])
        _divide(block, place, center, facing, 0.25 * size * size, tolerance, limit, boxes)
    return slot


@kernel
def prepare(block, lamp, x, n, both, tolerance, limit, store, cut):
    """Fit the cut to the point x with the normal n; ``both`` (0 or 1): to light that falls on either side.

    ``store`` holds boxes of regions (``BOXES``). They are at most ``limit``, or fewer where the relative variance
    that is expected is below ``tolerance``.

    ``cut.beta`` is for the balance heuristic p / (p + β p_bsdf): any positive number is unbiased. Where the lamp fills
    what is close to the surface, directions of the BSDF are almost all that is needed, and no cut is made. Elsewhere
    they make up for what the boxes next to the point do not follow, and only cost variance where nothing is close.
    """
    place = placements(block)[lamp]
    offset = sub(x, vec(lamps(block)[lamp].center))
    cut.lamp, cut.slot = lamp, -1
    way = sub(vec(place.centroid), offset)
    ratio = place.extent / max(dot(way, way), 1e-300)
    if PROJECTION_RATE * ratio < tolerance:
        cut.beta = LEAST_BETA
        return
    cells = lamp_cells(block)[place.first_cell:]
    if _surrounded(cells, transform_point(place.inverse, madd(offset, STEP * place.thickness, n))):
        cut.beta = SURROUNDED_BETA
        return
    origin, normal = transform_point(place.inverse, offset), transform_normal(place.matrix, n)
    slot = _region(block, lamp, place, origin, normal, both, tolerance, limit, store)
    boxes = store[slot]
    cut.origin[0], cut.origin[1], cut.origin[2] = origin
    _fit(boxes, place, origin, normal, both != 0, cut)
    for entry in range(boxes.entries - 1, -1, -1):
        first = boxes.first[entry]
        cut.mass[entry] = cut.mass[first] + cut.mass[first + 1] if first >= 0 else cut.weight[boxes.box[entry]]
    cut.total = cut.mass[0] * place.factor
    cut.beta = min(max(BETA_RATE * boxes.variance, LEAST_BETA), 1.0)
    if cut.total > 0.0:
        cut.slot = slot
    else:  # all of the lamp is behind the surface
        cut.beta = 1.0


@kernel
def beside(row, x):
    """Distance from x to the lamp's bounding box."""
    square = 0.0
    for k in range(3):
        away = max(abs(x[k] - row.center[k]) - row.half[k], 0.0)
        square += away * away
    return math.sqrt(square)


@kernel
def tuned_beta(row, x):
    """β by the distance from the lamp alone: 3 at its bounding box and within, less with the square of the distance."""
    size = (0.75 / math.pi * row.volume) ** (1.0 / 3.0)
    part = size / (size + 4.0 * beside(row, x))
    return max(SURROUNDED_BETA * part * part, LEAST_BETA)


@kernel
def project(block, lamp, x, cut):
    """As ``prepare``, without boxes: projection sampling, and β by the distance.

    Light that is scattered again before it reaches the camera is noisy for other reasons; there boxes do not pay.
    """
    cut.lamp, cut.slot, cut.beta = lamp, -1, tuned_beta(lamps(block)[lamp], x)


@kernel
def _place_in(low, high, level, slope, u):
    """Where u puts a point in [low, high] by a density that is ``level`` in the middle and has a slope."""
    tilt = 0.5 * slope * (high - low) / level
    part = 2.0 * u / (1.0 - tilt + math.sqrt(max((1.0 - tilt) * (1.0 - tilt) + 4.0 * tilt * u, 0.0)))
    return low + min(part, 1.0) * (high - low)


@kernel
def _choose(part, axis, first, second):
    """The side, of two of the masses given, that the number ``part[axis]`` chooses; it is stretched back to [0, 1)."""
    place = part[axis] * (first + second)
    side = 1 if place >= first and second > 0.0 else 0
    part[axis] = min((place - first) / second if side else place / first, BELOW_ONE)
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
def _draw(block, lamp, place, boxes, cut, cells, u):
    """A point of the interior, or of a solid box, by the density of the cut."""
    part = stack_array(3)
    part[0], part[1], part[2] = u
    entry = 0
    while boxes.first[entry] >= 0:
        first = boxes.first[entry]
        entry = first + _choose(part, boxes.axis[entry], cut.mass[first], cut.mass[first + 1])
    k = boxes.box[entry]
    slope = (cut.slope[0, k], cut.slope[1, k], cut.slope[2, k])
    base = cut.level[k]
    index = boxes.cell[k]
    origin = vec(cut.origin)
    low, high = sub(_corner(boxes, k), origin), sub(_far_corner(boxes, k), origin)
    steps = lamp_steps(block)[place.first_cell:]
    first = steps[index].first if boxes.solid[k] == 0 else -1
    if first >= 0:
        base_there = base - dot(slope, origin)
        while first >= 0:
            a, b = steps[first], steps[first + 1]
            index = first + _choose(part, steps[index].axis,
                                    a.volume * (base_there + dot(slope, vec(a.centroid))),
                                    b.volume * (base_there + dot(slope, vec(b.centroid))))
            first = steps[index].first
        low, high = sub(vec(cells[index].low), origin), sub(vec(cells[index].high), origin)
    u1, u2, u3 = part[0], part[1], part[2]
    state = seeded(u[0], u[1], u[2])
    q = (0.0, 0.0, 0.0)
    for _ in range(ATTEMPTS):
        q = _point(low, high, base, slope, u1, u2, u3)
        if boxes.solid[k] or cells[index].state == INSIDE:
            return q
        if found_inside(block, lamp, place, cells[index], add(q, origin)):
            return q
        state = following(state)
        u1, u2, u3 = uniform_point(state)
    return q


@kernel
def sample(block, lamp, x, store, cut, u1, u2, u3):
    """Unit direction from x by the cut; its density is ``density``."""
    if cut.slot < 0:
        return sample_direction(block, lamp, x, (0.0, 0.0, 0.0), u1, u2, u3)
    place = placements(block)[lamp]
    q = _draw(block, lamp, place, store[cut.slot], cut, lamp_cells(block)[place.first_cell:], (u1, u2, u3))
    return normalize(transform_vector(place.matrix, q))


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
def density(block, lamp, d, store, cut, spans, count):
    """Density per solid angle of ``sample`` giving d, from the intervals that ``trace`` found."""
    if cut.slot < 0:
        return direction_pdf(block, lamp, vec(cut.origin), (0.0, 0.0, 0.0), d, spans, count)
    way = transform_vector(placements(block)[lamp].inverse, d)
    boxes = store[cut.slot]
    sx, sy, sz = _direction(way[0]), _direction(way[1]), _direction(way[2])
    ox, oy, oz = vec(cut.origin)
    low_x, low_y, low_z = boxes.low[0], boxes.low[1], boxes.low[2]
    high_x, high_y, high_z = boxes.high[0], boxes.high[1], boxes.high[2]
    enter, leave = cut.enter, cut.leave
    for k in range(np.uint64(boxes.count)):
        ax, bx = (low_x[k] - ox) * sx, (high_x[k] - ox) * sx
        ay, by = (low_y[k] - oy) * sy, (high_y[k] - oy) * sy
        az, bz = (low_z[k] - oz) * sz, (high_z[k] - oz) * sz
        enter[k] = max(max(min(ax, bx), min(ay, by)), max(min(az, bz), 0.0))
        leave[k] = min(min(max(ax, bx), max(ay, by)), max(az, bz))
    total = 0.0
    for k in range(boxes.count):
        start, end = enter[k], leave[k]
        if start >= end:
            continue
        level = cut.level[k]
        slope = cut.slope[0, k] * way[0] + cut.slope[1, k] * way[1] + cut.slope[2, k] * way[2]
        if boxes.solid[k]:
            total += _piece(level, slope, start, end)
            continue
        for index in range(count):
            c, h = spans[index, 0], spans[index, 1]
            a, b = max(start, c - h), min(end, c + h)
            if a < b:
                total += _piece(level, slope, a, b)
    return total / cut.total
