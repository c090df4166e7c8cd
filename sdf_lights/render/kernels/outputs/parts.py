# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a film's passes need of kernels: addresses, places and scalars."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ....jit import CallablePart
from ...film import Film
from ...material import UV
from ...passes import BY_NAME, DATA_SUMS, LIGHT_SUMS, Rule
from ...scene import Scene
from . import apart, data, light, sums
from .records import DATA, LIGHT, LOBES
from .state import LIGHT_RAY

# Of each place of the table of code: the bits of ``outputs`` that need it, the kernel, and how many numbers it is given.
_KERNELS: dict[int, tuple[int, Callable, int]] = {
    apart.CLEAR: (LIGHT | DATA, sums.clear, 1),
    apart.ADD: (LIGHT | DATA, sums.add_sample, 1),
    apart.LIGHT: (LIGHT, light.add_light, 5),
    apart.DIVIDE: (LOBES, light.divide, 6),
    apart.SURFACE: (DATA, data.add_surface, 1),
    apart.LEAVE: (DATA, data.leave, 1),
}
_parts: dict[tuple, CallablePart] = {}


def bits_of(film: Film) -> int:
    """``outputs`` of a film."""
    return (LIGHT | LOBES) * bool(film.light_places) | DATA * bool(film.data_places)


def pack(scene: Scene, film: Film, records: tuple) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Tables and scalars for the passes of ``film``, for blocks and workspaces of these ``records``. The kernels are compiled
    first and kept for good."""
    bits = bits_of(film)
    code = np.zeros(len(apart.PLACES), np.int64)
    for place, (needed, kernel, count) in _KERNELS.items():
        if bits & needed:
            key = place, tuple(map(str, records))
            if key not in _parts:
                _parts[key] = CallablePart(kernel, (), count, records)
            code[place] = _parts[key].address
    numbers = np.zeros(film.data_sums.shape[1], np.int64)
    for name in film.passes:
        if BY_NAME[name].rule is Rule.NUMBER:
            numbers[film.data_places[BY_NAME[name].source]] = 1
    tables = {
        "output_code": code,
        "film_light": film.light_sums.ravel(),
        "film_data": film.data_sums.ravel(),
        "light_places": np.array([film.light_places.get(name, -1) for name in LIGHT_SUMS], np.int64),
        "data_places": np.array([film.data_places.get(name, -1) for name in DATA_SUMS], np.int64),
        "data_numbers": numbers,
    }
    attributes = scene.looked_up()
    scalars = {
        "outputs": bits,
        "light_columns": film.light_sums.shape[1] // 2,
        "data_columns": film.data_sums.shape[1],
        "uv_attribute": attributes.index(UV) if UV in attributes else 0,
        "mist_start": scene.mist.start,
        "mist_inverse_depth": 1.0 / scene.mist.depth if scene.mist.depth > 0.0 else 0.0,
        "mist_power": scene.mist.power,
    }
    return tables, scalars


def workspace_counts(film: Film) -> dict[str, int]:
    """Elements of a workspace's tables."""
    return {
        "first_scatterings": LIGHT_RAY + 1 if film.light_places else 0,
        "output_sums": film.light_sums.shape[1] + film.data_sums.shape[1],
    }
