# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Participating media: the effect on light of the inside of a mesh, or of the whole world.

The coefficients of overlapping media add up, as in Cycles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..frozen import frozen
from ..graph.formula import Formula, Vector

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


@dataclass(frozen=True, eq=False)
class Varying:
    """Coefficients that vary in space: formulas in the place of the numbers of a ``Medium``, ``scattering`` in the same
    order. They are those of materials, evaluated at a point of a ray, whose normal is the direction to the viewer.
    ``parameters`` are those of ``material.Material``. Where absorption or scattering is negative, or anything is not a
    number, it is 0.
    """

    absorption: Vector
    scattering: tuple[Vector, ...]
    emission: Vector
    parameters: list

    def roots(self) -> list[Formula]:
        """All of them: of each way of scattering, of absorption, of emission."""
        return [channel for color in (*self.scattering, self.absorption, self.emission) for channel in color]


@frozen
class Medium:
    """``absorption`` in 1/m, ``emission`` in W/(sr·m³): radiance gained per metre.

    With ``varying`` they are means, for what needs one number for the whole medium.
    """

    absorption: RGB = BLACK
    scattering: tuple[Scattering, ...] = ()
    emission: RGB = BLACK
    varying: Varying | None = None

    @property
    def extinction(self) -> np.ndarray:
        """(RGB) absorption and scattering, 1/m."""
        return np.sum([self.absorption, *(part.coefficient for part in self.scattering)], axis=0)

    @property
    def does_nothing(self) -> bool:
        """Whether rays pass as through empty space: it neither absorbs, nor scatters, nor emits."""
        return self.varying is None and not (self.extinction.any() or any(self.emission))


def some_varies(scene) -> bool:
    """Whether some medium of a ``scene.Scene`` varies in space."""
    media = [scene.world.medium, *(material.medium for material in scene.materials)]
    return any(medium is not None and medium.varying is not None for medium in media)


def hides_horizon(medium: Medium | None) -> bool:
    """Whether no light comes through infinite space filled by the medium."""
    return medium is not None and medium.varying is None and bool((medium.extinction > 0.0).all())
