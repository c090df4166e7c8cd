# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures that few scenes have: a module each, compiled where a scene has it (see ``apart.py``).

A module has kernels ``evaluate`` and ``sample`` of its closure, and those that add closures for a lobe. What is kept in which
field of ``CLOSURE`` is up to the module.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .....jit import CallablePart
from ....tables import film as film_table
from .. import apart
from ..program import LOBE_PRINCIPLED
from ..records import (
    ASHIKHMIN_SHIRLEY,
    CHIANG,
    DIFFUSE_TOON,
    FACETS,
    GLOSSY_TOON,
    HAIR,
    HUANG,
    PORTAL,
    SUBSURFACE,
    THIN_GLASS,
    VELVET,
)
from ..shadow_shading import shaded_transparency
from ..special_lobes import (
    FIRST,
    LOBE_ASHIKHMIN_SHIRLEY,
    LOBE_CHIANG,
    LOBE_CONDUCTOR,
    LOBE_HAIR,
    LOBE_HUANG,
    LOBE_METALLIC,
    LOBE_PORTAL,
    LOBE_ROUGH_GLASS,
    LOBE_ROUGH_GLOSSY,
    LOBE_ROUGH_REFRACTION,
    LOBE_SHEEN,
    LOBE_SUBSURFACE,
    LOBE_TOON,
    LOBE_VELVET,
    WITH_FACETS,
    WITH_SUBSURFACE,
    WITH_THIN_SCATTERING,
    WITH_THIN_WALL,
)
from . import ashikhmin_shirley, chiang, facets, film, hair, huang, portal, subsurface, thin_wall, toon, velvet

TABLES = {**apart.TABLES, **film.TABLES}

# Lobe -> what adds its closures, and their kinds.
LOBES: dict[int, tuple[Callable, tuple[int, ...]]] = {
    LOBE_ROUGH_GLOSSY: (facets.add_glossy, (FACETS,)),
    LOBE_ASHIKHMIN_SHIRLEY: (ashikhmin_shirley.add_lobe, (ASHIKHMIN_SHIRLEY,)),
    LOBE_ROUGH_GLASS: (facets.add_glass, (FACETS,)),
    LOBE_ROUGH_REFRACTION: (facets.add_refraction, (FACETS,)),
    LOBE_METALLIC: (facets.add_metallic, (FACETS,)),
    LOBE_CONDUCTOR: (facets.add_conductor, (FACETS,)),
    LOBE_SHEEN: (velvet.add_sheen, ()),
    LOBE_VELVET: (velvet.add_lobe, (VELVET,)),
    LOBE_TOON: (toon.add_lobe, (DIFFUSE_TOON, GLOSSY_TOON)),
    LOBE_HAIR: (hair.add_lobe, (HAIR,)),
    LOBE_CHIANG: (chiang.add_lobe, (CHIANG,)),
    LOBE_HUANG: (huang.add_lobe, (HUANG,)),
    LOBE_PORTAL: (portal.add_lobe, (PORTAL,)),
    LOBE_SUBSURFACE: (subsurface.add_lobe, (SUBSURFACE,)),
}
# Kind of closure -> the module that evaluates and samples it.
CLOSURES = {
    FACETS: facets,
    ASHIKHMIN_SHIRLEY: ashikhmin_shirley,
    THIN_GLASS: thin_wall,
    VELVET: velvet,
    DIFFUSE_TOON: toon,
    GLOSSY_TOON: toon,
    HAIR: hair,
    CHIANG: chiang,
    HUANG: huang,
    PORTAL: portal,
    SUBSURFACE: subsurface,
}
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


_parts: dict[tuple, object] = {}


def _address(kernel, count: int, records: tuple) -> int:
    key = kernel, tuple(map(str, records))
    if key not in _parts:
        _parts[key] = CallablePart(kernel, (), count, records)
    return _parts[key].address


def tables(lobes: np.ndarray) -> dict[str, np.ndarray]:
    """Tables that these closures read."""
    return {"film": film_table.load() if {FACETS, THIN_GLASS} & kinds(lobes)[1] else np.zeros(1)}
