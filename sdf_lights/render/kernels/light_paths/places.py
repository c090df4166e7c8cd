# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Places that the camera sees, and that these see: what light is for."""

from __future__ import annotations

import math

import numpy as np

from ....jit import kernel
from ....vec import madd
from ..camera import camera_ray
from ..ray_origins import clear_self_primitive
from ..rays import intersect, ray_table, start_anew
from ..samplers import get_4d, pixel_seed
from ..shading.records import DIFFUSE
from .records import PLACE

AWAY = 1e-4  # part of a ray's length by which the next one starts before its end


@kernel
def find_places(block, workspace, width, height, hits, before, places):
    """Fill ``places`` (n, 3) with what rays of the camera through even points of the picture meet, and what rays in any
    direction from there meet, ``hits`` of each at most; or with where they are ``before``, as a part of their length.
    Returns how many."""
    scene, scratch, found, seed = block[0], workspace[0], 0, pixel_seed(PLACE, PLACE, block[0].seed)
    clear_self_primitive(ray_table(scratch)[0])
    for index in range(len(places) // hits):
        u = get_4d(index, seed, 0)
        origin, direction, t_min, t_max = camera_ray(scene, u[0] * width, u[1] * height, 0.5, 0.5)
        for _ in range(hits):
            start_anew(scene, scratch)
            if not (t_max > t_min and intersect(scene, scratch, origin, direction, t_min, t_max, DIFFUSE)):
                break
            distance = float(ray_table(scratch)[0].t_far)
            place = madd(origin, distance * (1.0 - before), direction)
            for axis in range(3):
                places[found, axis] = place[axis]
            found += 1
            origin = madd(origin, distance * (1.0 - AWAY), direction)
            z, phi = 1.0 - 2.0 * u[2], 2.0 * math.pi * u[3]
            s = math.sqrt(max(1.0 - z * z, 0.0))
            direction, t_min, t_max = (s * math.cos(phi), s * math.sin(phi), z), 0.0, np.inf
    return found
