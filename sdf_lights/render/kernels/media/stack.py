# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The media around a ray, and their changes where it crosses surfaces.

As in Cycles, a medium is left through the instance and the material by which it was entered. Several media around a
point add up.
"""

from __future__ import annotations

import numpy as np

from ....jit import kernel
from ....vec import dot, madd, negate, put, put_sum, transform_vector, vec
from ...scene import Ray
from .. import lights
from ..geometry import hit_material, instance_at, instance_table, surface_table
from ..path import path_table
from ..ray_continuation import continue_past_hit
from ..rays import beyond, hit_instance, hit_normal, intersect, ray_table
from .dispatch import BEGIN, CROSS, ESCAPE, LOOK, NOTE, PASS
from .records import LIGHT_RAY, MOST_BOUNDS, MOST_MEDIA, NOTHING, WORLD, bounds_table, inside_table, medium_table

CAMERA = int(Ray.CAMERA)
UP, BLACK = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
MOST_CROSSINGS = 64  # of the ray that finds the media around the camera


@kernel
def receiver(block, inside):
    """Light tree of the medium that a ray has entered last."""
    last = inside.count - 1
    if last < 0 or inside.owner[last] == WORLD:
        return lights.open_tree(block)
    return lights.tree_of(block, inside.owner[last])


@kernel
def _settle(block, inside):
    """Add up the coefficients of all media."""
    for axis in range(3):
        inside.extinction[axis] = 0.0
        inside.scattering[axis] = 0.0
        inside.emission[axis] = 0.0
    inside.varies = 0
    for entry in range(inside.count):
        medium = medium_table(block)[inside.medium[entry]]
        put_sum(inside.extinction, vec(medium.extinction))
        put_sum(inside.scattering, vec(medium.scattering))
        put_sum(inside.emission, vec(medium.emission))
        inside.varies += int(medium.varies != NOTHING)
    inside.scatters = int(inside.scattering[0] > 0.0 or inside.scattering[1] > 0.0 or inside.scattering[2] > 0.0)
    inside.glows = int(inside.emission[0] > 0.0 or inside.emission[1] > 0.0 or inside.emission[2] > 0.0)


@kernel
def outside(block, inside):
    """Leave all media but the world's."""
    inside.count, inside.passed = 0, NOTHING
    if block.world_medium >= 0:
        inside.count = 1
        inside.medium[0], inside.owner[0] = block.world_medium, WORLD
    _settle(block, inside)


@kernel
def _place_of(inside, medium, owner):
    """Index of a medium among those around a ray; their number if it is not there. A medium belongs to one material."""
    place = 0
    while place < inside.count and (inside.owner[place] != owner or inside.medium[place] != medium):
        place += 1
    return place


@kernel
def cross(block, inside, medium, owner, enters):
    """Enter or leave a medium of the instance ``owner``, if there is one."""
    if medium == NOTHING:
        return
    place = _place_of(inside, medium, owner)
    if enters:
        if place < inside.count or place == MOST_MEDIA:
            return
        inside.medium[place], inside.owner[place] = medium, owner
        inside.count += 1
    else:
        if place == inside.count:
            return
        inside.count -= 1
        inside.medium[place], inside.owner[place] = inside.medium[inside.count], inside.owner[inside.count]
    _settle(block, inside)


@kernel
def faces(block, ray, direction):
    """Whether a ray has hit a triangle from its front."""
    instance = instance_at(block, hit_instance(ray))
    # Embree returns the normal of the triangle as it was built: in world space if baked, else in the mesh's local
    # space.
    wo = negate(direction)
    facing = dot(hit_normal(ray), wo if instance.baked else transform_vector(instance.inverse, wo))
    return (facing < 0.0) == (instance.baked != 0 and instance.mirrored != 0)


@kernel
def met_bounds(block, ray):
    """Index of the material that a ray has hit."""
    return hit_material(instance_table(block)[hit_instance(ray)], block, np.int64(ray.primitive))


