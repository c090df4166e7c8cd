# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates and samples all closures of a surface together: the one-sample model with the balance heuristic."""

import math

import numpy as np

from ....jit import kernel
from ....vec import ZERO, add, dot, frame, mul, negate, scale, to_world, vec
from . import diffuse, dispatch, microfacet
from .records import (
    DIFFUSE,
    GLOSSY,
    LAMBERT,
    MICROFACET,
    OREN_NAYAR,
    SHEEN,
    SINGULAR,
    STRAIGHT,
    TRANSLUCENT,
    TRANSMISSION,
    TRANSPARENT,
    VELVET,
    closure_table,
    surface_table,
)

_BELOW_ONE = 1.0 - 2.0**-53


@kernel
def _bump_shadowing(surface, closure, wi):
    """Factor on a closure whose normal is not the surface's.

    As in Cycles, it applies to all light rays, and to sampled directions of diffuse reflection. Light from behind the
    unbumped surface is cut. Near the horizon diffuse closures darken gradually, by Conty Estevez, Lecocq and Stein
    2019, "A microfacet-based shadowing function to solve the bump terminator problem"; not where the material leaves
    bumps uncorrected.
    """
    smooth, n = vec(surface.n), vec(closure.normal)
    cosine, tilt = dot(smooth, wi), dot(smooth, n)
    if cosine * tilt * dot(n, wi) < 0.0:
        return 0.0
    if closure.kind >= MICROFACET or surface.uncorrected:
        return 1.0
    cosine, tilt = abs(cosine), abs(tilt)
    if tilt >= 1.0 or cosine >= 1.0:
        return 1.0
    if cosine < 1e-6:
        return 0.0
    alpha2 = min(0.125 * (1.0 / (tilt * tilt) - 1.0), 1.0)
    return 1.0 / (1.0 + microfacet.masking(alpha2, cosine))


@kernel
def evaluate_closure(block, workspace, index, wi):
    """f · |cos| of a closure with its weight, and its pdf."""
    surface, closure = surface_table(workspace)[0], closure_table(workspace)[index]
    kind = closure.kind
    if kind == LAMBERT or kind == TRANSLUCENT:
        cosine = dot(vec(closure.normal), wi)
        pdf = max(cosine if kind == LAMBERT else -cosine, 0.0) / math.pi
        value = (pdf, pdf, pdf)
    elif kind == MICROFACET:
        value, pdf = microfacet.evaluate(closure, vec(surface.wo), wi)
    elif kind == OREN_NAYAR:
        value = diffuse.oren_nayar(closure, vec(surface.wo), wi)
        pdf = max(dot(vec(closure.normal), wi), 0.0) / math.pi
    elif kind == SHEEN:
        pdf = diffuse.sheen(closure, vec(surface.wo), wi)
        value = (pdf, pdf, pdf)
    else:
        r, g, b, pdf = dispatch.evaluate(block, workspace, kind, index, wi[0], wi[1], wi[2])
        value = (r, g, b)
    if pdf <= 0.0:
        return ZERO, 0.0
    value = mul(value, vec(closure.weight))
    return scale(value, _bump_shadowing(surface, closure, wi)) if closure.bumped else value, pdf


@kernel
def lobes_lit(surface, wi, kinds):
    """Those of these ``kinds`` of scattering whose lobes scatter light from wi."""
    return kinds & (TRANSMISSION if dot(vec(surface.ng), wi) < 0.0 else GLOSSY)


@kernel
def is_lit(closure, kinds, lobes):
    """Whether the scattering of a closure is of one of these ``kinds``; ``lobes``: see ``lobes_lit``. To lights, velvet
    is glossy, as in Cycles."""
    return (lobes if closure.kind >= MICROFACET or closure.kind == VELVET else kinds & DIFFUSE) != 0


@kernel
def evaluate(block, workspace, wi, kinds):
    """f · |cos| (RGB) of all closures that are not singular, the pdf with which ``sample`` draws wi, and the part of
    that pdf from lobes.

    Closures whose scattering is of none of these ``kinds`` count only in the pdf: an emitter is not visible to them.
    """
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    total, density, glossy_pdf = ZERO, 0.0, 0.0
    lobes = lobes_lit(surface, wi, kinds)
    for i in range(surface.closure_count):
        closure = closures[i]
        if closure.singular == 0:
            value, pdf = evaluate_closure(block, workspace, np.int64(i), wi)
            if is_lit(closure, kinds, lobes):
                total = add(total, value)
            density += closure.pick * pdf
            if closure.kind >= MICROFACET:
                glossy_pdf += closure.pick * pdf
    return total, density, glossy_pdf


