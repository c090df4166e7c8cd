# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A random walk below the surface of one instance: Chiang, Kutz and Burley 2016, "Practical and controllable subsurface
scattering for production path tracing".

Directions and distances are drawn by the medium's scattering, or so that they lead out again: towards the plane of the
entry or towards a surface on the far side. See Křivánek and d'Eon 2014, "A zero-variance-based sampling scheme for
Monte Carlo subsurface scattering"; Meng, Hanika and Dachsbacher 2016, "Improving the Dwivedi sampling scheme"; d'Eon
and Křivánek 2020, "Zero-variance theory for efficient subsurface scattering". The balance heuristic combines these and
the colours.
"""

from __future__ import annotations

import math

from ....jit import kernel
from ....replaced import replaced_on_gpu
from ....vec import dot, frame, largest, madd, mul, scale, sub, to_world, vec
from ..geometry import surface_table
from ..media.beams import attenuation, channel_probabilities, fade
from ..media.phase import draw_cosine, henyey_greenstein
from ..path import SUBSURFACE_SETS, path_table
from ..ray_origins import step_size
from ..rays import ray_table
from ..samplers import get_4d
from ..shading.records import BURLEY, closure_table
from . import disk
from .coefficients import coefficients
from .exits import put_exit
from .records import intersect_instance

MOST_STEPS = 256
LEAST_WEIGHT = 1e-6
FAR_SIDE = 10.0  # mean free paths within which the far side is searched
# Number of steps after which the medium scatters uniformly, by the similarity relation, and the amount of guiding from
# then on.
LAST_SKEWED, GUIDED_LATER = 9, 0.75


@kernel
def diffusion_length(albedo):
    """In mean free paths: d'Eon and Křivánek 2020, equation 67."""
    return 1.0 / math.sqrt(1.0 - albedo ** (2.44294 - 0.0215813 * albedo + 0.578637 / albedo))


@kernel
def _density(extinction, t, found):
    """Density of a distance t in a medium; the probability of at least t if a surface is ``found`` there."""
    left = fade(extinction, t)
    return left if found else extinction * left


@kernel
def _choose(u, channel_pmf):
    """A colour by its probability, and u remapped to [0, 1)."""
    color = 0
    while color < 2 and u >= channel_pmf[color]:
        u -= channel_pmf[color]
        color += 1
    return color, min(u / channel_pmf[color], 1.0 - 2.0**-53) if channel_pmf[color] > 0.0 else 0.5


@kernel
def scatter(block, workspace, unused):
    """Follow the path from the workspace's surface, below which it goes along its direction, to where it leaves the
    instance. Returns 0 if it is lost."""
    closure = closure_table(workspace)[surface_table(workspace)[0].entered]
    if closure.distribution == BURLEY:
        return disk.scatter(block, workspace, closure)
    return walk(block, workspace, closure)


@replaced_on_gpu
@kernel
def walk(block, workspace, closure):
    """``scatter`` by a random walk."""
    path, surface, ray = path_table(workspace)[0], surface_table(workspace)[0], ray_table(workspace)[0]
    extinction, albedo, factor = coefficients(closure)
    g, instance = closure.a, surface.instance
    entry, n, direction = vec(surface.position), vec(surface.n), vec(path.direction)
    # The step off a surface may be longer than free paths, so the walk starts on it and ignores hits within that step.
    position, nearest = entry, step_size(entry)
    throughput = mul(vec(path.throughput), factor)
    length = diffusion_length(largest(albedo))
    logarithm = math.log((length + 1.0) / (length - 1.0))
    guided = 1.0 - max(0.5, abs(g) ** 0.125)
    thickness = 0.0  # of the instance below the entry; 0: the far side is too distant
    t_axis, b_axis = frame(n)
    for step in range(MOST_STEPS):
        if step == LAST_SKEWED + 1:
            # σs' = (1 − g) σs, and σa stays.
            extinction = (
                extinction[0] * (1.0 - albedo[0] * g),
                extinction[1] * (1.0 - albedo[1] * g),
                extinction[2] * (1.0 - albedo[2] * g),
            )
            albedo = (
                albedo[0] * (1.0 - g) / (1.0 - albedo[0] * g),
                albedo[1] * (1.0 - g) / (1.0 - albedo[1] * g),
                albedo[2] * (1.0 - g) / (1.0 - albedo[2] * g),
            )
            g, guided = 0.0, GUIDED_LATER
        u = get_4d(path.index, path.seed, SUBSURFACE_SETS + MOST_STEPS * path.dimension + step)
        channel_pmf = channel_probabilities(mul(throughput, albedo))
        color, rest = _choose(u[0], channel_pmf)
        sampled = extinction[color]
        out, back, outward, backward, to_back = 0.0, 0.0, 1.0, 1.0, 0.0
        if step > 0:
            leads_out, goes_back = rest < guided, False
            if thickness > 0.0:
                depth = min(max(dot(sub(entry, position), n), 0.0), thickness)
                to_back = 1.0 / (1.0 + math.exp((thickness - 2.0 * depth) / length))
                goes_back = leads_out and rest < guided * to_back
            before = direction
            angle = 2.0 * math.pi * u[3]
            if leads_out:
                cosine = length - (length + 1.0) * math.exp(-u[2] * logarithm)
                if goes_back:
                    cosine = -cosine
                sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
                direction = to_world((sine * math.cos(angle), sine * math.sin(angle), cosine), t_axis, b_axis, n)
            else:
                own = draw_cosine(g, u[2])
                sine = math.sqrt(max(1.0 - own * own, 0.0))
                t, b = frame(before)
                direction = to_world((sine * math.cos(angle), sine * math.sin(angle), own), t, b, before)
                cosine = min(max(dot(direction, n), -1.0), 1.0)
            # Densities of guided directions over that of the phase function, which cancels the scattering.
            phase = 2.0 * math.pi * logarithm * henyey_greenstein(dot(before, direction), g)
            out, back = 1.0 / ((length - cosine) * phase), 1.0 / ((length + cosine) * phase)
            outward, backward = 1.0 - cosine / length, 1.0 + cosine / length
            if leads_out:
                sampled *= backward if goes_back else outward
        distance = -math.log(1.0 - u[1]) / sampled
        reach = distance if step > 0 else max(distance, FAR_SIDE / min(extinction[0], extinction[1], extinction[2]))
        found = intersect_instance(block, workspace, instance, position, direction, nearest, max(reach, nearest))
        nearest = 0.0
        if found:
            t_hit = float(ray.t_far)
            if step == 0:
                thickness = dot(sub(entry, madd(position, t_hit, direction)), n)
                found = t_hit < distance
            if found:
                distance = t_hit
        density = 0.0
        for axis in range(3):
            if channel_pmf[axis] > 0.0:
                own = _density(extinction[axis], distance, found)
                if step > 0:
                    guide = out * _density(outward * extinction[axis], distance, found)
                    if thickness > 0.0:
                        guide = (1.0 - to_back) * guide + to_back * back * _density(
                            backward * extinction[axis], distance, found
                        )
                    own = (1.0 - guided) * own + guided * guide
                density += channel_pmf[axis] * own
        if not density > 0.0:
            return 0.0
        throughput = scale(mul(throughput, attenuation(extinction, distance)), 1.0 / density)
        position = madd(position, distance, direction)
        if found:
            put_exit(workspace, position, direction, throughput)
            return 1.0
        throughput = mul(throughput, mul(extinction, albedo))
        if not largest(throughput) >= LEAST_WEIGHT:
            return 0.0
    return 0.0
