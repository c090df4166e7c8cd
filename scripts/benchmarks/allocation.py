# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gain of each term of sample allocation and path splitting: error × time without the term, over that with all
terms.

No reference is needed: the error is the variance of renders with different seeds, relative as in ``errors.rel_mse``.
The time is processor time after the first sample begins. All variants take turns, seed by seed. Rare light makes a mean
over pixels depend on the seeds, so there is a second figure, without the noisiest ``OUTLIERS`` of the pixels.
"""

from __future__ import annotations

import functools
import importlib
import math
import statistics
from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import host
import numpy as np

from . import artist_scenes, beside_cycles, errors, indirect_rooms, lamp_scenes, pictures, simple_scenes, some_of
from .resume import in_parts
from .turns import in_turns, stack_of, work_of

HELP = "the gain of each term of sample allocation and path splitting, on scenes with and without lamps"

LAMPS = ("S1", "S2", "S4", "S5", *indirect_rooms.ROOMS)
ORDINARY = ("animation", "street", "forest", "neon_bar", "living_room_night")
QUICK = ("S1", "S4", "animation", "street")
BOUNCES = 4  # of scenes of lamps
SIZE, QUICK_SIZE = 96, 64
SAMPLES, QUICK_SAMPLES = 32, 16
SEEDS, QUICK_SEEDS = 6, 3
OUTLIERS = 1 / 500


def ears(noise, groups, samples: int, rates, branches) -> tuple[np.ndarray, np.ndarray]:
    """As ``sample_allocation._best``, by EARS (Rath et al. 2022, "EARS: efficiency-aware Russian roulette and
    splitting").

    The splitting factor is √(I / m) · √(T / V). T and V are the mean time and the mean variance of a sample of the
    whole picture. Both depend on the factors, so this is a fixed point. All pixels take the same number of samples.
    """
    count = np.ones(len(noise.first))
    for _ in range(64 if len(branches) > 1 else 0):
        time = noise.cost + noise.met * count[noise.known].mean()
        variance = (noise.first + noise.second / count)[noise.known].mean()
        factor = np.sqrt(noise.second / max(noise.met, 1e-9) * time / max(variance, 1e-30))
        count = np.clip(factor, 1.0, branches[-1])
    return np.ones(len(count)), np.rint(count)


# The terms that are switched off or replaced, and their text in the document: settings of the scene, or values of
# modules.
ALL = "all"
NEIGHBOURS, NEAR, FAR = (tuple(map(float, np.poly1d((1, 1)) ** (2 * reach))) for reach in (1, 2, 4))
TERMS: dict[str, tuple[str, dict, dict]] = {
    "splitting": ("paths do not divide", dict(indirect_paths=1), {}),
    "guidance": ("all pixels take the same number of samples", dict(guided_samples=False), {}),
    "both": ("neither", dict(indirect_paths=1, guided_samples=False), {}),
    "power": ("noise is taken to fall as that of independent samples", {}, dict(MOST_POWER=1.0)),
    "first_rows": (
        "paths divide by a constant until samples scatter",
        {},
        dict(first_pixels=lambda film, settings: None),
    ),
    "gains": ("both as soon as they promise anything", {}, dict(SPLITTING_GAIN=1.0, GUIDANCE_GAIN=1.0)),
    "cut_cost": ("the boxes of lamps count as no time", {}, dict(CUT_COST=0.0)),
    "telling": ("no pixel divides only to show how branches scatter", {}, dict(PROBE_FRACTION=0.0)),
    "rates": ("pixels take from half to twice the set number of samples", {}, dict(MOST_RATE=2.0)),
    "neighbours": ("only the eight nearest neighbours count", {}, dict(NEAR=NEIGHBOURS, FAR=NEIGHBOURS)),
    "survival": ("Russian roulette may end branches with any probability", {}, dict(LEAST_SURVIVAL=0.0)),
    "no_roulette": ("no Russian roulette of branches", {}, dict(LEAST_SURVIVAL=math.inf)),
    "connections": ("connections to light paths count as no time", {}, dict(CONNECTION_COST=0.0, WEIGHTS_COST=0.0)),
    "connected_left": ("what connections estimate may end any branch", {}, dict(LEAST_PATH_WEIGHT=0.0)),
    "cost": ("what a sample costs beside branches and boxes counts as no time", {}, dict(COST=0.0)),
    "least_rate": ("pixels take a quarter of the set number of samples or more", {}, dict(LEAST_RATE=0.25)),
    "floor": ("errors are relative to a floor that is five times as high", {}, dict(FLOOR=0.05)),
    "far": ("brightness of the 24 nearest neighbours, not of 80", {}, dict(FAR=NEAR)),
    "near": ("noise of branches of the 80 nearest neighbours, not of 24", {}, dict(NEAR=FAR)),
    "patch": ("patches of two pixels", {}, dict(PATCH=2)),
    "bands": ("a quarter of the rows first", {}, dict(BANDS=4)),
    "light_paths": ("no light paths", dict(lamp_paths="NEVER"), {}),
    "path_reuse": ("no path reuse", dict(path_reuse="NEVER"), {}),
    "neither": ("no light paths, and no path reuse", dict(lamp_paths="NEVER", path_reuse="NEVER"), {}),
    "shared_limit": ("paths divide by one limit, be they reused or not", {}, dict(SHARED_GAIN=0.8)),
    "shared_noise": ("branches that groups share are as noisy as within a pixel", {}, dict(SHARED_NOISE=1.0)),
    "every_point": ("all points of a group share each surface that branches find", {}, dict(MOST_TIME=math.inf)),
    "few_points": ("an eighth of the points share surfaces that are not diffuse", {}, dict(MOST_TIME=0.0)),
    "one_connection": ("one connection for each branch", {}, dict(CONNECTIONS=1)),
    "eight_connections": ("eight connections for each branch", {}, dict(CONNECTIONS=8)),
    "fewer_paths": ("half as many light paths", {}, dict(SHARED=16)),
    "coarse_tree": ("an eighth of the light paths for the tree", {}, dict(TREE_SHARED=8)),
    "first_update": ("the first decision after four samples, not after two", {}, dict(FIRST_UPDATE=4)),
    "levels": ("the noise of pixels has 9 powers of two, not 25", {}, dict(LEAST=2.0**-8, LEVELS=9)),
    "hidden_parts": ("hidden parts of lamps get as many light rays as others", {}, dict(LEAST_HIDDEN=math.inf)),
    "ears": (
        "splitting as in EARS (Rath et al. 2022), the same number of samples for all pixels",
        dict(guided_samples=False),
        dict(_best=ears, SPLITTING_GAIN=math.inf),
    ),
    "two_halves": (
        "adaptive sampling by two halves, as in Cycles (Dammertz et al. 2010), with a noise threshold of 0.05",
        dict(guided_samples=False, noise_threshold=0.05),
        {},
    ),
}


# The settings that terms change, for all others.
DEFAULTS = dict(
    indirect_paths=0, guided_samples=True, noise_threshold=0.0, lamp_paths="AUTOMATIC", path_reuse="AUTOMATIC"
)
# Modules whose values are replaced where they stand.
OWNERS = ("render.sample_allocation", "render.cpu.light_paths", "render.cpu.path_reuse", "emitter.sampling.hidden")
DOCUMENT = host.REPOSITORY / "docs" / "sampling.md"
BEGIN, END = "<!-- allocation -->", "<!-- end of allocation -->"


def arguments(parser) -> None:
    known = [*LAMPS, *ORDINARY]
    parser.add_argument("--document-allocation", action="store_true", help="write the table of docs/sampling.md")
    parser.add_argument(
        "--only", type=some_of(known), metavar="SCENES", help=f"with commas between: {', '.join(known)}"
    )
    parser.add_argument("--terms", type=some_of(TERMS), metavar="TERMS", help=f"of {', '.join(TERMS)}")


@contextmanager
def _without(values: dict) -> Iterator[None]:
    """The program with other values for these names in the modules of ``OWNERS``, or in ``path_splitting``."""
    splitting, renderer = host.program("render.cpu.path_splitting"), host.program("render.cpu.renderer")
    constants = {name: value for name, value in values.items() if hasattr(splitting, name)}
    owners = {name: _owner(name) for name in values if name not in constants}
    kept = {name: getattr(owner, name) for name, owner in owners.items()}
    try:
        for name, owner in owners.items():
            setattr(owner, name, values[name])
        if constants:
            renderer.render_tile = _tile(splitting, tuple(sorted(constants.items())))
        yield
    finally:
        for name, value in kept.items():
            setattr(owners[name], name, value)
        renderer.render_tile = splitting.render_tile


def _owner(name: str):
    """The module of ``OWNERS`` that has this name."""
    return next(module for module in map(host.program, OWNERS) if hasattr(module, name))


@functools.cache
def _tile(splitting, constants: tuple[tuple[str, float], ...]):
    """``render_tile`` of ``path_splitting`` with other constants."""
    jit, names = importlib.import_module("...jit", splitting.__package__), dict(constants)
    suffix = "_".join(f"{name}_{value}" for name, value in constants)
    roulette = jit.specialised(splitting.roulette_branches, f"roulette_branches_{suffix}", **names)
    branches = jit.specialised(
        splitting.trace_branches, f"trace_branches_{suffix}", roulette_branches=roulette, **names
    )
    return jit.specialised(splitting.render_tile, f"render_tile_{suffix}", trace_branches=branches)


def build(name: str, size: int) -> bpy.types.Scene:
    """A scene of lamps or of artists, of this name."""
    if name in indirect_rooms.ROOMS:
        return indirect_rooms.build(name, size)
    if name not in lamp_scenes.SCENES:
        return artist_scenes.build(name, size)
    lamp_scenes.SCENES[name].build(size)
    lamp_scenes.show()
    return bpy.context.scene


def _render(name: str, scene, term: str, samples: int, seed: int, device: str) -> pictures.Picture:
    if name in ORDINARY:
        beside_cycles.settings(scene, beside_cycles.GUIDED, samples, seed, device)
    else:
        simple_scenes.plain_sdf_lights(scene, samples, BOUNCES, device)
        scene.sdf_lights.seed = seed
    chosen, values = TERMS[term][1:] if term != ALL else ({}, {})
    for setting, value in (DEFAULTS | chosen).items():
        setattr(scene.sdf_lights, setting, value)
    with _without(values):
        return pictures.render()


def measure(name: str, terms: list[str], options) -> list[dict]:
    """A row for each term, of one scene."""
    scene = build(name, QUICK_SIZE if options.quick else SIZE)
    samples = QUICK_SAMPLES if options.quick else SAMPLES
    seeds = options.repeats or (QUICK_SEEDS if options.quick else SEEDS)
    variants = [ALL, *terms]
    for variant in variants:
        _render(name, scene, variant, 1, 0, options.device)  # compiles, and fills caches
    start = statistics.median(_render(name, scene, "both", 1, 0, options.device).work for _ in range(3))
    made = in_turns(
        variants, range(max(seeds, 2)), lambda term, seed: _render(name, scene, term, samples, seed, options.device)
    )
    stacks = {term: stack_of(pile) for term, pile in made.items()}
    work = {term: max(work_of(pile) - start, 1e-6) for term, pile in made.items()}
    return [dict(allocation_scene=name, without=term) | gain for term, gain in gains_of(stacks, work).items()]


def gains_of(stacks: dict[str, np.ndarray], work: dict[str, float]) -> dict[str, dict[str, float]]:
    """The gain of each term, from pictures (seeds, height, width, channels) and seconds of each variant, ALL among
    them.

    ``gain``: error × time without the term, over that with all; ``gain_of_most``: without the noisiest pixels; ``time``
    alone.
    """
    mean = np.mean([stack.mean(axis=0) for stack in stacks.values()], axis=0)
    floor = mean**2 + errors.FLOOR * mean.mean() ** 2
    costs = {}
    for term, stack in stacks.items():
        noise = np.sort((stack.var(axis=0, ddof=1) / floor).mean(axis=2).ravel())
        most = noise[: len(noise) - max(int(OUTLIERS * len(noise)), 1)]
        costs[term] = np.array([noise.mean(), most.mean(), 1.0]) * work[term]
    return {
        term: dict(zip(("gain", "gain_of_most", "time"), (costs[term] / costs[ALL]).tolist()))
        for term in stacks
        if term != ALL
    }


def summary_of(rows: list[dict]) -> dict:
    """Geometric means by term, of scenes of lamps and of others, and the least of all; of all pixels but the
    noisiest."""
    summary = {}
    for term in TERMS:
        for kind, names in (("lamps", LAMPS), ("ordinary", ORDINARY)):
            gains = [r["gain_of_most"] for r in rows if r["without"] == term and r["allocation_scene"] in names]
            if gains:
                summary[f"{term}_gain_{kind}_geomean"] = statistics.geometric_mean(gains)
                summary[f"{term}_gain_{kind}_min"] = min(gains)
    return summary


def document(rows: list[dict]) -> None:
    """Write the table of docs/sampling.md."""
    scenes = list(dict.fromkeys(row["allocation_scene"] for row in rows))
    found = {(row["without"], row["allocation_scene"]): row for row in rows}
    lines = [f"| switched off | {' | '.join(scenes)} |", "|---" * (len(scenes) + 1) + "|"]
    for term, (text, _, _) in TERMS.items():
        cells = [found.get((term, scene)) for scene in scenes]
        if any(cells):
            shown = (f"{row['gain_of_most']:.2f} ({row['gain']:.2f})" if row else "" for row in cells)
            lines.append(f"| `{term}`: {text} | {' | '.join(shown)} |")
    before, _, rest = DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    DOCUMENT.write_text("\n".join([before + BEGIN, *lines, END]) + after, encoding="utf-8")


def run(options) -> tuple[dict, list[dict]]:
    names = options.only or list(QUICK if options.quick else (*LAMPS, *ORDINARY))
    terms = options.terms or list(TERMS)
    found = in_parts(names, lambda name: measure(name, terms, options), options)
    rows = [row for part in found for row in part]
    if options.document_allocation:
        document(rows)
    return summary_of(rows), rows
