# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A lamp as a light: the interior of a closed-form shape that glows uniformly.

Projection sampling (Huang, Zheng, Xu, Kitamura and Wang 2026, "Efficient Monte Carlo rendering of implicit-shaped
volumetric emitters", equations 2, 4 and 6; as a solid angle technique already in Simon et al. 2017): a uniform point of
the interior gives a direction, whose density is the integral of r² along the ray,

    p(ω|x) = 1/(3V) Σ (r₊³ − r₋³) = 1/(3V) Σ 2h (3c² + h²),     L(ω) = ρ Σ 2h

over the intervals [c − h, c + h] of the ray inside. Distances and the volume V are those of the world, so no Jacobian
is needed: the uniform point stays uniform under the lamp's affine transform.

Where V has no closed form the estimate V̂ stands for it in ρ = P/(4π V̂) and in the density alike, while the points
stay uniform in the true interior. Directions sampled here then give the exact power P, since V̂ cancels in L/p; those
that a BSDF samples carry V/V̂. Under MIS the two shares w and 1 − w of the light add up to w + (1 − w)·V/V̂: no pixel
is off by more than the relative error of V̂, whose bound is in ``volume_error``. (Where ρ is given as a density it is
the other way round: what a BSDF samples is exact, and the lamp's own share carries V̂/V.)

Everything the kernels store is relative to the centre of the lamp's bounding box, and rays are moved to their closest
approach to it: the distance of the camera or of the lamp from the origin costs no digits.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from ..jit import kernel, table
from ..sdf.program import INSTRUCTION, NoClosedForm
from ..vec import dot, madd, normalize, scale, sub, transform_point, vec
from . import cells as cell_tree
from . import volume as volume_integral
from .cells import ATTEMPTS, CELL, cell_point
from .hashing import following, seeded, uniform
from .intervals import primitive_spans, regularize, rows_needed, solve
from .membership import DEEPEST, contains
from .points import primitive_point
from .primitives import box_span

LAMP = np.dtype([
    ("center", np.float64, (3,)),  # of the world bounding box; what follows is relative to it
    ("half", np.float64, (3,)),  # of the world bounding box
    ("reach", np.float64),  # radius of the bounding sphere around the centre
    ("volume", np.float64),  # m³, in the world
    ("volume_error", np.float64),  # bound on the relative error of the volume; 0 where it has a closed form
    ("emission", np.float64, (3,)),  # ρ, W/(sr·m³)
    ("power", np.float64),  # W, mean of the colour channels: 4π V ρ
    ("visibility", np.int64),  # render.scene.Ray
    ("matrix", np.float64, (3, 4)),  # space that points are drawn in -> world, relative to the centre
    ("inverse", np.float64, (3, 4)),  # back
    ("determinant", np.float64),  # |det| of matrix
    ("primitive", np.int64),  # the Op of a lamp that is a single primitive, else −1: drawn from cells
    ("parameters", np.float64, (4,)),  # of that primitive
    ("first_instruction", np.int64),
    ("instruction_count", np.int64),
    ("first_cell", np.int64),
    ("cell_count", np.int64),
], align=True)

TABLES = {"lamps": LAMP, "lamp_instructions": INSTRUCTION, "lamp_cells": CELL}
SCALARS = [("lamp_rows", np.int64)]  # rows that ``spans`` must have: the most that any lamp of the scene can use

MOST_ROWS = 1 << 16  # of spans a lamp may need
LEAST_ACCEPTANCE = 1.0 / 200.0  # part of the boxes of a lamp's tree that must be interior
SMALLEST_INTERVAL = 1e-10  # of a lamp's reach: shorter intervals and gaps are rounding, where faces coincide

lamps = table("lamps", LAMP)
instructions = table("lamp_instructions", INSTRUCTION)
cells = table("lamp_cells", CELL)


class LampError(ValueError):
    """A lamp cannot give light. One sentence that names the lamp and says what to change."""


@dataclass(frozen=True)
class BuiltLamp:
    """A lamp ready to be packed: one ``LAMP`` row, its program relative to the row's centre, and its tree of cells."""

    row: np.ndarray
    program: np.ndarray
    cells: np.ndarray


def build_lamp(name: str, shape, matrix: np.ndarray, power: float = 10.0, density: float | None = None,
               color=(1.0, 1.0, 1.0), visibility: int = 31) -> BuiltLamp:
    """Prepare a lamp (see ``render.scene.Lamp``) for the kernels.

    ``matrix`` (4 × 4) takes the ``shape`` (``sdf.shapes.Shape``) to the world, in metres. ``power`` is in watts;
    a ``density`` in W/(sr·m³) takes its place where it is given. ``visibility`` holds the bits of ``render.scene.Ray``.

    Raises ``LampError`` where the lamp has no interior or emits nothing: the caller leaves it out of the scene.
    """
    matrix = np.asarray(matrix, np.float64)
    color = np.asarray(color, np.float64)
    _check_placement(name, shape, matrix)
    _check_emission(name, power, density, color)

    low, high = shape.bounds(matrix)
    center = 0.5 * (low + high)
    relative = matrix.copy()
    relative[:3, 3] -= center
    try:
        program = shape.program(relative)
    except NoClosedForm as error:
        raise LampError(f"Lamp “{name}”: {str(error).rstrip('.')}: change the shape or its transform.") from None
    rows, depth = rows_needed(program)
    if rows > MOST_ROWS or depth > DEEPEST:
        raise LampError(f"Lamp “{name}”: its shape has too many parts inside one another: simplify it.")

    determinant = abs(float(np.linalg.det(matrix[:3, :3])))
    local_volume, error = _volume(shape)
    volume = local_volume * determinant
    if not (volume > 0.0 and math.isfinite(volume)):
        raise LampError(f"Lamp “{name}”: its shape has no interior, so it gives no light: make its parts overlap.")

    row = np.zeros(1, LAMP)
    row["center"], row["half"] = center, 0.5 * (high - low)
    row["reach"] = np.linalg.norm(row["half"])
    row["volume"], row["volume_error"] = volume, error / local_volume
    row["emission"] = color * (power / (4.0 * math.pi * volume) if density is None else density)
    row["power"] = 4.0 * math.pi * volume * row["emission"].mean()
    row["visibility"] = int(visibility)
    if len(program) == 1:
        row["primitive"], row["parameters"] = program["op"][0], program["parameters"][0]
        row["inverse"] = program["inverse"][0]
        row["matrix"] = np.linalg.inv(np.vstack([program["inverse"][0], [0.0, 0.0, 0.0, 1.0]]))[:3]
        tree = np.zeros(0, CELL)
    else:
        row["primitive"] = -1
        row["matrix"], row["inverse"] = relative[:3], np.linalg.inv(relative)[:3]
        tree = _tree(shape)
        if local_volume < LEAST_ACCEPTANCE * tree["mass"][0]:
            raise LampError(f"Lamp “{name}”: its shape is too thin for its size to be sampled: make its parts thicker.")
    row["determinant"] = abs(np.linalg.det(row["matrix"][0, :, :3]))
    return BuiltLamp(row, program, tree)


def _check_placement(name: str, shape, matrix: np.ndarray) -> None:
    problem = shape.validate()
    if problem:
        raise LampError(f"Lamp “{name}”: {problem}")
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise LampError(f"Lamp “{name}”: its transform has a number that is not finite: clear the transform.")
    singular = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    if not singular[2] > 1e-9 * singular[0]:
        raise LampError(f"Lamp “{name}”: its scale is zero along some axis: give it a scale other than zero.")


def _check_emission(name: str, power: float, density: float | None, color: np.ndarray) -> None:
    what, value = ("power", power) if density is None else ("density", density)
    if not (math.isfinite(value) and value > 0.0):
        raise LampError(f"Lamp “{name}”: its {what} is {value:g}, so it gives no light: make it more than zero.")
    if color.shape != (3,) or not np.isfinite(color).all() or color.min() < 0.0:
        raise LampError(f"Lamp “{name}”: its color has a part that is negative or not a number: choose another color.")
    if not color.max() > 0.0:
        raise LampError(f"Lamp “{name}”: its color is black, so it gives no light: choose a brighter one.")


@functools.lru_cache(maxsize=256)
def _volume(shape) -> tuple[float, float]:
    """Volume of a shape in its own space, and a bound on its error."""
    exact = shape.volume()
    if exact is not None:
        return exact, 0.0
    return volume_integral.estimate(shape.program(), *shape.bounds())


@functools.lru_cache(maxsize=256)
def _tree(shape) -> np.ndarray:
    """Tree of cells in the shape's own space; shared by all lamps of that shape, so not to be written to."""
    low, high = shape.bounds()
    tree = np.zeros(cell_tree.LIMIT, CELL)
    count = cell_tree.build(shape.program(), tuple(low), tuple(high), _volume(shape)[0], tree)
    tree = tree[:count].copy()
    tree.flags.writeable = False
    return tree


def pack_lamps(built: list[BuiltLamp]) -> dict[str, np.ndarray]:
    """Tables of ``TABLES`` for lamps in the order given."""
    rows = np.concatenate([lamp.row for lamp in built] or [np.zeros(0, LAMP)])
    programs = [lamp.program for lamp in built]
    trees = [lamp.cells for lamp in built]
    for first, count, parts in (("first_instruction", "instruction_count", programs),
                                ("first_cell", "cell_count", trees)):
        rows[count] = [len(part) for part in parts]
        rows[first] = np.cumsum(rows[count]) - rows[count]
    return {
        "lamps": rows,
        "lamp_instructions": np.concatenate(programs or [np.zeros(0, INSTRUCTION)]),
        "lamp_cells": np.concatenate(trees or [np.zeros(0, CELL)]),
    }


def pack_scalars(built: list[BuiltLamp]) -> dict[str, int]:
    """Values of ``SCALARS``."""
    return {"lamp_rows": max((rows_needed(lamp.program)[0] for lamp in built), default=1)}


@kernel
def interior_point(block, lamp, u1, u2, u3):
    """Uniform point in a lamp, relative to its centre.

    A point that the tree's boxes put outside the shape is drawn again with numbers hashed from u1, u2 and u3.
    """
    row = lamps(block)[lamp]
    if row.primitive >= 0:
        return transform_point(row.matrix, primitive_point(row.primitive, row.parameters, u1, u2, u3))
    program = instructions(block)[row.first_instruction:row.first_instruction + row.instruction_count]
    tree = cells(block)[row.first_cell:row.first_cell + row.cell_count]
    state = seeded(u1, u2, u3)
    p = (0.0, 0.0, 0.0)
    for _ in range(ATTEMPTS):
        q, certain = cell_point(tree, u1, u2, u3)
        p = transform_point(row.matrix, q)
        if certain or contains(program, p):
            break
        state = following(state)
        u1 = uniform(state)
        state = following(state)
        u2 = uniform(state)
        state = following(state)
        u3 = uniform(state)
    return p


@kernel
def sample_direction(block, lamp, x, n, u1, u2, u3):
    """Unit direction from x to a uniform point of the lamp; its density is ``direction_pdf``."""
    p = interior_point(block, lamp, u1, u2, u3)
    return normalize(madd(sub(vec(lamps(block)[lamp].center), x), 1.0, p))


@kernel
def _approach(row, o, d):
    """Distance along the ray to its closest approach to a lamp's centre, and that point relative to the centre."""
    offset = sub(o, vec(row.center))
    distance = -dot(offset, d)
    return distance, madd(offset, distance, d)


@kernel
def crosses(block, lamp, o, d, t_max):
    """False if the ray certainly has no interval of the lamp in 0 < t < t_max: a test of its bounding box."""
    row = lamps(block)[lamp]
    distance, p = _approach(row, o, d)
    if dot(p, p) >= row.reach * row.reach:
        return False
    start, end = box_span(p, d, row.half[0], row.half[1], row.half[2])
    return start <= end and distance + end > 0.0 and distance + start < t_max


@kernel
def _keep(spans, count, distance, start, end):
    """Append what is left at t ≥ 0 of an interval whose ends are relative to ``distance``; returns the new count."""
    if distance + end <= 0.0:
        return count
    start = max(start, -distance)
    spans[count, 0], spans[count, 1] = distance + 0.5 * (start + end), 0.5 * (end - start)
    return count + 1


@kernel
def trace(block, lamp, o, d, spans):
    """Write all intervals of the ray o + t·d, t ≥ 0, to ``spans``: rows (c, h) in order. Returns their number.

    ``spans`` has at least ``block.lamp_rows`` rows: no shape of the scene can need more, so nothing is ever dropped.
    Intervals and gaps below ``SMALLEST_INTERVAL`` × reach are rounding noise of coincident faces, and removed.
    """
    row = lamps(block)[lamp]
    distance, p = _approach(row, o, d)
    if dot(p, p) >= row.reach * row.reach or distance + row.reach <= 0.0:
        return 0
    if row.instruction_count == 1:
        count, a0, b0, a1, b1 = primitive_spans(instructions(block)[row.first_instruction], p, d)
        kept = _keep(spans, 0, distance, a0, b0) if count > 0 else 0
        return _keep(spans, kept, distance, a1, b1) if count > 1 else kept
    start, end = box_span(p, d, row.half[0], row.half[1], row.half[2])
    if start > end or distance + end <= 0.0:
        return 0
    program = instructions(block)[row.first_instruction:row.first_instruction + row.instruction_count]
    count = regularize(spans, solve(program, p, d, spans), SMALLEST_INTERVAL * row.reach)
    kept = 0
    for index in range(count):
        kept = _keep(spans, kept, distance, spans[index, 0], spans[index, 1])
    return kept


@kernel
def direction_pdf(block, lamp, x, n, d, spans, count):
    """Density per solid angle of ``sample_direction`` giving d, from the intervals that ``trace`` found from x."""
    total = 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        total += 2.0 * h * (3.0 * c * c + h * h)
    return total / (3.0 * lamps(block)[lamp].volume)


@kernel
def radiance(block, lamp, spans, count, t_min, t_max):
    """Line integral of the emission over the traced intervals between the distances t_min and t_max: RGB."""
    total = 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        # Differences to the interval's own ends, so that a whole interval gives 2h to the last digit.
        total += max(2.0 * h - max(t_min - (c - h), 0.0) - max(c + h - t_max, 0.0), 0.0)
    return scale(vec(lamps(block)[lamp].emission), total)
