# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sample allocation: how many samples each pixel takes, and into how many branches its paths divide.

n samples of a pixel with k branches each have the squared error

    w (D n^−a + I / (n k)).

D comes from what is sampled before paths divide, I from branches, and w is the weight of the pixel in the error of the
picture. The samples take the time n (C + m k), where a branch meets m surfaces; a ray that leaves the scene counts as a part of
one. The scatter of samples estimates D and I.
The method of Lagrange gives each pixel those n and k, of a few, that minimise error + λ time. Edges and highlights get many
samples with few branches. Places that other surfaces light get few samples with many branches. λ makes the mean number
of samples the one that is set. If all pixels have the same number, λ is error by time, which minimises the product of the
picture's error and its time.

One sample does not scatter. At first, the differences of neighbours therefore estimate D and I of the whole picture. An
eighth of the rows is enough for this, so the others divide by the estimate in their first sample.

The picture has no bias. What branches bring is averaged over all branches of a pixel, and what comes before over its
samples. The numbers of both depend on the samples of neighbours, not on the pixel's own. A median or a mean over the
picture counts a pixel as one of all.

What neighbours show is noisy, most of all with few samples and rare light. All pixels whose neighbours show the same
therefore share one expectation: the mean of the noise that these pixels have themselves. So a pixel whose neighbours have
met no light does not count as clean, if similar pixels have met some.

The exponent a is that of the whole picture. It is measured by the difference of two halves: the samples up to the last
update, and as many since. Where samples are stratified well, as with lamps, edges and textures, a is greater than 1, and
branches pay. Where they do little, as with many lights, leaves or fog, more samples pay.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from .film import Film
from .settings import MOST_BRANCHES, Settings

FIRST_UPDATE = 2  # samples before the first update: the fewest that scatter; each later update is at twice as many
PATCH = 4  # side, in pixels, of a patch whose differences are summed: most patches have no edge
BANDS, FIRST_BAND = 8, 3  # one row of patches of 8, the fourth, takes its first sample before the others
SPREAD = (
    2.5  # branches until samples scatter, as a multiple of the best number by patches: too few cost more than too many
)
COST = 1.1  # C, in surfaces that a branch meets: measured with plain materials; less with principled ones
MOST_POWER = 2.0  # a is between that of independent samples, 1, and this
PRIOR = 16.0  # weight, in pixels, of what the neighbours show: 4 and 64 do as well
FLOOR = 0.01  # part of the mean square brightness that is added to the squares which errors are relative to
# Limits of the number of samples, relative to the one that is set; the lower one is rounded down to a power of two. The
# upper one is at most the number of samples so far, as few samples show little.
LEAST_RATE, MOST_RATE = 0.5, 8.0
BRANCHES = tuple(1 << power for power in range(MOST_BRANCHES.bit_length()))
LEVELS = 2  # levels of D and I for each power of two: pixels of the same levels are treated alike
LEAST = 2.0**-24  # the least D and I, relative to the greatest
LOWEST = 1 - int(LEVELS * np.log2(LEAST))
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)  # its multiples spread evenly
NEXT, NEAR = (
    (1.0, 2.0, 1.0),
    (1.0, 4.0, 6.0, 4.0, 1.0),
)  # weights of neighbours along each axis: D varies more sharply than I


def first_pixels(film: Film, settings: Settings) -> np.ndarray | None:
    """(pixels,) 1 for pixels that take their first sample before the others, for ``divide``; None if nothing depends on it."""
    if settings.indirect_paths or settings.max_bounces == 0:
        return None
    band = np.arange(film.height) // PATCH
    return np.repeat(band % BANDS == min(FIRST_BAND, band[-1]), film.width).astype(film.active.dtype)


def divide(film: Film) -> None:
    """Set ``film.branches`` by the first sample of some pixels."""
    if film.divided[:, 2].any():
        film.branches[:] = _branches_by_one(film)


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
    samples = min(film.next_update, settings.samples)
    rates = _rates(samples, min(MOST_RATE, film.samples)) if guided else (1.0,)
    branches = BRANCHES if divides else (film.branches[known].mean(),)
    rate, count = _best(noise, film.count, samples, rates, branches)
    film.rate[known] = rate[known]
    if divides:
        film.branches[known] = count[known]


def samples_left(film: Film) -> int:
    """Number of samples until the next ``update``. The picture does not depend on how a caller divides them."""
    return max(film.next_update, 1) - film.samples


def _rates(samples: int, most: float) -> tuple[float, ...]:
    """Rates that give pixels powers of two of samples, as a Sobol sequence needs, for any number that is set."""
    first, last = (math.floor(math.log2(rate * samples)) for rate in (LEAST_RATE, most))
    return tuple(2.0**power / samples for power in range(first, last + 1))


def _branches_by_one(film: Film) -> int:
    """The number of branches of all paths, by the first sample of whole rows of pixels."""
    before, after = _light(film)
    branches, _, met = film.divided.sum(axis=0)
    first = _differences(before, film)
    second = _differences(after / film.branches, film) * film.branches[0]
    lit = second > 0.0
    if not lit.any():
        return int(film.branches[0])
    ratio = np.median(np.divide(second, first, out=np.full(second.shape, np.inf), where=first > 0.0)[lit])
    best = math.sqrt(ratio * COST * branches / met)
    return round(min(max(SPREAD * best, 1.0), MOST_BRANCHES))


def _differences(values: np.ndarray, film: Film) -> np.ndarray:
    """Sums over patches of squared second differences along rows; a slope has none."""
    found = np.diff(values.reshape(film.height, film.width), 2, axis=1) ** 2
    for axis in (0, 1):
        found = np.add.reduceat(found, range(0, found.shape[axis], PATCH), axis=axis) if found.size else found
    return found


