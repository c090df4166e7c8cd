# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What ``codegen_native`` and the code of ``native_emission`` must agree about."""

from __future__ import annotations

import hashlib
from typing import NamedTuple

from .functions import Function

SYMBOL = "read"  # of the function in the code

LANES = 8  # a cache line of doubles: two registers with AVX2, four with NEON


class Place(NamedTuple):
    """Position of a variable in the record of a surface: the byte of its first component, and "f8" or "i4"."""

    offset: int
    dtype: str


def part_symbol(function: Function, operands: int) -> str:
    """Identifies a function in code for formulas of the position: the same in each process, unlike its address.
    Raises ValueError for a function that needs a scene."""
    if function.scene:
        raise ValueError(f"{function.name!r} cannot be called in the formula of a shape")
    return symbol(function, operands, "position")


def symbol(function: Function, operands: int, context: object) -> str:
    """Identifies a function that code calls in some context."""
    known = function.kernel.__module__, function.kernel.__name__, function.static, function.scene, operands, context
    return f"sdf_lights_{hashlib.sha256(repr(known).encode()).hexdigest()[:24]}"


def library_symbol(name: str) -> str:
    """The symbol of a function of C's mathematics in code for formulas."""
    return f"sdf_lights_{name}"