@kernel
def has_lobes(workspace):
    """Whether the surface has lobes that are not singular."""
    closures = closure_table(workspace)
    for i in range(surface_table(workspace)[0].closure_count):
        if closures[i].singular == 0 and closures[i].kind >= MICROFACET:
            return True
    return False


@kernel
def transmits(workspace):
    """Whether light on the far side of the surface matters, other than straight through or mirrored."""
    closures = closure_table(workspace)
    for i in range(surface_table(workspace)[0].closure_count):
        closure = closures[i]
        if closure.singular == 0 and (closure.kind == TRANSLUCENT or closure.kind >= MICROFACET and closure.transmits):
            return True
    return False


@kernel
def _sample_closure(block, workspace, index, u1, u2, u3):
    """wi, f · |cos| with the closure's weight, pdf, and kind."""
    surface, closure = surface_table(workspace)[0], closure_table(workspace)[index]
    wo, kind = vec(surface.wo), closure.kind
    if kind == MICROFACET:
        wi, value, pdf, through, singular = microfacet.sample(closure, wo, u1, u2, u3)
        side = TRANSMISSION if through else GLOSSY
        return wi, mul(value, vec(closure.weight)), pdf, side | SINGULAR if singular else side
    if kind == STRAIGHT:
        return negate(wo), vec(closure.weight), 1.0, TRANSPARENT | SINGULAR
    if kind > SHEEN:
        x, y, z, red, green, blue, pdf, side = dispatch.sample(block, workspace, kind, index, u1, u2, u3)
        return (x, y, z), mul((red, green, blue), vec(closure.weight)), pdf, int(side)
    n = vec(closure.normal)
    if kind == SHEEN:
        wi = diffuse.sheen_sample(closure, wo, u1, u2)
    else:
        if kind == TRANSLUCENT:
            n = negate(n)
        t, b = frame(n)
        wi = to_world(diffuse.cosine_hemisphere(u1, u2), t, b, n)
    if kind == TRANSLUCENT:
        pdf = max(dot(n, wi), 0.0) / math.pi
        return wi, scale(vec(closure.weight), pdf), pdf, TRANSMISSION
    value, pdf = evaluate_closure(block, workspace, index, wi)
    return wi, value, pdf, DIFFUSE


@kernel
def sample(block, workspace, u1, u2, u3):
    """Draw a direction from all closures: wi, f · |cos| (RGB), pdf, the part of the pdf from lobes, and kind (see
    records.py).

    A pdf of 0 means that nothing was drawn. For a singular kind value / pdf is the path's weight, and neither is a
    density.
    """
    surface, closures = surface_table(workspace)[0], closure_table(workspace)
    count = surface.closure_count
    if count == 0:
        return ZERO, ZERO, 0.0, 0.0, 0
    chosen = 0
    if count > 1:
        while chosen < count - 1 and u3 >= closures[chosen].pick:
            u3 -= closures[chosen].pick
            chosen += 1
        if not closures[chosen].pick > 0.0:  # the last one is black, and the others' sum is below 1 by rounding
            return ZERO, ZERO, 0.0, 0.0, 0
        u3 = min(u3 / closures[chosen].pick, _BELOW_ONE)
    closure = closures[chosen]
    wi, value, pdf, kind = _sample_closure(block, workspace, chosen, u1, u2, u3)
    if not 0.0 < pdf < math.inf:
        return ZERO, ZERO, 0.0, 0.0, 0
    if not kind & TRANSPARENT:
        # A direction must leave on the side of its kind, for any shading normal. Curves have no other normal.
        if surface.strand == 0 and (dot(vec(surface.ng), wi) < 0.0) != (kind & TRANSMISSION != 0):
            return ZERO, ZERO, 0.0, 0.0, 0
        if closure.bumped and SHEEN < closure.kind < MICROFACET:
            value = scale(value, _bump_shadowing(surface, closure, wi))
    pdf *= closure.pick
    glossy_pdf = pdf if closure.kind >= MICROFACET else 0.0
    if count > 1 and not kind & SINGULAR:
        for i in range(count):
            other = closures[i]
            if i != chosen and other.singular == 0:
                others, density = evaluate_closure(block, workspace, np.int64(i), wi)
                value = add(value, others)
                pdf += other.pick * density
                if other.kind >= MICROFACET:
                    glossy_pdf += other.pick * density
    return wi, value, pdf, glossy_pdf, kind
