# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Crossings of rays by an independent march: it uses no trees, closed forms, terms or bracketing methods.

It takes steps of the distance, but at least a minimum step, through the shape's whole formula, from before the bounding
sphere to behind it; then bisection. Two crossings closer than the minimum step may be missed, and the oracle says so:
``finest`` is the shortest distance between two crossings of a ray, and below a few steps the oracle is not reliable.
"""

from __future__ import annotations

import functools
import math
import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from sdf_lights.graph.codegen_native import LANES, compiled
from sdf_lights.jit import call_field, kernel
from sdf_lights.sdf.shapes import Shape

LEAST = 1e-5  # minimum step, relative to half of the bounding box's diagonal
FINER = 1000.0  # factor by which rays that differ are marched more finely
CAUTION = 0.5  # fraction of the certified step that is taken, so that the bound is tested too
MOST_STEPS = 400_000  # of a ray
HALVINGS = 48  # of a step that crosses
CHUNK = 512  # rays that a thread marches at a time

LANE = np.dtype(
    [
        ("ray", np.int64),  # −1: none
        ("steps", np.int64),
        ("t", np.float64),
        ("value", np.float64),  # of the last step; the value is NaN before the first
        ("inside", np.int64),
        ("halvings", np.int64),  # that remain for the crossing between ``t`` and ``precompile``
        ("low", np.float64),
        ("high", np.float64),
        ("ahead", np.float64),
        ("at_ahead", np.float64),
        ("last", np.float64),  # crossing
    ]
)


class Crossings(NamedTuple):
    counts: np.ndarray  # (n,) intervals
    lengths: np.ndarray  # (n,) total length of the intervals
    finest: np.ndarray  # (n,) shortest distance between neighbouring crossings; infinite if there are fewer than two
    complete: np.ndarray  # (n,) False if the march ended early


@functools.lru_cache(maxsize=16)
def steepness(shape: Shape) -> float:
    """The shape's Lipschitz bound; if it has none for all of space, twice the steepest slope found in its box."""
    if np.isfinite(shape.lipschitz) and shape.certified:
        return shape.lipschitz
    rng = np.random.default_rng(3)
    low, high = shape.bounds()
    size = np.linalg.norm(high - low)
    a = low - 0.05 * size + rng.random((100_000, 3)) * (high - low + 0.1 * size)
    b = a + 1e-4 * size * rng.normal(size=a.shape)
    slopes = np.abs(shape.distance(a) - shape.distance(b)) / np.linalg.norm(a - b, axis=1)
    return 2.0 * float(np.nanmax(slopes))


@kernel
def _cross(lane, t, out):
    """Enter or leave the shape at t."""
    row = out[lane.ray]
    if lane.inside == 1:
        row[0] += 1.0
        row[1] += t - lane.last
    row[2] = min(row[2], t - lane.last)
    lane.last, lane.inside = t, 1 - lane.inside


@kernel
def _advance(lane, value, end, out):
    """Process the value at the point that a lane asked for."""
    inside = 1 if value <= 0.0 else 0  # where it is not a number the field is outside
    if lane.halvings > 0:
        middle = 0.5 * (lane.low + lane.high)
        if inside == lane.inside:
            lane.low = middle
        else:
            lane.high = middle
        lane.halvings -= 1
        if lane.halvings > 0:
            return
        _cross(lane, lane.high, out)
        lane.t, lane.value = lane.ahead, lane.at_ahead
    elif inside != lane.inside and lane.steps > 0:
        lane.low, lane.high, lane.halvings, lane.at_ahead = lane.t, lane.ahead, HALVINGS, value
        return
    else:
        lane.t, lane.value = lane.ahead, value
        if inside == 1 and lane.steps == 0:
            lane.inside, lane.last = 1, lane.t
    lane.steps += 1
    if lane.t >= end or lane.steps > MOST_STEPS:
        out[lane.ray, 3] = 1.0 if lane.t >= end else 0.0
        if lane.inside == 1:
            _cross(lane, lane.t, out)
        lane.ray = -1


