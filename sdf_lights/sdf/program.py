# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The flat program of a shape whose ray intervals have a closed form, for the emitter's kernels.

A program is an array of ``INSTRUCTION`` in postfix order. A primitive pushes its set of points; an operator pops
``arity`` sets (always two: longer operations are left folds) and pushes their combination. One set is left.

A primitive row has ``inverse`` (3 × 4: the space of the whole shape -> the primitive's local space) and ``parameters``:

    SPHERE    radius                     centre at the origin
    BOX       half sizes x, y, z         centre at the origin
    TORUS     major radius, minor radius around the z axis
    CAPSULE   radius, height             along z; height is the length of the segment, without the caps
    CYLINDER  radius, height             along z, centred
    CONE      radius, height             along z, base at −height/2, apex at +height/2
    HALF_SPACE                           z ≤ 0
    FRUSTUM   radii at −height/2 and +height/2, height    along z, centred; either radius may be 0
    SPONGE    half size, levels          Menger sponge in a cube centred at the origin; levels is a whole number

``inverse`` and ``parameters`` of operator rows are zero.
"""

from __future__ import annotations

import enum

import numpy as np

from ..affine import inverse

INSTRUCTION = np.dtype(
    [("op", np.int64), ("arity", np.int64), ("inverse", np.float64, (3, 4)), ("parameters", np.float64, (4,))]
)


class Op(enum.IntEnum):
    """Operations of a program. Those below ``UNION`` push a primitive; the others combine the last two solids."""

    SPHERE = 0
    BOX = 1
    TORUS = 2
    CAPSULE = 3
    CYLINDER = 4
    CONE = 5
    HALF_SPACE = 6
    FRUSTUM = 7
    SPONGE = 8
    UNION = 16
    INTERSECTION = 17
    DIFFERENCE = 18
    EXCLUSIVE = 19


class NoClosedForm(Exception):
    """The shape's ray intervals have no closed form; they must be found numerically from its formula."""


def primitive(op: Op, matrix: np.ndarray, parameters: tuple[float, ...]) -> np.ndarray:
    """Program of one primitive under the 4 × 4 ``matrix``.

    Raises ``NoClosedForm`` if the matrix has no inverse: a flattened shape has no interior.
    """
    row = np.zeros(1, INSTRUCTION)
    row["op"] = op
    try:
        row["inverse"] = inverse(matrix)[:3]
    except np.linalg.LinAlgError:
        raise NoClosedForm(f"The transform of a {op.name.lower()} has no inverse.") from None
    row["parameters"][0, : len(parameters)] = parameters
    return row


def combine(op: Op, operands: list[np.ndarray]) -> np.ndarray:
    """Program (instructions,) of an operator applied to the programs of its operands, from left to right."""
    row = np.zeros(1, INSTRUCTION)
    row["op"] = op
    row["arity"] = 2
    parts = [operands[0]]
    for operand in operands[1:]:
        parts += [operand, row]
    return np.concatenate(parts)
