# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise as a formula: the same in every evaluator, without tables.

Value noise: random numbers at the points of a lattice, interpolated. The numbers come from the permutation polynomial
(34 x² + x) mod 289 of McEwan, Sheets, Richardson and Gustavson, "Efficient computational noise in GLSL" (2012). All its
integers are less than 2²⁴, so they are exact in single precision too. The pattern repeats after 289 lattice points.
"""

from __future__ import annotations

import itertools

from ..graph.continuity import declare
from ..graph.formula import Formula, Vector, apply, clamp

PERIOD = 289

STEEPEST = 15.0 / 4.0
"""Greatest slope of ``value_noise``: in the middle between four −1 and four 1. The slope of the fade is at most 15/8.
The gradient's length is convex in the corners' values, so it is enough to consider corners of ±1."""


def _remainder(a: Formula) -> Formula:
    # Adding one half keeps the quotient away from integers, where an inexact division would show.
    return a - PERIOD * apply("floor", (a + 0.5) * (1.0 / PERIOD))


def _permuted(a: Formula) -> Formula:
    # In single precision the quotient of so large a number can be off by one: the second remainder is that of a small
    # number.
    return _remainder(_remainder((34.0 * a + 1.0) * a))


def _mixed(a: Formula, b: Formula, share: Formula) -> Formula:
    return a + (b - a) * share


def _fade(u: Formula) -> Formula:
    """u³ (6 u² − 15 u + 10), with zero first and second derivatives at 0 and 1; written around the middle, where its
    bounds are tighter."""
    v = u - 0.5
    square = v * v
    return v * (15.0 / 8.0 - square * (5.0 - square * 6.0)) + 0.5


def value_noise(p: Vector, seed: Formula | float = 0.0) -> Formula:
    """Noise between −1 and 1 on a lattice of spacing 1, with a continuous second derivative.

    ``seed`` is a whole number from 0 to 288.
    """
    pairs, triples = (tuple(itertools.product((0, 1), repeat=count)) for count in (2, 3))
    cell = Vector(*(apply("floor", x) for x in p))
    inside = p - cell
    fade = Vector(*map(_fade, inside))
    start = [_remainder(x) for x in cell]
    # The first lattice point follows the last one of the period.
    after = [_remainder(x + 1.0) for x in start]
    columns = [_permuted(_remainder(x + seed)) for x in (start[0], after[0])]
    rows = {(i, j): _permuted(columns[i] + (start, after)[j][1]) for i, j in pairs}
    values = {(i, j, k): _permuted(rows[i, j] + (start, after)[k][2]) for i, j, k in triples}
    along_x = {(j, k): _mixed(values[0, j, k], values[1, j, k], fade.x) for j, k in pairs}
    along_y = [_mixed(along_x[0, k], along_x[1, k], fade.y) for k in (0, 1)]
    between = _mixed(along_y[0], along_y[1], fade.z)
    # Interval arithmetic cannot see through remainders; the clamp gives it the limits.
    return declare(clamp(between * (2.0 / (PERIOD - 1.0)) - 1.0, -1.0, 1.0), p)
