# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ashikhmin and Shirley 2000, "An anisotropic Phong BRDF model", without its Fresnel term, as in Cycles.

Fields of the closure: those of ``facets``.
"""

import math

from .....jit import kernel
from .....vec import add, dot, frame, normalize, scale, sub, to_world, vec
from ..closures import finish, lobe_table, positive
from ..operands import vector
from ..records import ASHIKHMIN_SHIRLEY, GGX, GLOSSY, SINGULAR, closure_table, surface_table
from ..special_lobes import LOBE_ASHIKHMIN_SHIRLEY
from .facets import begin_glossy, frame_about

_LOWEST = 1e-4  # roughness; a mirror
_SMALL = 1e-6
_NOTHING = (0.0, 0.0, 0.0, 0.0)
_NO_DIRECTION = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0)


@kernel
def add_lobe(block, workspace, lobe, weight):
    """Add the closure of lobe number ``lobe``, a glossy one, with this weight."""
    lobe = lobe_table(block)[int(lobe)]
    color = scale(positive(vector(block, workspace, lobe.args[0])), weight)
    index, _ = begin_glossy(block, workspace, lobe, color, GGX)
    if index >= 0:
        closure = closure_table(workspace)[index]
        closure.kind = ASHIKHMIN_SHIRLEY
        closure.alpha, closure.a = max(closure.alpha, _LOWEST), max(closure.a, _LOWEST)
        closure.singular = int(max(closure.alpha, closure.a) <= _LOWEST)
        finish(workspace, index, color)
    return 0.0


@kernel
def _exponent(alpha):
    return 2.0 / (alpha * alpha) - 2.0


@kernel
def _distribution(closure, wo, wi):
    """Normalised lobe over half vectors times 2π, and the cosines of the half vector with wo and the normal."""
    n = vec(closure.normal)
    h = normalize(add(wo, wi))
    cosine_h, cosine_ho = max(dot(h, n), _SMALL), max(abs(dot(h, wo)), _SMALL)
    x, y = _exponent(closure.alpha), _exponent(closure.a)
    if x != y and cosine_h < 1.0:
        t, b = frame_about(n, vec(closure.tangent))
        p, q = dot(t, h), dot(b, h)
        power = cosine_h ** ((x * p * p + y * q * q) / (1.0 - cosine_h * cosine_h))
    else:
        power = cosine_h**x
    return math.sqrt((x + 1.0) * (y + 1.0)) * power, cosine_ho


@kernel
def evaluate(block, workspace, index, x, y, z):
    """f · |cos| without its weight, and pdf."""
    closure = closure_table(workspace)[int(index)]
    n, wo, wi = vec(closure.normal), vec(surface_table(workspace)[0].wo), (x, y, z)
    cosine_o, cosine_i = dot(n, wo), dot(n, wi)
    if cosine_o < 0.0 or cosine_i < 0.0:
        return _NOTHING
    cosine_o, cosine_i = max(cosine_o, _SMALL), max(cosine_i, _SMALL)
    lobe, cosine_ho = _distribution(closure, wo, wi)
    pdf = lobe / (8.0 * math.pi * cosine_ho)
    value = pdf * cosine_i / max(cosine_o, cosine_i)
    return value, value, value, pdf


@kernel
def _azimuth(closure, u):
    """Azimuth of a half vector about the normal, from the tangent."""
    x, y = _exponent(closure.alpha), _exponent(closure.a)
    if x == y:
        return 2.0 * math.pi * u
    # In the first quadrant; the others are its mirror images.
    quarter = 4.0 * u
    part = min(int(quarter), 3)
    inside = quarter - part
    if part == 1 or part == 3:
        inside = 1.0 - inside
    phi = math.atan(math.sqrt((x + 1.0) / (y + 1.0)) * math.tan(0.5 * math.pi * inside))
    if part == 1:
        return math.pi - phi
    if part == 2:
        return math.pi + phi
    return 2.0 * math.pi - phi if part == 3 else phi


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf (0: no direction) and kind."""
    closure = closure_table(workspace)[int(index)]
    n, wo = vec(closure.normal), vec(surface_table(workspace)[0].wo)
    if dot(n, wo) <= 0.0:
        return _NO_DIRECTION
    phi = _azimuth(closure, u1)
    c, s = math.cos(phi), math.sin(phi)
    exponent = _exponent(closure.alpha) * c * c + _exponent(closure.a) * s * s
    height = max(u2, 1e-30) ** (1.0 / (exponent + 1.0))
    radius = math.sqrt(max(1.0 - height * height, 0.0))
    t, b = frame(n)
    if closure.alpha != closure.a:
        t, b = frame_about(n, vec(closure.tangent))
    h = to_world((radius * c, radius * s, height), t, b, n)
    wi = sub(scale(h, 2.0 * dot(h, wo)), wo)
    if closure.singular != 0:
        wi = sub(scale(n, 2.0 * dot(n, wo)), wo)
        return wi[0], wi[1], wi[2], 1.0, 1.0, 1.0, 1.0, GLOSSY | SINGULAR
    r, g, blue, pdf = evaluate(block, workspace, index, wi[0], wi[1], wi[2])
    return wi[0], wi[1], wi[2], r, g, blue, pdf, GLOSSY


LOBES = {LOBE_ASHIKHMIN_SHIRLEY: (add_lobe, (ASHIKHMIN_SHIRLEY,))}
CLOSURES = (ASHIKHMIN_SHIRLEY,)
