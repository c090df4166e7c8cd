# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How surfaces scatter a light path: what a path from the camera would find there, the other way round."""

from __future__ import annotations

from ....jit import kernel
from ....vec import ZERO, add, average, dot, mul, negate, scale, sub, vec
from ..shading import evaluate
from ..shading.microfacet import reflectance
from ..shading.records import (
    DIFFUSE,
    MICROFACET,
    SCATTERED,
    SINGULAR,
    STRAIGHT,
    TRANSPARENT,
    closure_table,
    surface_table,
)
from .records import FOLLOW_ALL, material_table

SAME_DIRECTION = 1.0 - 1e-9  # cosine of the angle between what a mirror gives and what it should
CLEAR = 1.01  # factor of the height that ``specular_normal`` raises mirror directions to: bent ones are just there


@kernel
def mirrored(workspace, wi):
    """What singular closures scatter from wi to the surface's wo, the chance with which they are drawn, and the ratio
    of the solid angle at wo to that at wi, by the cosines there."""
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    wo, total, chance, ratio = vec(surface.wo), ZERO, 0.0, 1.0
    for index in range(surface.closure_count):
        closure = closures[index]
        if closure.kind != MICROFACET or closure.singular == 0 and closure.ior != 1.0:
            continue
        n = vec(closure.normal)
        cosine = dot(n, wo)
        if cosine <= 0.0:
            continue
        r, t, cosine_t = reflectance(closure, cosine)
        all_of_it = average(add(r, t))
        if all_of_it <= 0.0:
            continue
        back = sub(scale(n, 2.0 * cosine), wo)
        if dot(back, wi) > SAME_DIRECTION:
            total = add(total, mul(r, vec(closure.weight)))
            chance += closure.pick * average(r) / all_of_it
            continue
        eta = 1.0 / closure.ior
        through = negate(wo) if closure.ior == 1.0 else sub(scale(n, eta * cosine - cosine_t), scale(wo, eta))
        if dot(through, wi) > SAME_DIRECTION:
            total = add(total, mul(t, vec(closure.weight)))
            chance += closure.pick * average(t) / all_of_it
            ratio = abs(dot(n, wi)) * closure.ior * closure.ior / cosine
    return total, chance, ratio


@kernel
def scattered_flux(block, workspace, wi, kind, pdf):
    """Factor of the flux that came from wi and left along the wo of the workspace's surface, which was drawn with
    ``pdf``; and the chance that a path from the camera, which scatters from wo to wi, counts this as glossy, not as
    diffuse."""
    surface = surface_table(workspace)[0]
    if kind & TRANSPARENT:
        return scale(vec(surface.transparency), 1.0 / pdf), 0.0
    ng = vec(surface.ng)
    turn = abs(dot(ng, vec(surface.wo))) / (abs(dot(ng, wi)) * pdf)
    if kind & SINGULAR:
        value, _, ratio = mirrored(workspace, wi)
        return scale(value, turn * ratio), 1.0
    kinds = SCATTERED if material_table(block)[surface.material] & FOLLOW_ALL else DIFFUSE
    value, density, glossy_pdf = evaluate(block, workspace, wi, kinds)
    return scale(value, turn), glossy_pdf / density if density > 0.0 else 0.0


@kernel
def _is_unbent(n, ng, d):
    """Whether ``closures.specular_normal`` leaves the normal n of a mirror as it is, and clearly so, where it is seen
    along d, from either side."""
    side = dot(ng, d)
    height = abs(side)
    mirrored_height = 2.0 * (dot(n, d) if side > 0.0 else -dot(n, d)) * dot(n, ng) - height
    return mirrored_height >= CLEAR * min(0.9 * height, 0.01)


@kernel
def is_reversible(workspace, wi):
    """Whether the surface of the workspace scatters wi to its wo as a mirror or as sharp glass, and would scatter wo to
    wi with the same normals.

    Paths from the camera bend normals by their direction of view (``closures.specular_normal``), and light paths by
    another. A surface with singular closures that ``mirrored`` does not know is not reversible."""
    surface, closures, found = surface_table(workspace)[0], closure_table(workspace), False
    wo, ng = vec(surface.wo), vec(surface.ng)
    for index in range(surface.closure_count):
        closure = closures[index]
        if closure.kind != MICROFACET:
            if closure.singular and closure.kind != STRAIGHT:
                return False
            continue
        if closure.singular == 0 and closure.ior != 1.0:
            continue
        n = vec(closure.normal)
        cosine = dot(n, wo)
        if cosine <= 0.0:
            continue
        hit = closure.singular != 0 and dot(sub(scale(n, 2.0 * cosine), wo), wi) > SAME_DIRECTION
        if not hit and closure.transmits:
            _, _, cosine_t = reflectance(closure, cosine)
            eta = 1.0 / closure.ior
            if closure.ior == 1.0:
                hit = -dot(wo, wi) > SAME_DIRECTION
            elif cosine_t > 0.0:
                hit = dot(sub(scale(n, eta * cosine - cosine_t), scale(wo, eta)), wi) > SAME_DIRECTION
        if hit:
            if not (_is_unbent(n, ng, wo) and _is_unbent(n, ng, wi)):
                return False
            found = True
    return found
