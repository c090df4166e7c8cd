# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Portals: openings of a room, towards which light of the world is sampled. They emit no light and hide none.

One of those that face the point is chosen by its approximate solid angle, and its solid angle is sampled.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import kernel, table
from ...scene import Scene
from .kinds import area
from .records import header_table

SHARE = 0.5  # of the samples of the world, if any portal faces the point

TABLES = {"light_portals": area.RECORD}

rows = table("light_portals", area.RECORD)


def pack(tables: dict[str, np.ndarray], scene: Scene) -> None:
    """Fill the table of the portals; those of zero area are left out."""
    found = []
    for portal in scene.portals:
        row = np.zeros((), area.RECORD)
        area.pack(row, portal, np.zeros(3))
        if np.isfinite(portal.matrix).all() and row["half_u"] > 0.0 and row["half_v"] > 0.0:
            found.append(row)
    tables["light_portals"] = np.array(found, area.RECORD)
    tables["light_header"]["portal_count"] = len(found)


@kernel
def _size(portal, x):
    """Approximate solid angle of a portal from x; 0 behind it."""
    lx, ly, h = area.local(portal, x)
    if h <= 0.0:
        return 0.0
    extent = portal.half_u * portal.half_v
    square = lx * lx + ly * ly + h * h + extent
    return extent * h / (square * math.sqrt(square))


@kernel
def total_size(block, x):
    """The sum of the sizes of all portals from x; 0 if none faces it."""
    total = 0.0
    for index in range(header_table(block)[0].portal_count):
        total += _size(rows(block)[index], x)
    return total


@kernel
def sample_portal(block, x, total, u1, u2):
    """Direction from x through one of the portals, whose sizes have the sum ``total``, and whether there is one."""
    last = header_table(block)[0].portal_count - 1
    left, chosen, part = u1 * total, 0, _size(rows(block)[0], x)
    while chosen < last and left >= part:
        left -= part
        chosen += 1
        part = _size(rows(block)[chosen], x)
    if not part > 0.0:
        return (0.0, 0.0, 1.0), False
    wi, _, _, pdf, _ = area.sample(rows(block)[chosen], x, min(left / part, 1.0 - 2.0**-53), u2)
    return wi, pdf > 0.0


@kernel
def portal_pdf(block, x, total, d):
    """Density per solid angle of ``sample_portal`` giving d."""
    density = 0.0
    for index in range(header_table(block)[0].portal_count):
        portal = rows(block)[index]
        size = _size(portal, x)
        if size > 0.0:
            _, _, pdf = area.hit(portal, x, d)
            density += size / total * pdf
    return density
