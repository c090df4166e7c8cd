# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that a back end has code of its own for: each says so where it is defined.

The GPU translates kernels to GLSL. Some of them stand for what it does in another way: another kernel, or GLSL by hand, takes
their place (``render.gpu.replacements``). A test compares the two lists.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable

_replaced: list[Callable] = []


def replaced_on_gpu(kernel):
    """Decorator of a kernel in whose place the GPU has something else. Who changes it looks there, too."""
    _replaced.append(inspect.unwrap(kernel))
    return kernel


def all_replaced() -> tuple[Callable, ...]:
    """Python functions of all kernels that were marked, of the modules that have been imported."""
    return tuple(_replaced)
