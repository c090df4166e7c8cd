# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics with less noise, as in Cycles: microfacets that are black for rays after diffuse bounces, and lobes that are
blurred for rays with a small pdf."""

import math

import numpy as np

from ....jit import kernel
from ....vec import ZERO, add, average, dot, put, vec
from .microfacet import is_singular, reflectance
from .records import (
    ASHIKHMIN_SHIRLEY,
    CHIANG,
    FACETS,
    GLOSSY,
    HUANG,
    LAST_GLOSSY,
    MICROFACET,
    THIN_GLASS,
    TRANSMISSION,
    closure_table,
    surface_table,
)

SCALARS = [
    ("filter_glossy", np.float64),  # blurs what rays of a density below it meet
    ("caustics", np.int64),  # bits of GLOSSY and TRANSMISSION: what may follow a diffuse bounce
]

LEAST_LEFT = 0.05  # part of a closure's probability that stays at least, if it loses reflection or refraction


@kernel
def darken_microfacets(workspace, kept):
    """Remove reflection, refraction or both from the microfacets of ``workspace.surface``; ``kept``: the bits of GLOSSY
    and TRANSMISSION that stay. Black closures draw no directions: what other closures scatter there would count as
    glossy."""
    surface, closures, total = surface_table(workspace)[0], closure_table(workspace), 0.0
    for i in range(surface.closure_count):
        closure = closures[i]
        if MICROFACET <= closure.kind <= LAST_GLOSSY:
            reflects = closure.reflects != 0 and kept & GLOSSY != 0 and closure.kind != THIN_GLASS
            transmits = closure.transmits != 0 and kept & TRANSMISSION != 0
            if not (reflects or transmits):
                put(closure.weight, ZERO)
                closure.pick = 0.0
            elif closure.kind != THIN_GLASS and closure.reflects and closure.transmits and not (reflects and transmits):
                r, t, _ = reflectance(closure, abs(dot(vec(closure.normal), vec(surface.wo))))
                whole = average(add(r, t))
                if reflects:
                    rest = average(r)
                    put(closure.transmission_tint, ZERO)
                else:
                    rest = average(t)
                    put(closure.reflection_tint, ZERO)
                # Microfacets that are turned away may scatter some light even where the smooth surface has none left.
                closure.pick *= max(rest, LEAST_LEFT * whole) / whole if whole > 0.0 else 1.0
        total += closure.pick
    if total > 0.0:
        for i in range(surface.closure_count):
            closures[i].pick /= total
    else:
        surface.closure_count = surface.evaluable = 0


@kernel
def blur_lobes(block, workspace, density):
    """Make the lobes of ``workspace.surface`` at least as rough as Filter Glossy asks, for a path of this least
    ``density`` (1/sr). Their total scattering stays the same, as in Cycles."""
    if density >= block.filter_glossy:
        return
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    roughness = 0.5 * math.sqrt(1.0 - density / block.filter_glossy)
    for i in range(surface.closure_count):
        closure = closures[i]
        kind = closure.kind
        facets = MICROFACET <= kind <= THIN_GLASS
        if facets or kind == CHIANG or kind == HUANG:
            closure.alpha = max(closure.alpha, roughness)
        if kind == FACETS or kind == ASHIKHMIN_SHIRLEY or kind == CHIANG:
            closure.a = max(closure.a, roughness)
        if kind == CHIANG:
            closure.b = max(closure.b, roughness)
        if facets and closure.singular != 0 and not is_singular(roughness):
            closure.singular = 0
            surface.evaluable += 1
