# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``dispatch.py`` calls, compiled for films with the passes that need them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...film import Film
from .. import code_tables
from . import catchers, data, dispatch, light, sums, vectors
from .pack import bits_of
from .records import CATCHERS, DATA, LIGHT, LOBES, VECTORS

# For each index of the table of code: the bits of ``outputs`` that need it, the kernel, and its number of arguments.
KERNELS: dict[int, tuple[int, Callable, int]] = {
    dispatch.CLEAR: (LIGHT | DATA, sums.clear, 1),
    dispatch.ADD: (LIGHT | DATA, sums.add_sample, 1),
    dispatch.LIGHT: (LIGHT, light.add_light, 5),
    dispatch.DIVIDE: (LOBES, light.divide, 6),
    dispatch.SURFACE: (DATA, data.add_surface, 1),
    dispatch.MISS: (DATA, data.add_miss, 1),
    dispatch.CATCH: (CATCHERS, catchers.catch, 1),
    dispatch.RELEASE: (CATCHERS, catchers.release, 1),
    dispatch.BARE: (CATCHERS, catchers.add_bare, 1),
    dispatch.VECTOR: (VECTORS, vectors.add_vector, 1),
    dispatch.BACKGROUND: (VECTORS, vectors.add_background_vector, 1),
}


def addresses(film: Film, records: tuple) -> np.ndarray:
    """The table "output_code" for the passes of ``film``, for blocks and workspaces of these ``records``. The kernels
    are compiled first and kept for ever."""
    return _addresses(bits_of(film), records)


def compile_all(records: tuple) -> None:
    """Compile all kernels here in advance."""
    _addresses(~0, records)


def _addresses(bits: int, records: tuple) -> np.ndarray:
    needed = {place: (kernel, count) for place, (some, kernel, count) in KERNELS.items() if bits & some}
    return code_tables.addresses(needed, len(dispatch.PLACES), records)
