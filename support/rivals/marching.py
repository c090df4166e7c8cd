# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Marching along rays, by the rules with which ``crossings`` is compared. No renderer uses it.

The rules tell the step from a point where the field is φ. All continue to the end of the ray. If the sign changes in a
step, the zero is located by the same method as in ``cover``. No step is shorter than a minimum step.

- ``PUBLISHED`` (Huang et al. 2026): φ outside, min(−φ, clamp) inside.
- ``SPHERES`` (Hart 1996): |φ|/L, with L the Lipschitz bound of the field.
- ``RELAXED``: spheres whose next one only has to touch the last, as far as the slope of the last steps lets expect
  (Bálint and Valasek 2018, "Accelerating sphere tracing"). A step is taken back where the balls do not meet.

Eight rays are marched at once, each in its own lane, so the time is that of a field evaluated for many rays.
"""

from __future__ import annotations

import math

import numpy as np

from sdf_lights.emitter.intersection.cover import PRECISION, SIGN, estimate, first_estimate, refine_bracket, signed
from sdf_lights.emitter.intersection.fields import LANES, STACK, VALUES, evaluate
from sdf_lights.jit import kernel, stack_array
from sdf_lights.vec import length

PUBLISHED, SPHERES, RELAXED = 0, 1, 2
CLAMP = 0.05  # of a step inside by the published rule, relative to the lamp's size
RELAXATION = 0.95  # fraction of the step at which the balls would touch at the present slope

LANE = np.dtype(
    [
        ("ray", np.int64),  # −1: none
        ("asked", np.float64),  # where the field is evaluated
        ("t", np.float64),
        ("value", np.float64),  # of the last valid point
        ("step", np.float64),
        ("slope", np.float64),  # of |φ|, relative to the greatest
        ("safe", np.int64),  # 1 where the step needs no check
        ("locating", np.int64),  # 1 while a zero in the last step is located …
        ("start", np.float64),
        ("at_start", np.float64),
        ("end", np.float64),
        ("at_end", np.float64),
        ("third", np.float64),
        ("at_third", np.float64),  # … in this bracket
        ("inside", np.int64),
        ("entry", np.float64),  # whether the ray is in an interval, and where that began
        ("speed", np.float64),  # |d|
    ]
)


@kernel
def _go_on(lane, rule, rate, speed, size, least, end):
    """Set the next step of a lane. ``rate`` bounds the change of the field; lengths are in units of the parameter."""
    value = abs(lane.value) if abs(lane.value) > SIGN else 0.0
    if rule == PUBLISHED:
        step = value / speed if lane.value > 0.0 else min(value / speed, CLAMP * size)
    else:
        step = value / rate
    step, lane.safe = max(step, least * size), 1
    if rule == RELAXED:
        longer = RELAXATION * 2.0 * value / (rate * (1.0 - lane.slope))
        if longer > step:
            step, lane.safe = longer, 0
    lane.step = min(step, end - lane.t)


@kernel
def _cross(lane, t, out):
    """Count a zero: one that ends an interval, or begins one."""
    if lane.inside == 1:
        out[lane.ray, 0] += 1.0
        out[lane.ray, 1] += t - lane.entry
    lane.entry, lane.inside = t, 1 - lane.inside


@kernel
def _advance(lane, value, rule, lipschitz, speed, size, least, end, out):
    """Process a value at ``lane.asked``."""
    out[lane.ray, 2] += 1.0
    precision = PRECISION * size
    rate = lipschitz * speed
    if lane.locating == 1:
        zero, other, at_other, third, at_third = refine_bracket(
            lane.start, lane.at_start, lane.end, lane.at_end, lane.third, lane.asked, value, precision
        )
        lane.start, lane.at_start, lane.end, lane.at_end = lane.asked, value, other, at_other
        lane.third, lane.at_third = third, at_third
        if math.isnan(zero):
            return
        lane.locating = 0
        _cross(lane, zero, out)
    elif math.isnan(lane.value):
        lane.inside, lane.value = 0, value
        if value < 0.0:
            _cross(lane, lane.t, out)
    else:
        crossed = (value > 0.0) != (lane.value > 0.0)
        if lane.safe == 0 and (crossed or abs(value) + abs(lane.value) < rate * lane.step):
            lane.slope, lane.safe = -1.0, 1
            lane.step = min(max(abs(lane.value) / rate, least * size), lane.step)
            return
        if lane.step > 0.0:
            lane.slope += 0.7 * (max(-1.0, (abs(value) - abs(lane.value)) / (rate * lane.step)) - lane.slope)
        if crossed:
            lane.start, lane.at_start, lane.end, lane.at_end = lane.t, lane.value, lane.asked, value
            lane.third, lane.locating = math.nan, 1
        lane.t, lane.value = lane.asked, value
        if crossed:
            return
    if lane.t >= end:
        if lane.inside == 1:
            _cross(lane, end, out)
        lane.ray = -1
    else:
        _go_on(lane, rule, rate, speed, size, least, end)


@kernel
def march(block, row, count, rule, lipschitz, least, origins, directions, segments, out):
    """March rays (n, 3), (n, 3), from segments[:, 0] to segments[:, 1], in tree space; the field has ``count`` terms.

    ``least`` is the shortest step, relative to the lamp's size, like ``CLAMP``. Rows of ``out`` (n, 3) get the number
    of intervals, their length and the number of evaluations of each ray.
    """
    lanes = np.zeros(LANES, LANE)
    stack = stack_array(STACK)
    stack[:] = 0.0
    reach = math.sqrt(row.high[0] ** 2 + row.high[1] ** 2 + row.high[2] ** 2)
    following, busy = 0, LANES
    for index in range(LANES):
        lanes[index].ray = -1
    while busy > 0:
        busy = 0
        for index in range(LANES):
            lane = lanes[index]
            while lane.ray < 0 and following < len(origins):
                out[following] = 0.0
                if segments[following, 0] < segments[following, 1]:
                    d = (directions[following, 0], directions[following, 1], directions[following, 2])
                    lane.ray, lane.speed, lane.t, lane.step = following, length(d), segments[following, 0], 0.0
                    lane.value, lane.slope, lane.safe, lane.locating = math.nan, -1.0, 1, 0
                following += 1
            if lane.ray < 0:
                continue
            busy += 1
            if lane.locating == 1 and math.isnan(lane.third):
                lane.asked = first_estimate(lane.start, lane.at_start, lane.end, lane.at_end, 0.0, 0.0)
            elif lane.locating == 1:
                lane.asked = estimate(
                    lane.start,
                    lane.at_start,
                    lane.end,
                    lane.at_end,
                    lane.third,
                    lane.at_third,
                    PRECISION * reach / lane.speed,
                )
            else:
                lane.asked = lane.t + lane.step
            for axis in range(3):
                stack[axis * LANES + index] = origins[lane.ray, axis] + lane.asked * directions[lane.ray, axis]
        if busy > 0:
            evaluate(block, row, 0, count, LANES, stack)
            for index in range(LANES):
                lane = lanes[index]
                if lane.ray >= 0:
                    _advance(
                        lane,
                        signed(stack[VALUES + index]),
                        rule,
                        lipschitz,
                        lane.speed,
                        reach / lane.speed,
                        least,
                        segments[lane.ray, 1],
                        out,
                    )
