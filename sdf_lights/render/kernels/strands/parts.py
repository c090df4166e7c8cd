# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kernels that ``apart.py`` and Embree call, compiled for scenes with curves or spheres."""

from __future__ import annotations

import numpy as np

from ....jit import CallablePart, Callback
from . import apart, departure, surface

_parts: dict[tuple, CallablePart] = {}
_callbacks: list[Callback] = []


def addresses(has_strands: bool, records: tuple) -> np.ndarray:
    """The table "strand_code", for blocks and workspaces of these ``records``. The code is kept for ever."""
    table = np.zeros(len(apart.PLACES), np.int64)
    if has_strands:
        key = tuple(map(str, records))
        if key not in _parts:
            _parts[key] = CallablePart(surface.fill, (), 6, records)
        table[apart.FILL] = _parts[key].address
    return table


def filter_address() -> int:
    """Address of ``departure.refuse``, in the form that Embree calls."""
    if not _callbacks:
        _callbacks.append(Callback(departure.refuse, departure.ARGUMENTS))
    return _callbacks[0].address
