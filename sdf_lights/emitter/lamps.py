# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A lamp as a light: the interior of a shape that glows.

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

There are three kinds of lamps. A *primitive* has a closed form for everything. A *closed* shape is a program of
primitives and set operations, whose intervals have closed forms. Of all others the *field* is traced and drawn from.
The last two have an interior tree (``interior``).

Emission that varies is ρ(x) = P e(x) / (4π ∫e dV), or the density times e(x), for a relative emission e (``sdf.emission``)
whose integral is estimated with what is in the boxes of the tree (``moments``). The projection density stays that of
uniform points.

Everything the kernels store is relative to the centre of the lamp's bounding box, and rays are moved to their closest
approach to it: the distance of the camera or of the lamp from the origin costs no digits.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..affine import inverse
from ..jit import kernel, table
from ..sdf.emission import Emission
from ..sdf.program import INSTRUCTION, NoClosedForm, Op
from ..vec import add, dot, madd, normalize, scale, sub, transform_point, transform_vector, vec
from . import emission as emissions
from . import fields, interior, moments
from .crossings import crossings
from .emission import GLOW, CompiledEmission, compile_emission, line_integral
from .fields import LIST
from .hashing import following, seeded, uniform
from .interior import INSIDE, NODE, Tree, tree_point
from .intervals import primitive_spans, regularize, rows_needed, solve
from .membership import contains
from .points import primitive_point
from .primitives import box_span
from .smoothness import Tried, try_rays
from .volume import measure

PRIMITIVE, CLOSED, FIELD = 0, 1, 2  # kinds of lamps

LAMP = np.dtype([
    ("center", np.float64, (3,)),  # of the world bounding box; what follows is relative to it
    ("half", np.float64, (3,)),  # of the world bounding box
    ("reach", np.float64),  # radius of the bounding sphere around the centre
    ("volume", np.float64),  # m³, in the world
    ("volume_error", np.float64),  # bound on the relative error of the volume; 0 where it has a closed form
    ("emission", np.float64, (3,)),  # ρ, W/(sr·m³): its mean over the volume
    ("emission_error", np.float64),  # bound on the relative error of that mean; 0 where it does not vary
    ("glow", np.int64),  # index of the emission, where it varies; −1: ρ is the same everywhere
    ("power", np.float64),  # W, mean of the colour channels: 4π V ρ
    ("visibility", np.int64),  # render.scene.Ray
    ("kind", np.int64),
    ("matrix", np.float64, (3, 4)),  # tree space, or the space of a single primitive -> world, relative to the centre
    ("inverse", np.float64, (3, 4)),  # back
    ("primitive", np.int64),  # the Op of a lamp that is a single primitive
    ("parameters", np.float64, (4,)),  # of that primitive
    ("low", np.float64, (3,)),  # corners of the root's box in tree space
    ("high", np.float64, (3,)),
    ("rows", np.int64),  # of spans that hold the intervals of a ray at most
    ("first_instruction", np.int64),
    ("instruction_count", np.int64),
    ("direct", np.int64),  # 1 where rays are solved by the whole program, without the tree
    ("first_term", np.int64),
    ("first_node", np.int64),
    ("node_count", np.int64),
    ("first_list", np.int64),
], align=True)

TABLES = {
    "lamps": LAMP, "lamp_instructions": INSTRUCTION, **interior.TABLES, **fields.TABLES, **emissions.TABLES}
SCALARS = [("lamp_rows", np.int64)]  # rows of ``spans`` for intervals: the most that any lamp of the scene can use

MOST_ROWS = 1 << 22  # of spans that a program may need; memory of those that no ray uses is never touched
FIELD_ROWS = 512  # intervals of a ray in a field lamp; what is more counts as unresolved
DIRECT = 100  # instructions of a program that is traced as a whole, without its tree
LEAST_ACCEPTANCE = 1.0 / 200.0  # part of the boxes of a lamp's tree that must be interior
ATTEMPTS = 4096  # draws before giving up; the least acceptance that lamps allow makes that a chance of 1e-9
NOTICEABLE = 1e-3  # part of a lamp's length along rays that is left open before the user is told
SMALLEST_INTERVAL = 1e-10  # of a lamp's reach: shorter intervals and gaps are rounding, where faces coincide

EMPTY = "its shape has no interior, so it gives no light: make its parts overlap."

lamps = table("lamps", LAMP)
instructions = table("lamp_instructions", INSTRUCTION)
nodes = table("lamp_nodes", NODE)
lists = table("lamp_lists", LIST)


