# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks kernels for which a back end has different code.

The GPU translates kernels to GLSL. For some of them it uses another kernel or hand-written GLSL
(``render.gpu.replacements``). A test compares the two lists.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable

_replaced: list[Callable] = []


def replaced_on_gpu(kernel):
    """Decorator of a kernel that the GPU replaces. If you change it, check the replacement, too."""
    _replaced.append(inspect.unwrap(kernel))
    return kernel


def all_replaced() -> tuple[Callable, ...]:
    """Python functions of all marked kernels in imported modules."""
    return tuple(_replaced)
