# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders of variants that take turns, so that other work on the machine disturbs all of them alike."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field

import numpy as np

from . import pictures

MOST_SAMPLES = 1 << 15  # of a pixel

Made = dict[Hashable, list[pictures.Picture]]


def in_turns(variants: Iterable, seeds: Iterable[int], render: Callable[..., pictures.Picture]) -> Made:
    """Pictures ``render(variant, seed)`` of each variant, seed after seed."""
    made: Made = {variant: [] for variant in variants}
    for seed in seeds:
        for variant, pile in made.items():
            pile.append(render(variant, seed))
    return made


def stack_of(pile: list[pictures.Picture]) -> np.ndarray:
    """Pixels (seeds, height, width, channels)."""
    return np.array([picture.pixels for picture in pile])


def work_of(pile: list[pictures.Picture]) -> float:
    """Median of processor seconds."""
    return statistics.median(picture.work for picture in pile)


@dataclass
class Rate:
    """Seconds of additional ``samples``, turn by turn; those of the very first render, which compiles; and the mean of
    the last picture."""

    samples: int
    first: float = 0.0
    seconds: list[float] = field(default_factory=list)
    mean: float = 0.0

    def per_second(self, pixels: int, of: Callable = statistics.median) -> float:
        """Samples a second of all pixels; ``of`` chooses among the turns."""
        return pixels * self.samples / max(of(self.seconds), 1e-9)


def rates(
    engines: Iterable[str],
    few: int,
    many: int,
    repeats: int,
    render: Callable[..., pictures.Picture],
    seconds: float = 0.0,
) -> dict[str, Rate]:
    """The rate of each engine: ``render(engine, samples)`` of few and many samples, in turns. A first turn compiles and
    fills caches; it does not count. An engine that is so fast that the additional samples take less than ``seconds``
    takes more of them."""
    found = {engine: Rate(many - few) for engine in engines}
    for turn in range(repeats + 1):
        for engine, rate in found.items():
            while True:
                short, long = (render(engine, samples) for samples in (few, few + rate.samples))
                rate.first = rate.first or short.seconds
                taken = long.seconds - short.seconds
                if turn or taken >= seconds or rate.samples >= MOST_SAMPLES:
                    break
                rate.samples *= 4
            rate.mean = float(long.pixels.mean())
            if turn:
                rate.seconds.append(taken)
    return found
