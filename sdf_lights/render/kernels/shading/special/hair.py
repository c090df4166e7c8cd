# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair BSDF: one lobe of reflection or of transmission by a thin fiber, after Marschner et al. 2003, "Light scattering from
human hair fibers". A Cauchy distribution along the fiber, about the mirror direction; about it a cosine or another Cauchy
distribution.

Fields of the closure: the tangent; alpha is the roughness along the fiber, a that about it, b the tilt of its scales.
"""

import math

from .....jit import kernel
from .....vec import add, cross, dot, frame, madd, normalize, put, scale, vec
from ..program import NONE
from ..records import GLOSSY, HAIR, TRANSMISSION, closure_table, surface_table
from ..special_lobes import IS_TRANSMISSION
from ..surface import begin, finish, lobe_table, positive, specular_normal
from ..values import number, vector

_HALF_PI = 0.5 * math.pi
_ALONG = _HALF_PI - 0.001  # inclinations beyond are along the fiber
_NOTHING = (0.0, 0.0, 0.0, 0.0)
_NO_DIRECTION = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0)


@kernel
def add_lobe(block, workspace, lobe, weight):
    lobe, surface = lobe_table(block)[int(lobe)], surface_table(workspace)[0]
    args = lobe.args
    color = scale(positive(vector(block, workspace, args[0])), weight)
    index = begin(workspace, color, specular_normal(surface, vec(surface.n)))
    if index < 0:
        return 0.0
    closure = closure_table(workspace)[index]
    closure.kind = HAIR
    closure.transmits = int(lobe.features & IS_TRANSMISSION != 0)
    closure.reflects = 1 - closure.transmits
    closure.alpha = min(max(number(block, workspace, args[2]), 0.001), 1.0)
    closure.a = min(max(number(block, workspace, args[3]), 0.001), 1.0)
    closure.b = -number(block, workspace, args[1])
    if args[4] == NONE:
        # On a mesh nothing says which way its hair lies.
        put(closure.tangent, normalize(vec(surface.dpdv)))
        closure.b = 0.0
    else:
        put(closure.tangent, normalize(vector(block, workspace, args[4])))
    finish(workspace, index, color)
    return 0.0


@kernel
def _across(closure, w):
    """Inclination of w towards the fiber, and its direction seen along the fiber."""
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
def _density_about(closure, cosine):
    """Density of the angle about the fiber, by its cosine; 0 on the other side of the fiber than the lobe's."""
    r = closure.a
    phi = math.acos(min(max(cosine, -1.0), 1.0))
    if closure.transmits:
        p = math.pi - phi
        return r / (2.0 * math.atan(_HALF_PI / r) * (p * p + r * r))
    if cosine < 0.0 or phi > math.pi * r:
        return 0.0
    return math.cos(0.5 * phi / r) * 0.25 / r


@kernel
def evaluate(block, workspace, index, x, y, z):
    """f · |cos| without its weight, and pdf."""
    closure = closure_table(workspace)[int(index)]
    wi = (x, y, z)
    if (dot(vec(closure.normal), wi) < 0.0) != (closure.transmits != 0):
        return _NOTHING
    theta_o, across_o = _across(closure, vec(surface_table(workspace)[0].wo))
    theta_i, across_i = _across(closure, wi)
    if abs(theta_i) > _ALONG:
        return _NOTHING
    pdf = _density_along(closure, theta_o, theta_i) * _density_about(closure, dot(across_o, across_i))
    return pdf, pdf, pdf, pdf


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf (0: no direction) and kind."""
    closure = closure_table(workspace)[int(index)]
    theta_o, across = _across(closure, vec(surface_table(workspace)[0].wo))
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
    red, green, blue, pdf = evaluate(block, workspace, index, wi[0], wi[1], wi[2])
    if pdf <= 0.0:
        return _NO_DIRECTION
    return wi[0], wi[1], wi[2], red, green, blue, pdf, TRANSMISSION if closure.transmits else GLOSSY
