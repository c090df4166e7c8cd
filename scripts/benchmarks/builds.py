# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The time to build a lamp after a number of its shape has changed.

This includes everything except the compilation of a formula, which depends on no number: the shape's formula and
bounds, the interior tree with the bounds of slopes, the volume with its certain limits, and the bounds tightened by the
tree. Each turn changes the shape by some millionths, so cached data of the shape is useless. Times are wall-clock
times, medians of the turns.
"""

from __future__ import annotations

import dataclasses
import statistics
import time

import numpy as np

from .resume import in_parts

HELP = "milliseconds to build a lamp of every primitive and fractal, of 20 parts, and of the worked examples"

TURNS = 7
CHANGE = 1e-6  # relative, from turn to turn
PARTS = 20
KINDS = ("primitive", "csg_20", "fractal", "example")


def changed(shape, factor: float):
    """The shape with its first free number multiplied by a factor close to 1."""
    for about in shape.fields():
        if not about.whole:
            value = getattr(shape, about.name)
            value = tuple(factor * v for v in value) if about.size == 3 else factor * value
            found = dataclasses.replace(shape, **{about.name: value})
            if not found.validate():
                return found
    raise ValueError(f"{shape.label()} has no number to change.")


def _cases() -> list[tuple[str, str, object]]:
    """Kind, name, and a function from the factor of a turn to a shape."""
    from sdf_lights.sdf.examples import examples
    from sdf_lights.sdf.expression import Expression
    from sdf_lights.sdf.shapes import Difference, Exclusive, Transformed, Union, fractals, orbits
    from sdf_lights.sdf.shapes.blends import SmoothDifference, SmoothUnion
    from support.lamps.hard_cases import scattered
    from support.shapes.samples import PRIMITIVES

    of_fractals = (fractals.__name__, orbits.__name__)
    cases = [
        (
            "fractal" if type(shape).__module__ in of_fractals else "primitive",
            name,
            lambda factor, shape=shape: changed(shape, factor),
        )
        for name, shape in PRIMITIVES.items()
        if shape.bounded
    ]

    def parts(factor):
        return scattered(PARTS, smooth=False, size=0.9 * PARTS ** (-1.0 / 3.0) * factor).children

    def mixed(factor):
        """A difference of smooth unions and sharp ones."""
        all_parts = parts(factor)
        return Difference(
            SmoothUnion(*all_parts[:10], radius=0.1),
            Union(*all_parts[10:15]),
            SmoothUnion(*all_parts[15:], radius=0.05),
        )

    operations = {
        "union": lambda factor: Union(*parts(factor)),
        "smooth union": lambda factor: SmoothUnion(*parts(factor), radius=0.1),
        "difference": lambda factor: Difference(changed(PRIMITIVES["box"], factor), *parts(factor)[1:]),
        "smooth difference": lambda factor: SmoothDifference(
            changed(PRIMITIVES["box"], factor), *parts(factor)[1:], radius=0.05
        ),
        "exclusive": lambda factor: Exclusive(*parts(factor)),
        "mixed": mixed,
    }
    cases += [("csg_20", f"{name} of {PARTS}", make) for name, make in operations.items()]
    cases += [
        (
            "example",
            name,
            lambda factor, shape=Expression(example.text).shape(): Transformed(
                shape, np.diag([factor, factor, factor, 1.0])
            ),
        )
        for name, example in examples().items()
    ]
    return cases


def _built(shape) -> dict:
    """Milliseconds of one build, and its results."""
    from sdf_lights.emitter.building import build
    from sdf_lights.emitter.tree import interior, volume

    interior.tree.cache_clear()
    build.volume_of.cache_clear()
    started = time.perf_counter()
    tree = interior.tree(shape)
    grown = time.perf_counter()
    lamp = build.build_lamp("Lamp", shape, np.eye(4))
    ended = time.perf_counter()
    exact = shape.volume()
    found = volume.measure(tree) if exact is None else volume.Volume(exact, 0.0, exact, exact)
    low, high = shape.bounds()
    return dict(
        ms=1e3 * (ended - started),
        tree_ms=1e3 * (grown - started),
        boxes=len(tree.nodes),
        volume=found.value,
        error=found.error / found.value,
        certain_low=found.low,
        certain_high=found.high,
        fill=float(found.value / tree.nodes["mass"][0]),
        tightened=float(np.prod(2.0 * lamp.row["half"][0]) / np.prod(high - low)),
    )


def measure(kind: str, name: str, make, turns: int) -> dict:
    """A row: the last build of a case, with medians of the times."""
    made = [_built(make(1.0 + CHANGE * turn)) for turn in range(turns + 1)][1:]  # the first may compile
    times = {key: statistics.median(one[key] for one in made) for key in ("ms", "tree_ms")}
    return dict(kind=kind, built=name) | made[-1] | times


def bounds_of_gradients(turns: int) -> dict:
    """Milliseconds of processor time to bound the gradients in the boxes of a smooth union: by the interpreter, and of
    its terms alone by NumPy, which is the reference."""
    from sdf_lights.emitter.tree import interior, slopes
    from sdf_lights.graph.lipschitz import gradient_bounds
    from support.lamps.hard_cases import scattered

    tree = interior.tree(scattered(PARTS, smooth=True, size=0.9 * PARTS ** (-1.0 / 3.0)))
    nodes = tree.nodes[tree.boundary]
    boxes, lists = tree.boxes[tree.boundary], [tree.lists[r["row_first"] :][: r["row_count"]] for r in nodes]
    terms = [
        (term, boxes[[number in row for row in lists]])
        for number, term in enumerate(tree.field.source)
        if term.arity == 0
    ]

    def by_interpreter() -> None:
        slopes.bounds_of(tree.field, boxes, tree.lists, nodes["row_first"], nodes["row_count"])

    def by_numpy() -> None:
        for term, places in terms:
            gradient_bounds(term.formula, places[:, :3], places[:, 3:], term.parameters, 1)

    found: dict = {by_interpreter: [], by_numpy: []}
    for _ in range(turns + 1):
        for bound, times in found.items():
            started = time.process_time()
            bound()
            times.append(1e3 * (time.process_time() - started))
    return {f"bounds_ms_{bound.__name__}": statistics.median(times[1:]) for bound, times in found.items()}


def run(options) -> tuple[dict, list[dict]]:
    turns = options.repeats or (1 if options.quick else TURNS)
    cases = _cases()
    rows = in_parts(cases, lambda kind, name, make: measure(kind, name, make, turns), options)
    worst = {kind: max(row["ms"] for row in rows if row["kind"] == kind) for kind in KINDS}
    return dict(
        build_ms_worst_primitive=worst["primitive"],
        build_ms_csg_20=worst["csg_20"],
        build_ms_worst_fractal=worst["fractal"],
        build_ms_worst_example=worst["example"],
        **bounds_of_gradients(turns),
    ), rows
