# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether light paths or path reuse pay.

Two samples of a few pixels without light paths are compared with two samples with them. Path reuse needs neighbours, so
whole rows of pixels tell what it does to the scatter of branches. All are compared by the product of error and time,
each with the best number of branches for it: with connections, paths need fewer. Time is counted in surfaces that rays
meet, as in ``sample_allocation.py``. It is never measured, so a seed gives one picture on all machines. Samples without
either are the first ones of the picture. Those with one of them have films of their own.
"""

from __future__ import annotations

import numpy as np

from ...frozen import frozen
from ..film import Film
from ..sample_allocation import BranchGains, golden_ratio_sequence, own_cost
from ..settings import Settings
from .light_paths import LightPaths

SAMPLES = 2  # of each pilot pixel: the fewest that scatter
# Pilot pixels: for each pixel and sample of the render, so that two samples take 1 % of its time; of a render at most,
# and at least.
PART, MOST, FEWEST = 0.005, 4096, 96
# The most that a pilot may cost, as a part of the render, where no SDF lamp makes a gain likely.
MOST_COST = 0.02
# Error × time without light paths over that with them, from which on they are used. A pilot has few light paths: where
# it promised 0.7 to 1.7, they brought 1 to 8, and where it promised less than 0.5, 0.3 to 0.5. And what they must
# promise before they are tried.
GAIN, LEAST_POTENTIAL = 0.7, 1.5
# The same of paths that do not split, on the GPU. Where it promised 0.6 to 0.8, they brought 0.5, and 2.3 where it
# promised 0.7 to 1.1. Where it promised 1.2 to 4.6, they brought 1.7 to 22.
WHOLE_GAIN = 0.85
# The same of path reuse, and the least number of samples of a render that tries it. One or two samples of an eighth of
# the pixels, or of so many pixels, tell: 2 % of the shortest render. These rows have half of the points of a group. So
# path reuse brings more than it promises where nearly all arrivals are even: 1.4 to 1.6 where it promised 1.0 to 1.2.
REUSE_GAIN, EVEN_REUSE_GAIN, LEAST_SAMPLES, MOST_OF_ROWS = 1.15, 0.9, 16, 1 << 16
LEAST_SHARED = 1.0  # gain of path reuse, from which on vertices that groups share are tried
ROWS_BRANCHES = 4  # at most, of each pixel of these rows
# Light paths bring about a power of what their pilot promises over this. With SDF lamps: 0.9 to 1.5 where they bring 1
# to 3, 3 to 12 where they bring 20 to 200. Without: 1.1 and 1.7 where they bring 2.5, 0.8 to 1.1 where they bring 8.
PROMISE, LAMPS_POWER, LIGHTS_POWER = 0.85, 1.3, 2.0
# With vertices of light paths of SDF lamps, path reuse promises about this part of what it brings.
SHARED_PROMISE = 0.45
OUTLIERS = 0.01  # part of the pilot pixels that a second comparison leaves out: a few bright ones must not decide
FLOOR = 0.05  # part of the mean square brightness that is added to the squares which errors are relative to


def pilot_pixels(film: Film, samples: int) -> np.ndarray | None:
    """(pixels,) 1 at the pilot pixels of a render with so many samples, evenly among the active ones without any yet;
    None if these are too few."""
    active = np.flatnonzero((film.active != 0) & (film.count == 0))
    wanted = min(PART * samples * len(active), MOST, len(active))
    if wanted < FEWEST:
        return None
    found = np.zeros_like(film.active)
    found[active[golden_ratio_sequence(len(active)) < wanted / len(active)]] = 1
    return found


def is_affordable(pixels: np.ndarray, light_paths: LightPaths, film: Film, samples: int) -> bool:
    """Whether a pilot of these ``pixels``, (n,) with 1 for each, costs little beside a render with so many samples, or
    is likely to pay."""
    cost = SAMPLES * np.count_nonzero(pixels) + light_paths.pilot_cost(SAMPLES)
    return light_paths.has_lamps() or cost <= MOST_COST * samples * np.count_nonzero(film.active)


@frozen
class GainEstimate:
    """``gain``: error × time without light paths or path reuse, over that with one of them or both, as pilots estimate
    it. Of path reuse also the step (see ``PackedScene.set_path_reuse``) and the number of branches to begin with."""

    gain: float = 0.0
    step: int = 0
    branches: int = 1


@frozen
class Pilot:
    """What the samples of the pilot pixels tell: (pixels,) sums of RGB, the variance of a sample, and that of what it
    has before its path splits; the time of a sample before it splits and after that, in surfaces that rays meet; and
    into how many branches it splits."""

    sums: np.ndarray
    whole: np.ndarray
    before: np.ndarray
    time_before: float
    time_after: float
    branches: float

    @classmethod
    def of(cls, film: Film, pixels: np.ndarray) -> Pilot:
        """From a film whose ``pixels`` (n,) have ``SAMPLES`` samples."""
        at = np.flatnonzero(pixels)
        of_before, of_all, total, _ = film.squares[at].T
        before = film.sums["combined"].reshape(-1, 4)[at, :3].sum(axis=1)
        whole, first = (
            np.maximum(squares - sums**2 / SAMPLES, 0.0) / (SAMPLES - 1)
            for squares, sums in ((of_all, total), (of_before, before))
        )
        branches, _, met, _, _ = film.divided[at].sum(axis=0) / max(film.count[at].sum(), 1)
        return cls(total, whole, first, own_cost(film, at), met, max(branches, 1.0))

    def error_times_time(self, weights: np.ndarray, splits: bool = True) -> float:
        """Of samples that split into the best number of branches, or not, with the errors of pixels times ``weights``.

        n branches take n times the time, and leave one nth of the variance, so their product is that of any number
        (Bolin and Meyer 1997, "An error metric for Monte Carlo ray tracing")."""
        before = max(float(weights @ self.before), 0.0)
        after = max(float(weights @ self.whole) - before, 0.0)
        if not splits:
            return (before + self.branches * after) * (self.time_before + self.time_after / self.branches)
        return (np.sqrt(before * self.time_before) + np.sqrt(after * self.time_after)) ** 2


def _weights(sums: np.ndarray) -> np.ndarray:
    return 1.0 / (sums**2 + FLOOR * np.mean(sums**2) + 1e-300)


def may_be_worthwhile(without: Pilot) -> bool:
    """Whether either could pay, if it took all noise from the light that surfaces scatter."""
    weights = _weights(without.sums)
    return float(weights @ without.whole) > LEAST_POTENTIAL * float(weights @ without.before)


def brought(promise: float, lamps: bool) -> float:
    """What light paths should bring by what a pilot promises; ``lamps``: SDF lamps are among their sources."""
    return (promise / PROMISE) ** (LAMPS_POWER if lamps else LIGHTS_POWER)


def gain(without: Pilot, other: Pilot, splits: bool = True) -> float:
    """Error × time of one pilot over that of the other, for paths that split or not: the lesser of those of all pixels
    and of most."""
    weights = _weights(without.sums + other.sums)
    found = []
    for part in (0.0, OUTLIERS):
        products = []
        for pilot in (without, other):
            noise = weights * pilot.whole
            used = np.where(noise <= np.quantile(noise, 1.0 - part), weights, 0.0)
            products.append(pilot.error_times_time(used, splits))
        found.append(products[0] / products[1] if products[1] > 0.0 else 0.0)
    return min(found)


class ReusePilot:
    """What samples without path reuse, two or more of some pixels, tell of its gain."""

    def __init__(self, alone: Film, settings: Settings):
        self._alone, self._gains = alone, BranchGains(alone, settings)

    def potential(self) -> float:
        """The gain, if branches did not scatter at all."""
        return self._gains.of(0.0, 1.0)[0]

    def gain(self, shared: Film) -> tuple[float, int]:
        """Error × time without path reuse over that with it, and the mean of the best numbers of branches with it. The
        pixels that have a sample with it have two without: what these tell of the noise and time of a branch goes for
        all pixels."""
        alone, rows = self._alone, shared.count > 0
        weights = np.where(rows, _weights(alone.squares[:, 2] / 2.0 + shared.squares[:, 2]), 0.0)

        def branch(film: Film) -> tuple[float, float]:
            """Its noise, and the surfaces that it meets."""
            freedom = np.maximum(film.divided[:, 0] - film.count, 1.0)
            branches, _, met, _, _ = film.divided[rows].sum(axis=0)
            return float(weights @ (film.squares[:, 3] / freedom)), met / branches

        if not (shared.divided[:, 2].any() and alone.divided[rows, 2].any()):
            return 0.0, 1
        (noise, time), (noise_alone, time_alone) = branch(shared), branch(alone)
        if not noise_alone > 0.0:
            return 0.0, 1
        return self._gains.of(noise / noise_alone, time / time_alone)
