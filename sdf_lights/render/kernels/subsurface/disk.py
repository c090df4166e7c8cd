# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exits by the profile of Christensen and Burley 2015, "Approximate reflectance profiles for efficient subsurface
scattering".

The exits are the hits of a line through a disk around the entry with the instance: King, Kulla, Conty and Fajardo 2013,
"BSSRDF importance sampling".
"""

from __future__ import annotations

import math

from ....jit import kernel
from ....replaced import replaced_on_gpu
from ....vec import add, average, cross, dot, length, madd, mul, negate, normalize, scale, sub, transform_normal, vec
from ..geometry import instance_at, surface_table
from ..path import KEPT_RAY, SUBSURFACE_SETS, path_table
from ..rays import beyond, hit_normal, ray_table
from ..samplers import get_4d
from .coefficients import LEGACY_SCALE
from .exits import put_exit
from .records import intersect_instance

TRUNCATED = 16.0  # in radii: the end of the profile
# fraction of the profile within that distance
_SHARE = 1.0 - 0.25 * math.exp(-TRUNCATED) - 0.75 * math.exp(-TRUNCATED / 3.0)
_STEPS = 10  # of Newton's method
MOST_HITS = 256


@kernel
def profile(radius, r):
    """2 π r R(r), the density of the distance r of an exit; 0 for a radius of 0."""
    if not 0.0 < r < TRUNCATED * radius:
        return 0.0
    third = math.exp(-r / (3.0 * radius))
    return (third * third * third + third) / (4.0 * radius * _SHARE)


@kernel
def profile_distance(u):
    """The distance, in radii, within which the fraction u of the profile lies."""
    u *= _SHARE
    r = math.exp(2.4 * u * u) - 1.0 if u <= 0.9 else 15.0
    for _ in range(_STEPS):
        third = math.exp(-r / 3.0)
        value = 1.0 - 0.25 * third * third * third - 0.75 * third - u
        if abs(value) < 1e-9:
            break
        r = max(r - value / (0.25 * third * third * third + 0.25 * third), 0.0)
    return r


@kernel
def _profiles(radius, r):
    return (profile(radius[0], r), profile(radius[1], r), profile(radius[2], r))


@kernel
def _hit_normal(block, ray, index):
    """Normal of the triangle that was hit, on its front."""
    instance = instance_at(block, index)
    if instance.baked:
        n = normalize(hit_normal(ray))
        return negate(n) if instance.mirrored else n
    return normalize(transform_normal(instance.inverse, hit_normal(ray)))


@kernel
def _across(n):
    """Axes across n. As in Cycles, the density of a hit is taken as that of its distance from the entry. So results in
    corners depend slightly on the axes; these are those of Cycles."""
    t = (n[2] - n[1], n[0] - n[2], n[1] - n[0])
    if n[0] == n[1] and n[0] == n[2]:
        t = (n[2] - n[1], n[0] + n[2], -n[1] - n[0])
    t = normalize(t)
    return t, cross(n, t)


@kernel
def _axis(u, n, t, b):
    """The axis of the disk, its probability, two axes across it, and u remapped; half of all samples use n."""
    if u < 0.5:
        return n, 0.5, t, b, 2.0 * u
    if u < 0.75:
        return t, 0.25, n, b, 4.0 * u - 2.0
    return b, 0.25, n, t, 4.0 * u - 3.0


@replaced_on_gpu
@kernel
def scatter(block, workspace, closure):
    """As ``walk.scatter``."""
    path, surface, rays = path_table(workspace)[0], surface_table(workspace)[0], ray_table(workspace)
    ray, index, entry, ng = rays[0], surface.instance, vec(surface.position), vec(surface.ng)
    radius = scale(vec(closure.edge), LEGACY_SCALE)
    count = int(radius[0] > 0.0) + int(radius[1] > 0.0) + int(radius[2] > 0.0)
    u = get_4d(path.index, path.seed, SUBSURFACE_SETS + path.dimension)
    color, place = 0, min(int(u[0] * count), count - 1)
    while radius[color] <= 0.0 or place > 0:
        place -= int(radius[color] > 0.0)
        color += 1
    rest = u[0] * count - math.floor(u[0] * count)
    r = profile_distance(rest) * radius[color]
    half = math.sqrt(max(TRUNCATED * TRUNCATED * radius[color] * radius[color] - r * r, 0.0))
    t, b = _across(ng)
    axis, probability, across, other, rest = _axis(u[1], ng, t, b)
    angle = 2.0 * math.pi * rest
    start = add(madd(entry, half, axis), add(scale(across, r * math.cos(angle)), scale(other, r * math.sin(angle))))
    drawn = _profiles(radius, r)
    density = (drawn[0] + drawn[1] + drawn[2]) / count
    if not density > 0.0:
        return 0.0
    total, t_min, choice = 0.0, 0.0, u[2]
    weight, normal, position = (0.0, 0.0, 0.0), ng, entry
    for _ in range(MOST_HITS):
        if not intersect_instance(block, workspace, index, start, negate(axis), t_min, 2.0 * half):
            break
        t_hit = float(ray.t_far)
        n = _hit_normal(block, ray, index)
        # Each of the three axes would have found this point with some probability: the power heuristic.
        all_axes = (0.5 * dot(ng, n), 0.25 * dot(t, n), 0.25 * dot(b, n))
        own = probability * abs(dot(axis, n)) / dot(all_axes, all_axes)
        x = madd(start, -t_hit, axis)
        found = scale(_profiles(radius, length(sub(x, entry))), own / density)
        amount = average(found)
        if amount > 0.0:
            total += amount
            part = amount / total
            if choice < part:
                choice /= part
                weight, normal, position = scale(found, 1.0 / amount), n, x
                rays[KEPT_RAY] = rays[0]
            else:
                choice = (choice - part) / (1.0 - part)
        t_min = beyond(t_hit)
    if not total > 0.0:
        return 0.0
    rays[0] = rays[KEPT_RAY]
    if surface.backfacing:
        normal = negate(normal)
    put_exit(workspace, position, normal, scale(mul(vec(path.throughput), weight), total))
    return 1.0