class LampError(ValueError):
    """A lamp cannot give light. One sentence that names the lamp and says what to change."""


class Measured(NamedTuple):
    """An emission that varies, in a shape."""

    compiled: CompiledEmission
    weighed: moments.Weighed
    tried: Tried


@dataclass(frozen=True)
class BuiltLamp:
    """A lamp ready to be packed: its name, one ``LAMP`` row, its program, and its tree unless it is a primitive.

    Where the emission varies there are one row ``GLOW`` and what that is made from. Compiled code lives as long as the
    tree and the emission: keep the lamp while kernels may run on its tables. ``remarks`` are sentences for the user.
    """

    name: str
    row: np.ndarray
    program: np.ndarray
    tree: Tree | None
    glow: np.ndarray
    emission: Measured | None
    remarks: tuple[str, ...] = ()


def build_lamp(name: str, shape, matrix: np.ndarray, power: float = 10.0, density: float | None = None,
               color=(1.0, 1.0, 1.0), visibility: int = 31, emission: Emission | None = None) -> BuiltLamp:
    """Prepare a lamp (see ``render.scene.Lamp``) for the kernels.

    ``matrix`` (4 × 4) takes the ``shape`` (``sdf.shapes.Shape``) to the world, in metres. ``power`` is in watts;
    a ``density`` in W/(sr·m³) takes its place where it is given. ``visibility`` holds the bits of ``render.scene.Ray``;
    without an ``emission`` the lamp is uniform.

    Raises ``LampError`` where the lamp has no interior or emits nothing: the caller leaves it out of the scene.
    """
    matrix = np.asarray(matrix, np.float64)
    color = np.asarray(color, np.float64)
    _check_placement(name, shape, matrix)
    _check_emission(name, power, density, color)
    low, high = shape.bounds(matrix)
    _check_bounds(name, low, high)
    try:
        tree = None if _is_primitive(shape) else interior.tree(shape)
    except interior.TreeError as error:
        raise LampError(f"Lamp “{name}”: {error}") from None
    if tree is not None:
        tight_low, tight_high = tree.bounds(matrix)
        low, high = np.maximum(low, tight_low), np.minimum(high, tight_high)
        _check_bounds(name, low, high)
    local_volume, error = volume_of(shape)
    volume = local_volume * abs(float(np.linalg.det(matrix[:3, :3])))
    if not (volume > 0.0 and math.isfinite(volume)):
        raise LampError(f"Lamp “{name}”: {EMPTY}")
    if tree is not None and local_volume < LEAST_ACCEPTANCE * tree.nodes["mass"][0]:
        raise LampError(f"Lamp “{name}”: its shape is too thin for its size to be sampled: make its parts thicker.")

    row = np.zeros(1, LAMP)
    row["center"], row["half"] = 0.5 * (low + high), 0.5 * (high - low)
    row["reach"] = np.linalg.norm(row["half"])
    row["volume"], row["volume_error"] = volume, error / local_volume
    row["visibility"] = int(visibility)
    relative = matrix.copy()
    relative[:3, 3] -= row["center"][0]
    found = measured(shape, emission) if emission is not None and emission.varies else None
    mean = np.ones(3) if emission is None else _constant(shape, emission) if found is None else found.weighed.mean
    if not mean.max() > 0.0:
        raise LampError(f"Lamp “{name}”: its emission is zero or undefined everywhere inside, so it gives no light: make "
                        "the last line of its emission positive somewhere.")
    scale = color * (power / (4.0 * math.pi * volume * mean.mean()) if density is None else density)
    row["emission"] = scale * mean
    if not row["emission"].max() > 0.0:
        raise LampError(f"Lamp “{name}”: its emission has none of the light's own color, so it gives no light: make that "
                        "white.")
    row["power"] = 4.0 * math.pi * volume * row["emission"].mean()
    row["glow"] = -1 if found is None else 0
    row["emission_error"] = 0.0 if found is None else found.weighed.error + error / local_volume
    glow, remarks = (np.zeros(0, GLOW), ()) if found is None else (
        _place_glow(found, relative, scale), _remarks(name, found.tried))
    program = _place_primitive(row, shape, relative) if tree is None else _place_tree(row, tree, relative)
    if row["rows"][0] > MOST_ROWS:
        raise LampError(f"Lamp “{name}”: its shape has too many parts: simplify it.")
    return BuiltLamp(name, row, program, tree, glow, found, remarks)


def _is_primitive(shape) -> bool:
    try:
        program = shape.program()
        return len(program) == 1 and program["op"][0] != Op.SPONGE  # which has neither two intervals at most, nor points
    except NoClosedForm:
        return False


