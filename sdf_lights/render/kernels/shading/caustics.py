# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics that are switched off: microfacets are black to the rays of diffuse bounces, as in Cycles."""

from ....jit import kernel
from ....vec import ZERO, put
from .records import GLOSSY, GLOSSY_TOON, MICROFACET, THIN_GLASS, TRANSMISSION, closure_table, surface_table


@kernel
def darken_microfacets(workspace, kept):
    """Take reflection, refraction or both from the microfacets of ``workspace.surface``; ``kept``: the bits of GLOSSY and
    TRANSMISSION that stay. What is drawn of them nevertheless carries nothing, so chances stay as they are."""
    closures = closure_table(workspace)
    for i in range(surface_table(workspace)[0].closure_count):
        closure = closures[i]
        if MICROFACET <= closure.kind <= GLOSSY_TOON:
            reflects = closure.reflects != 0 and kept & GLOSSY != 0 and closure.kind != THIN_GLASS
            transmits = closure.transmits != 0 and kept & TRANSMISSION != 0
            if not (reflects or transmits):
                put(closure.weight, ZERO)
            elif not reflects:
                put(closure.reflection_tint, ZERO)
            elif not transmits:
                put(closure.transmission_tint, ZERO)
