# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures that few scenes have: one module each, compiled if a scene has it (see ``dispatch.py``).

A module of this folder has kernels ``evaluate`` and ``sample`` of its closures; ``CLOSURES``, the names of their kinds;
and ``LOBES``: for each lobe the kernel that adds its closures, and their kinds. Each module defines its own use of the
fields of ``CLOSURE``.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable

import numpy as np

from .....jit import CallablePart, layout
from ....tables import thin_film as thin_film_table
from .. import dispatch
from ..material_records import LOBE_PRINCIPLED
from ..records import FACETS, SUBSURFACE, THIN_GLASS
from ..shadow_shading import shaded_transparency
from ..special_lobes import (
    FIRST,
    LOBE_SUBSURFACE,
    METHOD,
    WITH_FACETS,
    WITH_SUBSURFACE,
    WITH_THIN_SCATTERING,
    WITH_THIN_WALL,
)
from . import facets, subsurface, thin_film, thin_wall

TABLES = {**dispatch.TABLES, **thin_film.TABLES}

# ``jit`` counts all modules of this folder as sources.
_MODULES = [importlib.import_module(f".{item.name}", __name__) for item in pkgutil.iter_modules(__path__)]

# Lobe -> the kernel that adds its closures, and their kinds.
LOBES: dict[int, tuple[Callable, tuple[int, ...]]] = {
    lobe: row for module in _MODULES for lobe, row in getattr(module, "LOBES", {}).items()
}
# Kind of closure -> the module that evaluates and samples it.
CLOSURES = {kind: module for module in _MODULES for kind in getattr(module, "CLOSURES", ())}
# Kernels called by Principled.
REFINE, THIN_WALL, SCATTERING = facets.refine, thin_wall.add_lobe, subsurface.add_principled
# Kernels called by light rays at thin walls.
TRANSPARENCY = shaded_transparency

# Number of arguments of each of these.
_ADD, _REFINE, _THIN_WALL, _TRANSPARENCY, _SCATTERING, _EVALUATE, _SAMPLE = 2, 3, 4, 1, 5, 4, 4


def kinds(lobes: np.ndarray) -> tuple[set[int], set[int], bool, bool, bool]:
    """For the lobes (n,), rows of ``LOBE``, of a scene: kinds of lobe and of closure in this package, whether
    Principled has such microfacets, whether it can be a thin wall, and whether it has subsurface scattering."""
    principled = lobes["features"][lobes["kind"] == LOBE_PRINCIPLED]
    refined, thin = bool((principled & WITH_FACETS).any()), bool((principled & WITH_THIN_WALL).any())
    deep = bool((principled & (WITH_SUBSURFACE | WITH_THIN_SCATTERING)).any())
    found = {int(kind) for kind in np.unique(lobes["kind"])} & set(LOBES)
    closures = {closure for kind in found for closure in LOBES[kind][1]}
    if refined:
        closures.add(FACETS)
    if thin:
        closures.add(THIN_GLASS)
    if (principled & WITH_SUBSURFACE).any():
        closures.add(SUBSURFACE)
    return found, closures & set(CLOSURES), refined, thin, deep


def methods(lobes: np.ndarray) -> set[int]:
    """Methods of subsurface scattering (``records.BURLEY`` …) of the lobes (n,) of a scene."""
    features = lobes["features"]
    deep = (lobes["kind"] == LOBE_SUBSURFACE) | (lobes["kind"] == LOBE_PRINCIPLED) & (features & WITH_SUBSURFACE != 0)
    return {int(method) for method in np.unique(features[deep] >> METHOD & 3)}


def addresses(lobes: np.ndarray, records: tuple) -> np.ndarray:
    """The table "special_code" of a scene with these lobes (n,), for blocks and workspaces of these ``records``. The
    code is compiled first and kept for ever."""
    table = np.zeros(dispatch.PLACES, np.int64)
    found, closures, refined, thin, deep = kinds(lobes)
    if refined:
        table[dispatch.REFINE] = _address(REFINE, _REFINE, records)
    if thin:
        table[dispatch.THIN_WALL] = _address(THIN_WALL, _THIN_WALL, records)
        table[dispatch.TRANSPARENCY] = _address(TRANSPARENCY, _TRANSPARENCY, records)
    if deep:
        table[dispatch.SUBSURFACE] = _address(SCATTERING, _SCATTERING, records)
    for kind in found:
        table[dispatch.ADD + kind - FIRST] = _address(LOBES[kind][0], _ADD, records)
    for kind in closures:
        table[dispatch.EVALUATE + kind] = _address(CLOSURES[kind].evaluate, _EVALUATE, records)
        table[dispatch.SAMPLE + kind] = _address(CLOSURES[kind].sample, _SAMPLE, records)
    return table


def _all() -> list[tuple[Callable, int]]:
    """All kernels here, with their number of arguments."""
    found = [(REFINE, _REFINE), (THIN_WALL, _THIN_WALL), (TRANSPARENCY, _TRANSPARENCY), (SCATTERING, _SCATTERING)]
    found += [(add, _ADD) for add, _ in LOBES.values()]
    for closure in CLOSURES.values():
        found += [(closure.evaluate, _EVALUATE), (closure.sample, _SAMPLE)]
    return found


def kernels() -> list[Callable]:
    """All kernels here."""
    return [kernel for kernel, _ in _all()]


def compile_all(records: tuple) -> None:
    """Compile all kernels here in advance."""
    for kernel, count in _all():
        _address(kernel, count, records)


_parts: dict[tuple, object] = {}


def _address(kernel, count: int, records: tuple) -> int:
    key = kernel, layout(records)
    if key not in _parts:
        _parts[key] = CallablePart(kernel, (), count, records)
    return _parts[key].address


def tables(lobes: np.ndarray) -> dict[str, np.ndarray]:
    """Tables that the closures of these lobes (n,) read."""
    return {"thin_film": thin_film_table.load() if {FACETS, THIN_GLASS} & kinds(lobes)[1] else np.zeros(1)}
