# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures that few scenes have: a module each, compiled where a scene has it (see ``apart.py``).

A module of this folder has kernels ``evaluate`` and ``sample`` of its closures, ``CLOSURES`` that names their kinds, and ``LOBES``: of
each lobe the kernel that adds its closures, and their kinds. What is kept in which field of ``CLOSURE`` is up to the module.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable

import numpy as np

from .....jit import CallablePart
from ....tables import thin_film as film_table
from .. import apart
from ..material_compiler import LOBE_PRINCIPLED
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

TABLES = {**apart.TABLES, **thin_film.TABLES}

# ``jit`` counts all modules of this folder as sources.
_MODULES = [importlib.import_module(f".{item.name}", __name__) for item in pkgutil.iter_modules(__path__)]

# Lobe -> what adds its closures, and their kinds.
LOBES: dict[int, tuple[Callable, tuple[int, ...]]] = {
    lobe: row for module in _MODULES for lobe, row in getattr(module, "LOBES", {}).items()
}
# Kind of closure -> the module that evaluates and samples it.
CLOSURES = {kind: module for module in _MODULES for kind in getattr(module, "CLOSURES", ())}
# What Principled calls.
REFINE, THIN_WALL, SCATTERING = facets.refine, thin_wall.add_lobe, subsurface.add_principled
# What light rays call at thin walls.
TRANSPARENCY = shaded_transparency

# Numbers that each of these is given.
_ADD, _REFINE, _THIN_WALL, _TRANSPARENCY, _SCATTERING, _EVALUATE, _SAMPLE = 2, 3, 4, 1, 5, 4, 4


def kinds(lobes: np.ndarray) -> tuple[set[int], set[int], bool, bool, bool]:
    """Of the lobes (rows of ``LOBE``) of a scene: kinds of lobe and of closure that are in this package, whether Principled has
    microfacets of it, whether it can be a thin wall, and whether it scatters below the surface."""
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
    """Methods of scattering below surfaces (``records.BURLEY`` …) of the lobes of a scene."""
    features = lobes["features"]
    deep = (lobes["kind"] == LOBE_SUBSURFACE) | (lobes["kind"] == LOBE_PRINCIPLED) & (features & WITH_SUBSURFACE != 0)
    return {int(method) for method in np.unique(features[deep] >> METHOD & 3)}


def addresses(lobes: np.ndarray, records: tuple) -> np.ndarray:
    """The table "special_code" of a scene with these lobes, for blocks and workspaces of these ``records``. What it points at
    is compiled first and kept for good."""
    table = np.zeros(apart.PLACES, np.int64)
    found, closures, refined, thin, deep = kinds(lobes)
    if refined:
        table[apart.REFINE] = _address(REFINE, _REFINE, records)
    if thin:
        table[apart.THIN_WALL] = _address(THIN_WALL, _THIN_WALL, records)
        table[apart.TRANSPARENCY] = _address(TRANSPARENCY, _TRANSPARENCY, records)
    if deep:
        table[apart.SUBSURFACE] = _address(SCATTERING, _SCATTERING, records)
    for kind in found:
        table[apart.ADD + kind - FIRST] = _address(LOBES[kind][0], _ADD, records)
    for kind in closures:
        table[apart.EVALUATE + kind] = _address(CLOSURES[kind].evaluate, _EVALUATE, records)
        table[apart.SAMPLE + kind] = _address(CLOSURES[kind].sample, _SAMPLE, records)
    return table


def _all() -> list[tuple[Callable, int]]:
    """All kernels here, and how many numbers each takes."""
    found = [(REFINE, _REFINE), (THIN_WALL, _THIN_WALL), (TRANSPARENCY, _TRANSPARENCY), (SCATTERING, _SCATTERING)]
    found += [(add, _ADD) for add, _ in LOBES.values()]
    for closure in CLOSURES.values():
        found += [(closure.evaluate, _EVALUATE), (closure.sample, _SAMPLE)]
    return found


def kernels() -> list[Callable]:
    """All kernels here."""
    return [kernel for kernel, _ in _all()]


def compile_all(records: tuple) -> None:
    """Compile all kernels here, before a scene asks for them."""
    for kernel, count in _all():
        _address(kernel, count, records)


_parts: dict[tuple, object] = {}


def _address(kernel, count: int, records: tuple) -> int:
    key = kernel, tuple(map(str, records))
    if key not in _parts:
        _parts[key] = CallablePart(kernel, (), count, records)
    return _parts[key].address


def tables(lobes: np.ndarray) -> dict[str, np.ndarray]:
    """Tables that these closures read."""
    return {"film": film_table.load() if {FACETS, THIN_GLASS} & kinds(lobes)[1] else np.zeros(1)}
