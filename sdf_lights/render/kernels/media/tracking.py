# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light along rays through media that vary in space: null-collision estimators.

Transmittance: residual ratio tracking (Novák, Selle and Jarosz 2014, "Residual ratio tracking for estimating
attenuation in participating media"), whose control is the least extinction of a cell.

Scattering: delta tracking with weights for RGB (Kutz, Habel, Li and Novák 2017, "Spectral and decomposition tracking
for rendering heterogeneous volumes"). Where the extinction σ is above the majorant μ, the null collision has the
negative weight (μ − σ)/μ: so estimates are unbiased with any majorant, which only decides how noisy they are.
"""

from __future__ import annotations

import math

from ....jit import kernel, stack_array
from ....vec import absolute, add, largest, madd, mul, scale, sub
from .beams import attenuation
from .cells import END, GLOW, LEAST, LOCAL_RAYS, MAJORANT, SECTION, SPREAD, enter_cells, section
from .point import coefficients, draw, set_ray

BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
MOST_COLLISIONS = 1 << 14  # along a ray, which ends there: it would take too long
_FAINT, _SURVIVAL = 0.05, 0.5  # Russian roulette of a transmittance


@kernel
def _survivor(workspace, weight):
    """A weight after Russian roulette."""
    if largest(absolute(weight)) >= _FAINT:
        return weight
    return scale(weight, 1.0 / _SURVIVAL) if draw(workspace) < _SURVIVAL else BLACK


@kernel
def _least(found):
    return (found[LEAST], found[LEAST + 1], found[LEAST + 2])


@kernel
def _part(block, workspace, inside, start, d, t, end, found, weight):
    """``weight`` times the transmittance estimated from t to ``end``, which are in the section ``found``."""
    least, spread = _least(found), found[SPREAD]
    weight = mul(weight, attenuation(least, end - t))
    if not spread > 0.0:
        return weight
    for _ in range(MOST_COLLISIONS):
        t -= math.log(1.0 - draw(workspace)) / spread
        if not t < end or largest(absolute(weight)) == 0.0:
            return weight
        _, extinction, _ = coefficients(block, workspace, inside, madd(start, t, d))
        weight = mul(weight, sub(WHITE, scale(sub(extinction, least), 1.0 / spread)))
        weight = _survivor(workspace, weight)
    return BLACK


@kernel
def transmittance(block, workspace, inside, start, d, t_from, t_to, kind):
    """Transmittance (RGB) of the media ``inside`` between two distances of a ray of this kind."""
    rays, found = stack_array(LOCAL_RAYS), stack_array(SECTION)
    set_ray(workspace, d, kind)
    start = madd(start, t_from, d)
    enter_cells(block, workspace, inside, start, d, t_to - t_from, rays)
    return faded(block, workspace, inside, start, d, t_to - t_from, rays, found)


@kernel
def faded(block, workspace, inside, start, d, length, rays, found):
    """``transmittance`` up to ``length``, for a ray with its cells."""
    weight, t = WHITE, 0.0
    while t < length and largest(absolute(weight)) > 0.0:
        section(block, inside, rays, t, found)
        end = min(found[END], length)
        weight = _survivor(workspace, _part(block, workspace, inside, start, d, t, end, found, weight))
        t = end
    return weight


@kernel
def glow(block, workspace, inside, start, d, length, rays, found):
    """The emission (RGB) of the media ``inside`` along a ray that reaches its start: one point in each cell of
    ``rays``."""
    total, weight, t = BLACK, WHITE, 0.0
    while t < length and largest(absolute(weight)) > 0.0:
        section(block, inside, rays, t, found)
        end = min(found[END], length)
        if end < math.inf and found[GLOW] > 0.0:
            middle = t + (end - t) * draw(workspace)
            weight = _part(block, workspace, inside, start, d, t, middle, found, weight)
            _, _, emission = coefficients(block, workspace, inside, madd(start, middle, d))
            total = add(total, scale(mul(weight, emission), end - t))
            t = middle
        weight = _survivor(workspace, _part(block, workspace, inside, start, d, t, end, found, weight))
        t = end
    return total


@kernel
def collide(block, workspace, inside, start, d, length, weight, rays, found):
    """The distance at which the media ``inside`` scatter a path that has this ``weight`` (RGB), and its weight then;
    a negative distance and the weight behind ``length`` if it is not scattered.

    The ray has its cells. The weights of the phase functions there are in the workspace.
    """
    t, end, majorant = 0.0, 0.0, 0.0
    section(block, inside, rays, t, found)
    end, majorant = min(found[END], length), found[MAJORANT]
    for _ in range(MOST_COLLISIONS):
        way = -math.log(1.0 - draw(workspace)) / majorant if majorant > 0.0 else math.inf
        while not t + way < end:
            if not end < length:
                return -1.0, weight
            # Where the majorant changes, the same number goes on: what is left of it is exponential, too.
            left = (way - (end - t)) * majorant if majorant > 0.0 else -math.log(1.0 - draw(workspace))
            t = end
            section(block, inside, rays, t, found)
            end, majorant = min(found[END], length), found[MAJORANT]
            way = left / majorant if majorant > 0.0 else math.inf
        t += way
        scattering, extinction, _ = coefficients(block, workspace, inside, madd(start, t, d))
        scattered = scale(mul(weight, scattering), 1.0 / majorant)
        passed = sub(weight, scale(mul(weight, extinction), 1.0 / majorant))
        a = abs(scattered[0]) + abs(scattered[1]) + abs(scattered[2])
        b = abs(passed[0]) + abs(passed[1]) + abs(passed[2])
        if not a + b > 0.0:
            return -1.0, BLACK
        if draw(workspace) * (a + b) < a:
            return t, scale(scattered, (a + b) / a)
        weight = scale(passed, (a + b) / b)
    return -1.0, BLACK
