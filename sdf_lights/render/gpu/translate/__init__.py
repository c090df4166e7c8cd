# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Translates kernels to GLSL: the functions that Numba compiles for the CPU become source for a GPU, in float32.

A kernel is written once. It may contain what Numba's kernels of this project contain: scalars, tuples, records and
tables, calls of other kernels, ``if``, ``while`` and ``for … in range``. Types are inferred from the arguments of a
call. Each combination of types gives one GLSL function, named after its module and itself.

- float64 becomes float, all integers become int, but uint32 uint, and uint64 two of them; a tuple of two to four floats
  becomes a vector, any other tuple a structure.
- The block and the workspace are no arguments. A record of a table of the block is the int at which it begins in the
  buffer ``words``; tables of the workspace are global variables.
- Values of small integer fields are known from the scene's own tables (``Tables.values``): a comparison that can have
  one outcome only is decided here, so a program holds no code for kinds of lights, lobes or shapes that the scene
  lacks.

- An array of a kernel's module is read from the buffer where it is one of the scene's tables (``Tables.constant``).

GLSL has no recursion and no pointers. Kernels that need these, or call foreign code, have a function by the same name
in ``shaders_glsl/`` (see ``Native``).
"""

from .translator import Translator
from .values import (
    BLOCK,
    BOOL,
    CONSTANT,
    FLOAT,
    INT,
    SECONDARY,
    UINT,
    ULONG,
    VECTOR,
    WORKSPACE,
    Native,
    Ref,
    Tuple,
    Untranslatable,
    Value,
    known,
    safe_name,
)

__all__ = [
    "SECONDARY",
    "BLOCK",
    "BOOL",
    "CONSTANT",
    "FLOAT",
    "INT",
    "UINT",
    "ULONG",
    "VECTOR",
    "WORKSPACE",
    "Native",
    "Ref",
    "Translator",
    "Tuple",
    "Untranslatable",
    "Value",
    "known",
    "safe_name",
]
