# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether light paths pay: two samples of a few pixels without them are compared with two samples with them.

A sample whose path splits into k branches has the variance D + I / k, where I is that of a branch, and takes the time
C + m k (``sample_allocation.py``). Both kinds of samples are compared by the product of error and time at the best k of
each. Time is counted in surfaces that rays meet, never measured, so that a seed gives one picture on all machines.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..film import Film
from ..sample_allocation import BRANCHES, even_numbers, own_cost

SAMPLES = 2  # of each pilot pixel: the fewest that scatter
PART, MOST, FEWEST = (
    0.01,
    4096,
    128,
)  # pilot pixels: for each pixel sample of the render; of a render at most, and at least
GAIN = 1.6  # error × time without light paths, over that with them, from which on they are used: noisy estimates promise too much
OUTLIERS = 0.01  # part of the pilot pixels that a second comparison leaves out: a few bright ones must not decide
LEAST_REST = 0.05  # of the variance of samples, which is not that of branches: estimates are noisy
FLOOR = 0.05  # part of the mean square brightness that is added to the squares which errors are relative to


def pilot_pixels(film: Film, region: np.ndarray, samples: int) -> np.ndarray | None:
    """(pixels,) 1 at the pilot pixels of a render with so many samples, evenly in the pixels where ``region`` is 1; None
    if these are too few."""
    wanted = min(PART * samples * len(region), MOST, int(region.sum()))
    if wanted < FEWEST or samples < SAMPLES:
        return None
    found = np.zeros_like(region)
    inside = np.flatnonzero(region)
    found[inside[even_numbers(len(inside)) < wanted / len(inside)]] = 1
    return found


@dataclass(frozen=True)
class Pilot:
    """What two samples of each pilot pixel tell: (pixels,) sums of RGB, the variance of ``samples`` and that of
    ``branches``; their number, and the costs C and m."""

    sums: np.ndarray
    samples: np.ndarray
    branches: np.ndarray
    count: float
    cost: float
    met: float

    @classmethod
    def of(cls, film: Film, pixels: np.ndarray) -> Pilot:
        """From a film whose ``pixels`` have ``SAMPLES`` samples."""
        at = np.flatnonzero(pixels)
        _, of_all, total, of_branches = film.squares[at].T
        branches, _, met, _, _ = film.divided[at].sum(axis=0)
        variance = np.maximum(of_all - total**2 / SAMPLES, 0.0) / (SAMPLES - 1)
        freedom = np.maximum(film.divided[at, 0] - film.count[at], 1.0)
        count = branches / film.count[at].sum()
        return cls(total, variance, of_branches / freedom, count, own_cost(film), met / max(branches, 1.0))

    def product(self, weights: np.ndarray, noise_of_branches: float = 1.0) -> float:
        """The least product of error and time, if branches had this part of their noise."""
        whole, within = float(weights @ self.samples), float(weights @ self.branches)
        rest, within = max(whole - within / self.count, LEAST_REST * whole), noise_of_branches * within
        return min((rest + within / k) * (self.cost + self.met * k) for k in BRANCHES)


def _weights(sums: np.ndarray) -> np.ndarray:
    return 1.0 / (sums**2 + FLOOR * np.mean(sums**2) + 1e-300)


def promises(without: Pilot) -> bool:
    """Whether light paths could pay, if they took all noise from what surfaces scatter."""
    weights = _weights(without.sums)
    return without.product(weights) > GAIN * without.product(weights, 0.0) > 0.0


def pays(without: Pilot, connected: Pilot) -> bool:
    """Whether light paths lower error × time clearly, of all pixels and of most."""
    return gain(without, connected) > GAIN


def gain(without: Pilot, connected: Pilot) -> float:
    """Error × time without light paths over that with them: the lesser of those of all pixels and of most."""
    weights = _weights(without.sums + connected.sums)
    found = []
    for part in (0.0, OUTLIERS):
        products = []
        for pilot in (without, connected):
            noise = weights * pilot.samples
            products.append(pilot.product(weights * (noise <= np.quantile(noise, 1.0 - part))))
        found.append(products[0] / products[1] if products[1] > 0.0 else 0.0)
    return min(found)