def _place_primitive(row: np.ndarray, shape, matrix: np.ndarray) -> np.ndarray:
    """Fill in the row of a single primitive; returns its program, in the space of the row's centre."""
    program = shape.program(matrix)
    row["kind"], row["primitive"], row["parameters"] = PRIMITIVE, program["op"][0], program["parameters"][0]
    row["inverse"] = program["inverse"][0]
    row["matrix"] = inverse(np.vstack([program["inverse"][0], [0.0, 0.0, 0.0, 1.0]]))[:3]
    row["rows"] = rows_needed(program)[0]
    return program


def _place_tree(row: np.ndarray, tree: Tree, matrix: np.ndarray) -> np.ndarray:
    """Fill in the row of a lamp with a tree; returns its program, in tree space, which is empty for a field."""
    matrix = matrix.copy()
    matrix[:3, 3] += matrix[:3, :3] @ tree.center
    row["kind"] = CLOSED if tree.field is None else FIELD
    row["matrix"], row["inverse"] = matrix[:3], inverse(matrix)[:3]
    row["low"], row["high"] = -tree.half, tree.half
    row["direct"] = 0 < len(tree.program) <= DIRECT
    row["rows"] = rows_needed(tree.program)[0] if tree.field is None else FIELD_ROWS
    return tree.program


@functools.lru_cache(maxsize=64)
def measured(shape, emission: Emission) -> Measured:
    """An emission that varies, in a valid shape."""
    compiled = compile_emission(emission, shape)
    weighed = moments.weigh(interior.tree(shape), volume_of(shape)[0], compiled)
    return Measured(compiled, weighed, try_rays(shape, compiled.placed))


def _constant(shape, emission: Emission) -> np.ndarray:
    """Colour of an emission that does not vary."""
    return emission.placed(shape).evaluate(np.zeros(3))


