# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A dense march through a field, in double precision, as the judge of a lamp's ray intervals."""

from __future__ import annotations

import enum
import warnings

import numpy as np

from sdf_lights.emitter.tree.interior import TreeError
from sdf_lights.graph import numpy_evaluation

from ..shapes import random_programs
from .hard_cases import around
from .rays import Traced

RAYS, STEPS = 16, 3000
PRECISION = 1e-7  # relative to the diagonal of the box


def missed(shape, traced: Traced, rays: int = RAYS, steps: int = STEPS) -> float:
    """The greatest length, relative to the diagonal, at which a ray through a shape is inside by its intervals and
    outside by the field, or the reverse, beyond the length that the ray reported as unresolved."""
    low, high = shape.bounds()
    size = np.linalg.norm(high - low)
    origins, directions = around(shape, np.random.default_rng(1), rays)
    worst = 0.0
    for o, d, left in zip(origins, directions, traced.trace(origins, directions)[:, 2]):
        spans = traced.intervals(o, d)
        with np.errstate(divide="ignore"):
            ends = np.sort([(corner - o) / d for corner in (low, high)], axis=0)
        start, end = max(ends[0].max(), 0.0), ends[1].min()
        if not start < end:
            continue
        step = (end - start) / steps
        t = start + (np.arange(steps) + 0.5) * step
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            values = numpy_evaluation.evaluate(shape.formula(), o + t[:, None] * d, shape.parameters())
        inside = values <= 0.0
        found = np.zeros(steps, bool)
        near = np.abs(values) <= 1e-12 * size  # either side, within rounding
        for a, b in spans:
            found |= (t >= a) & (t <= b)
            near |= (np.abs(t - a) < PRECISION * size) | (np.abs(t - b) < PRECISION * size)
        wrong = (inside != found) & ~near
        worst = max(worst, (wrong.sum() * step - left) / size)
    return worst


class Verdict(enum.Enum):
    """The verdict on a random program of the language."""

    NO_LAMP = enum.auto()
    NOT_CERTIFIED = enum.auto()
    RIGHT = enum.auto()  # certified, and rightly so
    WRONG = enum.auto()


def verdict(seed: int) -> Verdict:
    """The verdict on the program of ``random_programs`` with this seed."""
    found = random_programs.valid(seed)
    if found is None:
        return Verdict.NO_LAMP
    try:
        traced = Traced(found[1])
    except TreeError:
        return Verdict.NO_LAMP
    if not traced.tree.certified:
        return Verdict.NOT_CERTIFIED
    return Verdict.WRONG if missed(found[1], traced) > 0.0 else Verdict.RIGHT
