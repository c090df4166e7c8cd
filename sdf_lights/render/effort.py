# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a render spends its time: how many samples each pixel takes, and into how many branches its paths divide.

A sample with k branches has the variance D + I/k: that of what comes before its path divides, and that of one branch.
It takes the time C + m k, with m surfaces that a branch meets. By the method of Lagrange, the product of the picture's
error and of its time is least for

    k_j = √(C w_j I_j / (m_j ⟨w D⟩)),

where w is the weight of pixel j in the error and ⟨ ⟩ the mean over the picture: time goes to where the light that is
scattered again is noisy, not to where it is merely noisier than the rest of the same pixel. In the same way, errors that fall
as n^−a with the number of samples add up to the least, for as much time as with as many samples for each pixel, where this
number is in proportion to the *rate*

    M_j = (w_j e_j² n_j^a / (C + m_j k_j))^(1/(1 + a)),

with the squared error e² that n samples have left. Edges and highlights are much noisier than the rest, once the lamps
are sampled well.

Nothing is biased. The mean of a sample does not depend on the branches of its path. The rate of a pixel does not depend on its
own samples, but on those of its neighbours.
"""

from __future__ import annotations

import numpy as np

from .film import LEAST_SAMPLES, Film, half_count
from .settings import MOST_BRANCHES, Settings

FIRST_UPDATE = 8  # samples; the next ones are each at twice as many
COST = 1.0  # C, in surfaces that a branch meets: 1.1 was measured with plain materials, less with principled ones
# By how much the halves of the samples until now overestimate what of D the picture is left with: single samples of it are
# spread better than those of branches, so it falls faster. Fixed numbers of branches were compared with what this chooses.
SETTLES = 4.0
BLOCK = 8  # pixels to a side that share estimates: those of a single one are no better than their own noise
FLOOR = 0.01  # of the mean square brightness, in the squares that errors are relative to
LEAST_RATE, MOST_RATE = 0.5, 8.0  # powers of two, as numbers of samples from a Sobol sequence should be
POWER = 1.3  # a: measured where edges and lamps are what is noisy; 1 is that of independent samples
STEPS = 8  # of rates, for each power of two
LEAST_GAIN, MOST_GAIN = 0.02, 2.0  # of the variance, by samples that are spread evenly


def update(film: Film, settings: Settings) -> None:
    """Set ``film.rate`` and ``film.branches`` by the samples until now, where the settings leave that to us.

    A noise threshold, which stops pixels that are clean enough, promises how many samples the others have at most.
    """
    guided = settings.guided_samples and settings.noise_threshold <= 0.0
    if film.samples < max(film.next_update, FIRST_UPDATE) or not (guided or not settings.indirect_paths):
        return
    film.next_update = 2 * film.samples
    found = _Noise(film)
    if not settings.indirect_paths and film.samples >= LEAST_SAMPLES and film.indirect[:, 3].any():
        film.branches[:] = np.where(found.known, found.best_branches(), film.branches)
    if guided:
        film.rate[:] = np.where(found.known, found.best_rates(), film.rate)


class _Noise:
    """What the samples of a film tell of each pixel."""

    def __init__(self, film: Film):
        self._film = film
        self.known = (film.active != 0) & (film.count >= min(film.samples, LEAST_SAMPLES) * LEAST_RATE)
        count, half = np.maximum(film.count, 1), np.maximum(half_count(film.count), 1)
        before, after = film.direct[:, 0] / count, film.indirect[:, 0] / count
        whole = before + after
        self._count = count
        self._weight = self.known / np.maximum(self._around(whole) ** 2 + FLOOR * np.mean(whole) ** 2, 1e-30)
        # Squared errors, where the samples make two halves.
        self._halves = self.known & (film.count >= LEAST_SAMPLES)
        self._first, self._second = (before - film.direct[:, 1] / half) ** 2, (after - film.indirect[:, 1] / half) ** 2
        self._error = (whole - (film.direct[:, 1] + film.indirect[:, 1]) / half) ** 2
        self._scatter = np.maximum(film.direct[:, 2] / count - whole**2, 0.0) / count
        self._branches, self._met, self._shares = film.indirect[:, 2], film.indirect[:, 3], film.indirect[:, 4] / count

    def best_branches(self) -> np.ndarray:
        """k of each pixel, a power of two."""
        weight = self._weight * self._halves * self._count
        number = max(np.count_nonzero(self._halves), 1)
        first = np.sum(weight * self._first) / number
        second, halves = self._blocks(weight * _part(self._second, self._shares)), self._blocks(self._halves)
        with np.errstate(divide="ignore", invalid="ignore"):
            own = second / (halves * self._met_by_a_branch())
            all_of_it = second.sum() * self._branches.sum() / (number * self._met.sum())
            # A block's own estimate is noisy itself; the picture's counts as much.
            found = np.sqrt(SETTLES * COST * 0.5 * (own + all_of_it) / first)
            found = 2.0 ** np.rint(np.log2(found))  # as numbers of samples from a Sobol sequence should be
        # Where no branch meets a surface, or nothing else is noisy, the quotient is infinite or not a number.
        return self._spread(np.where(np.isnan(found), 1.0, np.clip(found, 1.0, MOST_BRANCHES)))

    def best_rates(self) -> np.ndarray:
        """M of each pixel, as a power of two; the mean time stays."""
        film = self._film
        # Samples are spread evenly, which the scatter of single ones does not show; the difference of halves does.
        gain = _part(self._others(self._halves * self._error), self._others(self._halves * self._scatter), 1.0)
        error = self._around(self._scatter * self._count**POWER) * np.clip(gain, LEAST_GAIN, MOST_GAIN)
        cost = COST + film.branches * self._spread(np.nan_to_num(self._met_by_a_branch()))
        wanted = (self._weight * error / cost) ** (1.0 / (1.0 + POWER))
        most = wanted.max()
        if not most > 0.0:
            return film.rate
        levels = np.log2(np.maximum(wanted / most, 2.0**-24))
        # The level that gets the rate 1, by bisection over a histogram of levels by their cost.
        bins = np.rint(-STEPS * levels).astype(np.int64)
        amounts = np.bincount(bins, cost * self.known)
        at = -np.arange(len(amounts)) / STEPS
        low, high = at[-1], 0.0
        for _ in range(30):
            middle = 0.5 * (low + high)
            if amounts @ _rate(at - middle) > amounts.sum():
                low = middle
            else:
                high = middle
        return _rate(levels - high)

    def _met_by_a_branch(self) -> np.ndarray:
        """m of each block; not a number where no path divided."""
        return _part(self._blocks(self._met), self._blocks(self._branches), np.nan)

    def _blocks(self, values: np.ndarray) -> np.ndarray:
        """Sums over blocks of pixels."""
        film = self._film
        rows = values.reshape(film.height, film.width).astype(float)
        return np.add.reduceat(
            np.add.reduceat(rows, range(0, film.height, BLOCK), axis=0), range(0, film.width, BLOCK), axis=1)

    def _spread(self, values: np.ndarray) -> np.ndarray:
        """Values of blocks, for each of their pixels."""
        film = self._film
        return values.repeat(BLOCK, axis=0)[:film.height].repeat(BLOCK, axis=1)[:, :film.width].ravel()

    def _others(self, values: np.ndarray) -> np.ndarray:
        """Sums over the other pixels of a pixel's block."""
        return self._spread(self._blocks(values)) - values

    def _around(self, values: np.ndarray) -> np.ndarray:
        """Binomial means of the eight pixels around each."""
        shape = self._film.height, self._film.width
        padded = np.pad(values.reshape(shape), 1, mode="reflect" if min(shape) > 1 else "edge")
        rows = padded[:-2] + 2.0 * padded[1:-1] + padded[2:]
        return ((rows[:, :-2] + 2.0 * rows[:, 1:-1] + rows[:, 2:]).ravel() - 4.0 * values) / 12.0


def _part(values, of, otherwise: float = 0.0) -> np.ndarray:
    """Quotient; ``otherwise`` where it is none."""
    of = np.asarray(of, float)
    return np.divide(values, of, out=np.full(of.shape, otherwise), where=of > 0.0)


def _rate(level: np.ndarray) -> np.ndarray:
    return np.clip(2.0 ** np.rint(level), LEAST_RATE, MOST_RATE)
