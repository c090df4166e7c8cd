# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Toon: uniform inside a cone about the normal or the mirror direction, falling towards its rim, zero outside.

Fields of the closure: a is the half angle of the uniform cone, b the width of its rim, also an angle.
"""

import math

from .....jit import kernel
from .....vec import dot, frame, scale, sub, to_world, vec
from ..closures import begin, finish, lobe_table, positive, saturate
from ..operands import normal, number, vector
from ..records import DIFFUSE, GLOSSY, closure_kind, closure_table, surface_table
from ..special_lobes import lobe_kind, option

DIFFUSE_TOON, GLOSSY_TOON = map(closure_kind, ("diffuse_toon", "glossy_toon"))
_IS_GLOSSY = option("toon", "component", "GLOSSY")
_HALF_PI = 0.5 * math.pi
_NOTHING = (0.0, 0.0, 0.0, 0.0)


@kernel
def add_lobe(block, workspace, lobe, weight):
    """Add the closure of lobe number ``lobe``, with this weight."""
    lobe = lobe_table(block)[int(lobe)]
    args = lobe.args
    color = scale(positive(vector(block, workspace, args[0])), weight)
    index = begin(workspace, color, normal(block, workspace, args[3]))
    if index >= 0:
        closure = closure_table(workspace)[index]
        closure.kind = GLOSSY_TOON if lobe.features & _IS_GLOSSY else DIFFUSE_TOON
        closure.reflects = 1
        closure.transmits = 0
        closure.a = min(max(number(block, workspace, args[1]), 1e-5), 1.0) * _HALF_PI
        closure.b = saturate(number(block, workspace, args[2])) * _HALF_PI
        finish(workspace, index, color)
    return 0.0


@kernel
def _axis(closure, wo):
    """The axis of the cone."""
    n = vec(closure.normal)
    return sub(scale(n, 2.0 * dot(n, wo)), wo) if closure.kind == GLOSSY_TOON else n


@kernel
def _half_angle(closure):
    return min(closure.a + closure.b, _HALF_PI)


@kernel
def _density(closure):
    """Density of directions in the whole cone."""
    sine = math.sin(0.5 * _half_angle(closure))
    return 1.0 / (4.0 * math.pi * sine * sine)


@kernel
def _intensity(closure, angle):
    if angle < closure.a:
        return 1.0
    return max(1.0 - (angle - closure.a) / closure.b, 0.0) if closure.b > 0.0 else 0.0


@kernel
def evaluate(block, workspace, index, x, y, z):
    """f · |cos| without its weight, and pdf."""
    closure = closure_table(workspace)[int(index)]
    wo, wi = vec(surface_table(workspace)[0].wo), (x, y, z)
    n = vec(closure.normal)
    if dot(n, wi) <= 0.0 or closure.kind == GLOSSY_TOON and dot(n, wo) <= 0.0:
        return _NOTHING
    angle = math.acos(min(max(dot(_axis(closure, wo), wi), -1.0), 1.0))
    if angle >= _half_angle(closure):
        return _NOTHING
    pdf = _density(closure)
    value = pdf * _intensity(closure, angle)
    return value, value, value, pdf


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf (0: no direction) and kind."""
    closure = closure_table(workspace)[int(index)]
    axis = _axis(closure, vec(surface_table(workspace)[0].wo))
    sine = math.sin(0.5 * _half_angle(closure))
    down = 2.0 * u2 * sine * sine  # one minus the cosine
    radius, phi = math.sqrt(max(down * (2.0 - down), 0.0)), 2.0 * math.pi * u1
    t, b = frame(axis)
    wi = to_world((radius * math.cos(phi), radius * math.sin(phi), 1.0 - down), t, b, axis)
    red, green, blue, pdf = evaluate(block, workspace, index, wi[0], wi[1], wi[2])
    return wi[0], wi[1], wi[2], red, green, blue, pdf, GLOSSY if closure.kind == GLOSSY_TOON else DIFFUSE


LOBES = {lobe_kind("toon"): (add_lobe, (DIFFUSE_TOON, GLOSSY_TOON))}
CLOSURES = (DIFFUSE_TOON, GLOSSY_TOON)
