# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Point and spot lights: a point, a sphere, or with soft falloff a disk that faces the lit point, as in Cycles.

A light of P watts has the radiance P / (4 π² r²), so far away its radiant intensity is P / 4π. A spot's cone only
removes light from that. Both shapes show a circular cone to any point outside, sampled uniformly in solid angle.
"""

from __future__ import annotations

import math

import numpy as np

from .....affine import inverse_linear
from .....jit import kernel, table
from .....vec import dot, frame, madd, negate, scale, sub, vec
from ....lights.point import PointLight, SpotLight
from ..cone import FULL_SPHERE, cone_pdf, one_minus_cos, sample_cone, sample_sphere
from ..extent import Extent, unit
from ..records import no_sample

RECORD = np.dtype(
    [
        ("center", np.float64, 3),
        ("radius", np.float64),
        ("radiance", np.float64, 3),  # of radius 0: radiant intensity
        ("disk", np.int64),
        ("spot", np.int64),
        ("axis", np.float64, 3),  # of the spot's cone
        ("to_local", np.float64, (3, 3)),
        ("cos_half", np.float64),
        ("smooth", np.float64),
        ("spread", np.float64),
    ],  # 1 − cosine of the half angle of a round cone around all the light
    align=True,
)

CROSSING = 0.05  # part of the light paths of a sphere that start inside it
BLEND_LEAST = 1e-6  # a smooth step this narrow counts as a step

LIGHT, TABLE = PointLight, "light_points"
rows = table(TABLE, RECORD)


def pack(row, light, rgb) -> Extent:
    """Radiant flux to radiance, or to radiant intensity. The object's scale does not change size or power."""
    radius = max(light.radius, 0.0)
    row["center"], row["radius"], row["disk"] = light.matrix[:3, 3], radius, light.soft_falloff
    row["radiance"] = rgb / (4.0 * math.pi**2 * radius**2 if radius > 0.0 else 4.0 * math.pi)
    row["spread"] = 2.0
    reach = np.full(3, radius)
    cone = {}
    if isinstance(light, SpotLight):
        cone = _pack_spot(row, light)
    center = row["center"]
    return Extent(center - reach, center + reach, np.abs(rgb).mean() / (4.0 * math.pi), **cone)


def _pack_spot(row, light) -> dict:
    """The cone in local space, so that scale makes it elliptic, as in Cycles, and a round cone around it."""
    linear = light.matrix[:3, :3]
    scales = np.linalg.norm(linear, axis=0)
    half = 0.5 * min(max(light.angle, 0.0), math.pi)
    row["spot"], row["cos_half"] = 1, math.cos(half)
    row["smooth"] = 1.0 / max((1.0 - math.cos(half)) * light.blend, BLEND_LEAST)
    if abs(np.linalg.det(linear)) <= 1e-12 * scales.prod() or scales.prod() == 0.0:
        linear, scales = np.eye(3), np.ones(3)
    row["to_local"] = inverse_linear(linear)
    row["axis"] = axis = -unit(linear[:, 2])
    orthogonal = np.abs(linear.T @ linear - np.diag(scales**2)).max() <= 1e-6 * scales.max() ** 2
    if not orthogonal or half >= 0.5 * math.pi:
        return {}
    tangent = math.tan(half) * max(scales[0], scales[1]) / scales[2]
    # Slightly wider than the cone itself, for the rounding of directions at its rim.
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    row["spread"] = tangent * tangent * cosine / (1.0 + 1.0 / cosine) * (1.0 + 1e-9) + 1e-15
    return dict(axis=axis, cos_o=1.0, cos_e=cosine)


@kernel
def attenuation(light, wi):
    """Fraction of a spot's light that goes along −wi: a smooth step in the cosine to the axis, in the light's local
    space."""
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
def sphere_distance(light, x, d):
    """Distance along d to the source of the light, or −1 if the ray misses."""
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
def sphere_pdf(light, x):
    """Density of ``sample`` in every direction that hits the light."""
    to = sub(vec(light.center), x)
    square = dot(to, to)
    if square == 0.0 and light.disk:
        return 0.0
    if _inside(light, square):
        return FULL_SPHERE
    return cone_pdf(min(_width(light, square), light.spread))


@kernel
def sphere_radiance(light, x, d):
    """Radiance along −d at x of a light of positive radius, which the ray must hit."""
    to = sub(vec(light.center), x)
    if _inside(light, dot(to, to)):
        return vec(light.radiance)
    return scale(vec(light.radiance), attenuation(light, d))


@kernel
def sample(light, x, u1, u2):
    """See ``interfaces.Light``."""
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
        return wi, sphere_distance(light, x, wi), vec(light.radiance), FULL_SPHERE, False
    width = _width(light, square)
    if light.spread < width:
        wi = sample_cone(negate(vec(light.axis)), light.spread, u1, u2)
        distance = sphere_distance(light, x, wi)
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


@kernel
def hit(light, o, d):
    """See ``interfaces.Light``."""
    if light.radius <= 0.0:
        return -1.0, (0.0, 0.0, 0.0), 0.0
    distance = sphere_distance(light, o, d)
    if not distance > 0.0:
        return -1.0, (0.0, 0.0, 0.0), 0.0
    return distance, sphere_radiance(light, o, d), sphere_pdf(light, o)


@kernel
def leave(light, u1, u2, u3, u4):
    """See ``interfaces.Light``: a direction in the cone of a spot, and a point of the disk across it.

    A sphere lights what is inside it, too, from its far side: a few of the rays cross it.
    """
    crosses = light.disk == 0 and light.radius > 0.0 and u4 < CROSSING
    if crosses or light.spot == 0:
        direction, measure = sample_sphere(u1, u2), 4.0 * math.pi
    else:
        direction, measure = sample_cone(vec(light.axis), light.spread, u1, u2), 2.0 * math.pi * light.spread
    center = vec(light.center)
    if light.radius == 0.0:
        return center, direction, scale(vec(light.radiance), attenuation(light, negate(direction)) * measure), math.inf
    if light.disk == 0:
        measure /= CROSSING if crosses else 1.0 - CROSSING
        u4 = u4 / CROSSING if crosses else (u4 - CROSSING) / (1.0 - CROSSING)
    r, phi = light.radius * math.sqrt(u3), 2.0 * math.pi * u4
    t, b = frame(direction)
    place = madd(madd(center, r * math.cos(phi), t), r * math.sin(phi), b)
    depth = 0.0 if light.disk else math.sqrt(max(light.radius * light.radius - r * r, 0.0))
    measure *= math.pi * light.radius * light.radius
    if crosses:
        return madd(place, -depth, direction), direction, scale(vec(light.radiance), measure), 2.0 * depth
    passed = attenuation(light, negate(direction)) * measure
    return madd(place, depth, direction), direction, scale(vec(light.radiance), passed), math.inf


def flux(rows) -> np.ndarray:
    """See ``interfaces.Light``."""
    size = np.where(rows["radius"] > 0.0, math.pi * rows["radius"] ** 2, 1.0)
    return np.abs(rows["radiance"]).mean(axis=1) * size * 2.0 * math.pi * rows["spread"]


def has_size(light) -> bool:
    """See ``interfaces.Light``."""
    return light.radius > 0.0
