# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The symmetry of regular polygons and stars, without angles."""

from __future__ import annotations

import math

from ...graph.formula import Formula, maximum
from .base import Slots

MOST_SECTORS = 64


def into_sector(along: Formula, aside: Formula, count: int, most: int, slot: Slots) -> tuple[Formula, Formula]:
    """A point of the plane folded by the symmetry of ``count`` equal arms, one of them along the first axis.

    ``aside``, its second coordinate, is ≥ 0 and stays so. The angle between the result and the first axis is at most
    π/count. Only reflections are used, so the fold is continuous and changes no length. The graph is the same for any
    count up to ``most``.
    """
    # The point is now within ``left`` sectors of π/count from the axis. A reflection in the ray that halves them maps
    # the farther half to the nearer. Once a single sector is left, the mirror has no normal and changes nothing.
    left = count
    for _ in range(math.ceil(math.log2(most))):
        kept = (left + 1) // 2
        angle = math.pi / count * kept
        u, v = (slot(value if left > 1 else 0.0) for value in (-math.sin(angle), math.cos(angle)))
        beyond = maximum(along * u + aside * v, 0.0) * 2.0
        along, aside, left = along - beyond * u, aside - beyond * v, kept
    return along, aside
