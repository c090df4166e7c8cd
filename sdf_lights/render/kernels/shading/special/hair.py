# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair BSDF: one lobe of reflection or of transmission by a thin fiber, after Marschner et al. 2003, "Light scattering
from human hair fibers". A Cauchy distribution along the fiber, about the mirror direction; about it a cosine or another
Cauchy distribution.

Fields of the closure: the tangent; alpha is the roughness along the fiber, a that around it, b the tilt of its scales.
"""

import math

from .....jit import kernel
from .....vec import add, cross, dot, frame, madd, normalize, put, scale, vec
from ..closures import begin, finish, lobe_table, positive, specular_normal
from ..material_records import NONE
from ..operands import number, vector
from ..records import GLOSSY, HAIR, TRANSMISSION, closure_table, surface_table
from ..special_lobes import lobe_kind, option

_IS_TRANSMISSION = option("hair", "component", "TRANSMISSION")
_HALF_PI = 0.5 * math.pi
_ALONG = _HALF_PI - 0.001  # inclinations beyond count as along the fiber
_NO_DIRECTION = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0)


@kernel
def add_lobe(block, workspace, lobe, weight):
    """Add the closure of lobe number ``lobe``, with this weight."""
    lobe, surface = lobe_table(block)[int(lobe)], surface_table(workspace)[0]
    args = lobe.args
    color = scale(positive(vector(block, workspace, args[0])), weight)
    index = begin(workspace, color, specular_normal(surface, vec(surface.n)))
    if index < 0:
        return 0.0
    closure = closure_table(workspace)[index]
    closure.kind = HAIR
    closure.transmits = int(lobe.features & _IS_TRANSMISSION != 0)
    closure.reflects = 1 - closure.transmits
    closure.alpha = min(max(number(block, workspace, args[2]), 0.001), 1.0)
    closure.a = min(max(number(block, workspace, args[3]), 0.001), 1.0)
    closure.b = -number(block, workspace, args[1])
    if args[4] == NONE and surface.strand:
        put(closure.tangent, normalize(vec(surface.dpdu)))
    elif args[4] == NONE:
        # On a mesh the direction of hair is unknown.
        put(closure.tangent, normalize(vec(surface.dpdv)))
        closure.b = 0.0
    else:
        put(closure.tangent, normalize(vector(block, workspace, args[4])))
    finish(workspace, index, color)
    return 0.0


@kernel
def _across(closure, w):
    """Inclination of w towards the fiber, and its direction projected along the fiber."""
    t = vec(closure.tangent)
    height = min(max(dot(t, w), -1.0), 1.0)
    v = madd(w, -height, t)
    square = dot(v, v)
    if square < 1e-24:
        v, _ = frame(t)
        square = 1.0
    return math.asin(height), scale(v, 1.0 / math.sqrt(square))


@kernel
def _ends(closure, theta_o):
    """Ends of the range of the Cauchy distribution of half angles, as angles."""
    return (
        math.atan(((_HALF_PI + theta_o) * 0.5 - closure.b) / closure.alpha),
        math.atan(((theta_o - _HALF_PI) * 0.5 - closure.b) / closure.alpha),
    )


@kernel
def _density_along(closure, theta_o, theta_i):
    """Density of inclinations over solid angle."""
    first, last = _ends(closure, theta_o)
    t = 0.5 * (theta_o + theta_i) - closure.b
    r = closure.alpha
    return r / (2.0 * (t * t + r * r) * (first - last) * math.cos(theta_i))


@kernel
def _density_about(closure, phi):
    """Density of the angle about the fiber, from 0 to π."""
    r = closure.a
    if closure.transmits:
        p = math.pi - phi
        return r / (2.0 * math.atan(_HALF_PI / r) * (p * p + r * r))
    return math.cos(0.5 * phi / r) * 0.25 / r if phi <= math.pi * r else 0.0


@kernel
def _density(closure, wo, wi):
    """Density of wi, and the cosine of the angle about the fiber between it and wo."""
    theta_o, across_o = _across(closure, wo)
    theta_i, across_i = _across(closure, wi)
    cosine = dot(across_o, across_i)
    if abs(theta_i) > _ALONG:
        return 0.0, cosine
    return (
        _density_along(closure, theta_o, theta_i) * _density_about(closure, math.acos(min(max(cosine, -1.0), 1.0))),
        cosine,
    )


@kernel
def evaluate(block, workspace, index, x, y, z):
    """f · |cos| without its weight, and pdf.

    Light rays see a mesh on one side only, and reflection within a quarter turn around the fiber; ``sample`` draws
    everything. So smaller lamps give less light, as in Cycles.
    """
    closure = closure_table(workspace)[int(index)]
    wi = (x, y, z)
    pdf, cosine = _density(closure, vec(surface_table(workspace)[0].wo), wi)
    if (dot(vec(closure.normal), wi) < 0.0) != (closure.transmits != 0) or closure.reflects and cosine < 0.0:
        return 0.0, 0.0, 0.0, pdf
    return pdf, pdf, pdf, pdf


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf (0: no direction) and kind."""
    closure, surface = closure_table(workspace)[int(index)], surface_table(workspace)[0]
    theta_o, across = _across(closure, vec(surface.wo))
    tangent = vec(closure.tangent)
    first, last = _ends(closure, theta_o)
    theta_i = 2.0 * (closure.alpha * math.tan(u1 * (first - last) + last) + closure.b) - theta_o
    r = closure.a
    if closure.transmits:
        phi = math.pi + r * math.tan(2.0 * math.atan(_HALF_PI / r) * (u2 - 0.5))
    else:
        phi = 2.0 * math.asin(min(max(1.0 - 2.0 * u2, -1.0), 1.0)) * r
    c, s = math.cos(theta_i), math.sin(theta_i)
    side = cross(tangent, across)
    wi = add(add(scale(across, c * math.cos(phi)), scale(side, c * math.sin(phi))), scale(tangent, s))
    pdf, _ = _density(closure, vec(surface.wo), wi)
    if pdf <= 0.0:
        return _NO_DIRECTION
    through = dot(vec(surface.ng), wi) < 0.0
    if surface.strand:
        through = closure.transmits != 0
    return wi[0], wi[1], wi[2], pdf, pdf, pdf, pdf, TRANSMISSION if through else GLOSSY


LOBES = {lobe_kind("hair"): (add_lobe, (HAIR,))}
CLOSURES = (HAIR,)
