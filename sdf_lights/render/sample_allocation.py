# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sample allocation: how many samples each pixel takes, and into how many branches its paths divide.

n samples of a pixel with k branches each have the squared error

    w (D n^−a + I / (n k)).

I is the variance of a branch, about what the branches of its own sample bring on the mean. D is all other noise: of
what is sampled before paths divide, and of the light that branches are sent for, which differs from sample to sample
where the camera's ray meets edges, textures, or other things at other times. More branches do nothing against that. w
is the weight of the pixel in the error of the picture. The samples take the time n (C + m k), where a branch meets m
surfaces; a ray that leaves the scene counts as a part of one, and C is more where a light ray to a lamp needs its
boxes. The scatter of samples and of their branches estimates D and I (law of total variance). The method of Lagrange
gives each pixel those n and k, of a few, that minimise error + λ time. Edges and highlights get many samples with few
branches. Places that other surfaces light get few samples with many branches. λ makes the mean number of samples the
one that is set. If all pixels have the same number, λ is error by time, which minimises the product of the picture's
error and its time. The best of noisy estimates promises too much. So paths divide, and pixels get different numbers,
only where that product should fall clearly.

One sample does not scatter, but its branches do. At first, they and the differences of neighbours therefore estimate D
and I of the whole picture. An eighth of the rows is enough for this, so the others divide by the estimate in their
first sample.

The picture has no bias. What branches bring is averaged over all branches of a pixel, and what comes before over its
samples. The numbers of both depend on the samples of neighbours, not on the pixel's own. A median or a mean over the
picture counts a pixel as one of all.

The exponent a is that of the whole picture. It is measured by the difference of two halves: the samples up to the last
update, and as many since. Where samples are stratified well, as with lamps, edges and textures, a is greater than 1,
and branches pay. Where they do little, as with many lights, leaves or fog, more samples pay.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from .film import Film
from .settings import MOST_BRANCHES, Settings

# Figures are error × time without a term, or with another value, over that with it: see the tables of docs/sampling.md.
# Samples before the first update: the fewest that scatter. Each later update is at twice as many. With 4: 0.94 under
# lamps, 1.14 to 1.17 in ordinary scenes.
FIRST_UPDATE = 2
PATCH = 4  # side, in pixels, of a patch whose differences are summed: most patches have no edge. With 2: 1.0 to 1.2
BANDS = 8  # one row of patches of 8 takes its first sample before the others. One of 4: 1.0 to 1.4
# C, in surfaces that a branch meets: 0.7 to 1.8 were measured, and 2 more where a light ray needs the boxes of a lamp.
# The least is used, because the best of noisy estimates makes branches look too good. Without the 0.7: 0.9 to 1.4.
# Without the 2: 1.45 under lamps.
COST, CUT_COST = 0.7, 2.0
# Branches of pixels that show how branches scatter: of all pixels at first, later of this part of them, which costs 1
# %. Without them: 1.06 to 1.17 in ordinary scenes.
PROBE_BRANCHES, PROBE_FRACTION = 2, 1.0 / 32.0
# Parts of error × time that must be left where paths divide, and where pixels take different numbers of samples. The
# estimate for splitting is 0.3 to 0.7 under lamps. In ordinary scenes it is 0.8 to 1, and splitting gains nothing.
# Without: 1.1 to 1.2 there. Where paths are reused, most pixels need one branch. Those that can take little from
# others, such as glossy ones, need many, but are few. So any gain is enough there; with the same limit: 1.1 to 1.2
# under lamps. Not so with light paths: all branches share the vertices of a set, and promise more than they bring.
SPLITTING_GAIN, SHARED_GAIN, GUIDANCE_GAIN = 0.8, 1.0, 0.9
# Noise of branches that groups share, relative to that within a pixel. More branches also make the mean of a block less
# noisy: 0.7 to 0.9 of its flicker. With 1: 1.0 to 1.2. With light paths it is 1, as above; with 4 there: 1.0 to 1.15.
SHARED_NOISE = 4.0
MOST_POWER = 2.0  # a is between that of independent samples, 1, and this; without: 1.05 under lamps
# Part of the mean square brightness that is added to the squares which errors are relative to. It defines the error.
FLOOR = 0.01
# Limits of the number of samples, relative to the one that is set; the lower one is rounded down to a power of two. The
# upper one is at most the number of samples so far, because few samples show little. With 2: up to 1.24 where light is
# rare. With a quarter as the lower one: 1.0 to 1.1.
LEAST_RATE, MOST_RATE = 0.5, 8.0
BRANCHES = tuple(1 << power for power in range(MOST_BRANCHES.bit_length()))
# The least D and I, relative to the greatest, and the number of powers of two from there: pixels with the same powers
# are treated alike. They limit a table, and are not tuned: with 2^-8 and 9, 0.93 to 1.07.
LEAST = 2.0**-24
LEVELS = 1 - int(np.log2(LEAST))
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)  # its multiples spread evenly
# Weights of neighbours along each axis: D varies more sharply than I. With NEXT for all: up to 1.5. With NEAR instead
# of FAR: 0.9 to 1.2. With FAR instead of NEAR: 0.8 to 2.4.
NEXT, NEAR, FAR = (tuple(float(math.comb(2 * reach, place)) for place in range(2 * reach + 1)) for reach in (1, 2, 4))


