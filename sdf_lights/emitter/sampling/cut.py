# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cell-cut sampling: directions to a lamp in proportion to the light that its parts give the lit point.

A point at offset v of a uniform lamp gives a surface with normal n the light t(v) = max(0, n·v)/|v|³. Projection
sampling ignores this. Cell-cut sampling finds a *cut* of the lamp's tree: the boxes that matter to the lit point. In
each box the density of points is the linear function that fits t there,

    q(y) = Σ_k [y in box k] (α_k + b_k·y) / Z.

Linear functions keep everything in closed form. Points of a full box are drawn without rejection. The integral over the
interior of a box follows from its volume and centroid, so Z does. The density of a direction is the integral of r² q
along its ray. It is a polynomial on each piece of the ray's intervals inside a box:

    p(ω) = ∫ r² q dr = Σ 2h [L c² + (L + 2cB) h²/3],      L = q at the middle c of the piece, B = its slope along the ray.

t is the field of a dipole, hence harmonic: its mean over a ball is its value at the centre. So the error of the linear
function is of second order in the size of a box, and hardly changes the balance between boxes.

*Which* boxes are used changes slowly with the point, and any choice is unbiased: ``cut_boxes`` stores them by region.
*How much* each counts is fitted to the individual lit point and normal, for all boxes at once, which the compiler
vectorises.

If a point of a clipped box is not in the interior, it is drawn again in the same leaf, so stratified numbers stay
stratified in all larger boxes. Leaves are chosen by their known interior volume.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel, stack_array, table
from ...replaced import replaced_on_gpu
from ...sdf.program import INSTRUCTION
from ...vec import add, dot, madd, normalize, scale, sub, transform_normal, transform_point, transform_vector, vec
from ..hashing import following, seeded, uniform_point
from ..intersection.fields import lamp_lists, value
from ..intersection.membership import contains
from ..lamps import CLOSED, PRIMITIVE, lamps, varies
from ..tree.moments import lamp_cells
from ..tree.nodes import INSIDE
from .cut_boxes import BOXES, KEYS, MOST_ENTRIES, REGIONS, ROUGHEST, SOFT, corner, far_corner, region
from .cut_tables import MOST_BOXES, OF_REGIONS, TABLES, lamp_steps, pack_cuts, placements  # noqa: F401  (two are for callers)
from .projection import direction_pdf, sample_direction
from .strategies import BOXES as BY_BOXES
from .strategies import NO_BSDF_RAYS, POINTS, PROJECTION, WHOLE_RAYS

CUT = np.dtype(
    [
        ("lamp", np.int64),
        ("strategy", np.int64),  # of ``strategies``: how directions are drawn
        ("slot", np.int64),  # of the region's boxes, if the strategy uses them
        ("points", np.int64),  # of ``strategies``: what represents the lamp at the end of a light ray
        ("total", np.float64),  # Z in the world
        ("bsdf_mis_scale", np.float64),  # factor of the BSDF's density in the balance heuristic
        # The lit point, in tree space relative to the region's centre; in world space without boxes.
        ("origin", np.float64, (3,)),
        # The density α + b·(y − origin) in each box, up to Z.
        ("level", np.float32, MOST_BOXES),
        ("slope", np.float32, (3, MOST_BOXES)),
        ("weight", np.float32, MOST_BOXES),  # integral of the density over the accepted points
        ("enter", np.float32, MOST_BOXES),
        ("leave", np.float32, MOST_BOXES),
        ("crossed", np.int32, MOST_BOXES + 1),
        ("mass", np.float64, MOST_ENTRIES),  # integral of the density over the boxes from which points are drawn
    ],
    align=True,
)

WORKSPACE_TABLES = {"lamp_regions": KEYS, "lamp_boxes": BOXES, "lamp_cuts": CUT}
WORKSPACE_COUNTS = {"lamp_regions": REGIONS, "lamp_boxes": REGIONS, "lamp_cuts": 2}

