# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths from the world and from suns.

Their light passes through the whole scene, and most of it never comes near to what the picture shows: in a room, a part
of it comes through the windows. So light paths are sent past *targets*: places that the camera sees, or that are seen
from there, which the light of the world and of suns reaches. A direction is drawn as for light rays, then a target,
then a point of a disk around that, across the direction. The disk is one of some sizes, so other places are lit, too,
and one disk is that of the whole scene. The density of the line is the mean over all targets and disks.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import kernel
from ....vec import ZERO, average, dot, frame, length, madd, negate, scale, sub, vec
from .. import lights
from ..emission_graphs import NO_RAY, modulated
from ..ray_origins import clear_self_primitive
from ..rays import intersect, ray_table, start_anew
from ..samplers import get_2d, pixel_seed
from ..shading.records import DIFFUSE
from .records import PLACE, target_table

SCENE_SHARE = 0.1  # of the disk of the whole scene
SIZES, GROWTH = 5, 3.0  # of a target's disks; each is so many times as wide as the last one
SMALLER = 0.7  # share of a disk, of that of the next smaller one
TOTAL = (1.0 - SMALLER**SIZES) / (1.0 - SMALLER)
TRIALS = 16  # rays of each emitter to a place
SAME_PLACE = 1e-3  # part of the scene's radius: a ray that ends so near to a place reaches that


@kernel
def _radiance(block, workspace, emitter, x, u1, u2):
    """Direction towards the light of a distant emitter, and its radiance over the density of that."""
    wi, _, radiance, pdf, _ = lights.sample_light(block, emitter, x, ZERO, u1, u2)
    if not pdf > 0.0:
        return wi, ZERO
    if block.emission_graphs:
        radiance = modulated(block, workspace, emitter, radiance, x, wi, np.inf, NO_RAY)
    return wi, scale(radiance, 1.0 / pdf)


@kernel
def _density(block, place, wi):
    """Density by area, across wi, of the lines that are drawn, at a line through a place."""
    targets = target_table(block)
    scene = targets[0]
    off = sub(place, vec(scene.position))
    along = dot(off, wi)
    square = dot(off, off) - along * along
    total = SCENE_SHARE / (math.pi * scene.radius * scene.radius) if square < scene.radius * scene.radius else 0.0
    share = (1.0 - SCENE_SHARE) / (TOTAL * math.pi * (len(targets) - 1))
    for index in range(1, len(targets)):
        target = targets[index]
        off = sub(place, vec(target.position))
        along = dot(off, wi)
        square = dot(off, off) - along * along
        size, part = target.radius * target.radius, share
        for _ in range(SIZES):
            if square < size:
                total += part / size
            size, part = size * GROWTH * GROWTH, part * SMALLER
    return total


@kernel
def leave_distant(block, workspace, emitter, u1, u2, u3, v1, v2):
    """Start outside the scene, direction and flux (RGB, W) of a light path from the world or a sun."""
    targets = target_table(block)
    scene = targets[0]
    wi, radiance = _radiance(block, workspace, emitter, vec(scene.position), u1, u2)
    if average(radiance) <= 0.0:
        return ZERO, ZERO, ZERO
    index, radius = 0, scene.radius
    if len(targets) > 1 and u3 >= SCENE_SHARE:
        number = (u3 - SCENE_SHARE) / (1.0 - SCENE_SHARE) * (len(targets) - 1)
        index = min(int(number), len(targets) - 2)
        left, part, radius = (number - index) * TOTAL, 1.0, targets[index + 1].radius
        for _ in range(SIZES - 1):
            if left >= part:
                left, part, radius = left - part, part * SMALLER, radius * GROWTH
            else:
                break
        index += 1
    t, b = frame(wi)
    r, phi = radius * math.sqrt(v1), 2.0 * math.pi * v2
    place = madd(madd(vec(targets[index].position), r * math.cos(phi), t), r * math.sin(phi), b)
    density = _density(block, place, wi)
    if not density > 0.0:
        return ZERO, ZERO, ZERO
    # From the plane that touches the scene.
    origin = madd(place, scene.radius - dot(sub(place, vec(scene.position)), wi), wi)
    return origin, negate(wi), scale(radiance, 1.0 / density)


@kernel
def measure(block, workspace, emitter, number, places, found):
    """``found`` (n,): the mean irradiance, across its rays, by which a distant emitter reaches each of the places."""
    scene, scratch, seed = block[0], workspace[0], pixel_seed(PLACE + 1, PLACE + number, block[0].seed)
    sphere = target_table(scene)[0]
    near = SAME_PLACE * sphere.radius
    clear_self_primitive(ray_table(scratch)[0])
    for index in range(len(places)):
        place, total = (places[index, 0], places[index, 1], places[index, 2]), 0.0
        way = 2.0 * sphere.radius + length(sub(place, vec(sphere.position)))
        for trial in range(TRIALS):
            u = get_2d(index * TRIALS + trial, seed, 0)
            wi, radiance = _radiance(scene, scratch, emitter, place, u[0], u[1])
            if average(radiance) > 0.0:
                start_anew(scene, scratch)
                met = intersect(scene, scratch, madd(place, way, wi), negate(wi), 0.0, way - near, DIFFUSE)
                total += 0.0 if met else average(radiance)
        found[index] = total / TRIALS
