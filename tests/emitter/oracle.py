# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Crossings of rays by a march of its own: nothing here knows of trees, closed forms, lanes or brackets.

Steps of the distance, but never shorter than a least one, through the shape's whole formula, from before the bounding
sphere to behind it; then bisection. Two crossings closer than the least step may be missed, and the oracle says so:
``finest`` is the shortest distance between two crossings of a ray, and below a few steps it is no authority.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sdf_lights.sdf import read_native
from sdf_lights.sdf.shapes import Shape

LEAST = 1e-5  # least step, relative to half of the bounding box's diagonal
CAUTION = 0.5  # part of the certified step that is taken, so that the bound is tested too
MOST_STEPS = 40_000
CHUNK = 16_384


class Crossings(NamedTuple):
    counts: np.ndarray  # (n,) intervals
    lengths: np.ndarray  # (n,) of the intervals together
    finest: np.ndarray  # (n,) shortest distance between neighbouring crossings; infinite where there are fewer than two
    complete: np.ndarray  # (n,) False where the march ended early


def steepness(shape: Shape) -> float:
    """The shape's Lipschitz bound; where it has none for all of space, twice the steepest slope found in its box."""
    if np.isfinite(shape.lipschitz) and shape.certified:
        return shape.lipschitz
    rng = np.random.default_rng(3)
    low, high = shape.bounds()
    size = np.linalg.norm(high - low)
    a = low - 0.05 * size + rng.random((100_000, 3)) * (high - low + 0.1 * size)
    b = a + 1e-4 * size * rng.normal(size=a.shape)
    slopes = np.abs(shape.distance(a) - shape.distance(b)) / np.linalg.norm(a - b, axis=1)
    return 2.0 * float(np.nanmax(slopes))


def find(shape: Shape, origins: np.ndarray, directions: np.ndarray, least: float = LEAST) -> Crossings:
    """Crossings at t ≥ 0 of rays (n, 3) with directions of unit length. ``least`` is relative, as ``LEAST`` is."""
    bound = steepness(shape)
    parts = [_find(shape, origins[i:i + CHUNK], directions[i:i + CHUNK], least, bound)
             for i in range(0, len(origins), CHUNK)]
    return Crossings(*(np.concatenate(columns) for columns in zip(*parts)))


def _find(shape, origins, directions, least, bound) -> Crossings:
    low, high = shape.bounds()
    middle, reach = 0.5 * (low + high), 0.5 * np.linalg.norm(high - low)
    least *= reach
    # Distances are measured from the closest approach to the middle of the box, where they have all their digits.
    closest = -((origins - middle) * directions).sum(axis=1)
    nearest = origins + closest[:, None] * directions
    off = np.linalg.norm(nearest - middle, axis=1)
    half = np.sqrt(np.maximum((1.01 * reach) ** 2 - off * off, 0.0))
    start, end = np.maximum(-half, -closest), half

    def inside(rays, t):
        return field(rays, t) <= 0.0

    def field(rays, t):
        return read_native.evaluate(shape.formula(), nearest[rays] + t[:, None] * directions[rays], shape.parameters())

    rays = np.flatnonzero(start < end)
    t = start[rays]
    value = field(rays, t)
    now = value <= 0.0
    found = [(rays[now], t[now], t[now])]
    steps = 0
    while len(rays) and steps < MOST_STEPS:
        steps += 1
        # Where it is not a number the field is outside, and certifies nothing.
        step = np.fmax(np.abs(value) * (CAUTION / bound), least)
        ahead = np.minimum(t + step, end[rays])
        value = field(rays, ahead)
        then = value <= 0.0
        crossed = then != now
        found.append((rays[crossed], t[crossed], ahead[crossed]))
        going = ahead < end[rays]
        closing = ~going & then
        found.append((rays[closing], ahead[closing], ahead[closing]))
        rays, t, now, value = rays[going], ahead[going], then[going], value[going]
    complete = np.ones(len(origins), bool)
    complete[rays] = False
    found.append((rays[now], t[now], t[now]))

    which, a, b = (np.concatenate(column) for column in zip(*found))
    entering = inside(which, b)
    for _ in range(40):
        middle_t = 0.5 * (a + b)
        like_b = inside(which, middle_t) == entering
        a, b = np.where(like_b, a, middle_t), np.where(like_b, middle_t, b)
    order = np.lexsort((b, which))
    which, t = which[order], b[order]
    assert len(which) % 2 == 0 and np.array_equal(which[::2], which[1::2])
    counts = np.bincount(which[::2], minlength=len(origins))
    lengths = np.bincount(which[::2], t[1::2] - t[::2], minlength=len(origins))
    finest = np.full(len(origins), np.inf)
    same = which[1:] == which[:-1]
    np.minimum.at(finest, which[1:][same], np.diff(t)[same])
    return Crossings(counts, lengths, finest, complete)


class Verdict(NamedTuple):
    """What rays were judged to be, against the oracle. The first three are fractions of all rays."""

    wrong: float  # another number of intervals
    below: float  # another number, but the difference is too fine for the oracle
    missed: float  # of the wrong, those with too few
    length_error: float  # mean of the absolute error of the length inside, relative to the box's half diagonal
    wrong_rays: np.ndarray


def judge(shape: Shape, origins, directions, counts: np.ndarray, lengths: np.ndarray, truth: Crossings) -> Verdict:
    """Compare counts and lengths with the oracle's; rays that differ are marched again with steps 1000 times finer."""
    low, high = shape.bounds()
    reach = 0.5 * np.linalg.norm(high - low)
    differ = np.flatnonzero(counts != truth.counts)
    below = np.zeros(len(counts), bool)
    wrong = np.zeros(len(counts), bool)
    expected, total = truth.counts.copy(), truth.lengths.copy()
    if len(differ):
        least = LEAST / 1000.0
        again = find(shape, origins[differ], directions[differ], least)
        expected[differ], total[differ] = again.counts, again.lengths
        fine = (again.finest < 8.0 * least * reach) | ~again.complete
        below[differ] = (counts[differ] != again.counts) & fine
        wrong[differ] = (counts[differ] != again.counts) & ~fine
    return Verdict(wrong.mean(), below.mean(), (wrong & (counts < expected)).mean(),
                   float(np.abs(lengths - total).mean() / reach), np.flatnonzero(wrong))
