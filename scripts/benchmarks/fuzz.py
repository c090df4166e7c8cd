# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes by both engines: which pictures differ by more than noise, and which features make them differ."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

import bpy
import numpy as np

from . import pictures, random_scenes
from .node_pictures import CYCLES, ENGINES
from .progress import Progress

HELP = "random scenes beside Cycles: pictures that differ by more than noise"
FIRST, SCENES, QUICK_SCENES = 0, 100, 4
SIZE, SAMPLES, SEEDS = 48, 64, 4
BLOCK = 8  # pixels a side
MEAN, DOUBT, BLOCK_DOUBT = 0.01, 4.0, 7.0  # see ``Difference.is_beyond_noise``
KNOWN = 0.01  # part of the brightness of a block that is allowed besides noise
BRIGHTEST = 2.0  # pixels count up to so many times the 99th percentile: fireflies decide nothing


@dataclass(frozen=True)
class Difference:
    """Of two engines' pictures: the mean's, relative, and in standard errors; and that of the worst block."""

    mean: float
    errors: float
    block: float
    block_errors: float

    @property
    def is_beyond_noise(self) -> bool:
        return abs(self.mean) > MEAN and abs(self.errors) > DOUBT or abs(self.block_errors) > BLOCK_DOUBT


def difference_of(theirs: np.ndarray, ours: np.ndarray) -> Difference:
    """Of pictures (seeds, height, width, channels) of two engines, whose sides are multiples of ``BLOCK``."""
    most = max(BRIGHTEST * np.quantile(theirs.mean(0), 0.99), 1e-3)
    theirs, ours = np.minimum(theirs, most), np.minimum(ours, most)
    seeds, height, width, channels = theirs.shape
    shape = seeds, height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels
    blocks = [picture.reshape(shape).mean((2, 4)) for picture in (theirs, ours)]
    means = [picture.mean((1, 2, 3)) for picture in (theirs, ours)]
    brightness = max(float(means[0].mean()), 1e-9)
    change = float(means[1].mean() - means[0].mean())
    variance = sum(part.var(ddof=1) for part in means) / seeds + (1e-4 * brightness) ** 2
    scatter = sum(part.var(0, ddof=1) for part in blocks) / seeds
    scale = blocks[0].mean(0) + 0.05 * brightness
    changes = blocks[1].mean(0) - blocks[0].mean(0)
    # A block of few bright samples does not know its own variance.
    doubts = changes / np.sqrt(np.maximum(scatter, np.median(scatter)) + (KNOWN * scale) ** 2)
    worst = np.unravel_index(np.abs(doubts).argmax(), doubts.shape)
    return Difference(
        change / brightness, change / variance**0.5, float((changes / scale)[worst]), float(doubts[worst])
    )


def arguments(command: argparse.ArgumentParser) -> None:
    command.add_argument("--first", type=int, default=FIRST, help=f"seed of the first scene (default: {FIRST})")
    command.add_argument("--scenes", type=int, help=f"number of scenes (default: {SCENES}; --quick: {QUICK_SCENES})")
    command.add_argument("--reduce", action="store_true", help="leave out features for as long as pictures differ")


def measure(seed: int, device: str, without: frozenset[str] = frozenset()) -> tuple[Difference, list[str]]:
    """The difference of the scene of this ``seed``, and its features."""
    choices = random_scenes.build(seed, SIZE, SAMPLES, device, without)
    scene, made = bpy.context.scene, {}
    for engine in ENGINES:
        scene.render.engine = engine
        stack = []
        for number in range(SEEDS):
            scene.cycles.seed = scene.sdf_lights.seed = number + 1
            stack.append(pictures.render().pixels)
        made[engine] = np.array(stack)
    theirs = made.pop(CYCLES)
    return difference_of(theirs, *made.values()), choices.names


def reduced(seed: int, device: str, names: list[str]) -> list[str]:
    """Few of the features ``names`` with which the pictures of the scene still differ by more than noise."""
    without: frozenset[str] = frozenset()
    # Whole objects first: their features go with them.
    for name in sorted(names, key=lambda name: not name.startswith(("thing", "light"))):
        if measure(seed, device, without | {name})[0].is_beyond_noise:
            without |= {name}
    return measure(seed, device, without)[1]


def row_of(seed: int, options: argparse.Namespace) -> dict:
    found, names = measure(seed, options.device)
    if found.is_beyond_noise and options.reduce:
        names = reduced(seed, options.device, names)
    return dict(
        fuzz_seed=seed,
        mean=found.mean,
        errors=found.errors,
        block=found.block,
        block_errors=found.block_errors,
        features=", ".join(names) if found.is_beyond_noise else "",
    )


def summary_of(rows: list[dict]) -> dict:
    """``fuzz_scenes``; ``fuzz_beyond_noise``: how many of them differ."""
    return dict(fuzz_scenes=len(rows), fuzz_beyond_noise=sum(bool(row["features"]) for row in rows))


def run(options: argparse.Namespace) -> tuple[dict, list[dict]]:
    count = options.scenes or (QUICK_SCENES if options.quick else SCENES)
    progress, rows = Progress(count), []
    for seed in range(options.first, options.first + count):
        progress.show(f"scene {seed}")
        rows.append(row_of(seed, options))
        progress.step()
        if rows[-1]["features"]:
            print(f"scene {seed}: {rows[-1]['features']}", file=sys.stderr)
    progress.close()
    return summary_of(rows), rows
