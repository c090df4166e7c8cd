# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Velvet of Ashikhmin, Premože and Shirley 2000, "A microfacet-based BRDF generator": microfacets with inverted
normals, sampled uniformly over the hemisphere. Also Sheen of fibers, whose closure is not in this package.

Fields of the closure: a is 1/σ².
"""

import math

from .....jit import kernel
from .....vec import add, dot, frame, normalize, scale, to_world, vec
from ..closures import add_fibers, begin, finish, lobe_table, positive, saturate
from ..operands import normal, number, vector
from ..records import DIFFUSE, VELVET, closure_table, surface_table
from ..special_lobes import LOBE_SHEEN, LOBE_VELVET

_NOTHING = (0.0, 0.0, 0.0, 0.0)
_SMALL = 1e-5


@kernel
def add_sheen(block, workspace, lobe, weight):
    """Sheen BSDF of fibers."""
    args = lobe_table(block)[int(lobe)].args
    color = scale(positive(vector(block, workspace, args[0])), weight)
    add_fibers(block, workspace, color, normal(block, workspace, args[2]), number(block, workspace, args[1]))
    return 0.0


@kernel
def add_lobe(block, workspace, lobe, weight):
    """Sheen BSDF of Ashikhmin's distribution."""
    args = lobe_table(block)[int(lobe)].args
    color = scale(positive(vector(block, workspace, args[0])), weight)
    index = begin(workspace, color, normal(block, workspace, args[2]))
    if index >= 0:
        closure = closure_table(workspace)[index]
        sigma = max(saturate(number(block, workspace, args[1])), 0.01)
        closure.kind = VELVET
        closure.a = 1.0 / (sigma * sigma)
        finish(workspace, index, color)
    return 0.0


@kernel
def evaluate(block, workspace, index, x, y, z):
    """f · |cos| without its weight, and pdf."""
    closure = closure_table(workspace)[int(index)]
    n, wo, wi = vec(closure.normal), vec(surface_table(workspace)[0].wo), (x, y, z)
    cosine_o, cosine_i = dot(n, wo), dot(n, wi)
    if cosine_o <= _SMALL or cosine_i <= 0.0:
        return _NOTHING
    h = normalize(add(wo, wi))
    cosine_h, cosine_ho = dot(n, h), abs(dot(wo, h))
    if cosine_h >= 1.0 - _SMALL or cosine_ho <= _SMALL:
        return _NOTHING
    sine2 = 1.0 - cosine_h * cosine_h
    d = math.exp(-closure.a * cosine_h * cosine_h / sine2) * closure.a / (math.pi * sine2 * sine2)
    # The masking of V-shaped grooves (Torrance and Sparrow).
    ratio = max(cosine_h / cosine_ho, _SMALL)
    masking = min(1.0, 2.0 * ratio * cosine_o, 2.0 * ratio * cosine_i)
    value = 0.25 * d * masking / cosine_o
    return value, value, value, 0.5 / math.pi


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf (0: no direction) and kind."""
    n = vec(closure_table(workspace)[int(index)].normal)
    radius, phi = math.sqrt(max(1.0 - u2 * u2, 0.0)), 2.0 * math.pi * u1
    t, b = frame(n)
    wi = to_world((radius * math.cos(phi), radius * math.sin(phi), u2), t, b, n)
    red, green, blue, pdf = evaluate(block, workspace, index, wi[0], wi[1], wi[2])
    return wi[0], wi[1], wi[2], red, green, blue, pdf, DIFFUSE


LOBES = {LOBE_SHEEN: (add_sheen, ()), LOBE_VELVET: (add_lobe, (VELVET,))}
CLOSURES = (VELVET,)
