# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustic paths: from points of SDF lamps, aimed at mirrors, glass and narrow lobes, on to surfaces that are seen by
the camera.

A camera ray through the place of the picture where the surface is tells whether it is seen, and shades it as for paths
from the camera. With the flux Φ that comes along −ω, the value of a pixel grows by

    f |cos| Φ / (|ng · ω| A)

times the pixel's filter. A is the area that a pixel shows there: see ``weights.py``.
"""

from __future__ import annotations

import math

import numpy as np

from .... import emitter as lamps
from ....jit import kernel
from ....vec import ZERO, dot, frame, largest, length, mul, negate, put, scale, sub, to_world, vec
from ..camera import camera_ray, camera_table, filter_table, pixel_through_lens, view_depth
from ..geometry import find_surface, instance_table, surface_at, surface_table
from ..light_paths.mirrors import mirrored, scattered_flux
from ..light_paths.records import PLACE
from ..light_paths.trace import any_direction, leave_lamp
from ..path import CAMERA
from ..ray_origins import clear_self_primitive, spawn_ray
from ..rays import hit_instance, intersect, ray_table, start_anew
from ..samplers import get_2d, get_3d, get_4d, pixel_seed
from ..shading import evaluate, sample, shade
from ..shading.records import (
    DIFFUSE,
    GLOSSY,
    MICROFACET,
    SCATTERED,
    SINGULAR,
    TRANSMISSION,
    TRANSPARENT,
    closure_table,
)
from ..workspace import secondary_table, spans_of
from .lobes import has_narrow_lobe, ratio_of_lobe, weight_of
from .records import MOST_MIRRORS, UNAIMED, chance_table, power_table, target_table
from .weights import area_of_pixel, cone_around, direction_density, knows_mirror, lines_of, ratio_of, rival_of

SEEN = 1e-5  # part of a distance by which a ray may end before a place that it reaches
LENS_SET, FIRST_SET = 2, 3  # of random numbers: for the lens, and at the first surface


@kernel
def _leave(block, index, total, seed):
    """Lamp, start, direction and flux (RGB, W) of a caustic path, one of ``total``, and its target. The lamp is −1 if
    there is no light."""
    u, v, powers = get_4d(index, seed, 0), get_3d(index, seed, 1), power_table(block)
    sum_of_powers = powers[len(powers) - 1]
    lamp = min(np.searchsorted(powers, u[0] * sum_of_powers, side="right"), len(powers) - 1)
    power = powers[lamp] - (powers[lamp - 1] if lamp > 0 else 0.0)
    if not power > 0.0:
        return np.int64(-1), ZERO, ZERO, ZERO, -1
    origin, intensity = leave_lamp(block, lamp, u[1], u[2], u[3])
    targets, target, direction = target_table(block), -1, any_direction(v[0], v[1])
    if v[2] >= UNAIMED:
        left = (v[2] - UNAIMED) / (1.0 - UNAIMED)
        chances, first = chance_table(block), lamp * len(targets)
        target = 0
        while target < len(targets) - 1 and left >= chances[first + target]:
            left -= chances[first + target]
            target += 1
        axis, least = cone_around(targets[target], origin)
        if least > -1.0:
            t, b = frame(axis)
            cosine, around = 1.0 - v[0] * (1.0 - least), 2.0 * math.pi * v[1]
            sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
            direction = to_world((sine * math.cos(around), sine * math.sin(around), cosine), t, b, axis)
    density = direction_density(block, lamp, origin, direction)
    return np.int64(lamp), origin, direction, scale(intensity, sum_of_powers / (power * total * density)), target


@kernel
def _part_allowed(block, cosine, pdf, glossy_pdf, glossy, transmission):
    """The part of what the last surface scatters that a path from the camera would have followed back, by its limits of
    bounces: ``glossy`` and ``transmission`` are those on the way to its last mirror. ``cosine`` is that of the
    geometric normal."""
    if cosine < 0.0:
        return 1.0 if transmission + 1 <= block.transmission_bounces and glossy <= block.glossy_bounces else 0.0
    if transmission > block.transmission_bounces or glossy > block.glossy_bounces:
        return 0.0
    part = glossy_pdf / pdf
    found = 0.0 if glossy + 1 > block.glossy_bounces else part
    return found + (1.0 - part if block.diffuse_bounces >= 1 else 0.0)


@kernel
def _look(block, workspace, x, wi, index, seed, window, record):
    """Look from the camera at the place x, and fill the ``record`` with what it scatters there of light from wi, for a
    flux of 1. Returns the density of wi, the part of that from lobes, and A; a density of 0: it is not seen."""
    camera, surface = camera_table(block)[0], surface_table(workspace)[0]
    if view_depth(block, x) <= 0.0:
        return 0.0, 0.0, 0.0
    u = get_2d(index, seed, LENS_SET) if block.camera_aperture > 0.0 else (0.5, 0.5)
    px, py = pixel_through_lens(camera, x, u[0], u[1])
    if not (window[0] <= px <= window[2] and window[1] <= py <= window[3]):
        return 0.0, 0.0, 0.0
    origin, direction, t_min, t_max = camera_ray(block, px, py, u[0], u[1])
    clear_self_primitive(ray_table(workspace)[0])
    start_anew(block, workspace)
    if not intersect(block, workspace, origin, direction, t_min, t_max, CAMERA):
        return 0.0, 0.0, 0.0
    distance, away = float(ray_table(workspace)[0].t_far), length(sub(x, origin))
    if abs(distance - away) > SEEN * away:
        return 0.0, 0.0, 0.0
    footprint = distance * block.camera_pixel_angle + block.camera_pixel_width
    find_surface(block, workspace, negate(direction), CAMERA, footprint)
    if instance_table(block)[surface.instance].holdout:
        return 0.0, 0.0, 0.0
    shade(block, workspace)
    if surface.evaluable == 0:
        return 0.0, 0.0, 0.0
    value, pdf, glossy_pdf = evaluate(block, workspace, wi, SCATTERED)
    area = area_of_pixel(block, direction, distance, vec(surface.ng))
    cosine = abs(dot(vec(surface.ng), wi))
    if not (pdf > 0.0 and cosine > 0.0 and largest(value) > 0.0):
        return 0.0, 0.0, 0.0
    record.x, record.y = px, py
    put(record.light, scale(value, 1.0 / (cosine * area)))
    return pdf, glossy_pdf, area


@kernel
def _trace(block, workspace, index, total, seed, window, records, first):
    """Follow one caustic path, and write what the camera sees of it into ``records`` from ``first`` on,
    ``MOST_MIRRORS`` at most. Returns how many, and how many rays that took."""
    surface, secondary, ray = surface_table(workspace)[0], secondary_table(workspace)[0], ray_table(workspace)[0]
    clear_self_primitive(ray)
    lamp, origin, direction, flux, target = _leave(block, index, total, seed)
    count, rays, glossy, transmission = 0, 0, 0, 0
    if lamp < 0:
        return 0, 0
    to_lamp, mirror, start, own, least = negate(direction), ZERO, ZERO, ray.id, float(ray.least)
    t_lamp, spans, pdf_back, lines, lamp_pdf = -1.0, 0, 0.0, 0.0, 0.0
    for mirrors in range(min(MOST_MIRRORS, block.max_bounces) + 1):
        start_anew(block, workspace)
        rays += 1
        if not intersect(block, workspace, origin, direction, 0.0, np.inf, DIFFUSE):
            return count, rays
        wi = negate(direction)
        instance, primitive, u, v = hit_instance(ray), np.int64(ray.primitive), float(ray.u), float(ray.v)
        find_surface(block, workspace, wi, DIFFUSE, 0.0)
        if surface.strand != 0 and mirrors == 0:
            return count, rays
        shade(block, workspace)
        place, seen = vec(surface.position), mirrors > 0 and surface.evaluable > 0
        goes_on, next_flux, next_glossy, next_transmission = False, flux, glossy, transmission
        if mirrors < min(MOST_MIRRORS, block.max_bounces) and surface.strand == 0 and not pdf_back > 0.0:
            numbers = get_3d(index, seed, FIRST_SET + mirrors)
            direction, _, pdf, _, kind = sample(block, workspace, numbers[0], numbers[1], numbers[2])
            if pdf > 0.0 and kind & SINGULAR and kind & TRANSPARENT == 0:
                _, pdf, _ = mirrored(workspace, direction)
                if pdf > 0.0:
                    surface_at(block, surface_table(secondary)[0], instance, primitive, u, v, direction, DIFFUSE, 0.0)
                    shade(block, secondary)
                    if knows_mirror(block, secondary, wi):
                        factor, _ = scattered_flux(block, secondary, wi, kind, pdf)
                        next_flux = mul(flux, factor)
                        goes_on = largest(next_flux) > 0.0
                        # What a path from the camera scatters last, near the lamp, has no limit but that of all.
                        if mirrors > 0:
                            next_glossy += int(kind & GLOSSY != 0)
                            next_transmission += int(kind & TRANSMISSION != 0)
            elif mirrors == 0 and pdf > 0.0 and not kind & SINGULAR:
                surface_at(block, surface_table(secondary)[0], instance, primitive, u, v, direction, DIFFUSE, 0.0)
                lines, lamp_pdf = lines_of(block, surface)
                if lines > 0.0:
                    shade(block, secondary)
                    if has_narrow_lobe(secondary):
                        value, pdf_back, _ = evaluate(block, secondary, wi, SCATTERED)
                        ng = vec(surface.ng)
                        next_flux = scale(mul(flux, value), abs(dot(ng, direction)) / (abs(dot(ng, wi)) * pdf))
                        goes_on = pdf_back > 0.0 and largest(next_flux) > 0.0
            if goes_on and mirrors == 0:
                mirror = vec(surface_table(secondary)[0].position)
                start, own, least = spawn_ray(workspace, surface_table(secondary)[0], wi), ray.id, float(ray.least)
            if goes_on:
                origin = spawn_ray(workspace, surface, direction)
        own_next, least_next = ray.id, float(ray.least)
        if seen:
            record = records[first + count]
            rays += 1
            pdf, glossy_pdf, area = _look(block, workspace, place, wi, index, seed, window, record)
            if pdf > 0.0:
                cosine = dot(vec(surface.ng), wi)
                allowed = _part_allowed(block, cosine, pdf, glossy_pdf, glossy, transmission)
                rival = rival_of(block, vec(surface.ng), area, wi, pdf)
                if allowed > 0.0:
                    if pdf_back > 0.0:
                        ratio = ratio_of_lobe(lines, lamp_pdf, pdf_back, rival)
                    else:
                        if t_lamp < 0.0:
                            ray.id, ray.least = own, least
                            start_anew(block, workspace)
                            rays += 1
                            found = intersect(block, workspace, start, to_lamp, 0.0, np.inf, DIFFUSE)
                            t_lamp = float(ray.t_far) if found else np.inf
                        spans = lamps.trace(block, lamp, mirror, to_lamp, spans_of(workspace))
                        ratio = ratio_of(block, workspace, lamp, mirror, to_lamp, spans, t_lamp, rival)
                    put(record.light, scale(mul(vec(record.light), flux), allowed))
                    record.weight, record.ratio, record.target = weight_of(ratio), ratio, target
                    if 0.0 < record.light[0] + record.light[1] + record.light[2] < np.inf:
                        count += 1
        if not goes_on:
            return count, rays
        flux, glossy, transmission = next_flux, next_glossy, next_transmission
        ray.id, ray.least = own_next, least_next
    return count, rays


@kernel
def trace_caustic_paths(block, workspace, first, last, total, number, window, records, counts):
    """Trace the caustic paths ``first`` to before ``last`` of ``total``, of set ``number``.

    ``window``: x0, y0, x1, y1 in pixels, what the film shows with the reach of its filter. Rows of ``records``
    (n, ``MOST_MIRRORS``), flat, and of ``counts`` (n, 2), the number of records and of rays, are those of paths from
    ``first`` on, at their index modulo n."""
    scene, scratch = block[0], workspace[0]
    seed = pixel_seed(PLACE + number, PLACE + 2, scene.seed)
    for index in range(first, last):
        row = index % len(counts)
        counts[row, 0], counts[row, 1] = _trace(scene, scratch, index, total, seed, window, records, row * MOST_MIRRORS)


@kernel
def _filter_density(offsets, x):
    """Density of the pixel filter along an axis, in pixels, at the distance x from the middle of a pixel."""
    if not offsets[0] <= x < offsets[len(offsets) - 1]:
        return 0.0
    cell = min(np.searchsorted(offsets, x, side="right"), len(offsets) - 1)
    width = offsets[cell] - offsets[cell - 1]
    return 1.0 / ((len(offsets) - 1) * width) if width > 0.0 else 0.0


@kernel
def add_to_image(block, records, x0, y0, image):
    """Add all ``records`` to an ``image`` (height, width, RGB), whose first pixel is (x0, y0), by the pixel filter."""
    offsets = filter_table(block[0])
    radius = offsets[len(offsets) - 1]
    height, width = image.shape[0], image.shape[1]
    for index in range(len(records)):
        record = records[index]
        left = max(int(math.ceil(record.x - 0.5 - radius)) - x0, 0)
        low = max(int(math.ceil(record.y - 0.5 - radius)) - y0, 0)
        right = min(int(math.floor(record.x - 0.5 + radius)) - x0, width - 1)
        high = min(int(math.floor(record.y - 0.5 + radius)) - y0, height - 1)
        for row in range(low, high + 1):
            of_row = record.weight * _filter_density(offsets, record.y - (y0 + row + 0.5))
            for column in range(left, right + 1):
                part = of_row * _filter_density(offsets, record.x - (x0 + column + 0.5))
                for channel in range(3):
                    image[row, column, channel] += part * record.light[channel]


@kernel
def _is_mirror(block, workspace):
    """Whether the surface of the workspace has mirrors, sharp glass or narrow lobes that light paths know."""
    closures = closure_table(workspace)
    if block.caustic_lobes and has_narrow_lobe(workspace):
        return True
    for index in range(surface_table(workspace)[0].closure_count):
        if closures[index].kind == MICROFACET and closures[index].singular != 0:
            return True
    return False


@kernel
def find_mirrors(block, workspace, instance, primitives, corners, found):
    """``found`` (n,): 1 where triangles of an instance are mirrors, sharp glass or narrow lobes from either side, at
    the weights ``corners`` (n, 2) of their second and third corner."""
    scene, scratch = block[0], workspace[0]
    surface = surface_table(scratch)[0]
    for index in range(len(primitives)):
        wo, u, v = (0.0, 0.0, 1.0), corners[index, 0], corners[index, 1]
        for _ in range(2):
            surface_at(scene, surface, instance, primitives[index], u, v, wo, DIFFUSE, 0.0)
            wo = negate(vec(surface.ng))
            shade(scene, scratch)
            found[index] |= int(_is_mirror(scene, scratch))
