# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A lamp as a light: the interior of a shape that glows.

The radiance along a ray is

    L(ω) = ρ Σ 2h

over the intervals [c − h, c + h] of the ray inside. Distances and the volume V are in world space, so no Jacobian is
needed: a uniform point stays uniform under the lamp's affine transform. ``sampling`` draws directions.

If V has no closed form, the estimate V̂ replaces it both in ρ = P/(4π V̂) and in the density, while the points stay
uniform in the true interior. Then directions sampled here give the exact power P, because V̂ cancels in L/p. Directions
that a BSDF samples carry V/V̂. Under MIS the two shares w and 1 − w of the light add up to w + (1 − w)·V/V̂. So no
pixel is off by more than the relative error of V̂, whose bound is in ``volume_error``. (If ρ is given as a density, it
is the other way round: BSDF samples are exact, and the lamp's own share carries V̂/V.)

There are three kinds of lamps. A *primitive* has a closed form for everything. A *closed* shape is a program of
primitives and set operations, whose intervals have closed forms. For all others the *field* is traced and sampled. The
last two kinds have an interior tree (``interior``).

Emission that varies is ρ(x) = P e(x) / (4π ∫e dV), or the density times e(x), for a relative emission e
(``sdf.emission``). Its integral is estimated from the contents of the tree's boxes (``moments``). The projection
density stays that of uniform points.

Everything that the kernels store is relative to the centre of the lamp's bounding box, and rays are moved to their
closest approach to it. So the distance of the camera or of the lamp from the origin costs no digits.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import kernel, table
from ..replaced import replaced_on_gpu
from ..sdf.program import INSTRUCTION
from ..vec import dot, madd, scale, sub, transform_point, transform_vector, vec
from .emission import varying as emissions
from .emission.varying import attenuated_integral, line_integral
from .intersection import fields
from .intersection.fields import LIST
from .intersection.intervals import primitive_spans, regularize, solve
from .primitives.box import box_span
from .tree import nodes
from .tree.crossings import crossings
from .tree.nodes import NODE

PRIMITIVE, CLOSED, FIELD = 0, 1, 2  # kinds of lamps

LAMP = np.dtype(
    [
        ("center", np.float64, (3,)),  # of the world bounding box; the rest is relative to it
        ("half", np.float64, (3,)),  # of the world bounding box
        ("bounding_radius", np.float64),  # of the sphere around the centre
        ("volume", np.float64),  # m³, in the world
        ("volume_error", np.float64),  # bound of the relative error of the volume; 0 if it has a closed form
        ("emission", np.float64, (3,)),  # ρ, W/(sr·m³): its mean over the volume
        ("emission_error", np.float64),  # bound of the relative error of that mean; 0 if it is uniform
        ("glow", np.int64),  # index of the emission, if it varies; −1: ρ is uniform
        ("power", np.float64),  # W, mean of the colour channels: 4π V ρ
        ("visibility", np.int64),  # render.scene.Ray
        ("kind", np.int64),
        (
            "matrix",
            np.float64,
            (3, 4),
        ),  # tree space, or the space of a single primitive -> world, relative to the centre
        ("inverse", np.float64, (3, 4)),  # the inverse
        ("primitive", np.int64),  # the Op of a lamp that is a single primitive
        ("parameters", np.float64, (4,)),  # of that primitive
        ("low", np.float64, (3,)),  # corners of the root's box in tree space
        ("high", np.float64, (3,)),
        ("rows", np.int64),  # maximum rows of spans for the intervals of a ray
        ("first_instruction", np.int64),
        ("instruction_count", np.int64),
        ("direct", np.int64),  # 1 if rays are solved by the whole program, without the tree
        ("first_term", np.int64),
        ("first_node", np.int64),
        ("node_count", np.int64),
        ("first_list", np.int64),
    ],
    align=True,
)

TABLES = {"lamps": LAMP, "lamp_instructions": INSTRUCTION, **nodes.TABLES, **fields.TABLES, **emissions.TABLES}
SCALARS = [
    ("lamp_rows", np.int64),  # rows of ``spans`` for intervals: the most that any lamp of the scene can use
    ("region_set", np.int64),  # another number in each of several blocks that share a workspace, where lamps differ
]

# of a lamp's bounding radius: shorter intervals and gaps are rounding errors of coincident faces
SMALLEST_INTERVAL = 1e-10

lamps = table("lamps", LAMP)
instructions = table("lamp_instructions", INSTRUCTION)
nodes = table("lamp_nodes", NODE)
lists = table("lamp_lists", LIST)


@kernel
def intensity(block, lamp):
    """Radiant intensity (RGB) of a lamp of uniform emission, W/sr: ρ V."""
    row = lamps(block)[lamp]
    return scale(vec(row.emission), row.volume)


@kernel
def _approach(row, o, d):
    """Distance along the ray to its closest approach to a lamp's centre, and that point relative to the centre."""
    offset = sub(o, vec(row.center))
    distance = -dot(offset, d)
    return distance, madd(offset, distance, d)


@kernel
def _keep(spans, count, distance, start, end):
    """Append the part at t ≥ 0 of an interval whose ends are relative to ``distance``. Returns the new count."""
    if distance + end <= 0.0:
        return count
    start = max(start, -distance)
    spans[count, 0], spans[count, 1] = distance + 0.5 * (start + end), 0.5 * (end - start)
    return count + 1


@replaced_on_gpu
@kernel
def note_length(block, lamp, column, length, spans):
    """Add to one of the two lengths that ``trace`` sums for a lamp."""
    spans[block.lamp_rows + lamp, column] += length


@replaced_on_gpu
@kernel
def solve_all(block, row, p, d, spans):
    """Find the intervals of a ray in tree space in a lamp's whole program. Returns their number."""
    program = instructions(block)[row.first_instruction : row.first_instruction + row.instruction_count]
    return solve(program, p, d, spans)


@kernel
def _trace_parts(block, row, lamp, distance, p, d, spans):
    """As ``trace``, for a lamp with a tree. p and d are the ray in tree space; its origin is at −``distance``."""
    half = row.high
    start, end = box_span(p, d, half[0], half[1], half[2])
    start = max(start, -distance)
    if start >= end:
        return 0
    if row.direct:
        count = solve_all(block, row, p, d, spans)
    else:
        count, unresolved = crossings(block, row, p, d, start, end, spans)
        note_length(block, lamp, 0, unresolved, spans)
    count = regularize(spans, count, SMALLEST_INTERVAL * row.bounding_radius)
    kept = 0
    for index in range(count):
        kept = _keep(spans, kept, distance, spans[index, 0], spans[index, 1])
    for index in range(kept):
        note_length(block, lamp, 1, 2.0 * spans[index, 1], spans)
    return kept


@kernel
def trace(block, lamp, o, d, spans):
    """Write all intervals of the ray o + t·d, t ≥ 0, to ``spans``: rows (c, h) in order. Returns their number.

    ``spans`` is ``new_spans``: no closed-form shape of the scene can need more rows, so no interval is dropped. Row
    ``block.lamp_rows + lamp`` sums two lengths along rays: the length that was unresolved or had no row (only for
    fields), and the length inside the lamp. Intervals and gaps below ``SMALLEST_INTERVAL`` × the bounding radius are
    rounding errors of coincident faces, and are removed.
    """
    row = lamps(block)[lamp]
    distance, p = _approach(row, o, d)
    if dot(p, p) >= row.bounding_radius * row.bounding_radius or distance + row.bounding_radius <= 0.0:
        return 0
    if row.kind == PRIMITIVE:
        count, a0, b0, a1, b1 = primitive_spans(instructions(block)[row.first_instruction], p, d)
        kept = _keep(spans, 0, distance, a0, b0) if count > 0 else 0
        return _keep(spans, kept, distance, a1, b1) if count > 1 else kept
    return _trace_parts(
        block, row, lamp, distance, transform_point(row.inverse, p), transform_vector(row.inverse, d), spans
    )


@kernel
def varies(block, lamp):
    """Whether the emission of a lamp varies in space."""
    return lamps(block)[lamp].glow >= 0


@kernel
def radiance(block, lamp, x, d, spans, count, t_min, t_max, u):
    """Line integral of the emission along x + t·d over the traced intervals, between the distances t_min and t_max:
    RGB.

    If the emission varies, it is an unbiased estimate from one uniform number u. Otherwise u and the ray have no
    effect.
    """
    row = lamps(block)[lamp]
    if row.glow >= 0:
        return line_integral(block, row.glow, vec(row.center), x, d, spans, count, t_min, t_max, u)
    total = 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        # Differences to the interval's own ends, so that a whole interval gives 2h to the last digit.
        total += max(2.0 * h - max(t_min - (c - h), 0.0) - max(c + h - t_max, 0.0), 0.0)
    return scale(vec(row.emission), total)


@kernel
def _fading(extinction, start, size):
    """∫ exp(−extinction t) dt from ``start`` on, over ``size``."""
    depth = extinction * size
    if depth < 1e-4:
        return size * (1.0 - 0.5 * depth) * math.exp(-extinction * start)
    return math.exp(-extinction * start) * (1.0 - math.exp(-depth)) / extinction


@kernel
def attenuated_radiance(block, lamp, x, d, spans, count, t_min, t_max, u, extinction):
    """As ``radiance``, through a medium of this extinction (RGB, 1/m) from t_min on."""
    row = lamps(block)[lamp]
    if row.glow >= 0:
        return attenuated_integral(block, row.glow, vec(row.center), x, d, spans, count, t_min, t_max, u, extinction)
    r, g, b = 0.0, 0.0, 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        start, end = max(c - h, t_min), min(c + h, t_max)
        if start < end:
            r += _fading(extinction[0], start - t_min, end - start)
            g += _fading(extinction[1], start - t_min, end - start)
            b += _fading(extinction[2], start - t_min, end - start)
    return row.emission[0] * r, row.emission[1] * g, row.emission[2] * b
