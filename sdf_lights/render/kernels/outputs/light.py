# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of the light of Combined: by the first scattering, and the number of scatterings."""

from __future__ import annotations

import numpy as np

from ....jit import kernel
from ....vec import ZERO, add, dot, put, vec
from ..path import NO_EMITTER, of_instance, path_table, sample_table
from ..shading.records import (
    CHIANG,
    GLOSSY,
    HUANG,
    INTO_SUBSURFACE,
    MICROFACET,
    SINGULAR,
    VELVET,
    closure_table,
    surface_table,
)
from ..shading.scattering import evaluate_closure, is_lit, lobes_lit
from .records import (
    LIGHT_NAMES,
    LOBES,
    emitter_group_table,
    emitter_pass_table,
    first_scattering_table,
    instance_group_table,
    light_place_table,
    output_sum_table,
)
from .state import LIGHT_RAY

_DIFFUSE, _GLOSSY = LIGHT_NAMES["diffuse_direct"], LIGHT_NAMES["glossy_direct"]
_TRANSMISSION, _VOLUME = LIGHT_NAMES["transmission_direct"], LIGHT_NAMES["volume_direct"]
_WHITE = (1.0, 1.0, 1.0)


@kernel
def is_diffuse(kind):
    """Whether a kind of closure counts as diffuse, as in Cycles."""
    return kind < MICROFACET and kind != VELVET


@kernel
def reflects_to(closure, wi):
    """Whether the light of a closure that is not diffuse towards wi counts as glossy, as in Cycles."""
    kind = closure.kind
    return (
        kind == VELVET
        or kind == CHIANG
        or kind == HUANG
        or closure.transmits == 0
        or dot(vec(closure.normal), wi) > 0.0
    )


@kernel
def divide(block, workspace, x, y, z, kind, kinds, row):
    """Compute the parts of the light from wi = (x, y, z) that the diffuse and the glossy lobes of the surface scatter.

    ``kind`` is that of ``shading.sample`` if a lobe was drawn, else 0; ``kinds``: see ``shading.evaluate``; the parts
    go to ``row``.
    """
    kind, kinds, wi, first = int(kind), int(kinds), (x, y, z), first_scattering_table(workspace)[int(row)]
    first.in_medium = 0
    if kind & SINGULAR:
        put(first.diffuse, _WHITE if kind & INTO_SUBSURFACE else ZERO)
        put(first.glossy, _WHITE if kind & GLOSSY else ZERO)
        return 0.0
    diffuse, glossy, total = ZERO, ZERO, ZERO
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    lobes = lobes_lit(surface, wi, kinds)
    for index in range(surface.closure_count):
        closure = closures[index]
        if closure.singular or not is_lit(closure, kinds, lobes):
            continue
        value, _ = evaluate_closure(block, workspace, index, wi)
        total = add(total, value)
        if is_diffuse(closure.kind):
            diffuse = add(diffuse, value)
        elif reflects_to(closure, wi):
            glossy = add(glossy, value)
    for axis in range(3):
        inverse = 1.0 / total[axis] if total[axis] != 0.0 else 0.0
        first.diffuse[axis] = diffuse[axis] * inverse
        first.glossy[axis] = glossy[axis] * inverse
    return 0.0


@kernel
def _add(sums, place, start, value):
    if place >= 0:
        for axis in range(3):
            sums[start + place + axis] += value[axis]


@kernel
def add_light(block, workspace, r, g, b, emitter, scatters):
    """Add the light from an emitter, after so many scatterings, which the path has added to Combined."""
    sums, places = output_sum_table(workspace), light_place_table(block)
    start = block.light_columns if sample_table(workspace)[0].divided else 0
    if path_table(workspace)[0].catches:
        _add(sums, block.caught_light, start, (r, g, b))
        return 0.0
    if block.outputs & LOBES and scatters > 0.0:
        by = first_scattering_table(workspace)[LIGHT_RAY if path_table(workspace)[0].bounce == 0 else 0]
        again = 1 if scatters > 1.0 else 0
        if by.in_medium:
            _add(sums, places[_VOLUME + again], start, (r, g, b))
        else:
            diffuse = (by.diffuse[0] * r, by.diffuse[1] * g, by.diffuse[2] * b)
            glossy = (by.glossy[0] * r, by.glossy[1] * g, by.glossy[2] * b)
            rest = (r - diffuse[0] - glossy[0], g - diffuse[1] - glossy[1], b - diffuse[2] - glossy[2])
            _add(sums, places[_DIFFUSE + again], start, diffuse)
            _add(sums, places[_GLOSSY + again], start, glossy)
            _add(sums, places[_TRANSMISSION + again], start, rest)
    emitter = np.int64(emitter)
    groups, owns = emitter_group_table(block), emitter_pass_table(block)
    if len(groups) > 0:
        if emitter >= 0:
            _add(sums, groups[emitter], start, (r, g, b))
        elif emitter < NO_EMITTER:
            _add(sums, instance_group_table(block)[of_instance(emitter)], start, (r, g, b))
    if len(owns) > 0 and emitter >= 0:
        _add(sums, owns[emitter], start, (r, g, b))
    return 0.0