TOLERANCE = 5e-4  # relative variance of a sample below which boxes are small enough
MOST_TOLERANCE = 0.1  # for lamps with a small selection probability
LIMIT = MOST_BOXES
WIDTH = 8  # single precision numbers in a vector register
ATTEMPTS = 4096  # draws of a point in a box before giving up
FLAT = 0.05  # least density in a box, relative to that at its centroid
SURROUNDED_MIS_SCALE = 3.0  # if the lamp is all around
MIS_SCALE_RATE = 4.0  # per relative variance that the cut leaves
# Below this scale, BSDF rays cost more than they gain.
ALONE = 0.05
# Below this scale, points may replace rays: from half the radius of a ball with the same spread as the lamp.
POINT_MIS_SCALE = 0.3
STEP = 0.3  # of the thickness of the lamp
PROJECTION_RATE = 4.0  # relative variance of projection sampling, per extent over square distance, far away

# Relative variance left by emission that boxes cannot follow, above which projection sampling has less error: without
# boxes, it spreads stratified numbers more evenly.
MOST_ROUGH = 0.25
MOST_LEAF_ROUGH = (
    0.5  # the same for points in leaves of the tree; above it, the few samples of a leaf may have missed emission
)

BELOW_ONE = 1.0 - 2.0**-53
ZERO, HALF, ONE, FALL, TINY, SOFT_32, MOST_DROP = map(np.float32, (0.0, 0.5, 1.0, -3.0, 1e-30, SOFT, 1.0 - FLAT))

instructions = table("lamp_instructions", INSTRUCTION)


