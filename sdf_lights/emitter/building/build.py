# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a lamp from a shape: checks it, measures it, fills its row."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from ...affine import inverse
from ...frozen import frozen
from ...interruption import check, say
from ...sdf.emission import Emission
from ...sdf.program import NoClosedForm
from .. import primitives
from ..emission.smoothness import Tried, try_rays
from ..emission.varying import GLOW, CompiledEmission, compile_emission
from ..intersection.intervals import rows_needed
from ..lamps import CLOSED, FIELD, LAMP, PRIMITIVE
from ..tree import interior, moments
from ..tree.interior import Tree
from ..tree.volume import measure

MOST_ROWS = 1 << 22  # rows of spans that a program may need; memory that no ray uses is never touched
FIELD_ROWS = 512  # intervals of a ray in a field lamp; more count as unresolved
DIRECT = 100  # instructions of a program that is traced as a whole, without its tree
LEAST_ACCEPTANCE = 1.0 / 200.0  # minimum interior part of the boxes of a lamp's tree

EMPTY = "its shape has no interior, so it gives no light: make its parts overlap."


class LampError(ValueError):
    """A lamp cannot give light. One sentence that names the lamp and the cure."""


class Measured(NamedTuple):
    """A varying emission in a shape."""

    compiled: CompiledEmission
    emission_moments: moments.EmissionMoments
    tried: Tried


@frozen
class BuiltLamp:
    """A lamp ready for packing: its name, one ``LAMP`` row, its program, and its tree unless it is a primitive.

    If the emission varies, it also has one row ``GLOW`` and the data behind it. Compiled code lives as long as the tree
    and the emission: keep the lamp while kernels may run on its tables. ``remarks`` are sentences for the user.
    """

    name: str
    row: np.ndarray
    program: np.ndarray
    tree: Tree | None
    glow: np.ndarray
    emission: Measured | None
    remarks: tuple[str, ...] = ()


def build_lamp(
    name: str,
    shape,
    matrix: np.ndarray,
    power: float = 10.0,
    density: float | None = None,
    color=(1.0, 1.0, 1.0),
    visibility: int = 63,
    emission: Emission | None = None,
) -> BuiltLamp:
    """Prepare a lamp (see ``render.scene.Lamp``) for the kernels.

    ``matrix`` (4 × 4) maps the ``shape`` (``sdf.shapes.Shape``) to the world, in metres. ``power`` is in watts; a
    ``density`` in W/(sr·m³) replaces it. ``visibility`` holds the bits of ``render.scene.Ray``. Without an ``emission``
    the lamp is uniform.

    Raises ``LampError`` if the lamp has no interior or emits nothing: the caller leaves it out of the scene.
    """
    say(f"Building lamp “{name}”")
    check()
    matrix = np.asarray(matrix, np.float64)
    color = np.asarray(color, np.float64)
    _check_placement(name, shape, matrix)
    _check_emission(name, power, density, color)
    check()
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
    check()
    local_volume, error = volume_of(shape)
    volume = local_volume * abs(float(np.linalg.det(matrix[:3, :3])))
    if not (volume > 0.0 and math.isfinite(volume)):
        raise LampError(f"Lamp “{name}”: {EMPTY}")
    if tree is not None and local_volume < LEAST_ACCEPTANCE * tree.nodes["mass"][0]:
        raise LampError(
            f"Lamp “{name}”: its shape is too thin, relative to its size, to be sampled: make its parts thicker."
        )

    row = np.zeros(1, LAMP)
    row["center"], row["half"] = 0.5 * (low + high), 0.5 * (high - low)
    row["bounding_radius"] = np.linalg.norm(row["half"])
    row["volume"], row["volume_error"] = volume, error / local_volume
    row["visibility"] = int(visibility)
    relative = matrix.copy()
    relative[:3, 3] -= row["center"][0]
    found = measured(shape, emission) if emission is not None and emission.varies else None
    mean = (
        np.ones(3) if emission is None else _constant(shape, emission) if found is None else found.emission_moments.mean
    )
    if not mean.max() > 0.0:
        raise LampError(
            f"Lamp “{name}”: its emission is zero or undefined everywhere inside, so it gives no light: make the last "
            "line of its emission positive somewhere."
        )
    scale = color * (power / (4.0 * math.pi * volume * mean.mean()) if density is None else density)
    row["emission"] = scale * mean
    if not row["emission"].max() > 0.0:
        raise LampError(
            f"Lamp “{name}”: its emission shares no color component with the light's color, so it gives no light: "
            "make the light white."
        )
    row["power"] = 4.0 * math.pi * volume * row["emission"].mean()
    row["glow"] = -1 if found is None else 0
    row["emission_error"] = 0.0 if found is None else found.emission_moments.error + error / local_volume
    glow, remarks = (
        (np.zeros(0, GLOW), ()) if found is None else (_place_glow(found, relative, scale), _remarks(name, found.tried))
    )
    program = _place_primitive(row, shape, relative) if tree is None else _place_tree(row, tree, relative)
    if row["rows"][0] > MOST_ROWS:
        raise LampError(f"Lamp “{name}”: its shape has too many parts: simplify it.")
    return BuiltLamp(name, row, program, tree, glow, found, remarks)


