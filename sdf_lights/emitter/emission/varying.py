# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emission that varies in space: compiled code, and its integral along rays.

The integral over an interval of a ray is ∫ e(t(s)) t'(s) ds over 0 … 1. The first two derivatives of t vanish at both
ends. The rectangle rule uses n points, which are shifted together by a random fraction of their distance. A random
shift makes the rule unbiased for any e (Cranley and Patterson 1976). Korobov's change of variable (1963) makes the
integrand periodic, so the error falls as n⁻³ if e is smooth (Laurie 1996, "Periodizing transformations for numerical
integration"). Points are densest at the ends, where lamps have their bright or dark skin.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from ...frozen import frozen
from ...graph.codegen_native import LANES, compiled
from ...jit import call_field, kernel, stack_array, table
from ...replaced import replaced_on_gpu
from ...sdf.emission import Emission, Placed
from ...sdf.shapes import Shape
from ...vec import length, sub, transform_point, transform_vector
from ..intersection.fields import lamp_parameters

GLOW = np.dtype(
    [
        ("address", np.int64),  # of the compiled colour
        ("parameters", np.int64),  # index of its first parameter
        ("inverse", np.float64, (3, 4)),  # the world, relative to the lamp's centre -> the shape's local space
        ("scale", np.float64, (3,)),  # ρ in W/(sr·m³) at colour 1
        ("rate", np.float64),  # points of a ray per metre of the shape's local space
    ],
    align=True,
)

TABLES = {"lamp_glows": GLOW}

COLOUR = 3 * LANES  # offset of the values in a stack, after all x, all y and all z: all red, all green, all blue
WEIGHTS = 6 * LANES
DISTANCES = 7 * LANES  # offset of the distances over which rays are attenuated
COLOUR_STACK = 8 * LANES  # float64: jit.stack_array(COLOUR_STACK), imported by that name

FEWEST = 4  # points in an interval
GOLDEN = 0.6180339887498949

lamp_glows = table("lamp_glows", GLOW)


@frozen
class CompiledEmission:
    """A shape's emission, ready for the kernels. ``code`` owns the memory at ``address``."""

    placed: Placed
    code: object
    address: int

    @cached_property
    def parameters(self) -> np.ndarray:
        """Values of the slots of its formulas, float64."""
        return np.ascontiguousarray(self.placed.parameters)


def compile_emission(emission: Emission, shape: Shape) -> CompiledEmission:
    """The colour of an emission in a shape as machine code."""
    placed = emission.placed(shape)
    code = compiled(*placed.colour)
    return CompiledEmission(placed, code.owner, code.address)


@kernel
def run_colour(address, numbers, stack):
    """Colours at the ``LANES`` points at the head of ``stack`` (``COLOUR_STACK`` elements), written from ``COLOUR`` on.

    ``numbers`` is the address of the colour's parameters.
    """
    points = stack.ctypes.data
    call_field(address, LANES, points, numbers, points + 8 * COLOUR)


@kernel
def point_count(expected):
    """Number of points for an interval whose length asks for so many: a few, or a multiple of the lanes."""
    if expected <= FEWEST:
        return FEWEST
    return LANES * int(math.ceil(expected / LANES))


@kernel
def place_point(s):
    """t(s) and t'(s) of the change of variable: t = s³ (10 − 15 s + 6 s²)."""
    r = 1.0 - s
    return s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * r * r


@kernel
def _sum(glow, numbers, stack, total, extinction):
    """Add weighted colours to ``total`` (RGB), minus the attenuation for the distances in ``stack`` from ``DISTANCES``
    on."""
    run_colour(glow.address, numbers, stack)
    r, g, b = total
    attenuated = extinction[0] + extinction[1] + extinction[2] > 0.0
    for lane in range(LANES):
        weight = stack[WEIGHTS + lane]
        wr, wg, wb = weight, weight, weight
        if attenuated:
            way = stack[DISTANCES + lane]
            wr, wg, wb = (
                wr * math.exp(-extinction[0] * way),
                wg * math.exp(-extinction[1] * way),
                wb * math.exp(-extinction[2] * way),
            )
        r += wr * stack[COLOUR + lane]
        g += wg * stack[COLOUR + LANES + lane]
        b += wb * stack[COLOUR + 2 * LANES + lane]
    return r, g, b


@replaced_on_gpu
@kernel
def line_integral(block, index, center, x, d, spans, count, t_min, t_max, u):
    """∫ ρ along x + t·d over ``count`` intervals, rows (c, h) of ``spans``, between t_min and t_max: RGB, unbiased.

    ``index`` is a row of ``lamp_glows``, ``center`` the lamp's centre; u is uniform in [0, 1).
    """
    return attenuated_integral(block, index, center, x, d, spans, count, t_min, t_max, u, (0.0, 0.0, 0.0))


@replaced_on_gpu
@kernel
def attenuated_integral(block, index, center, x, d, spans, count, t_min, t_max, u, extinction):
    """As ``line_integral``, of ρ exp(−extinction (t − t_min)); the extinction is RGB, in 1/m."""
    glow = lamp_glows(block)[index]
    numbers = lamp_parameters(block).ctypes.data + 8 * glow.parameters
    p, way = transform_point(glow.inverse, sub(x, center)), transform_vector(glow.inverse, d)
    rate = glow.rate * length(way)
    stack = stack_array(COLOUR_STACK)
    total, used = (0.0, 0.0, 0.0), 0
    for span in range(count):
        c, h = spans[span, 0], spans[span, 1]
        start, end = max(c - h, t_min), min(c + h, t_max)
        size = end - start
        if not size > 0.0:
            continue
        points = point_count(rate * size)
        # A different shift in each interval, from one number: each is uniform, which is enough for an unbiased sum.
        shift = (u + span * GOLDEN) % 1.0
        for point in range(points):
            t, weight = place_point((point + shift) / points)
            t = start + size * t
            for k in range(3):
                stack[k * LANES + used] = p[k] + t * way[k]
            stack[WEIGHTS + used] = size * weight / points
            stack[DISTANCES + used] = t - t_min
            used += 1
            if used == LANES:
                total, used = _sum(glow, numbers, stack, total, extinction), 0
    if used > 0:
        for lane in range(used, LANES):
            for k in range(3):
                stack[k * LANES + lane] = stack[k * LANES]
            stack[WEIGHTS + lane] = 0.0
            stack[DISTANCES + lane] = 0.0
        total = _sum(glow, numbers, stack, total, extinction)
    return total[0] * glow.scale[0], total[1] * glow.scale[1], total[2] * glow.scale[2]


@kernel
def place_colour(block, index, offset, lane, stack):
    """Make a point of the world, relative to the lamp's centre, an input of ``colours``."""
    p = transform_point(lamp_glows(block)[index].inverse, offset)
    for k in range(3):
        stack[k * LANES + lane] = p[k]


@replaced_on_gpu
@kernel
def colours(block, index, stack):
    """Colours at the points in ``stack`` (``COLOUR_STACK`` elements), for ``density``."""
    glow = lamp_glows(block)[index]
    run_colour(glow.address, lamp_parameters(block).ctypes.data + 8 * glow.parameters, stack)


@kernel
def density(block, index, stack, lane):
    """ρ (RGB), W/(sr·m³), at one of the points of ``colours``."""
    glow = lamp_glows(block)[index]
    return (
        glow.scale[0] * stack[COLOUR + lane],
        glow.scale[1] * stack[COLOUR + LANES + lane],
        glow.scale[2] * stack[COLOUR + 2 * LANES + lane],
    )
