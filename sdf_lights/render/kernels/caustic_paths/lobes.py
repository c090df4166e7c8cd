# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Narrow lobes: light of a lamp that such a lobe of the surface y scatters to the surface x, which the camera sees.

Paths from the camera find it by a ray from x to y. From there, a light ray and a ray of the BSDF find the lamp, so the
density of the last direction is about p(ω'|y) + q, with q = ``lamp_pdf``. As for mirrors, the weight of a caustic path
is R² / (1 + R²), with

    R = L · p(ω'|y) / (p(ω'|y) + q) · A |ng · ω| / (n p(ω|x)).

L, the ``lines``, and q are those of the targets around y. R is the same for light rays, rays of the BSDF and
connections, as it depends on the path alone.
"""

from __future__ import annotations

import numpy as np

from ....jit import kernel
from ....vec import largest, vec
from ..shading.records import MICROFACET, SUBSURFACE, VELVET, closure_table, surface_table
from .records import density_table

WIDEST = 0.2  # GGX roughness of a lobe that counts as narrow, at most: paths from the camera sample others well


@kernel
def has_narrow_lobe(workspace):
    """Whether the surface of the workspace has a narrow lobe that is no mirror, and light paths know all that it
    scatters."""
    surface, closures, found = surface_table(workspace)[0], closure_table(workspace), False
    if surface.strand or largest(vec(surface.transparency)) > 0.0:
        return False
    for index in range(surface.closure_count):
        closure = closures[index]
        if closure.kind > MICROFACET or closure.kind == VELVET or closure.kind == SUBSURFACE:
            return False
        found |= closure.kind == MICROFACET and closure.singular == 0 and closure.alpha <= WIDEST
    return found


@kernel
def weight_of(ratio):
    """The weight of a light path, by R."""
    square = ratio * ratio
    return square / (1.0 + square) if square < np.inf else 1.0


@kernel
def ratio_of_lobe(lines, lamp_pdf, pdf, rival):
    """R, for the density p(ω'|y) and ``rival``, A |ng · ω| / (n p(ω|x))."""
    return lines * rival * pdf / (pdf + lamp_pdf) if pdf > 0.0 else 0.0


@kernel
def left_by_lobe(workspace, lines, lamp_pdf, pdf, rival):
    """The part of the light of lamps that caustic paths leave to a path, which the surface of the workspace scatters
    with the density ``pdf``: all of it without a narrow lobe."""
    if not (lines > 0.0 and has_narrow_lobe(workspace)):
        return 1.0
    return 1.0 - weight_of(ratio_of_lobe(lines, lamp_pdf, pdf, rival))


@kernel
def is_source(block, emitter):
    """Whether caustic paths start at this emitter."""
    return emitter < block.lamp_count and density_table(block)[emitter] > 0.0