@kernel
def _march(address, parameters, origins, directions, segments, bound, least, out):
    """March rays (n, 3), (n, 3) from segments[:, 0] to segments[:, 1] through the formula compiled at ``address``.

    Rows of ``out`` (n, 4) get the values of ``Crossings``. The points that are evaluated together belong to different
    rays.
    """
    lanes = np.zeros(LANES, LANE)
    points, values = np.zeros((3, LANES)), np.zeros(LANES)
    lanes["ray"][:] = -1
    following, busy = 0, 1
    while busy > 0:
        busy = 0
        for index in range(LANES):
            lane = lanes[index]
            while lane.ray < 0 and following < len(origins):
                out[following, 0], out[following, 1], out[following, 2], out[following, 3] = 0.0, 0.0, math.inf, 1.0
                if segments[following, 0] < segments[following, 1]:
                    lane.ray, lane.steps, lane.inside, lane.halvings = following, 0, 0, 0
                    lane.ahead, lane.last = segments[following, 0], -math.inf
                following += 1
            if lane.ray < 0:
                continue
            busy += 1
            asked = lane.ahead
            if lane.halvings > 0:
                asked = 0.5 * (lane.low + lane.high)
            elif lane.steps > 0:
                step = abs(lane.value) * (CAUTION / bound)
                step = step if step > least else least  # also for NaN, which proves nothing
                asked = lane.ahead = min(lane.t + step, segments[lane.ray, 1])
            for axis in range(3):
                points[axis, index] = origins[lane.ray, axis] + asked * directions[lane.ray, axis]
        if busy > 0:
            call_field(address, LANES, points.ctypes.data, parameters.ctypes.data, values.ctypes.data)
            for index in range(LANES):
                if lanes[index].ray >= 0:
                    _advance(lanes[index], values[index], segments[lanes[index].ray, 1], out)


def find(shape: Shape, origins: np.ndarray, directions: np.ndarray, least: float = LEAST) -> Crossings:
    """Crossings at t ≥ 0 of rays (n, 3) with directions of unit length. ``least`` is relative, as ``LEAST`` is."""
    low, high = shape.bounds()
    middle, reach = 0.5 * (low + high), 0.5 * np.linalg.norm(high - low)
    # Distances are measured from the closest approach to the middle of the box, where they have all their digits.
    closest = -((origins - middle) * directions).sum(axis=1)
    nearest = origins + closest[:, None] * directions
    off = np.linalg.norm(nearest - middle, axis=1)
    half = np.sqrt(np.maximum((1.01 * reach) ** 2 - off * off, 0.0))
    segments = np.stack([np.maximum(-half, -closest), half], axis=1)
    code, parameters, bound = compiled(shape.formula()), np.asarray(shape.parameters(), float), steepness(shape)
    out = np.empty((len(origins), 4))

    def march(first: int) -> None:
        chunk = slice(first, first + CHUNK)
        _march(
            code.address,
            parameters,
            nearest[chunk],
            directions[chunk],
            segments[chunk],
            bound,
            least * reach,
            out[chunk],
        )

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(march, range(0, len(origins), CHUNK)))
    return Crossings(out[:, 0].astype(int), out[:, 1], out[:, 2], out[:, 3] > 0.0)


class Verdict(NamedTuple):
    """The comparison of rays with the oracle. The first three are fractions of all rays."""

    wrong: float  # a different number of intervals
    below: float  # a different number, but the difference is too fine for the oracle
    missed: float  # of the wrong rays, those with too few
    length_error: float  # mean absolute error of the length inside, relative to the box's half diagonal
    wrong_rays: np.ndarray


def judge(shape: Shape, origins, directions, counts: np.ndarray, lengths: np.ndarray, truth: Crossings) -> Verdict:
    """Compare counts and lengths with the oracle's. Rays that differ are marched again with steps 1000 times finer.

    A march misses intervals shorter than its steps without notice, and closed forms find them. So rays that still
    differ are marched once more, 1000 times finer again: either the interval is there, or they are wrong.
    """
    low, high = shape.bounds()
    reach = 0.5 * np.linalg.norm(high - low)
    finest = 8.0 * LEAST / FINER * reach
    expected, total = truth.counts.copy(), truth.lengths.copy()
    below = counts != expected  # until one of the finer marches is complete
    for least in (LEAST / FINER, LEAST / FINER**2):
        differ = np.flatnonzero(counts != expected)
        again = find(shape, origins[differ], directions[differ], least)
        complete, differ = again.complete, differ[again.complete]
        expected[differ], total[differ] = again.counts[complete], again.lengths[complete]
        below[differ] = again.finest[complete] < finest
    below &= counts != expected
    wrong = (counts != expected) & ~below
    return Verdict(
        wrong.mean(),
        below.mean(),
        (wrong & (counts < expected)).mean(),
        float(np.abs(lengths - total).mean() / reach),
        np.flatnonzero(wrong),
    )
