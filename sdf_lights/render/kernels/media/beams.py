# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light along a straight segment through a homogeneous medium, and the choice of the scattering point on it.

Equi-angular sampling: Kulla and Fajardo 2012, "Importance sampling techniques for path tracing in participating media".
Colours share their samples by the balance heuristic: Wilkie et al. 2014, "Hero wavelength spectral sampling".
"""

import math

from ....jit import kernel
from ....vec import scale

_THIN = 1e-4  # optical depth below which a series replaces a difference
_CLOSEST = 1e-9  # relative to the distance: no target is closer to a ray
BLACK = (0.0, 0.0, 0.0)


@kernel
def fade(extinction, distance):
    """Transmittance over ``distance``, which may be infinite: a number."""
    return math.exp(-extinction * distance) if extinction > 0.0 else 1.0


@kernel
def attenuation(extinction, distance):
    """As ``fade``, for RGB."""
    return (fade(extinction[0], distance), fade(extinction[1], distance), fade(extinction[2], distance))


@kernel
def gathered(extinction, distance):
    """∫ exp(−extinction t) dt from 0 to ``distance``: the attenuated light that the metres add."""
    depth = extinction * distance
    if not extinction > 0.0:
        return distance
    if depth < _THIN:
        return distance * (1.0 - 0.5 * depth)
    return (1.0 - math.exp(-depth)) / extinction


@kernel
def gathered_rgb(extinction, distance):
    """``gathered`` of each channel."""
    return (gathered(extinction[0], distance), gathered(extinction[1], distance), gathered(extinction[2], distance))


@kernel
def distance_in(extinction, depth, u):
    """A distance with a density proportional to ``fade``, up to the optical ``depth``, which may be infinite."""
    if depth < _THIN:
        return u * depth / extinction
    return min(-math.log(1.0 - u * (1.0 - math.exp(-depth))), depth) / extinction


@kernel
def distance_density(extinction, length, distance):
    """Density of ``distance_in``, within ``length``."""
    total = gathered(extinction, length)
    return fade(extinction, distance) / total if total > 0.0 else 0.0


@kernel
def channel_probabilities(weight):
    """Probabilities of the three colours in proportion to ``weight``; zeros if all of it vanishes."""
    total = weight[0] + weight[1] + weight[2]
    return scale(weight, 1.0 / total) if 0.0 < total < math.inf else BLACK


@kernel
def mixed_density(extinction, length, distance, channel_pmf):
    """Density of a distance if a colour was chosen by ``channel_pmf`` and then the distance by ``distance_in``."""
    density = 0.0
    for axis in range(3):
        if channel_pmf[axis] > 0.0:
            density += channel_pmf[axis] * distance_density(extinction[axis], length, distance)
    return density


@kernel
def mixed_distance(extinction, length, channel_pmf, u):
    """A distance with the density ``mixed_density``."""
    axis = 0
    while axis < 2 and u >= channel_pmf[axis]:
        u -= channel_pmf[axis]
        axis += 1
    u = min(u / channel_pmf[axis], 1.0 - 2.0**-53) if channel_pmf[axis] > 0.0 else 0.5
    if not extinction[axis] > 0.0:
        return u * length
    return distance_in(extinction[axis], extinction[axis] * length, u)


@kernel
def view_angle(near, height, length):
    """Angle under which a point sees the ray from 0 to ``length``; the point has ``height`` above the distance
    ``near``."""
    if length == math.inf:
        return 0.5 * math.pi + math.atan2(near, height)
    return math.atan2(height * length, height * height - near * (length - near))


@kernel
def facing_distance(near, height, angle, u):
    """A distance that is uniform over the ``angle`` of ``view_angle`` from a point: its density is proportional to
    1/r²."""
    start = math.atan2(-near, height)
    return max(near + height * math.tan(start + u * angle), 0.0)


@kernel
def facing_density(near, height, angle, distance):
    """Density of ``facing_distance`` giving ``distance``, per metre."""
    away = distance - near
    return height / (angle * (height * height + away * away)) if angle > 0.0 else 0.0


@kernel
def draw_distance(extinction, length, channel_pmf, near, height, u):
    """Where to scatter light from a point: a distance from 0 to ``length`` and its density.

    Half of the samples follow the transmittance, half are uniform over the angle under which the point sees the ray;
    ``height`` < 0: there is no such point.
    """
    if height < 0.0:
        distance = mixed_distance(extinction, length, channel_pmf, u)
        return distance, mixed_density(extinction, length, distance, channel_pmf)
    height = max(height, _CLOSEST * (1.0 + abs(near)))
    angle = view_angle(near, height, length)
    if u < 0.5:
        distance = min(facing_distance(near, height, angle, 2.0 * u), length)
    else:
        distance = mixed_distance(extinction, length, channel_pmf, 2.0 * u - 1.0)
    return distance, 0.5 * (
        facing_density(near, height, angle, distance) + mixed_density(extinction, length, distance, channel_pmf)
    )