def _place_glow(found: Measured, matrix: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """The row of an emission; ``matrix`` takes the shape to the world, relative to the lamp's centre."""
    glow = np.zeros(1, GLOW)
    glow["address"], glow["rate"], glow["scale"] = found.compiled.address, found.tried.rate, scale
    glow["inverse"] = inverse(matrix)[:3]
    return glow


def _remarks(name: str, tried: Tried) -> tuple[str, ...]:
    """Sentences about an emission that counts as zero in places."""
    return tuple(
        f"Lamp “{name}”: its emission is {what} in {max(100.0 * share, 0.01):.2g} % of its inside, which is dark there: "
        f"{cure}."
        for share, what, cure in ((tried.negative, "negative", "use max(0, …) if that is meant"),
                                  (tried.undefined, "undefined or infinite", "look for a division by zero or a root"))
        if share > 0.0)


def _check_bounds(name: str, low: np.ndarray, high: np.ndarray) -> None:
    if not np.isfinite([low, high]).all():
        raise LampError(f"Lamp “{name}”: its shape has no limits: intersect it with a box or another shape.")
    if not np.all(high > low):
        raise LampError(f"Lamp “{name}”: {EMPTY}")


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
def volume_of(shape) -> tuple[float, float]:
    """Volume of a shape in its own space, and a bound on its error."""
    exact = shape.volume()
    if exact is not None:
        return exact, 0.0
    found = measure(interior.tree(shape))
    return found.value, found.error


def pack_lamps(built: list[BuiltLamp]) -> dict[str, np.ndarray]:
    """Tables of ``TABLES`` for lamps in the order given. Lamps of the same shape share all but their rows."""
    rows = np.concatenate([lamp.row for lamp in built] or [np.zeros(0, LAMP)])
    parts = {name: [np.zeros(0, dtype)] for name, dtype in TABLES.items()}
    used = dict.fromkeys(TABLES, 0)
    places: dict[int, tuple] = {}

    def append(name: str, array: np.ndarray) -> int:
        parts[name].append(array)
        used[name] += len(array)
        return used[name] - len(array)

    def place(tree: Tree | None, program: np.ndarray) -> tuple:
        first_instruction = append("lamp_instructions", program)
        if tree is None:
            return first_instruction, len(program), 0, 0, 0, 0
        terms, parameters = tree.arrays
        terms = terms.copy()
        terms["parameters"] += append("lamp_parameters", parameters)
        return (first_instruction, len(program), append("lamp_terms", terms), append("lamp_nodes", tree.nodes),
                len(tree.nodes), append("lamp_lists", tree.lists))

    for row, lamp in zip(rows, built):
        if lamp.emission is not None:
            glow = lamp.glow.copy()
            glow["parameters"] = append("lamp_parameters", lamp.emission.compiled.parameters)
            row["glow"] = append("lamp_glows", glow)
        key = id(lamp.program if lamp.tree is None else lamp.tree)
        if key not in places:
            places[key] = place(lamp.tree, lamp.program)
        for field, value in zip(("first_instruction", "instruction_count", "first_term", "first_node", "node_count",
                                 "first_list"), places[key]):
            row[field] = value
    return {**{name: _joined(arrays) for name, arrays in parts.items()}, "lamps": rows}


def _joined(arrays: list[np.ndarray]) -> np.ndarray:
    """The arrays one after the other, from the beginning of a line of the cache on: a node of a tree takes one."""
    rows, dtype = sum(map(len, arrays)), arrays[0].dtype
    memory = np.empty(rows * dtype.itemsize + 64, np.uint8)
    start = -memory.ctypes.data % 64
    return np.concatenate(arrays, out=memory[start:start + rows * dtype.itemsize].view(dtype))


def pack_scalars(built: list[BuiltLamp]) -> dict[str, int]:
    """Values of ``SCALARS``."""
    # The walk through a tree solves programs above the intervals that it has found.
    needed = [int(lamp.row["rows"][0]) * (1 if lamp.row["kind"][0] == FIELD else 2) for lamp in built]
    return {"lamp_rows": max(needed, default=1)}


def new_spans(rows: int, count: int) -> np.ndarray:
    """Scratch for ``trace``, for one thread: ``lamp_rows`` rows of intervals, and a row of lengths for each lamp."""
    return np.zeros((rows + count, 2))


def doubts(built: list[BuiltLamp]) -> list[str]:
    """Sentences about lamps whose intervals are not certain to be all that there are, and about odd emissions."""
    return [remark for lamp in built for remark in lamp.remarks] + [
        f"Lamp “{lamp.name}”: nothing bounds how fast its field changes, so rays may miss thin parts of it."
        for lamp in built if lamp.tree is not None and not lamp.tree.certified]


def unresolved(built: list[BuiltLamp], lengths: np.ndarray) -> list[str]:
    """A sentence for each lamp of which rays left too much open; ``lengths`` (lamps, 2) as ``trace`` sums them."""
    return [f"Lamp “{lamp.name}”: {100.0 * left / (left + inside):.2g} % of its length along rays could not be "
            "resolved, so its light may be off by as much: make its thinnest parts thicker, or simplify its shape."
            for lamp, (left, inside) in zip(built, lengths) if left > NOTICEABLE * (left + inside)]


@kernel
def _found_inside(block, row, q, leaf):
    """Whether the point q, in a leaf on the boundary, is inside: by all that matters there."""
    node = nodes(block)[row.first_node + leaf]
    if row.kind == CLOSED:
        program = instructions(block)[row.first_instruction:row.first_instruction + row.instruction_count]
        first = row.first_list + node.row_first
        return contains(program, q, lists(block)[first:first + node.row_count])
    return fields.value(block, row, node.row_first, node.row_count, q) <= 0.0


@kernel
def interior_point(block, lamp, u1, u2, u3):
    """Uniform point in a lamp, relative to its centre.

    A point that the tree's boxes put outside the shape is drawn again with numbers hashed from u1, u2 and u3.
    """
    row = lamps(block)[lamp]
    if row.kind == PRIMITIVE:
        return transform_point(row.matrix, primitive_point(row.primitive, row.parameters, u1, u2, u3))
    tree = nodes(block)[row.first_node:row.first_node + row.node_count]
    state = seeded(u1, u2, u3)
    q = (0.0, 0.0, 0.0)
    for _ in range(ATTEMPTS):
        q, leaf = tree_point(tree, row.low, row.high, u1, u2, u3)
        if tree[leaf].state == INSIDE or _found_inside(block, row, q, leaf):
            break
        state = following(state)
        u1 = uniform(state)
        state = following(state)
        u2 = uniform(state)
        state = following(state)
        u3 = uniform(state)
    return transform_point(row.matrix, q)


@kernel
def way_inside(block, lamp, x, u1, u2, u3):
    """From x to a uniform point of the lamp."""
    return add(sub(vec(lamps(block)[lamp].center), x), interior_point(block, lamp, u1, u2, u3))


@kernel
def sample_direction(block, lamp, x, n, u1, u2, u3):
    """Unit direction from x to a uniform point of the lamp; its density is ``direction_pdf``."""
    return normalize(way_inside(block, lamp, x, u1, u2, u3))


@kernel
def intensity(block, lamp):
    """Radiant intensity (RGB) of a lamp of uniform emission, W/sr: ρ V."""
    row = lamps(block)[lamp]
    return scale(vec(row.emission), row.volume)


@kernel
def _approach(row, o, d):
    """Distance along the ray to its closest approach to a lamp's centre, and that point relative to the centre."""
    offset = sub(o, vec(row.center))
    distance = -dot(offset, d)
    return distance, madd(offset, distance, d)


@kernel
def _keep(spans, count, distance, start, end):
    """Append what is left at t ≥ 0 of an interval whose ends are relative to ``distance``; returns the new count."""
    if distance + end <= 0.0:
        return count
    start = max(start, -distance)
    spans[count, 0], spans[count, 1] = distance + 0.5 * (start + end), 0.5 * (end - start)
    return count + 1


@kernel
def note_length(block, lamp, column, length, spans):
    """Add to one of the two lengths that ``trace`` sums for a lamp."""
    spans[block.lamp_rows + lamp, column] += length


@kernel
def solve_all(block, row, p, d, spans):
    """Intervals of a ray of tree space in a lamp's whole program; returns their number."""
    program = instructions(block)[row.first_instruction:row.first_instruction + row.instruction_count]
    return solve(program, p, d, spans)


@kernel
def _trace_parts(block, row, lamp, distance, p, d, spans):
    """As ``trace``, for a lamp with a tree. p and d are the ray in tree space; its origin is at −``distance``."""
    half = row.high
    start, end = box_span(p, d, half[0], half[1], half[2])
    start = max(start, -distance)
    if start >= end:
        return 0
    if row.direct:
        count = solve_all(block, row, p, d, spans)
    else:
        count, unresolved = crossings(block, row, p, d, start, end, spans)
        note_length(block, lamp, 0, unresolved, spans)
    count = regularize(spans, count, SMALLEST_INTERVAL * row.reach)
    kept = 0
    for index in range(count):
        kept = _keep(spans, kept, distance, spans[index, 0], spans[index, 1])
    for index in range(kept):
        note_length(block, lamp, 1, 2.0 * spans[index, 1], spans)
    return kept


@kernel
def trace(block, lamp, o, d, spans):
    """Write all intervals of the ray o + t·d, t ≥ 0, to ``spans``: rows (c, h) in order. Returns their number.

    ``spans`` is ``new_spans``: no closed-form shape of the scene can need more rows, so nothing of them is dropped.
    Row ``block.lamp_rows + lamp`` sums two lengths along rays, of which the first counts for fields alone: what could
    not be resolved or had no row, and what is inside the lamp. Intervals and gaps below ``SMALLEST_INTERVAL`` × reach are
    rounding noise of coincident faces, and removed.
    """
    row = lamps(block)[lamp]
    distance, p = _approach(row, o, d)
    if dot(p, p) >= row.reach * row.reach or distance + row.reach <= 0.0:
        return 0
    if row.kind == PRIMITIVE:
        count, a0, b0, a1, b1 = primitive_spans(instructions(block)[row.first_instruction], p, d)
        kept = _keep(spans, 0, distance, a0, b0) if count > 0 else 0
        return _keep(spans, kept, distance, a1, b1) if count > 1 else kept
    return _trace_parts(
        block, row, lamp, distance, transform_point(row.inverse, p), transform_vector(row.inverse, d), spans)


@kernel
def direction_pdf(block, lamp, x, n, d, spans, count):
    """Density per solid angle of ``sample_direction`` giving d, from the intervals that ``trace`` found from x."""
    total = 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        total += 2.0 * h * (3.0 * c * c + h * h)
    return total / (3.0 * lamps(block)[lamp].volume)


@kernel
def varies(block, lamp):
    """Whether the emission of a lamp differs from point to point."""
    return lamps(block)[lamp].glow >= 0


@kernel
def radiance(block, lamp, x, d, spans, count, t_min, t_max, u):
    """Line integral of the emission along x + t·d over the traced intervals, between the distances t_min and t_max: RGB.

    Where the emission varies it is an unbiased estimate, from one uniform number u; else u and the ray do not matter.
    """
    row = lamps(block)[lamp]
    if row.glow >= 0:
        return line_integral(block, row.glow, vec(row.center), x, d, spans, count, t_min, t_max, u)
    total = 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        # Differences to the interval's own ends, so that a whole interval gives 2h to the last digit.
        total += max(2.0 * h - max(t_min - (c - h), 0.0) - max(c + h - t_max, 0.0), 0.0)
    return scale(vec(row.emission), total)
