# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Phase functions of media.

Directions are drawn by Henyey and Greenstein's function with the g of Draine's, which is at most three times as large.
"""

import math

from ....jit import kernel
from ....vec import frame, to_world
from .records import medium_table, part_table

_EVEN = 1e-3  # |g| below which scattering counts as uniform


@kernel
def henyey_greenstein(cosine, g):
    """Phase function per solid angle (Henyey and Greenstein 1941); ``cosine`` is between both directions of travel."""
    root = 1.0 + g * (g - 2.0 * cosine)
    return (1.0 - g * g) / (4.0 * math.pi * root * math.sqrt(root))


@kernel
def draine(cosine, g, alpha):
    """``medium.Scattering``'s phase function."""
    value = henyey_greenstein(cosine, g)
    if alpha == 0.0:
        return value
    return value * (1.0 + alpha * cosine * cosine) / (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0)


@kernel
def draw_cosine(g, u):
    """A cosine drawn by Henyey and Greenstein's function."""
    if abs(g) < _EVEN:
        return 1.0 - 2.0 * u
    ratio = (1.0 - g * g) / (1.0 + g - 2.0 * g * u)
    return min(max((1.0 + g * g - ratio * ratio) / (2.0 * g), -1.0), 1.0)


@kernel
def part_weight(block, workspace, index):
    """The scattering of a part: the weight of its phase function."""
    return part_table(block)[index].weight


@kernel
def phase(block, workspace, inside, cosine):
    """Phase function of all media around a ray, and the density of ``sample_phase``; a cosine of 1 is straight on."""
    value, density, total = 0.0, 0.0, 0.0
    for entry in range(inside.count):
        medium = medium_table(block)[inside.medium[entry]]
        for index in range(medium.part_count):
            part = part_table(block)[medium.first_part + index]
            weight = part_weight(block, workspace, medium.first_part + index)
            own = henyey_greenstein(cosine, part.g)
            density += weight * own
            value += weight * (own if part.alpha == 0.0 else draine(cosine, part.g, part.alpha))
            total += weight
    if total <= 0.0:
        return 0.0, 0.0
    return value / total, density / total


@kernel
def sample_phase(block, workspace, inside, d, u1, u2, u3):
    """A direction into which light along d is scattered; u3 chooses among phase functions."""
    total = 0.0
    for entry in range(inside.count):
        medium = medium_table(block)[inside.medium[entry]]
        for index in range(medium.part_count):
            total += part_weight(block, workspace, medium.first_part + index)
    left, g = u3 * total, 0.0
    for entry in range(inside.count):
        medium = medium_table(block)[inside.medium[entry]]
        for index in range(medium.part_count):
            part = part_table(block)[medium.first_part + index]
            if left >= 0.0:
                g = part.g
            left -= part_weight(block, workspace, medium.first_part + index)
    cosine = draw_cosine(g, u1)
    sine, phi = math.sqrt(max(1.0 - cosine * cosine, 0.0)), 2.0 * math.pi * u2
    t, b = frame(d)
    return to_world((sine * math.cos(phi), sine * math.sin(phi), cosine), t, b, d)
