# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes whose surface is displaced by a pattern in space: waves, noise.

The field is (φ + d) / (1 + S) for a pattern d of slope at most S. If L is the child's Lipschitz bound, its own is (L +
S) / (1 + S).
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from ...frozen import frozen
from ...graph.formula import POINT, Formula, Vector, cos
from ...graph.loops import iterate
from ..noise import PERIOD, STEEPEST, value_noise
from .base import LARGEST, Family, Shape, Slots, Term, number, part, undone
from .operators import Operator, guarded, level_bounds

_MOST_OCTAVES = 12


class Displaced(Operator, abstract=True):
    """The child's field, guarded, plus a pattern."""

    amplitude: float

    @cached_property
    def _guarded(self) -> Shape:
        return guarded(self.child)

    def _pattern(self, p: Vector, slot: Slots) -> Formula:
        """Between −1 and 1."""
        raise NotImplementedError

    def _steepest(self) -> float:
        """Greatest slope of the pattern."""
        raise NotImplementedError

    @property
    def _slope(self) -> float:
        return self.amplitude * self._steepest()

    @cached_property
    def lipschitz(self):
        child = self._guarded.lipschitz
        return (child + self._slope) / (1.0 + self._slope) if math.isfinite(child) else child

    def build(self, p, slot):
        pattern = self._pattern(p, slot) * slot(self.amplitude)
        return (self._guarded.build(p, slot) + pattern) * slot(1.0 / (1.0 + self._slope))

    def terms(self, matrix, factor):
        # As a mixture of two fields, the second being the pattern with a slope of 1: no mixture is steeper than its
        # parts.
        child = self._guarded.terms(matrix, factor)
        slots = Slots()
        pattern = self._pattern(undone(matrix, POINT, slots), slots) * slots(factor / self._steepest())
        shares = Slots()
        mixture = POINT.x * shares(1.0 / (1.0 + self._slope)) + POINT.y * shares(self._slope / (1.0 + self._slope))
        steepest = max(child[-1].lipschitz, 1.0)
        return [
            *child,
            Term(pattern, np.array(slots.values), 0, Family.LEAF, 0.0, 1.0),
            Term(mixture, np.array(shares.values), 2, Family.UNION, math.inf, steepest),
        ]

    def bounds(self, matrix=None):
        return level_bounds(self._guarded, self.amplitude, matrix)

    def growth(self, matrix=None):
        return self._guarded.growth(matrix) * (1.0 + self._slope)


@frozen
class WaveDisplacement(Displaced):
    """The surface moved in and out by standing waves: the product of a cosine along each axis."""

    child: Shape = part("Shape whose surface moves")
    amplitude: float = number(0.05, "Greatest displacement of the surface", minimum=0.0, soft_maximum=1.0)
    wavelength: tuple[float, float, float] = number(
        (0.5, 0.5, 0.5), "Length of a wave along x, y and z; a very large one has no effect along that axis"
    )
    phase: tuple[float, float, float] = number(
        (0.0, 0.0, 0.0),
        "Phase of each cosine, in waves",
        unit="NONE",
        minimum=-LARGEST,
        soft_maximum=1.0,
    )

    def _pattern(self, p, slot):
        scales, phases = slot(tuple(math.tau / w for w in self.wavelength)), slot(self.phase) * math.tau
        x, y, z = (cos(q * s + f) for q, s, f in zip(p, scales, phases))
        return x * y * z

    def _steepest(self):
        # With a, b, c the squared cosines, the squared slope is at most k² ((1−a) b c + a (1−b) c + a b (1−c)) for the
        # greatest wave number k, and that sum is at most 1 for a, b, c from 0 to 1.
        return math.tau / min(self.wavelength)


@frozen
class NoiseDisplacement(Displaced):
    """The surface displaced by noise: octaves of it, each half as large and twice as fine as the one before."""

    child: Shape = part("Shape whose surface moves")
    amplitude: float = number(0.1, "Greatest displacement of the surface", minimum=0.0, soft_maximum=1.0)
    feature_size: float = number(0.3, "Size of the coarsest features")
    octaves: float = number(
        3.0, "Number of octaves, each twice as fine", unit="NONE", minimum=1.0, maximum=_MOST_OCTAVES, whole=True
    )
    seed: float = number(
        0.0,
        "Another number gives different noise",
        unit="NONE",
        minimum=0.0,
        maximum=PERIOD - 1.0,
        soft_maximum=100.0,
        whole=True,
    )

    @property
    def _coarsest(self) -> float:
        """Share of the first octave in the sum, which is between −1 and 1."""
        return 0.5 / (1.0 - 0.5**self.octaves)

    def _pattern(self, p, slot):
        seed = slot(self.seed)

        def octave(total, weight, x, y, z):
            total = total + weight * value_noise(Vector(x, y, z), seed)
            # The offset keeps the lattices' points apart.
            return (total, 0.5 * weight, 2.0 * x + 0.5, 2.0 * y + 0.5, 2.0 * z + 0.5), None

        start = p * slot(1.0 / self.feature_size)
        return iterate(slot(self.octaves), (0.0, slot(self._coarsest), *start), octave, _MOST_OCTAVES)[0]

    def _steepest(self):
        # Each octave is half as high and twice as fine: as steep as the first.
        return self.octaves * self._coarsest * STEEPEST / self.feature_size
