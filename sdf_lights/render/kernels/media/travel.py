# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A path through a medium: emission on the way, and whether it is scattered there."""

from __future__ import annotations

import numpy as np

from ....jit import kernel
from ....vec import is_zero, madd, mul, put, scale, vec
from ...scene import Ray
from ..outputs.state import scattered_in_medium
from ..path import KEPT_RAY, MEDIA_SETS, NO_EMITTER, PHASE_SET, TRAVEL_SET, contribute, of_instance, path_table
from ..ray_origins import clear_self_primitive
from ..rays import ray_table
from ..samplers import get_2d, get_3d
from .beams import attenuation, channel_probabilities, distance_density, distance_in, gathered_rgb
from .in_scattering import light_ray
from .phase import phase, sample_phase
from .records import WORLD, inside_table
from .stack import receiver

VOLUME = int(Ray.VOLUME)
BLACK = (0.0, 0.0, 0.0)


@kernel
def add_glow(block, workspace, emission):
    """Add the emission of the media along the path's ray. As in Cycles, it belongs to the object whose medium the path
    has entered last."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    owner = inside.owner[inside.count - 1]
    source = NO_EMITTER if owner == WORLD else of_instance(owner)
    contribute(block, workspace, emission, 1.0, source, path.bounce)


@kernel
def _scattered_part(albedo, left):
    """Probability of scattering if the transmittance is ``left``: the fraction of all light that is not absorbed."""
    scattered = albedo * (1.0 - left)
    return scattered / (scattered + left) if scattered > 0.0 else 0.0


@kernel
def _travel(block, workspace, length, may_scatter):
    """Follow the path for ``length`` through the present media. Returns True if it is scattered on the way, at
    ``path.length``."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    extinction, scattering = vec(inside.extinction), vec(inside.scattering)
    left = attenuation(extinction, length)
    throughput = vec(path.throughput)
    if not may_scatter or not inside.scatters:
        put(path.throughput, mul(throughput, left))
        return False
    albedo = (
        scattering[0] / extinction[0] if extinction[0] > 0.0 else 0.0,
        scattering[1] / extinction[1] if extinction[1] > 0.0 else 0.0,
        scattering[2] / extinction[2] if extinction[2] > 0.0 else 0.0,
    )
    probability = (
        _scattered_part(albedo[0], left[0]),
        _scattered_part(albedo[1], left[1]),
        _scattered_part(albedo[2], left[2]),
    )
    channel_pmf = channel_probabilities(
        (
            throughput[0] * (albedo[0] * (1.0 - left[0]) + left[0]),
            throughput[1] * (albedo[1] * (1.0 - left[1]) + left[1]),
            throughput[2] * (albedo[2] * (1.0 - left[2]) + left[2]),
        )
    )
    u = get_2d(path.index, path.seed, MEDIA_SETS + path.dimension + TRAVEL_SET)
    color, rest = 0, u[1]
    while color < 2 and rest >= channel_pmf[color]:
        rest -= channel_pmf[color]
        color += 1
    if u[0] >= probability[color]:
        through = (
            channel_pmf[0] * (1.0 - probability[0])
            + channel_pmf[1] * (1.0 - probability[1])
            + channel_pmf[2] * (1.0 - probability[2])
        )
        put(path.throughput, scale(mul(throughput, left), 1.0 / through) if through > 0.0 else BLACK)
        return False
    distance = distance_in(extinction[color], extinction[color] * length, u[0] / probability[color])
    density = 0.0
    for axis in range(3):
        if channel_pmf[axis] > 0.0 and probability[axis] > 0.0:
            density += channel_pmf[axis] * probability[axis] * distance_density(extinction[axis], length, distance)
    value = mul(mul(throughput, scattering), attenuation(extinction, distance))
    put(path.throughput, scale(value, 1.0 / density) if density > 0.0 else BLACK)
    path.length = path.t_min + distance
    return True


@kernel
def can_find_light(block, path):
    """Whether a path that is scattered here can find anything: lamps are left to light sampling."""
    last = path.bounce >= block.max_bounces or path.volume >= block.volume_bounces
    return block.emitters_hit != 0 or not last


@kernel
def enter(block, workspace, length):
    """Follow the path's ray for ``length`` through the present media, and add the light that they send along it.

    Returns 1 if the path is scattered on the way, at ``path.length``; else 0.
    """
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    if inside.glows:
        add_glow(block, workspace, mul(vec(inside.emission), gathered_rgb(vec(inside.extinction), length)))
    if inside.scatters and not path.last:
        rays = ray_table(workspace)
        rays[KEPT_RAY] = rays[0]
        clear_self_primitive(rays[0])
        light_ray(block, workspace, length)
        rays[0] = rays[KEPT_RAY]
    return 1.0 if _travel(block, workspace, length, not path.last and can_find_light(block, path)) else 0.0


@kernel
def fade(block, workspace, distance):
    """Transmittance (RGB) of the present media along the path's ray up to a distance."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    return attenuation(vec(inside.extinction), distance - path.t_min)


@kernel
def scatter(block, workspace, unused):
    """Continue the path from the point where a medium scatters it. Returns 0 if it ends there."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    d = vec(path.direction)
    u = get_3d(path.index, path.seed, MEDIA_SETS + path.dimension + PHASE_SET)
    wi = sample_phase(block, workspace, inside, d, u[0], u[1], u[2])
    value, density = phase(block, workspace, inside, d[0] * wi[0] + d[1] * wi[1] + d[2] * wi[2])
    if not density > 0.0 or is_zero(vec(path.throughput)):
        return 0.0
    position = madd(vec(path.start), path.length, d)
    scattered_in_medium(block, workspace, 0)
    path.scattered = path.bounce
    path.bounce += 1
    path.volume += 1
    path.last = int(path.bounce > block.max_bounces or path.volume > block.volume_bounces)
    put(path.throughput, scale(vec(path.throughput), value / density))
    put(path.origin, position)
    put(path.normal, BLACK)
    put(path.start, position)
    put(path.direction, wi)
    path.t_min, path.t_max, path.near = 0.0, np.inf, 0.0
    path.pdf, path.glossy_pdf = density, 0.0
    path.least_pdf = min(path.least_pdf, density)
    path.two_sided, path.has_glossy, path.in_medium, path.stopped = 1, 0, 1, 0
    path.kind, path.light_tree = VOLUME, receiver(block, inside)
    return 1.0
