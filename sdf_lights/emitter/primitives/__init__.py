# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Primitives in closed form: one module each, named after its member of ``sdf.program.Op``.

A module has the functions below. ``size`` are the parameters of its instruction. Everything is in the primitive's local
space.

    MOST_SPANS, or most_spans(size)          intervals of a ray at most
    spans(size, o, d)                        their number, 0 to 2, and ends (start, end, start, end), of the ray o + s·d
    write_spans(size, o, d, spans, first)    instead, where there may be more: writes rows from ``first``, returns the number
    classify(size, c, h)                     flags (inside, outside), 1 or 0, of the box with centre c and half sizes h. Both
                                             are 0 where the surface may pass through it: the answer is conservative
    point(size, u1, u2, u3)                  a uniform point inside: a smooth map of the unit cube, which keeps the stratification
                                             of its numbers. Without it the primitive is a lamp by its interior tree
    face(size, axis, c, h)                   coordinate f of flat faces ±f across an axis, for a box; infinite: none
    half_size(size)                          (3,) half sizes of its box around the origin

d may have any length but zero. An affine map of a uniform point is uniform in the mapped shape, so one ``point`` is
enough for every transform.
"""

from __future__ import annotations

import importlib
import math

from ...jit import dispatched, kernel
from ...sdf.program import Op
from .spans import NO_SPANS

# Imported by name, so the ``Op`` identifies a primitive. ``jit`` counts all modules of this folder as sources.
MODULES = {op: importlib.import_module(f".{op.name.lower()}", __name__) for op in Op if op < Op.UNION}


def most_spans(op: int, size) -> int:
    """Maximum number of intervals of a ray in a primitive."""
    module = MODULES[Op(op)]
    return module.MOST_SPANS if hasattr(module, "MOST_SPANS") else module.most_spans(size)


def has_points(op: int) -> bool:
    """Whether uniform points of the primitive have a closed form."""
    return hasattr(MODULES[Op(op)], "point")


def has_two_spans_at_most(op: int) -> bool:
    """Whether ``spans`` works for the primitive with any parameters."""
    return hasattr(MODULES[Op(op)], "spans")


def half_size(op: int, size):
    """(3,) half sizes of a primitive's box around the origin, in its local space."""
    return MODULES[Op(op)].half_size(size)


def _cases(name: str) -> list[dict]:
    """For ``dispatched``: the numbers and functions of the primitives that have a function of this name."""
    return [
        {"NUMBER": int(op), "CASE": getattr(module, name)} for op, module in MODULES.items() if hasattr(module, name)
    ]


NUMBER, CASE, REST = -1, None, None  # set by ``dispatched``

# Inlined, because calls for the wrong numbers made rays a third slower.


@kernel(forceinline=True)
def _spans(op, size, o, d):
    if op == NUMBER:
        return CASE(size, o, d)
    return REST(op, size, o, d)


@kernel
def _no_spans(op, size, o, d):
    return NO_SPANS


@kernel(forceinline=True)
def _write_spans(op, size, o, d, rows, first):
    if op == NUMBER:
        return CASE(size, o, d, rows, first)
    return REST(op, size, o, d, rows, first)


@kernel
def _write_two(op, size, o, d, rows, first):
    count, a0, b0, a1, b1 = spans(op, size, o, d)
    if count > 0:
        rows[first, 0], rows[first, 1] = a0, b0
    if count > 1:
        rows[first + 1, 0], rows[first + 1, 1] = a1, b1
    return count


@kernel(forceinline=True)
def _classify(op, size, c, h):
    if op == NUMBER:
        return CASE(size, c, h)
    return REST(op, size, c, h)


@kernel
def _undecided(op, size, c, h):
    return 0, 0


@kernel(forceinline=True)
def _point(op, size, u1, u2, u3):
    if op == NUMBER:
        return CASE(size, u1, u2, u3)
    return REST(op, size, u1, u2, u3)


@kernel
def _no_point(op, size, u1, u2, u3):
    return (0.0, 0.0, 0.0)


@kernel(forceinline=True)
def _face(op, size, axis, c, h):
    if op == NUMBER:
        return CASE(size, axis, c, h)
    return REST(op, size, axis, c, h)


@kernel
def _no_face(op, size, axis, c, h):
    return math.inf


spans = dispatched(_spans, _cases("spans"), _no_spans)
write_spans = dispatched(_write_spans, _cases("write_spans"), _write_two)
classify = dispatched(_classify, _cases("classify"), _undecided)
point = dispatched(_point, _cases("point"), _no_point)
face = dispatched(_face, _cases("face"), _no_face)