def first_pixels(film: Film, settings: Settings) -> np.ndarray | None:
    """(pixels,) 1 for pixels that take their first sample before the others, for ``divide``; None if nothing depends on
    it."""
    return None if settings.indirect_paths or settings.max_bounces == 0 else bands(film)


def bands(film: Film, most: float = math.inf) -> np.ndarray:
    """(pixels,) 1 in rows that are spread over the film: in an eighth of it, or in fewer where that is more than
    ``most`` pixels."""
    every = BANDS
    while film.width * film.height > most * every and every * PATCH < film.height:
        every *= 2
    band = np.arange(film.height) // PATCH
    return np.repeat(band % every == min(every // 2, band[-1]), film.width).astype(film.active.dtype)


def divide(film: Film, settings: Settings) -> None:
    """Set ``film.branches`` by the first sample of some pixels. More than one, if later samples are to tell more."""
    if film.divided[:, 2].any():
        begin_with(film, settings, _branches_by_one(film))


def begin_with(film: Film, settings: Settings, branches: int) -> None:
    """Let the first samples divide into so many branches, or more if later samples are to tell more."""
    if not settings.indirect_paths:
        film.branches[:] = max(branches, PROBE_BRANCHES if settings.samples > 1 else 1)


def update(film: Film, settings: Settings) -> None:
    """Set ``film.rate`` and ``film.branches`` by the samples so far, if the settings leave them open.

    A noise threshold stops clean pixels, and the number that is set is then the maximum of the others.
    """
    if samples_left(film) > 0 or film.samples >= settings.samples:
        return
    film.next_update = 2 * film.samples
    if film.samples < FIRST_UPDATE:
        return
    guided = settings.guided_samples and settings.noise_threshold <= 0.0
    divides = not settings.indirect_paths and film.divided[:, 2].any()
    known = (film.active != 0) & (film.count >= FIRST_UPDATE)
    if not (guided or divides) or not known.any():
        return
    noise = _noise(film, known)
    if noise is None:
        return
    if film.shares:
        noise = replace(noise, second=SHARED_NOISE * noise.second)
    samples = min(film.next_update, settings.samples)
    rates = _rates(samples, min(MOST_RATE, film.samples)) if guided else (1.0,)
    branches = BRANCHES if divides else (film.branches[known].mean(),)
    groups = _grouped(_levels(noise.first), _levels(noise.second), film.count, known)

    def best(rates, branches) -> tuple[float, np.ndarray, np.ndarray]:
        rate, count = _best(noise, groups, samples, rates, branches)
        return _cost(noise, film.count, samples, rate, count), rate, count

    found = best(rates, branches)
    if divides:
        alone = best(rates, (1,))
        if found[0] > (SHARED_GAIN if film.shares else SPLITTING_GAIN) * alone[0]:
            found, branches = alone, (1,)
    if guided:
        even = best((1.0,), branches)
        if found[0] > GUIDANCE_GAIN * even[0]:
            found = even
    _, rate, count = found
    film.rate[known] = rate[known]
    if divides:
        film.branches[known] = count[known]
        film.branches[(golden_ratio_sequence(len(known)) < PROBE_FRACTION) & (film.branches < PROBE_BRANCHES)] = (
            PROBE_BRANCHES
        )


class BranchGains:
    """What other branches would gain, as the samples of a film, two or more of some pixels, let it expect."""

    def __init__(self, film: Film, settings: Settings):
        self._film, self._settings = film, settings
        self._known = film.count >= FIRST_UPDATE
        self._noise = _noise(film, self._known) if self._known.any() else None
        self._product = 0.0 if self._noise is None else self._best(self._noise)[0]

    def of(self, noise_factor: float, time_factor: float) -> tuple[float, int]:
        """Error × time over that with branches of so many times the noise (squared) and time. Pixels have the best
        number of branches for either: also its mean for the latter."""
        noise = self._noise
        if noise is None:
            return 0.0, 1
        other, count = self._best(replace(noise, second=noise.second * noise_factor, met=noise.met * time_factor))
        return self._product / max(other, 1e-300), round(count[self._known].mean())

    def _best(self, noise: _Noise) -> tuple[float, np.ndarray]:
        """Error × time with the best number of branches of each pixel, and these (pixels,)."""
        count, samples, fixed = self._film.count, self._settings.samples, self._settings.indirect_paths
        groups = _grouped(_levels(noise.first), _levels(noise.second), count, self._known)
        rate, branches = _best(noise, groups, samples, (1.0,), (fixed,) if fixed else BRANCHES)
        return _cost(noise, count, samples, rate, branches), branches


def samples_left(film: Film) -> int:
    """Number of samples until the next ``update``. The picture does not depend on how a caller divides them."""
    return max(film.next_update, 1) - film.samples


def _rates(samples: int, most: float) -> tuple[float, ...]:
    """Rates that give pixels powers of two of samples, as a Sobol sequence needs, for any number that is set."""
    first, last = (math.floor(math.log2(rate * samples)) for rate in (LEAST_RATE, most))
    return tuple(2.0**power / samples for power in range(first, last + 1))


def _branches_by_one(film: Film) -> int:
    """The number of branches of all paths, by the first sample of whole rows of pixels."""
    shape = film.height, film.width
    branches, _, met, _, _ = film.divided.sum(axis=0)
    taken = int(film.branches[0])
    whole, within = (film.squares[:, column].reshape(shape) for column in (2, 3))
    # Second differences along rows: a slope has none.
    all_of_it = _patches(np.diff(whole, 2, axis=1) ** 2)
    within = within / max(taken - 1, 1)
    of_branch = _patches(within[:, :-2] + 4.0 * within[:, 1:-1] + within[:, 2:])
    lit = of_branch > 0.0
    if not lit.any():
        return taken
    before = np.median(all_of_it[lit] / of_branch[lit]) - 1.0 / taken
    best = math.sqrt(own_cost(film) * branches / met / max(before, 1e-9))
    return round(min(max(best, 1.0), MOST_BRANCHES))


def own_cost(film: Film, pixels=slice(None)) -> float:
    """C: what a sample of these pixels costs beside its branches, in surfaces that these meet."""
    return COST + CUT_COST * film.divided[pixels, 4].sum() / max(film.count[pixels].sum(), 1)


def _patches(values: np.ndarray) -> np.ndarray:
    """Sums over patches of pixels."""
    for axis in (0, 1):
        values = np.add.reduceat(values, range(0, values.shape[axis], PATCH), axis=axis) if values.size else values
    return values


@dataclass
class _Noise:
    """Estimates by the samples of a film:
    ``first`` w D and ``second`` w I of each pixel, ``power``, a, ``met``, m, and ``cost``, C.

    ``known``: the pixels that have estimates.
    """

    known: np.ndarray
    first: np.ndarray
    second: np.ndarray
    power: float
    met: float
    cost: float


def _noise(film: Film, known: np.ndarray) -> _Noise | None:
    """The estimates by the samples so far; None if nothing is noisy."""
    shape = film.height, film.width
    count, branches = np.maximum(film.count, 1), np.maximum(film.divided[:, 0], 1.0)
    sums, scattered = _light(film)
    before, after = sums / count, scattered / branches
    of_before, of_all, total, of_branches = film.squares.T
    variance = np.maximum(of_before - sums * before, 0.0) / np.maximum(count - 1, 1)
    rest = np.maximum(of_all - total**2 / count, 0.0) / np.maximum(count - 1, 1) - variance
    freedom = np.where(known, np.maximum(branches - count, 0.0), 0.0)
    informed = known & ((freedom > 0.0) | (not freedom.any()))
    branch = of_branches / np.maximum(freedom, 1.0)
    part = film.divided[:, 3] / count
    if len(film.caustics):
        after = after + film.caustic_light().sum(axis=1)
    near, scatter = _neighbour_means((before, variance), known, shape, NEXT)
    (far,) = _neighbour_means((after,), known, shape, FAR)
    mean = np.mean((before + after)[known])
    weight = 1.0 / np.maximum((near + far) ** 2 + FLOOR * mean**2, 1e-30)
    # What the scatter of branches does not explain falls with the number of samples alone. Where it explains too much,
    # branches are stratified, and scatter by as much less.
    second, excess = (each * weight for each in _neighbour_means((branch, rest - part * branch), informed, shape, NEAR))
    first = np.maximum(scatter * weight, 0.0) + np.maximum(excess, 0.0)
    second = np.maximum(second + np.minimum(excess, 0.0) / np.maximum(part, 1e-9), 0.0)
    if not (first.any() or second.any()):
        return None
    power = _power(film, known, sums, variance, weight)
    met = film.divided[:, 2].sum() / max(film.divided[:, 0].sum(), 1.0)
    return _Noise(known, first, second, power, met, own_cost(film))


def _power(film: Film, known: np.ndarray, sums: np.ndarray, variance: np.ndarray, weight: np.ndarray) -> float:
    """a, by the difference of the samples up to the last update and of as many since. The ``sums`` are kept for the
    next."""
    before, film.earlier = film.earlier, (film.count.copy(), sums)
    if before is None:
        return 1.0
    count, earlier = before
    twice = known & (count >= FIRST_UPDATE) & (film.count == 2 * count)
    expected = (weight * variance)[twice].sum()
    if not expected > 0.0:
        return 1.0
    # Of blocks whose samples are independent, these squares are the variance of a sample.
    found = (weight * (sums - 2.0 * earlier) ** 2 / np.maximum(film.count, 1))[twice].sum()
    size = np.mean(count[twice])
    return float(np.clip(1.0 - np.log(max(found / expected, 1e-6)) / np.log(size), 1.0, MOST_POWER))


def _light(film: Film) -> tuple[np.ndarray, np.ndarray]:
    """(pixels,) sums of R + G + B of all samples: before paths divide, and of branches."""
    return tuple(film.sums[name].reshape(len(film.count), -1)[:, :3].sum(axis=1) for name in ("combined", "scattered"))


def _best(noise: _Noise, groups, samples: int, rates, branches) -> tuple[np.ndarray, np.ndarray]:
    """(pixels,) the best of the given rates and branches; rate 1 is ``samples`` samples. ``groups``: what ``_grouped``
    gives."""
    kinds, of_pixel, pixels = groups
    d, i = (2.0**-level * values.max() for level, values in zip(kinds, (noise.first, noise.second)))
    choices = np.array(list(itertools.product(rates, branches)))
    number = np.maximum(samples * choices[:, :1], kinds[2])
    error = d * number**-noise.power + i / (number * choices[:, 1:])
    time = number * (noise.cost + noise.met * choices[:, 1:])

    def best(price: float) -> np.ndarray:
        return np.argmin(error + price * time, axis=0)

    found, every = np.full(len(d), len(choices) - 1), np.arange(len(d))
    if len(rates) == 1:
        for _ in range(8):
            found = best((error[found, every] @ pixels) / (time[found, every] @ pixels))
        return tuple(choices[found[of_pixel]].T)

    def taken(choice: np.ndarray) -> float:
        return number[choice, every] @ pixels

    low, high = -40.0, 40.0  # powers of two of the quotient of error and time; found to within 2 %
    start = (error[-1] @ pixels) / (time[-1] @ pixels)
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if taken(best(start * 2.0**middle)) > samples * pixels.sum() else (low, middle)
    more, fewer = best(start * 2.0**low), best(start * 2.0**high)
    # All pixels of a kind would change at one price. To meet the number of samples, only some change, spread evenly.
    part = (samples * pixels.sum() - taken(fewer)) / max(taken(more) - taken(fewer), 1.0)
    return tuple(choices[np.where(golden_ratio_sequence(len(of_pixel)) < part, more[of_pixel], fewer[of_pixel])].T)


def _cost(noise: _Noise, count: np.ndarray, samples: int, rate: np.ndarray, branches: np.ndarray) -> float:
    """The product of the picture's error and its time, as the model has them."""
    number = np.maximum(samples * rate, count)
    error = noise.first * number**-noise.power + noise.second / (number * branches)
    time = number * (noise.cost + noise.met * branches)
    return float(error[noise.known].sum() * time[noise.known].sum())


def golden_ratio_sequence(number: int) -> np.ndarray:
    """(number,) numbers below 1, those of neighbours evenly spread."""
    values = np.arange(number) * GOLDEN
    return values - np.floor(values)


def _levels(values: np.ndarray) -> np.ndarray:
    """How many powers of two values are below the greatest one, as whole numbers below ``LEVELS``."""
    most = values.max()
    if most <= 0.0:
        return np.zeros(len(values), np.int64)
    return np.rint(-np.log2(np.maximum(values / most, LEAST))).astype(np.int64)


def _grouped(first: np.ndarray, second: np.ndarray, count: np.ndarray, known: np.ndarray):
    """Kinds of pixels, (3, kinds) of what is given, the kind of each pixel, and how many known pixels each kind has.

    Counted in tables: to sort millions of pixels would take seconds.
    """
    counts = np.flatnonzero(np.bincount(count))
    keys = (np.searchsorted(counts, count) * LEVELS + first) * LEVELS + second
    found = np.bincount(keys)
    keys_found = np.flatnonzero(found)
    found[keys_found] = range(len(keys_found))
    of_pixel = found[keys]
    kinds = np.stack([keys_found // LEVELS % LEVELS, keys_found % LEVELS, counts[keys_found // LEVELS**2]])
    return kinds, of_pixel, np.bincount(of_pixel, known, len(keys_found))


def _neighbour_means(
    several: tuple[np.ndarray, ...], amount: np.ndarray, shape: tuple[int, int], weights
) -> list[np.ndarray]:
    """Of each of ``several`` arrays of values, the means around each pixel, each value counted by its ``amount``,
    without its own; 0 where there are none."""
    reach, own = len(weights) // 2, max(weights) ** 2

    def total(each: np.ndarray) -> np.ndarray:
        padded = np.pad(each.reshape(shape), reach)
        rows = sum(weight * padded[place : place + shape[0]] for place, weight in enumerate(weights))
        return (
            sum(weight * rows[:, place : place + shape[1]] for place, weight in enumerate(weights)).ravel() - own * each
        )

    amount = amount.astype(float)
    number = total(amount)
    some = number > 0.5
    return [np.divide(total(values * amount), number, out=np.zeros(len(values)), where=some) for values in several]
