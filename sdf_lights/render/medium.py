# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Participating media: what the inside of a mesh, or all of the world, does to light. The same everywhere inside.

Where media overlap their coefficients add up, as in Cycles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RGB = tuple[float, float, float]

BLACK = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Scattering:
    """Light scattered in one way: ``coefficient`` in 1/m, and a phase function in proportion to

        (1 + α cos²θ) (1 + g² − 2g cosθ)^(−3/2)

    (Draine 2003, "Scattering by interstellar dust grains"), which is Henyey and Greenstein's, of mean cosine g, where ``alpha``
    is 0, and Rayleigh's for g = 0 and α = 1. Light that goes straight on has cosθ = 1.
    """

    coefficient: RGB
    g: float = 0.0
    alpha: float = 0.0


@dataclass(frozen=True)
class Medium:
    """``absorption`` in 1/m, ``emission`` in W/(sr·m³): radiance gained in each metre."""

    absorption: RGB = BLACK
    scattering: tuple[Scattering, ...] = ()
    emission: RGB = BLACK

    @property
    def extinction(self) -> np.ndarray:
        """(RGB) absorption and scattering, 1/m."""
        return np.sum([self.absorption, *(part.coefficient for part in self.scattering)], axis=0)

    @property
    def does_nothing(self) -> bool:
        """Whether rays pass as through empty space: it neither absorbs, nor scatters, nor emits."""
        return not (self.extinction.any() or any(self.emission))


def hides_horizon(medium: Medium | None) -> bool:
    """Whether no light comes through endless space that the medium fills."""
    return medium is not None and bool((medium.extinction > 0.0).all())
