# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether rays find every entry and exit, at what cost, and how the cost grows with the number of parts.

Every shape and every hard case of the tests is traced like a lamp, and judged by the tests' oracle: an independent
march through the whole formula, with steps 100 times finer than those of a coarse march. The published rule and plain
sphere tracing march through the same compiled field, with two shortest steps: that of a coarse march, and the
resolution at which our own search stops. All locate their zeros by the same bracketing, so only the search differs.
"""

from __future__ import annotations

import functools
import math
import statistics
import time

import numpy as np

from .progress import Progress
from .resume import Parts

HELP = "crossings of rays: wrong counts, evaluations and time, against the published rule and sphere tracing"

RAYS = 1_000_000  # of all certified cases together
QUICK_RAYS = 20_000
COARSE = 1e-3  # shortest step of a march, relative to the shape's size
MARCHED = 1000  # rays of each case that the other rules march along too
SIZES = (1, 3, 10, 30, 100, 300, 1000)
SIZE_OF_10 = 0.42  # of primitives in a cube of half size 1
SPREADS = {"as many on a ray": -1.0 / 2.0, "as dense": -1.0 / 3.0}  # exponents of the number
TURNS = 3


def _cases(quick: bool) -> dict:
    """Name -> (shape, function that draws rays, whether its field is smooth)."""
    from support.lamps.hard_cases import HARD_CASES, around
    from support.shapes.samples import SHAPES_TO_TRY

    bounded = [(name, shape) for name, shape in SHAPES_TO_TRY.items() if shape.bounded]
    cases = {name: (shape, around, False) for name, shape in bounded[:: 5 if quick else 1]}
    return cases | {name: (case.shape, case.rays, case.smooth) for name, case in HARD_CASES.items()}


def _seconds(function, turns: int):
    """Result of a function, and the median of its processor seconds, after a warm-up turn."""
    taken = []
    for _ in range(turns + 1):
        started = time.thread_time()
        result = function()
        taken.append(time.thread_time() - started)
    return result, statistics.median(taken[1:])


def judged(name: str, shape, rays, smooth: bool, count: int, turns: int) -> dict:
    """One row: a shape traced like a lamp, and the other rules if it is a field."""
    from sdf_lights.emitter.intersection.cover import RESOLUTION
    from support.lamps import oracle
    from support.lamps.rays import Traced
    from support.lamps.shapes_under_test import FieldOf
    from support.rivals import marching

    origins, directions = rays(shape, np.random.default_rng(5), count)
    traced = Traced(shape)
    found = traced.trace(origins, directions)
    truth = oracle.find(shape, origins, directions)
    if not truth.counts.any():
        raise ValueError(f"{name}: no ray meets it, so there is nothing to judge")
    verdict = oracle.judge(shape, origins, directions, found[:, 0].astype(int), found[:, 1], truth)
    few = slice(0, min(MARCHED, count))
    field = traced if traced.tree.field is not None else Traced(FieldOf(shape))
    _, seconds = _seconds(lambda: traced.trace(origins[few], directions[few]), turns)
    ours, field_seconds = _seconds(lambda: field.trace(origins[few], directions[few]), turns)
    rays_marched = len(ours)
    row = dict(
        case=name,
        certified=shape.certified and traced.tree.certified,
        smooth=smooth,
        method="field" if field is traced else "closed form",
        rays=count,
        wrong=float(verdict.wrong),
        too_fine_to_judge=float(verdict.below),
        length_error=verdict.length_error,
        unresolved=float(found[:, 2].sum() / max(found[:, 1].sum(), 1e-300)),
        ns=1e9 * seconds / rays_marched,
        field_ns=1e9 * field_seconds / rays_marched,
        evaluations=float(ours[:, 3].mean()),
    )
    # The two rules need a bound for all of space. The published one uses none, and treats the field as a distance.
    lipschitz = oracle.steepness(shape)
    truth = oracle.find(shape, origins[few], directions[few])
    rules = (
        ("published", marching.PUBLISHED, RESOLUTION),
        ("published_coarse", marching.PUBLISHED, COARSE),
        ("spheres", marching.SPHERES, RESOLUTION),
    )
    for label, rule, least in rules:
        marched, marched_seconds = _seconds(
            lambda: field.march(rule, origins[few], directions[few], least, lipschitz), turns
        )
        verdict = oracle.judge(shape, origins[few], directions[few], marched[:, 0].astype(int), marched[:, 1], truth)
        row |= {
            f"{label}_wrong": float(verdict.wrong),
            f"{label}_evaluations": float(marched[:, 2].mean()),
            f"{label}_ns": 1e9 * marched_seconds / rays_marched,
        }
    return row


def growth(turns: int, count: int) -> list[dict]:
    """Cost of a ray through n primitives spread in a cube, sharp and smooth, traced in turns.

    From 10 on they shrink as n^(-1/2), so that a ray meets equally many of them; or as n^(-1/3), so that they fill the
    same part of the cube, and a ray meets more and more of them.
    """
    from support.lamps.hard_cases import scattered, towards
    from support.lamps.rays import Traced

    rng = np.random.default_rng(7)
    directions = rng.normal(size=(count, 3))
    origins = 4.0 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    origins, directions = towards(origins, rng.uniform(-1.0, 1.0, (count, 3)))
    keys = [(spread, smooth, n) for spread in SPREADS for smooth in (False, True) for n in SIZES]
    built = {
        (spread, smooth, n): Traced(scattered(n, smooth=smooth, size=SIZE_OF_10 * (0.1 * n) ** SPREADS[spread]))
        for spread, smooth, n in keys
    }
    seconds = {key: [] for key in keys}
    intervals, evaluations = {}, {}
    for _ in range(turns + 1):
        for key, traced in built.items():
            started = time.thread_time()
            found = traced.trace(origins, directions)
            seconds[key].append(time.thread_time() - started)
            intervals[key], evaluations[key] = found[:, 0].mean(), found[:, 3].mean()
    return [
        dict(
            spread=key[0],
            operation="smooth union" if key[1] else "union",
            primitives=key[2],
            ns_per_ray=1e9 * statistics.median(seconds[key][1:]) / count,
            intervals=float(intervals[key]),
            evaluations=float(evaluations[key]),
        )
        for key in keys
    ]


def run(options) -> tuple[dict, list[dict]]:
    turns = options.repeats or (1 if options.quick else TURNS)
    cases = _cases(options.quick)
    total = QUICK_RAYS if options.quick else RAYS
    certified = sum(shape.certified for shape, _, _ in cases.values())
    count = math.ceil(total / certified)
    # The growth takes as long as a tenth of the cases.
    progress, parts, rows = Progress(math.ceil(1.1 * len(cases))), Parts(options), []
    for name, (shape, rays, smooth) in cases.items():
        progress.show(name)
        rows.append(parts.of(name, functools.partial(judged, name, shape, rays, smooth, count, turns)))
        progress.step()
    sure = [row for row in rows if row["certified"]]
    smooth = [row for row in rows if row["smooth"]]

    def ratio(rule: str) -> float:
        return math.exp(statistics.fmean(math.log(row[f"{rule}_evaluations"] / row["evaluations"]) for row in smooth))

    missed = [row["wrong"] for row in rows if row["published_wrong"] > 0.0 and row["certified"]]
    progress.show("growth with the number of primitives")
    curve = parts.of("growth", functools.partial(growth, turns, 1000 if options.quick else 10_000))
    parts.finish()
    progress.close()
    cost = {(row["spread"], row["operation"], row["primitives"]): row["ns_per_ray"] for row in curve}

    def growth_of(spread: str) -> float:
        return max(cost[spread, kind, 1000] / cost[spread, kind, 10] for kind in ("union", "smooth union"))

    summary = dict(
        rays_certified=sum(row["rays"] for row in sure),
        wrong_crossing_fraction_certified=sum(row["wrong"] * row["rays"] for row in sure)
        / sum(row["rays"] for row in sure),
        too_fine_to_judge_fraction_certified=sum(row["too_fine_to_judge"] * row["rays"] for row in sure)
        / sum(row["rays"] for row in sure),
        wrong_crossing_fraction_not_certified=max((row["wrong"] for row in rows if not row["certified"]), default=0.0),
        wrong_crossing_fraction_where_published_misses=max(missed, default=0.0),
        cases_where_published_misses=len(missed),
        evaluations_ratio_paper_to_ours=ratio("published"),
        evaluations_ratio_coarse_paper_to_ours=ratio("published_coarse"),
        evaluations_ratio_spheres_to_ours=ratio("spheres"),
        cost_ratio_1000_to_10_nodes=growth_of("as many on a ray"),
        cost_ratio_1000_to_10_nodes_as_dense=growth_of("as dense"),
    )
    return summary, rows + curve