@dataclass
class _Noise:
    """Estimates by the samples of a film: ``first`` w D and ``second`` w I of each pixel, ``power``, a, and ``met``, m.

    ``known``: the pixels that have estimates.
    """

    known: np.ndarray
    first: np.ndarray
    second: np.ndarray
    power: float
    met: float


def _noise(film: Film, known: np.ndarray) -> _Noise | None:
    """The estimates by the samples so far; None if nothing is noisy."""
    shape = film.height, film.width
    count, branches = np.maximum(film.count, 1), np.maximum(film.divided[:, 0], 1.0)
    sums, scattered = _light(film)
    before, after = sums / count, scattered / branches
    spread = film.squares - np.stack([sums * before, scattered * after], axis=1)
    variance = np.maximum(spread, 0.0) / np.maximum(count - 1, 1)[:, None]
    whole = before + after
    weight = 1.0 / np.maximum(_around(whole, known, shape, NEXT) ** 2 + FLOOR * np.mean(whole[known]) ** 2, 1e-30)

    first, second = (
        _expected(found * weight, _around(found, known, shape, reach) * weight, known)
        for found, reach in ((variance[:, 0], NEXT), (variance[:, 1], NEAR))
    )
    if not (first.any() or second.any()):
        return None
    power = _power(film, known, sums, variance[:, 0], weight)
    return _Noise(known, first, second, power, film.divided[:, 2].sum() / max(film.divided[:, 0].sum(), 1.0))


def _power(film: Film, known: np.ndarray, sums: np.ndarray, variance: np.ndarray, weight: np.ndarray) -> float:
    """a, by the difference of the samples up to the last update and of as many since. The ``sums`` are kept for the next."""
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


def _expected(found: np.ndarray, told: np.ndarray, known: np.ndarray) -> np.ndarray:
    """(pixels,) means of ``found`` over all other pixels whose neighbours show about the same (``told``)."""
    levels = _levels(told)
    count, total, before = (
        np.bincount(levels[known], values, LOWEST)[levels] for values in (None, found[known], told[known])
    )
    prior = before / np.maximum(count, 1.0)
    return (np.maximum(total - found * known, 0.0) + PRIOR * prior) / (count - known + PRIOR)


def _light(film: Film) -> tuple[np.ndarray, np.ndarray]:
    """(pixels,) sums of R + G + B of all samples: before paths divide, and of branches."""
    return tuple(film.sums[name].reshape(len(film.count), -1)[:, :3].sum(axis=1) for name in ("combined", "scattered"))


def _best(noise: _Noise, count: np.ndarray, samples: int, rates, branches) -> tuple[np.ndarray, np.ndarray]:
    """(pixels,) the best of the given rates and branches; rate 1 is ``samples`` samples, ``count`` are there already."""
    levels = _levels(noise.first), _levels(noise.second)
    kinds, of_pixel, pixels = _alike(*levels, count, noise.known)
    d, i = (2.0 ** (-level / LEVELS) * values.max() for level, values in zip(kinds, (noise.first, noise.second)))
    choices = np.array(list(itertools.product(rates, branches)))
    number = np.maximum(samples * choices[:, :1], kinds[2])
    error = d * number**-noise.power + i / (number * choices[:, 1:])
    time = number * (COST + noise.met * choices[:, 1:])

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
    spread = np.arange(len(of_pixel)) * GOLDEN % 1.0
    return tuple(choices[np.where(spread < part, more[of_pixel], fewer[of_pixel])].T)


def _levels(values: np.ndarray) -> np.ndarray:
    """Logarithms of values below the greatest one, as whole numbers below ``LOWEST``."""
    most = values.max()
    if most <= 0.0:
        return np.zeros(len(values), np.int64)
    return np.rint(-LEVELS * np.log2(np.maximum(values / most, LEAST))).astype(np.int64)


def _alike(first: np.ndarray, second: np.ndarray, count: np.ndarray, known: np.ndarray):
    """Kinds of pixels, (3, kinds) of what is given, the kind of each pixel, and how many known pixels each kind has.

    Counted in tables: to sort millions of pixels would take seconds.
    """
    counts = np.flatnonzero(np.bincount(count))
    keys = (np.searchsorted(counts, count) * LOWEST + first) * LOWEST + second
    found = np.bincount(keys)
    keys_found = np.flatnonzero(found)
    found[keys_found] = range(len(keys_found))
    of_pixel = found[keys]
    kinds = np.stack([keys_found // LOWEST % LOWEST, keys_found % LOWEST, counts[keys_found // LOWEST**2]])
    return kinds, of_pixel, np.bincount(of_pixel, known, len(keys_found))


def _around(values: np.ndarray, known: np.ndarray, shape: tuple[int, int], weights) -> np.ndarray:
    """Means of the known values around each pixel, without its own; 0 where there are none."""
    reach, own = len(weights) // 2, max(weights) ** 2

    def total(each: np.ndarray) -> np.ndarray:
        padded = np.pad(each.reshape(shape), reach)
        rows = sum(weight * padded[place : place + shape[0]] for place, weight in enumerate(weights))
        return sum(weight * rows[:, place : place + shape[1]] for place, weight in enumerate(weights)).ravel()

    values, amount = values * known, known.astype(float)
    amount, values = total(amount) - own * amount, np.maximum(total(values) - own * values, 0.0)
    return np.divide(values, amount, out=np.zeros(len(values)), where=amount > 0.0)
