# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that go on past a transparent surface, or one that only bounds a medium.

Another face may lie exactly in the same place, such as the floor below a box of fog. Where that may be, the ray goes on
from just before the surface, which becomes its self primitive (``ray_origins``), and so meets the other face. It meets
one more only: a second face there is left behind.
"""

from __future__ import annotations

import numpy as np

from ...jit import kernel
from ...vec import madd, sub
from .geometry import TRIANGLES, corner_position, instance_at, shares, surface_table
from .ray_origins import EXACT, number_of
from .rays import OFFSET, beyond, hit_instance, ray_table

JUST_BEFORE = 0.25 * OFFSET  # relative step before a surface, so that rounding hides no other in the same place


@kernel
def _continue_past(ray, number, t, t_min):
    if t <= beyond(t_min):
        return beyond(t)
    ray.id = number
    ray.least = 0.0
    return t - max(abs(t), 1e-3) * JUST_BEFORE


@kernel
def continue_past_hit(block, workspace, t_min):
    """Distance from which the workspace's ray goes on past what it has hit; until there, it went on from ``t_min``."""
    ray = ray_table(workspace)[0]
    t = float(ray.t_far)
    instance, triangle = instance_at(block, hit_instance(ray)), np.int64(ray.primitive)
    if instance.primitive != TRIANGLES:
        return beyond(t)
    p0 = corner_position(block, instance, triangle, 0)
    edge1 = sub(corner_position(block, instance, triangle, 1), p0)
    edge2 = sub(corner_position(block, instance, triangle, 2), p0)
    if not shares(block, instance, madd(madd(p0, float(ray.u), edge1), float(ray.v), edge2)):
        return beyond(t)
    return _continue_past(ray, number_of(hit_instance(ray), triangle), t, t_min)


@kernel
def continue_past_surface(workspace, t, t_min):
    """The same for the workspace's surface, which the path's ray has hit at ``t``."""
    surface = surface_table(workspace)[0]
    if surface.exact_origin != EXACT:
        return beyond(t)
    return _continue_past(ray_table(workspace)[0], surface.number, t, t_min)
