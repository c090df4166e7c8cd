# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Path reuse: a surface where a branch of a path arrives gives its light to the paths of a group of pixels.

This module has the records, ``arrivals`` the part of the integrator, and ``cpu.path_reuse`` the groups.
"""

from __future__ import annotations

import numpy as np

from ....jit import table
from ...settings import MOST_BRANCHES
from ..path import COUNTS as PATH_COUNTS
from ..ray_packets import PACKET

# A group has one pixel of each of SIDE × SIDE pairs of neighbours. So light that is brighter than expected becomes
# scattered dots, not a square.
SIDE = 8
GROUP = SIDE * SIDE  # pixels whose paths share their branches

# A surface where a branch has arrived: a point of a triangle that a ray of this ``kind`` has met. ``even``: 1 if it
# scatters the same light in all directions. ``connects``: 1 if light paths leave vertices there. ``scale`` is a factor
# of its light, by Russian roulette. With the ``throughput`` (RGB) its light is a part of the branch's own sample.
# ``points`` is the number of points of the group, ``branches`` that of their branches, and ``density`` that of all
# these branches that may have found it, by area. Where it is not even: whether any point sees a surface that is
# ``two_sided``, or that ``has_glossy`` lobes, and the means of what ``POINT`` has. ``number`` counts the arrivals that
# were shared, and ``uneven`` those of them that were not ``even``. ``crossed``: the part of the light that a path which
# goes on has brought that is of lamps which its first ray has crossed, as far as caustic paths share it.
ARRIVAL = np.dtype(
    [
        ("position", "f8", 3),
        ("normal", "f8", 3),  # geometric, on the side of the branch
        ("u", "f8"),
        ("v", "f8"),
        ("instance", "i8"),
        ("primitive", "i8"),
        ("kind", "i8"),
        ("even", "i8"),
        ("connects", "i8"),
        ("number", "i8"),
        ("uneven", "i8"),
        ("scale", "f8"),
        ("throughput", "f8", 3),
        ("points", "i8"),
        ("branches", "i8"),
        ("density", "f8"),
        ("two_sided", "i8"),
        ("has_glossy", "i8"),
        ("connected", "f8"),
        ("by_light", "f8", 3),
        ("onward", "f8", 3),
        ("crossed", "f8", 3),
    ],
    align=True,
)
# A surface where a path of the group divides. First what a look at an arrival takes: its position and geometric normal,
# the ``start`` of rays on that side, the ``number`` of its triangle, and the ``least`` distance at which a ray meets
# anything. ``lambert`` is 1 if its only closure is a Lambertian one, with this normal and weight (RGB). Then the
# throughput (RGB) of the path, its number of branches, what the present arrival has ``brought``, and the sum of that
# over all arrivals, and of its square. From ``visible`` on, but for ``area``: of the present arrival. ``value`` (RGB)
# is f |cos| G of the point. ``pdf`` and ``area_pdf`` are densities of the arrival by solid angle, and by area for its
# kind of ray. ``part`` is that of its branches in the density of the arrival. ``by_light`` and ``onward`` (RGB) are f
# |cos| of the arrival as the point sees it, for the light ray there, and for the path that goes on. ``area`` (m²) is
# what a pixel shows there, 0 behind a mirror; ``rival`` that of the path to the arrival: see ``caustic_paths.weights``;
# and ``left`` what caustic paths leave of the light of lamps that the path which goes on crosses first.
POINT = np.dtype(
    [
        ("position", "f8", 3),
        ("ng", "f8", 3),
        ("start", "f8", 3),
        ("lambert", "i8"),
        ("lambert_normal", "f8", 3),
        ("lambert_weight", "f8", 3),
        ("number", "u4"),
        ("least", "f4"),
        ("throughput", "f8", 3),
        ("least_pdf", "f8"),
        ("branches", "i8"),
        ("pixel", "i8"),
        ("index", "i8"),
        ("brought", "f8"),
        ("sum", "f8"),
        ("squares", "f8"),
        ("connected_noise", "f8"),
        ("visible", "i8"),
        ("direction", "f8", 3),
        ("value", "f8", 3),
        ("pdf", "f8"),
        ("area_pdf", "f8"),
        ("part", "f8"),
        ("by_light", "f8", 3),
        ("onward", "f8", 3),
        ("area", "f8"),
        ("rival", "f8"),
        ("left", "f8"),
    ],
    align=True,
)

# ``reuse_step``: of so many points of a group, one shares an arrival that is not even.
SCALARS = [("reuses_paths", np.int64), ("reuse_step", np.int64)]
TABLES = {"path_reuse_code": np.dtype(np.int64)}
WORKSPACE_TABLES = {"reuse_arrival": ARRIVAL, "reuse_points": POINT, "ray_packet": PACKET}
# What ``arrivals.evaluate_arrival`` is for, or else the kind of the ray that goes on. BY_LAMP: caustic paths share it.
BY_LAMP, BY_LIGHT = -1, 0
# The first path of a group, its branches with their rays, and the samples of its paths, in rows behind those of a path.
GROUP_START, GROUP_PATH = PATH_COUNTS["path"], PATH_COUNTS["path"] + 1
GROUP_RAY, GROUP_SAMPLE = PATH_COUNTS["ray"], PATH_COUNTS["sample"]
COUNTS = {
    "path": GROUP_PATH + GROUP * MOST_BRANCHES,
    "sample": GROUP_SAMPLE + GROUP,
    "ray": GROUP_RAY + GROUP * MOST_BRANCHES,
    "reuse_arrival": 1,
    "reuse_points": GROUP,
    "ray_packet": 1,
}

arrival_table = table("reuse_arrival", ARRIVAL)
point_table = table("reuse_points", POINT)
