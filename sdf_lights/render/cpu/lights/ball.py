# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Point and spot lights: a point, a sphere, or with soft falloff a disk that faces the lit point, as in Cycles.

A light of P watts has the radiance P / (4 π² r²), so far away its radiant intensity is P / 4π; a spot's cone only
takes away from that. Both shapes show a circular cone to any point outside, sampled uniformly in solid angle.
"""

import math

from ....jit import kernel
from ....vec import dot, negate, scale, sub, vec
from .cone import FULL_SPHERE, cone_pdf, one_minus_cos, sample_cone, sample_sphere
from .records import no_sample


@kernel
def attenuation(light, wi):
    """Share of a spot's light that goes along −wi: a smooth step in the cosine to the axis, in the light's local space."""
    if light.spot == 0:
        return 1.0
    m = light.to_local
    x = m[0, 0] * wi[0] + m[0, 1] * wi[1] + m[0, 2] * wi[2]
    y = m[1, 0] * wi[0] + m[1, 1] * wi[1] + m[1, 2] * wi[2]
    z = m[2, 0] * wi[0] + m[2, 1] * wi[1] + m[2, 2] * wi[2]
    f = (z / math.sqrt(x * x + y * y + z * z) - light.cos_half) * light.smooth
    if f >= 1.0:
        return 1.0
    return f * f * (3.0 - 2.0 * f) if f > 0.0 else 0.0


@kernel
def _inside(light, square):
    return light.disk == 0 and square <= light.radius * light.radius


@kernel
def _width(light, square):
    """1 − cosine of the half angle that the light subtends from a squared distance to its centre, outside it."""
    r2 = light.radius * light.radius
    return one_minus_cos(r2 / (square + r2) if light.disk else r2 / square)


@kernel
def ball_distance(light, x, d):
    """Distance along d to where light comes from, or −1 if the ray misses."""
    to = sub(vec(light.center), x)
    square, along, r2 = dot(to, to), dot(to, d), light.radius * light.radius
    if light.disk:
        if along <= 0.0 or square * square > along * along * (square + r2):
            return -1.0
        return square / along
    root = along * along - (square - r2)
    if root < 0.0:
        return -1.0
    root = math.sqrt(root)
    return along - root if square > r2 else along + root


@kernel
def ball_pdf(light, x):
    """Density of ``sample_ball`` in every direction in which it meets light."""
    to = sub(vec(light.center), x)
    square = dot(to, to)
    if square == 0.0 and light.disk:
        return 0.0
    if _inside(light, square):
        return FULL_SPHERE
    return cone_pdf(min(_width(light, square), light.spread))


@kernel
def ball_radiance(light, x, d):
    """Radiance along −d at x of a light of positive radius, which the ray must hit."""
    to = sub(vec(light.center), x)
    if _inside(light, dot(to, to)):
        return vec(light.radiance)
    return scale(vec(light.radiance), attenuation(light, d))


@kernel
def sample_ball(light, x, u1, u2):
    to = sub(vec(light.center), x)
    square = dot(to, to)
    if square == 0.0 and (light.disk or light.radius == 0.0):
        return no_sample()
    if light.radius == 0.0:
        distance = math.sqrt(square)
        wi = scale(to, 1.0 / distance)
        return wi, distance, scale(vec(light.radiance), attenuation(light, wi) / square), 1.0, True
    if _inside(light, square):
        wi = sample_sphere(u1, u2)
        return wi, ball_distance(light, x, wi), vec(light.radiance), FULL_SPHERE, False
    width = _width(light, square)
    if light.spread < width:
        wi = sample_cone(negate(vec(light.axis)), light.spread, u1, u2)
        distance = ball_distance(light, x, wi)
        if distance < 0.0:
            return wi, 0.0, (0.0, 0.0, 0.0), cone_pdf(light.spread), False
    else:
        wi = sample_cone(scale(to, 1.0 / math.sqrt(square)), width, u1, u2)
        along = dot(to, wi)
        if light.disk:
            distance = square / along
        else:
            # A direction at the rim may miss by a rounding error.
            r2 = light.radius * light.radius
            distance = along - math.sqrt(max(along * along - (square - r2), 0.0))
    return wi, distance, scale(vec(light.radiance), attenuation(light, wi)), cone_pdf(min(width, light.spread)), False