@kernel
def cross_hit(block, inside, ray, direction):
    """Go through the surface that a ray has hit."""
    material = met_bounds(block, ray)
    cross(
        block,
        inside,
        bounds_table(block)[material].medium,
        hit_instance(ray),
        faces(block, ray, direction),
    )


@kernel
def _note_surface(block, workspace):
    """Record the medium behind the surface that the path has hit. A surface that only bounds a medium and lies in the
    same place counts as behind it: a floor is met inside of the fog that lies on it, not below it."""
    inside, surface, path = inside_table(workspace)[0], surface_table(workspace)[0], path_table(workspace)[0]
    if inside.passed != NOTHING and path.length <= beyond(path.t_min):
        cross(block, inside, inside.passed, inside.passed_owner, inside.passed_enters == 0)
    inside.passed = NOTHING
    inside.across = bounds_table(block)[surface.material].medium
    inside.across_owner = surface.instance
    inside.enters = int(surface.backfacing == 0)


@kernel
def _pass_bounds(block, workspace):
    """If the surface that the path's ray has hit only bounds a medium, pass through it. Returns whether it does."""
    path, ray = path_table(workspace)[0], ray_table(workspace)[0]
    bounds = bounds_table(block)[met_bounds(block, ray)]
    if not bounds.only:
        return False
    inside = inside_table(workspace)[0]
    before = inside.count
    cross_hit(block, inside, ray, vec(path.direction))
    inside.passed, inside.passed_owner = bounds.medium if inside.count != before else NOTHING, hit_instance(ray)
    inside.passed_enters = int(inside.count > before)
    path.t_min = continue_past_hit(block, workspace, path.t_min)
    path.crossed += 1
    if path.crossed >= MOST_BOUNDS:
        put(path.throughput, BLACK)
    return True


@kernel
def _begin(block, workspace):
    """Find the media around the camera: a mesh contains the camera if a ray leaves it without having entered it."""
    rows, path = inside_table(workspace), path_table(workspace)[0]
    origin = madd(vec(path.start), path.t_min, vec(path.direction))
    inside, entered = rows[0], rows[LIGHT_RAY]
    outside(block, inside)
    if not block.camera_in_media:
        return
    entered.count = 0
    t_min = 0.0
    for _ in range(MOST_CROSSINGS):
        if not intersect(block, workspace, origin, UP, t_min, np.inf, CAMERA):
            return
        ray = ray_table(workspace)[0]
        material = met_bounds(block, ray)
        medium, owner = bounds_table(block)[material].medium, hit_instance(ray)
        if medium != NOTHING and _place_of(entered, medium, owner) == entered.count:
            if not faces(block, ray, UP):
                cross(block, inside, medium, owner, True)
            elif entered.count < MOST_MEDIA:
                entered.medium[entered.count], entered.owner[entered.count] = medium, owner
                entered.count += 1
        t_min = beyond(float(ray.t_far))


@kernel
def bounds(block, workspace, what):
    """An event of the path at the surfaces of media: one of ``dispatch``'s BEGIN …; 1 if it has passed a surface,
    else 0.

    BEGIN: it leaves the camera. ESCAPE: it hits nothing any more; an open mesh does not fill infinite space. NOTE: it
    has hit the workspace's surface. CROSS: it passes through that. PASS: it passes through the surface that its ray has
    hit, if that only bounds a medium. LOOK, LOOK_THROUGH: a light ray begins at the path, in front of or behind the
    surface.
    """
    rows = inside_table(workspace)
    inside = rows[0]
    if what == BEGIN:
        _begin(block, workspace)
    elif what == ESCAPE:
        outside(block, inside)
    elif what == NOTE:
        _note_surface(block, workspace)
    elif what == PASS:
        return 1.0 if _pass_bounds(block, workspace) else 0.0
    else:
        if what != CROSS:
            rows[LIGHT_RAY] = rows[0]
            inside = rows[LIGHT_RAY]
        if what != LOOK:
            cross(block, inside, inside.across, inside.across_owner, inside.enters != 0)
    return 0.0
