# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of expressions in kernels, their types in GLSL, and numbers and names as GLSL."""

from __future__ import annotations

import math
import re

import numpy as np

from ....frozen import frozen
from ....graph.codegen_glsl import literal
from ..layout import Array, Record

FLOAT, INT, UINT, BOOL = "float", "int", "uint", "bool"
ULONG = "uvec2"  # uint64: the low half and the high half
SCALARS = (BOOL, INT, UINT, ULONG, FLOAT)  # each can be converted to those after it

# Reserved words of GLSL, and functions that generated code calls.
_RESERVED = frozenset(
    """
    active asm attribute bool break buffer bvec2 bvec3 bvec4 case cast centroid class coherent common const continue
    default discard do double else enum extern external false filter fixed flat float for goto half highp if image in
    inline inout input int interface invariant ivec2 ivec3 ivec4 layout long lowp mat2 mat3 mat4 mediump namespace
    noinline noperspective out output packed partition patch precise precision public readonly resource restrict return
    sample sampler shared short sizeof smooth static struct subroutine superp switch template texture this true typedef
    uint uniform union unsigned using uvec2 uvec3 uvec4 varying vec2 vec3 vec4 void volatile while writeonly
    abs acos asin atan ceil clamp cos cross distance dot exp floor fract inversesqrt isinf isnan length log max min mix
    mod normalize pow reflect refract sign sin sqrt step tan words
""".split()
)


class Untranslatable(Exception):
    """A kernel uses something without a GLSL version: what, and where."""


@frozen
class Tuple:
    """Type of a tuple."""

    items: tuple

    @property
    def vector(self) -> bool:
        """Whether it is a vec2, vec3 or vec4 of GLSL."""
        return 2 <= len(self.items) <= 4 and all(item == FLOAT for item in self.items)


@frozen
class Ref:
    """Type of a reference: a record or an array in a buffer, or in the workspace (``lvalue`` is then its GLSL).

    The value is an int: the first word in the buffer, or the text for ``{}`` in ``lvalue``. ``reader`` is the prefix of
    the functions that read words of that buffer.
    """

    layout: Record | Array
    lvalue: str = ""
    reader: str = ""


@frozen
class Value:
    """The value of an expression: GLSL ``text`` of a ``type``, or a known Python object (``CONSTANT``)."""

    type: object
    text: str = ""
    constant: object = None
    items: tuple = ()  # of a tuple written as its elements
    possible: frozenset | None = None  # possible values of an int, if they are known
    count: str = ""  # of the elements of an array in the buffer


CONSTANT = "constant"


class Scope:
    """A block or a workspace: ``prefix`` is that of its tables' names in GLSL."""

    def __init__(self, prefix: str = ""):
        self.prefix = prefix


BLOCK, WORKSPACE, SECONDARY = Scope(), Scope(), Scope("secondary_")


@frozen
class Native:
    """A kernel with hand-written GLSL under this ``name``. ``result`` is its type; None for none.

    Arguments known at translation time (the block, a table) are left out of the call.
    """

    name: str
    result: object = None


VECTOR = Tuple((FLOAT, FLOAT, FLOAT))


def known(value) -> Value:
    """A Python object as a value."""
    return Value(CONSTANT, constant=value)


def is_number(value) -> bool:
    """Whether it is a number or a boolean."""
    return isinstance(value, (bool, int, float, np.number, np.bool_))


def is_value(constant) -> bool:
    """Whether it is a number or a tuple of numbers."""
    return is_number(constant) or (isinstance(constant, tuple) and all(map(is_number, constant)) and len(constant) > 0)


def type_of(number) -> str:
    """GLSL type of a number."""
    if isinstance(number, (bool, np.bool_)):
        return BOOL
    if isinstance(number, np.uint32):
        return UINT
    if isinstance(number, np.uint64):
        return ULONG
    return INT if isinstance(number, (int, np.integer)) else FLOAT


def constant_text(number, kind: str) -> str:
    """GLSL for a number of this type."""
    if kind == BOOL:
        return "true" if number else "false"
    if kind == INT:
        return str(int(number)) if int(number) != -(1 << 31) else "(-2147483647 - 1)"
    if kind == UINT:
        return f"{int(number) & 0xFFFFFFFF}u"
    if kind == ULONG:
        return f"uvec2({int(number) & 0xFFFFFFFF}u, {int(number) >> 32 & 0xFFFFFFFF}u)"
    number = float(number)
    if math.isnan(number):
        return "NOT_A_NUMBER"
    if math.isinf(number):
        return "INFINITE" if number > 0.0 else "(-INFINITE)"
    if 1.0 - 2.0**-25 < number < 1.0:
        number = 1.0 - 2.0**-24  # numbers below one stay below it
    text = literal(number)
    return f"({text})" if text.startswith("-") else text


def join(a, b):
    """The type that holds values of both. Raises Untranslatable if there is none."""
    if a == b:
        return a
    if a in SCALARS and b in SCALARS:
        return max(a, b, key=SCALARS.index)
    if isinstance(a, Tuple) and isinstance(b, Tuple) and len(a.items) == len(b.items):
        return Tuple(tuple(map(join, a.items, b.items)))
    raise Untranslatable(f"a name or a result is {a} here and {b} there")


def safe_name(name: str) -> str:
    """A Python name as a GLSL one. No name that begins with it and goes on with an underscore has two of them in
    succession, which OpenGL reserves (GLSL 4.30 specification, section 3.7)."""
    name = re.sub("__+", "_", name.strip("_")) or "unused"
    return f"py_{name}" if name in _RESERVED or name.startswith("gl_") else name
