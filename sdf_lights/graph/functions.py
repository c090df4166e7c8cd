# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions that formulas call but that are no formulas themselves: noise, look-ups in tables and images.

A ``Function`` names a kernel (see ``jit.kernel``). Numba compiles it, the GPU's translator writes it as GLSL, and
without Numba it runs as Python. So it is written only once.
"""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable, Sequence

import numpy as np

from ..frozen import frozen


@frozen
class Function:
    """``kernel(*static, *operands)`` returns a tuple of ``results`` numbers, or a single number if ``results`` is 1.

    ``static`` are integers that choose a mode; they are compiled in. With ``scene``, the kernel's first two arguments
    are the scene's block and the thread's workspace: ``kernel(block, workspace, *static, *operands)``. With
    ``of_object``, it reads objects or the one that a ray has hit, so it cannot be called without an object, as in a
    world. ``traces``: it traces rays.
    """

    name: str
    kernel: Callable
    static: tuple[int, ...] = ()
    results: int = 1
    scene: bool = False
    of_object: bool = False
    traces: bool = False
    tables = 0  # leading operands that are addresses


@frozen
class TableFunction(Function):
    """A field that reads tables (see ``tables``): ``kernel(*addresses, *coordinates)`` returns one number.

    The coordinates are any further operands: those of a point, and numbers. The kernel must end for all numbers, NaN
    and infinity too. ``bounds`` takes ``(*addresses, low, high, low, high, …)``, the bounds of each coordinate over a
    box, and gives ``(low, high, slope_low, slope_high, …)``: bounds of the value, and of its derivative by each
    coordinate. At a crease those of both sides are bounded. They are certain but for rounding, which it covers with
    ``interval_evaluation.MARGIN``. ``zero_bounds`` gives the same, but bounds derivatives only where the value is zero,
    which may be much closer. ``glsl`` is the source of ``float name(int table, …, float x, …)`` in float32, which reads
    the number i of all tables one after the other by ``table_number(i)``, and is told where its own begin; it may call
    what that of ``needs`` defines. ``derivatives`` takes what the kernel takes and gives the derivative by each
    coordinate.
    """

    tables: int = 1
    bounds: Function | None = None
    zero_bounds: Function | None = None
    derivatives: Function | None = None
    lipschitz: float = math.inf  # bound of the length of the gradient by all coordinates together
    glsl: str = ""
    needs: "tuple[TableFunction, ...]" = ()
    operations: float = 200.0  # that a point takes, as many as that of a formula: about 0.1 ns each
    boxes: int = 1  # a tree may have as many times as many, if the tables are small: for bounds loose in large boxes


def evaluate(function: Function, operands: Sequence[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Results of a function that needs no scene, for each point: (…) each, for operands that broadcast to (…)."""
    arrays = np.broadcast_arrays(*(np.asarray(operand, np.float64) for operand in operands))
    shape = arrays[0].shape if arrays else ()
    rows = np.stack([array.ravel() for array in arrays], axis=1) if arrays else np.empty((1, 0))
    results = np.empty((len(rows), function.results))
    from .. import jit  # not at the top: adding a lamp, and enabling the add-on, do not wait for Numba

    if jit.AVAILABLE and function.kernel is not inspect.unwrap(function.kernel):
        compiled_part(function, len(arrays)).fill(np.ascontiguousarray(rows), results)
    else:
        for row, values in zip(results, rows.tolist()):
            row[:] = function.kernel(*function.static, *values)
    return tuple(column.reshape(shape) for column in results.T)


@functools.cache
def compiled_part(function: Function, operands: int):
    """Machine code of a function that needs no scene, called with so many operands: a ``jit.CallablePart``."""
    from .. import jit

    return jit.CallablePart(function.kernel, function.static, operands, None)