def is_certified(shape) -> bool:
    """Whether rays certainly find all parts of a valid, bounded shape. Builds its tree, if that is needed."""
    if not shape.certified or math.isfinite(shape.lipschitz):
        return shape.certified
    try:
        return interior.tree(shape).certified
    except interior.TreeError:
        return True  # there will be no rays


def _is_primitive(shape) -> bool:
    try:
        program = shape.program()
        return len(program) == 1 and primitives.has_points(program["op"][0])
    except NoClosedForm:
        return False


def _place_primitive(row: np.ndarray, shape, matrix: np.ndarray) -> np.ndarray:
    """Fill in the row of a single primitive. Returns its program, in the space around the row's centre."""
    program = shape.program(matrix)
    row["kind"], row["primitive"], row["parameters"] = PRIMITIVE, program["op"][0], program["parameters"][0]
    row["inverse"] = program["inverse"][0]
    row["matrix"] = inverse(np.vstack([program["inverse"][0], [0.0, 0.0, 0.0, 1.0]]))[:3]
    row["rows"] = rows_needed(program)[0]
    return program


def _place_tree(row: np.ndarray, tree: Tree, matrix: np.ndarray) -> np.ndarray:
    """Fill in the row of a lamp with a tree. Returns its program, in tree space; it is empty for a field."""
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
    """The varying emission of a valid shape."""
    compiled = compile_emission(emission, shape)
    emission_moments = moments.emission_moments(interior.tree(shape), volume_of(shape)[0], compiled)
    return Measured(compiled, emission_moments, try_rays(shape, compiled.placed))


def _constant(shape, emission: Emission) -> np.ndarray:
    """Colour of a uniform emission."""
    return emission.placed(shape).evaluate(np.zeros(3))


def _place_glow(found: Measured, matrix: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """The row of an emission; ``matrix`` maps the shape to the world, relative to the lamp's centre."""
    glow = np.zeros(1, GLOW)
    glow["address"], glow["rate"], glow["scale"] = found.compiled.address, found.tried.rate, scale
    glow["inverse"] = inverse(matrix)[:3]
    return glow


def _remarks(name: str, tried: Tried) -> tuple[str, ...]:
    """Sentences about an emission that counts as zero in some regions."""
    return tuple(
        f"Lamp “{name}”: its emission is {what} in {max(100.0 * share, 0.01):.2g} % of its inside, which is dark there: "
        f"{cure}."
        for share, what, cure in (
            (tried.negative, "negative", "use max(0, …) if that is meant"),
            (tried.undefined, "undefined or infinite", "look for a division by zero or a root"),
        )
        if share > 0.0
    )


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
    """Volume of a shape in its local space, and a bound of its error."""
    exact = shape.volume()
    if exact is not None:
        return exact, 0.0
    found = measure(interior.tree(shape))
    return found.value, found.error
