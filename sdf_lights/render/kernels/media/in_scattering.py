# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Next event estimation along a ray in a medium: the light that one emitter sends to a point of it.

An SDF lamp is a cloud of point lights here. Several pairs of a point of the lamp and a position on the ray are drawn so
that 1/r² cancels. One is chosen by its contribution without shadows (resampled importance sampling: Talbot, Cline and
Egbert 2005). This needs no help from phase function rays, which ignore lamps.
"""

from __future__ import annotations

import math

from .... import emitter as lamps
from ....emitter.emission.varying import COLOUR_STACK, LANES, colours, density, place_colour
from ....emitter.lamps import lamps as lamp_table
from ....jit import kernel, stack_array
from ....vec import add, average, dot, is_zero, largest, length, madd, mul, scale, sub, vec
from ...scene import Ray
from .. import lights
from ..emission_graphs import NO_RAY, modulated
from ..next_event import mis_applies, shade_triangle
from ..outputs.state import LIGHT_RAY, scattered_in_medium
from ..path import LIGHT_SET, MEDIA_SETS, PLACE_SET, contribute, path_table
from ..samplers import get_2d, get_4d
from ..visibility import shadow_ray, transmittance
from ..workspace import light_cut_of
from . import dispatch
from .beams import attenuation, channel_probabilities, draw_distance, gathered_rgb
from .phase import phase
from .records import inside_table
from .stack import receiver

VOLUME = int(Ray.VOLUME)
BLACK = (0.0, 0.0, 0.0)
NO_POINT = -1.0  # height of a target that is not a point
PAIRS = 4 * LANES
FEW_PAIRS = 2  # if the light was scattered before: most noise then has other sources

# Step between pairs: the powers of the root of x⁵ = x + 1 (Roberts 2018, "The unreasonable effectiveness of quasirandom
# sequences").
STEPS = (0.8566748838545029, 0.7338918566271259, 0.6287067210378087, 0.5385972572236101)


@kernel
def light_between(block, workspace, emitter, x, wi, distance):
    """The light (RGB) of an emitter at that distance that reaches the point x of the path's ray."""
    dispatch.bounds(block, workspace, dispatch.LOOK)
    to_light, t_max = shadow_ray(x, x, wi, distance)
    return transmittance(block, workspace, x, to_light, t_max, lights.blockers(block, emitter))


@kernel
def place_of_light(block, emitter, finite, center, start, d, ray_length, u1, u2):
    """Where a light is beside a ray, for ``beams.draw_distance``: the distance of the nearest point of the ray, and the
    distance from there; ``NO_POINT`` if the light is not ``finite``."""
    if not finite:
        return 0.0, NO_POINT
    target = sub(center, start)
    x = madd(start, min(max(dot(target, d), 0.0), ray_length), d)
    wi, distance, _, pdf, _ = lights.sample_light(block, emitter, x, BLACK, u1, u2)
    if pdf > 0.0 and distance < math.inf:
        target = sub(madd(x, distance, wi), start)
    near = dot(target, d)
    return near, math.sqrt(max(dot(target, target) - near * near, 0.0))


@kernel
def add_light(block, workspace, emitter, pmf, number, x, wi, distance, radiance, pdf, singular, weight, phase_density):
    """Add the light of a sample of an emitter at the point x of the path's ray, times a ``weight`` (RGB), if it reaches
    x. ``pmf`` and ``number`` are of the selection of the emitter."""
    if lights.casts_shadow(block, emitter):
        weight = mul(weight, light_between(block, workspace, emitter, x, wi, distance))
        if is_zero(weight):
            return
    if lights.triangle_textured(block, emitter):
        radiance = shade_triangle(block, workspace, emitter, x, wi, distance)
    elif block.emission_graphs:
        radiance = modulated(block, workspace, emitter, radiance, x, wi, distance, NO_RAY)
    own = 1.0
    if not singular and mis_applies(block, emitter):
        # Phase function rays ask at x, too; the selection of the emitter is for the whole ray.
        at_x = pdf * lights.selection_probability(block, number, x, BLACK, emitter, light_cut_of(workspace))
        own = at_x / (at_x + phase_density)
    contribute(block, workspace, mul(weight, radiance), own / (pmf * pdf), emitter, path_table(workspace)[0].bounce + 1)


@kernel
def to_point(places, lane, d):
    """The way from the place of a pair to its point in the lamp."""
    return madd((places[LANES + lane], places[2 * LANES + lane], places[3 * LANES + lane]), -places[lane], d)


@kernel
def choose(weights, count, u):
    """The number of a weight, chosen in proportion; ``u``: up to their sum."""
    left, chosen = u, 0
    while chosen < count - 1 and left >= weights[chosen]:
        left -= weights[chosen]
        chosen += 1
    return chosen


