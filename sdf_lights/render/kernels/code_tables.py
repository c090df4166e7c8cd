# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of code: kernels that are compiled only for scenes that need them, and that others call by address."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping

import numpy as np

from ...jit import CallablePart


def addresses(kernels: Mapping[int, tuple[Callable, int]], places: int, records: tuple) -> np.ndarray:
    """(places,) int64 addresses for blocks and workspaces of these ``records``; 0 where there is no kernel.
    ``kernels``: by place, a kernel and its number of arguments. The code is kept for ever."""
    table = np.zeros(places, np.int64)
    for place, (kernel, count) in kernels.items():
        table[place] = _part(kernel, count, records).address
    return table


@functools.cache
def _part(kernel, count: int, records: tuple) -> CallablePart:
    return CallablePart(kernel, (), count, records)
