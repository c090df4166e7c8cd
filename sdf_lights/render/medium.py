# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Participating media: the effect on light of the inside of a mesh, or of the whole world. Homogeneous.

The coefficients of overlapping media add up, as in Cycles.
"""

from __future__ import annotations

import numpy as np

from ..frozen import frozen

RGB = tuple[float, float, float]

BLACK = (0.0, 0.0, 0.0)


@frozen
class Scattering:
    """One way of scattering: ``coefficient`` in 1/m, and a phase function proportional to

        (1 + α cos²θ) (1 + g² − 2g cosθ)^(−3/2)

    (Draine 2003, "Scattering by interstellar dust grains"). For ``alpha`` = 0 it is Henyey and Greenstein's with mean
    cosine g. For g = 0 and α = 1 it is Rayleigh's. cosθ = 1 is straight on.
    """

    coefficient: RGB
    g: float = 0.0
    alpha: float = 0.0


@frozen
class Medium:
    """``absorption`` in 1/m, ``emission`` in W/(sr·m³): radiance gained per metre."""

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
    """Whether no light comes through infinite space filled by the medium."""
    return medium is not None and bool((medium.extinction > 0.0).all())
