# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes by both engines: which pictures differ by more than noise, and which features make them differ.

``--trees``: random node trees instead, whose value is the light of an object, so that there is no noise.
``--closures``: random shaders instead, on lit balls.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from . import node_pictures, node_scenes, pictures, random_nodes, random_scenes
from .node_pictures import CYCLES, ENGINES
from .progress import Progress

TOGETHER = 64  # node trees in one picture
TREE_SIZE, TREE_SAMPLES = 24, 4
CLOSURE_SIZE, CLOSURE_SAMPLES, CLOSURES_TOGETHER = 32, 128, 25
PIXEL = 0.01  # change of a pixel that counts, from black (0) over its median (0.5) to white (1)
JUMPS = 3.0  # factor on the change of our own picture when its rays move by a hundredth of a pixel
PIXELS = 0.01  # part of the pixels that may change

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
    command.add_argument("--trees", type=int, help="compare so many random node trees, instead of scenes")
    command.add_argument("--closures", type=int, help="compare so many random shaders on balls, instead of scenes")
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


def _built(cases: list, size: int) -> tuple:
    """The grid of the tiles of these cases, and a scene that shows it."""
    grid = node_scenes.grid_of(cases, size)
    scene, problems = node_scenes.build(grid)
    if problems:
        raise RuntimeError(f"these nodes cannot be built: {problems}")
    return grid, scene


def tree_rows(seeds: range, device: str) -> list[dict]:
    """Rows of the random node trees of these seeds, in one picture: the part of their pixels that differ, but for those
    beside jumps."""
    cases = [random_nodes.case(seed) for seed in seeds]
    grid, scene = _built(cases, TREE_SIZE)
    made = {}
    for engine in ENGINES:
        node_scenes.settings(scene, engine, TREE_SAMPLES, 0, False, device)
        made[engine] = pictures.render().pixels
    theirs, ours = made.pop(CYCLES), *made.values()
    steps = ((1, 0), (-1, 0), (0, 1), (0, -1))
    moved = [node_pictures.moved(scene, step) for step in steps]
    rows = []
    for index, case in enumerate(cases):
        given = grid.tile(theirs, index)
        scale = max(float(np.median(np.abs(given))), 1e-3)
        shown, own, *others = (_squashed(grid.tile(picture, index), scale) for picture in (theirs, ours, *moved))
        change = np.max([np.abs(other - own) for other in others], axis=0)
        beyond = np.abs(own - shown) - JUMPS * change > PIXEL
        rows.append(dict(tree_seed=case.seed, different_pixels=float(beyond.any(-1).mean())))
    return rows


def closure_rows(seeds: range, device: str) -> list[dict]:
    """Rows of the random shaders of these seeds, on balls in one picture."""
    cases = [random_nodes.closure_case(seed) for seed in seeds]
    grid, scene = _built(cases, CLOSURE_SIZE)
    made = {}
    for engine in ENGINES:
        node_scenes.settings(scene, engine, CLOSURE_SAMPLES, node_pictures.BOUNCES, True, device)
        stack = []
        for number in range(SEEDS):
            scene.cycles.seed = scene.sdf_lights.seed = number + 1
            stack.append(pictures.render().pixels)
        made[engine] = stack
    theirs, ours = made.pop(CYCLES), *made.values()
    rows = []
    for index, case in enumerate(cases):
        found = difference_of(*(np.array([grid.tile(picture, index) for picture in stack]) for stack in (theirs, ours)))
        rows.append(
            dict(
                closure_seed=int(case.seed),
                mean=found.mean,
                errors=found.errors,
                block=found.block,
                block_errors=found.block_errors,
                differs=bool(found.is_beyond_noise),
            )
        )
    return rows


def _squashed(picture: np.ndarray, scale: float) -> np.ndarray:
    """Values between −1 and 1, so that very large ones do not hide others; what is no number is black."""
    given = np.where(np.isfinite(picture), picture, 0.0)
    return given / (np.abs(given) + scale)


def summary_of(rows: list[dict]) -> dict:
    """``fuzz_scenes``, ``fuzz_trees`` or ``fuzz_closures``; ``fuzz_beyond_noise``: how many of them differ."""
    if rows and "tree_seed" in rows[0]:
        return dict(fuzz_trees=len(rows), fuzz_beyond_noise=sum(row["different_pixels"] > PIXELS for row in rows))
    if rows and "closure_seed" in rows[0]:
        return dict(fuzz_closures=len(rows), fuzz_beyond_noise=sum(row["differs"] for row in rows))
    return dict(fuzz_scenes=len(rows), fuzz_beyond_noise=sum(bool(row["features"]) for row in rows))


def run(options: argparse.Namespace) -> tuple[dict, list[dict]]:
    if options.trees:
        rows = _together("trees", options.trees, TOGETHER, tree_rows, options)
        return summary_of(rows), rows
    if options.closures:
        rows = _together("shaders", options.closures, CLOSURES_TOGETHER, closure_rows, options)
        return summary_of(rows), rows
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


def _together(what: str, count: int, most: int, rows_of: Callable, options: argparse.Namespace) -> list[dict]:
    """Rows of ``count`` seeds, of which at most ``most`` are in one picture."""
    progress, rows = Progress(count), []
    for first in range(options.first, options.first + count, most):
        seeds = range(first, min(first + most, options.first + count))
        progress.show(f"{what} {seeds.start} to {seeds.stop - 1}")
        rows += rows_of(seeds, options.device)
        for _ in seeds:
            progress.step()
    progress.close()
    return rows