@kernel
def light_ray(block, workspace, ray_length):
    """One ray towards one emitter, from a point of the path's ray between ``t_min`` and ``ray_length``."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    d, extinction, scattering = vec(path.direction), vec(inside.extinction), vec(inside.scattering)
    start = madd(vec(path.start), path.t_min, d)
    u = get_4d(path.index, path.seed, MEDIA_SETS + path.dimension + LIGHT_SET)
    v = get_2d(path.index, path.seed, MEDIA_SETS + path.dimension + PLACE_SET)
    number = receiver(block, inside)
    emitter, pmf, _, finite, center = lights.select_along(
        block, number, start, d, ray_length, average(extinction), u[0]
    )
    if not pmf > 0.0 or lights.visibility(block, emitter) & VOLUME == 0:
        return
    if not lights.may_light(block, emitter, path.bounce):
        return
    scattered_in_medium(block, workspace, LIGHT_RAY)
    throughput = mul(vec(path.throughput), scattering)
    channel_pmf = channel_probabilities(mul(throughput, gathered_rgb(extinction, ray_length)))
    if emitter < block.lamp_count:
        _light_by_lamp(
            block, workspace, emitter, pmf, start, ray_length, throughput, channel_pmf, (u[1], u[2], u[3], v[0]), v[1]
        )
        return
    near, height = place_of_light(block, emitter, finite, center, start, d, ray_length, u[1], u[2])
    place, place_density = draw_distance(extinction, ray_length, channel_pmf, near, height, v[0])
    if not place_density > 0.0:
        return
    x = madd(start, place, d)
    wi, distance, radiance, pdf, singular = lights.sample_light(block, emitter, x, BLACK, u[1], u[2])
    if pdf <= 0.0 or largest(radiance) <= 0.0:
        return
    value, phase_density = phase(block, workspace, inside, dot(d, wi))
    weight = scale(mul(scattering, attenuation(extinction, place)), value / place_density)
    add_light(block, workspace, emitter, pmf, number, x, wi, distance, radiance, pdf, singular, weight, phase_density)


@kernel
def _light_by_lamp(block, workspace, lamp, pmf, start, ray_length, throughput, channel_pmf, u, choice):
    """``light_ray`` from an SDF lamp."""
    path, inside = path_table(workspace)[0], inside_table(workspace)[0]
    row, d, extinction = lamp_table(block)[lamp], vec(path.direction), vec(inside.extinction)
    places, weights, stack = stack_array(PAIRS), stack_array(LANES), stack_array(COLOUR_STACK)
    origin = sub(start, vec(row.center))
    count = LANES if path.bounce == 0 else FEW_PAIRS
    for lane in range(count):
        u1, u2, u3 = (u[0] + lane * STEPS[0]) % 1.0, (u[1] + lane * STEPS[1]) % 1.0, (u[2] + lane * STEPS[2]) % 1.0
        way = lamps.interior_offset(block, lamp, start, u1, u2, u3)
        near = dot(way, d)
        height = math.sqrt(max(dot(way, way) - near * near, 0.0))
        place, place_density = draw_distance(
            extinction, ray_length, channel_pmf, near, height, (u[3] + lane * STEPS[3]) % 1.0
        )
        places[lane] = place
        places[LANES + lane], places[2 * LANES + lane], places[3 * LANES + lane] = way
        weights[lane] = 1.0 / place_density if place_density > 0.0 else 0.0
        if row.glow >= 0:
            place_colour(block, row.glow, add(origin, way), lane, stack)
    if row.glow >= 0:
        for lane in range(count, LANES):
            place_colour(block, row.glow, origin, lane, stack)
        colours(block, row.glow, stack)
    total = 0.0
    for lane in range(count):
        to = to_point(places, lane, d)
        square = dot(to, to)
        if not square > 0.0:
            weights[lane] = 0.0
            continue
        distance = math.sqrt(square)
        value, _ = phase(block, workspace, inside, dot(to, d) / distance)
        emission = density(block, row.glow, stack, lane) if row.glow >= 0 else vec(row.emission)
        light = mul(mul(throughput, emission), attenuation(extinction, places[lane] + distance))
        weights[lane] *= average(light) * value / square
        total += weights[lane]
    if not 0.0 < total < math.inf:
        return
    chosen = choose(weights, count, choice * total)
    if not weights[chosen] > 0.0:
        return
    place = places[chosen]
    to = to_point(places, chosen, d)
    distance = length(to)
    wi = scale(to, 1.0 / distance)
    emission = density(block, row.glow, stack, chosen) if row.glow >= 0 else vec(row.emission)
    # The weight is the mean of RGB with the transmittance on the way to the lamp; its own density cancels.
    seen = mul(mul(vec(inside.scattering), attenuation(extinction, place)), emission)
    by = average(mul(mul(vec(path.throughput), seen), attenuation(extinction, distance)))
    if not by > 0.0:
        return
    x = madd(start, place, d)
    shadow = light_between(block, workspace, lamp, x, wi, distance)
    if not is_zero(shadow):
        contribute(block, workspace, mul(seen, shadow), row.volume * total / (count * pmf * by), lamp, path.bounce + 1)