@kernel
def _together(count):
    """Number of boxes, rounded up to whole vector registers. The values behind the last box do not matter.

    Unsigned, because Numba would test signed indices for negative values.
    """
    return np.uint64((count + WIDTH - 1) // WIDTH * WIDTH)


@kernel
def _fit(boxes, normal, two_sided, cut):
    """Fit the density of every box to its light; ``normal`` is in tree space, in units of the region's size.

    ``two_sided``: light on either side counts. The loop has no branches and uses only single precision, so the compiler
    runs it on several boxes at once.
    """
    m = boxes.metric
    m00, m01, m02 = np.float32(m[0, 0]), np.float32(m[0, 1]), np.float32(m[0, 2])
    m11, m12, m22 = np.float32(m[1, 1]), np.float32(m[1, 2]), np.float32(m[2, 2])
    nx, ny, nz = np.float32(normal[0]), np.float32(normal[1]), np.float32(normal[2])
    ax, ay, az = abs(nx), abs(ny), abs(nz)
    ox, oy, oz = np.float32(cut.origin[0]), np.float32(cut.origin[1]), np.float32(cut.origin[2])
    low_x, low_y, low_z = boxes.low[0], boxes.low[1], boxes.low[2]
    high_x, high_y, high_z = boxes.high[0], boxes.high[1], boxes.high[2]
    middle_x, middle_y, middle_z = boxes.centroid[0], boxes.centroid[1], boxes.centroid[2]
    extents, fills, volumes = boxes.extent, boxes.fill, boxes.volume
    level, weight = cut.level, cut.weight
    slope_x, slope_y, slope_z = cut.slope[0], cut.slope[1], cut.slope[2]
    for k in range(_together(boxes.count)):
        lx, ly, lz = low_x[k] - ox, low_y[k] - oy, low_z[k] - oz
        hx, hy, hz = high_x[k] - ox, high_y[k] - oy, high_z[k] - oz
        wx, wy, wz = middle_x[k] - ox, middle_y[k] - oy, middle_z[k] - oz
        half = HALF * (ax * (hx - lx) + ay * (hy - ly) + az * (hz - lz))
        middle = HALF * (nx * (hx + lx) + ny * (hy + ly) + nz * (hz + lz))
        gx, gy, gz = m00 * wx + m01 * wy + m02 * wz, m01 * wx + m11 * wy + m12 * wz, m02 * wx + m12 * wy + m22 * wz
        square = max(wx * gx + wy * gy + wz * gz, TINY)
        extent = extents[k]
        inverse = ONE / (square + SOFT_32 * extent * min(extent / square, ONE))
        side = -ONE if two_sided and middle < ZERO else ONE
        middle *= side
        # If the horizon crosses the box: the mean of max(0, ·), or |·|, and its slope, over evenly spread heights.
        above = middle >= half
        upper = max(middle + half, ZERO)
        lower = half - middle if two_sided else ZERO
        across = HALF / max(half, TINY)
        rate = ONE if above else (upper - lower) * across
        height = side * (nx * wx + ny * wy + nz * wz) if above else HALF * (upper * upper + lower * lower) * across
        amount = fills[k] * height * inverse * math.sqrt(inverse)
        share = side * rate / max(height, TINY)
        fall = FALL * inverse
        bx, by, bz = share * nx + fall * gx, share * ny + fall * gy, share * nz + fall * gz
        drop = -(
            min(bx * (lx - wx), bx * (hx - wx))
            + min(by * (ly - wy), by * (hy - wy))
            + min(bz * (lz - wz), bz * (hz - wz))
        )
        keep = amount * (MOST_DROP / drop if drop > MOST_DROP else ONE)
        bx, by, bz = keep * bx, keep * by, keep * bz
        level[k] = amount - (bx * wx + by * wy + bz * wz)
        slope_x[k], slope_y[k], slope_z[k] = bx, by, bz
        weight[k] = volumes[k] * amount


@kernel
def _holds(cell, q):
    return (
        cell.low[0] <= q[0] <= cell.high[0]
        and cell.low[1] <= q[1] <= cell.high[1]
        and cell.low[2] <= q[2] <= cell.high[2]
    )


@kernel
def _surrounded(cells, q):
    """Whether the point q in tree space is in a box that is full, or nearly so."""
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
def _filled(block, lamp, place, offset):
    """Whether the lamp fills the surroundings of a world point, relative to the lamp's centre."""
    row = lamps(block)[lamp]
    if row.kind == PRIMITIVE:
        return contains(
            instructions(block)[row.first_instruction : row.first_instruction + row.instruction_count], offset
        )
    return _surrounded(lamp_cells(block)[place.first_cell :], transform_point(place.inverse, offset))


@kernel
def distance_to_bounds(row, x):
    """Distance from x to the lamp's bounding box."""
    square = 0.0
    for k in range(3):
        away = max(abs(x[k] - row.center[k]) - row.half[k], 0.0)
        square += away * away
    return math.sqrt(square)


@kernel
def tuned_mis_scale(block, lamp, x):
    """MIS scale of the BSDF by the distance alone: 3 at the lamp's bounding box and inside, then falling as
    1/distance².

    The unit of distance is the size of a ball with the same spread: a thin ring is wide, whatever its volume.
    """
    size = math.sqrt(5.0 / 3.0 * placements(block)[lamp].extent)
    part = size / (size + 4.0 * distance_to_bounds(lamps(block)[lamp], x))
    bsdf_mis_scale = SURROUNDED_MIS_SCALE * part * part
    return bsdf_mis_scale if bsdf_mis_scale > ALONE else NO_BSDF_RAYS


@kernel
def project(block, lamp, x, has_glossy, cut):
    """As ``prepare``, without boxes: projection sampling, with the MIS scale by the distance.

    Light that is scattered again before it reaches the camera has noise from other sources, so boxes do not pay there.
    Intervals do not pay either, unless the lamp is close: 1/r² hardly changes along a ray, and no BSDF ray of a diffuse
    surface competes.
    """
    cut.lamp, cut.strategy, cut.points = lamp, PROJECTION, WHOLE_RAYS
    cut.bsdf_mis_scale = tuned_mis_scale(block, lamp, x)
    if cut.bsdf_mis_scale < POINT_MIS_SCALE and not varies(block, lamp):
        cut.points, cut.bsdf_mis_scale = WHOLE_RAYS if has_glossy else POINTS, NO_BSDF_RAYS


@replaced_on_gpu
@kernel
def prepare(block, lamp, x, n, two_sided, has_glossy, tolerance, limit, keys, store, cut):
    """Fit the cut to the point x with the normal n; ``two_sided`` (0 or 1): light on either side counts.

    ``store`` holds the boxes of regions (``BOXES``), and ``keys`` identifies regions (``KEYS``). A region has at most
    ``limit`` boxes, and fewer if the expected relative variance is below ``tolerance``.

    ``cut.bsdf_mis_scale`` is β of the balance heuristic p / (p + β p_bsdf). Any β is unbiased. If the lamp fills the
    space close to the surface, BSDF directions do almost all of the work, and no cut is made. Elsewhere they cover what
    the boxes next to the point do not follow. If nothing is close, they only cost time, and β is 0.

    If β is 0, or close to 0 and the emission varies, points replace rays. Glossy lobes of the BSDF (``has_glossy``: 0
    or 1) compete with rays, so rays stay there. Projection sampling replaces boxes in which the emission varies too
    much.
    """
    place, varied = placements(block)[lamp], varies(block, lamp)
    if needs_no_boxes(block, lamp, place, x, n, has_glossy, tolerance, cut):
        alone = cut.bsdf_mis_scale == NO_BSDF_RAYS and not has_glossy and resolved(place)
        cut.points = POINTS if alone else WHOLE_RAYS
        return
    origin, normal = local(block, lamp, place, x, n)
    slot = region(block, lamp, place, origin, normal, two_sided, tolerance, limit, keys, store)
    boxes = store[slot]
    bsdf_mis_scale, rough = mis_scale_for(boxes.variance), boxes.rough > MOST_ROUGH
    # Surfaces inside a lamp hide a part of a ray, but all of a point, or nothing. Rays through a primitive cost little
    # more than points, and are less noisy.
    pays = varied or tolerance > TOLERANCE or lamps(block)[lamp].kind != PRIMITIVE
    points = (
        not has_glossy
        and resolved(place)
        and bsdf_mis_scale < (POINT_MIS_SCALE if varied else ALONE)
        and (rough or pays and place.clear != 0)
    )
    if rough and not points:
        project(block, lamp, x, has_glossy, cut)
        return
    fit(block, place, boxes, slot, origin, normal, two_sided, cut)
    if cut.strategy == BY_BOXES:
        cut.bsdf_mis_scale, cut.points = (NO_BSDF_RAYS, POINTS) if points else (bsdf_mis_scale, WHOLE_RAYS)


@kernel
def resolved(place):
    """Whether the tree of a lamp stores its emission, so that points can be drawn by it."""
    return place.leaf_rough <= MOST_LEAF_ROUGH


@kernel
def tolerance_for(probability):
    """Relative variance that boxes may leave, for a lamp that is selected with this probability.

    A lamp that gives a fraction of the light adds only that fraction of its variance, and the selected lamp varies,
    too. So the tolerance grows with the square of 1 / ``probability``. It grows in steps, because each step has
    separate boxes.
    """
    tolerance = TOLERANCE
    while probability < 0.25 and tolerance < MOST_TOLERANCE:
        probability, tolerance = 2.0 * probability, 4.0 * tolerance
    return tolerance


@kernel
def needs_no_boxes(block, lamp, place, x, n, has_glossy, tolerance, cut):
    """Whether a point needs no boxes: it is far away, or the lamp fills its surroundings. If so, the cut is set to
    projection sampling."""
    offset = sub(x, vec(lamps(block)[lamp].center))
    cut.lamp, cut.strategy, cut.points = lamp, PROJECTION, WHOLE_RAYS
    if place.rough > ROUGHEST and (has_glossy or not resolved(place)):
        project(block, lamp, x, has_glossy, cut)
        return True
    way = sub(vec(place.centroid), offset)
    ratio = place.extent / max(dot(way, way), 1e-300)
    if PROJECTION_RATE * ratio < tolerance:
        cut.bsdf_mis_scale = NO_BSDF_RAYS
        return True
    if _filled(block, lamp, place, madd(offset, STEP * place.thickness, n)):
        cut.bsdf_mis_scale = SURROUNDED_MIS_SCALE
        return True
    return False


@kernel
def local(block, lamp, place, x, n):
    """A point of the world and its normal in a lamp's tree space."""
    offset = sub(x, vec(lamps(block)[lamp].center))
    return transform_point(place.inverse, offset), transform_normal(place.matrix, n)


@kernel
def fit(block, place, boxes, slot, origin, normal, two_sided, cut):
    """Fit the cut to a point and a normal in tree space, by the boxes in ``slot``.

    If all of the lamp is behind the surface, projection sampling stays.
    """
    cut.origin[0], cut.origin[1], cut.origin[2] = sub(origin, vec(boxes.center))
    _fit(boxes, scale(normal, boxes.unit), two_sided != 0, cut)
    for entry in range(boxes.entries - 1, -1, -1):
        first = boxes.first[entry]
        cut.mass[entry] = cut.mass[first] + cut.mass[first + 1] if first >= 0 else cut.weight[boxes.box[entry]]
    cut.total = cut.mass[0] * lamp_cells(block)[place.first_cell].volume * place.factor
    cut.slot, cut.points = slot, WHOLE_RAYS
    cut.strategy, cut.bsdf_mis_scale = (BY_BOXES, NO_BSDF_RAYS) if cut.total > 0.0 else (PROJECTION, 1.0)


@kernel
def mis_scale_for(variance):
    """β for an expected relative variance."""
    bsdf_mis_scale = min(MIS_SCALE_RATE * variance, 1.0)
    return bsdf_mis_scale if bsdf_mis_scale > ALONE else NO_BSDF_RAYS


@kernel
def slope_of(cut, k):
    """Slope of the density in box k, in tree space."""
    return (np.float64(cut.slope[0, k]), np.float64(cut.slope[1, k]), np.float64(cut.slope[2, k]))


@kernel
def _place_in(low, high, level, slope, u):
    """Position of u in [low, high] for a density that is ``level`` in the middle and has a slope."""
    tilt = 0.5 * slope * (high - low) / level
    part = 2.0 * u / (1.0 - tilt + math.sqrt(max((1.0 - tilt) * (1.0 - tilt) + 4.0 * tilt * u, 0.0)))
    return low + min(part, 1.0) * (high - low)


@kernel
def choose(part, axis, first, second):
    """The side, of two given masses, that the number ``part[axis]`` chooses; the number is stretched back to [0, 1)."""
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
    program = instructions(block)[row.first_instruction : row.first_instruction + row.instruction_count]
    if row.kind == PRIMITIVE:
        return contains(program, transform_point(place.matrix, q))
    if row.kind == CLOSED:
        first = row.first_list + cell.row_first
        return contains(program, q, lamp_lists(block)[first : first + cell.row_count])
    return value(block, row, cell.row_first, cell.row_count, q) <= 0.0


@kernel
def chosen_box(boxes, cut, part):
    """The box that the numbers ``part`` choose; they are stretched back to [0, 1)."""
    entry = 0
    while boxes.first[entry] >= 0:
        first = boxes.first[entry]
        entry = first + choose(part, boxes.axis[entry], cut.mass[first], cut.mass[first + 1])
    return np.int64(boxes.box[entry])


@kernel
def draw(block, lamp, place, boxes, cut, cells, u):
    """A point of the interior, or of a solid box, by the density of the cut; that density, up to Z; and the box."""
    part = stack_array(3)
    part[0], part[1], part[2] = u
    k = chosen_box(boxes, cut, part)
    slope = slope_of(cut, k)
    base = np.float64(cut.level[k])
    index = boxes.cell[k]
    low, high = sub(corner(boxes, k), vec(cut.origin)), sub(far_corner(boxes, k), vec(cut.origin))
    origin = add(vec(boxes.center), vec(cut.origin))
    steps = lamp_steps(block)[place.first_cell :]
    first = steps[index].first if boxes.solid[k] == 0 else -1
    if first >= 0:
        base_there = base - dot(slope, origin)
        while first >= 0:
            a, b = steps[first], steps[first + 1]
            index = first + choose(
                part,
                steps[index].axis,
                a.volume * (base_there + dot(slope, vec(a.centroid))),
                b.volume * (base_there + dot(slope, vec(b.centroid))),
            )
            first = steps[index].first
        low, high = sub(vec(cells[index].low), origin), sub(vec(cells[index].high), origin)
    u1, u2, u3 = part[0], part[1], part[2]
    state = seeded(u[0], u[1], u[2])
    q = (0.0, 0.0, 0.0)
    for _ in range(ATTEMPTS):
        q = _point(low, high, base, slope, u1, u2, u3)
        if (
            boxes.solid[k]
            or cells[index].state == INSIDE
            or found_inside(block, lamp, place, cells[index], add(q, origin))
        ):
            break
        state = following(state)
        u1, u2, u3 = uniform_point(state)
    return q, base + dot(slope, q), k


@replaced_on_gpu
@kernel
def sample(block, lamp, x, store, cut, u1, u2, u3):
    """Unit direction from x by the cut; its density is ``density``."""
    if cut.strategy != BY_BOXES:
        return sample_direction(block, lamp, x, (0.0, 0.0, 0.0), u1, u2, u3)
    place = placements(block)[lamp]
    q, _, _ = draw(block, lamp, place, store[cut.slot], cut, lamp_cells(block)[place.first_cell :], (u1, u2, u3))
    return normalize(transform_vector(place.matrix, q))


@kernel
def _piece(level, slope, start, end):
    """∫ r² (level + slope·r) dr."""
    c, h = 0.5 * (start + end), 0.5 * (end - start)
    middle = level + slope * c
    return 2.0 * h * (middle * c * c + (middle + 2.0 * c * slope) * h * h / 3.0)


@kernel
def _inverse(v):
    """1/v, finite for zero."""
    return 1.0 / v if abs(v) > 1e-30 else 1e30


@kernel
def _cross(boxes, cut, way):
    """Find the boxes that a ray crosses, ``crossed``, and their intervals. Returns their number.

    First for all boxes at once, then without branches, because no processor can predict them. In single precision:
    boxes that share a side share its error, and the remaining error has no bias.
    """
    sx, sy, sz = np.float32(_inverse(way[0])), np.float32(_inverse(way[1])), np.float32(_inverse(way[2]))
    ox, oy, oz = np.float32(cut.origin[0]), np.float32(cut.origin[1]), np.float32(cut.origin[2])
    low_x, low_y, low_z = boxes.low[0], boxes.low[1], boxes.low[2]
    high_x, high_y, high_z = boxes.high[0], boxes.high[1], boxes.high[2]
    enter, leave = cut.enter, cut.leave
    for k in range(_together(boxes.count)):
        ax, bx = (low_x[k] - ox) * sx, (high_x[k] - ox) * sx
        ay, by = (low_y[k] - oy) * sy, (high_y[k] - oy) * sy
        az, bz = (low_z[k] - oz) * sz, (high_z[k] - oz) * sz
        enter[k] = max(max(min(ax, bx), min(ay, by)), max(min(az, bz), ZERO))
        leave[k] = min(min(max(ax, bx), max(ay, by)), max(az, bz))
    found = 0
    for k in range(boxes.count):
        cut.crossed[found] = k
        found += enter[k] < leave[k]
    return found


@replaced_on_gpu
@kernel
def density(block, lamp, d, store, cut, spans, count):
    """Density per solid angle of ``sample`` giving d, from the intervals that ``trace`` found."""
    if cut.strategy != BY_BOXES:
        return direction_pdf(block, lamp, vec(cut.origin), (0.0, 0.0, 0.0), d, spans, count)
    way = transform_vector(placements(block)[lamp].inverse, d)
    boxes = store[cut.slot]
    total = 0.0
    for place in range(_cross(boxes, cut, way)):
        k = np.int64(cut.crossed[place])
        start, end = np.float64(cut.enter[k]), np.float64(cut.leave[k])
        level, slope = np.float64(cut.level[k]), dot(slope_of(cut, k), way)
        if boxes.solid[k]:
            total += _piece(level, slope, start, end)
            continue
        for index in range(count):
            c, h = spans[index, 0], spans[index, 1]
            a, b = max(start, c - h), min(end, c + h)
            if a < b:
                total += _piece(level, slope, a, b)
    return total / cut.total
