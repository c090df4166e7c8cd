# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The integrator's queries about any kind of emitter: samples, hits of rays, and flags."""

import math

import numpy as np

from ....jit import kernel
from ....replaced import replaced_on_gpu
from ....vec import largest, put
from . import kinds, triangle
from .environment import sample_world, world_radiance
from .kinds import LAMP, TRIANGLE, WORLD
from .linking import is_in_light_tree
from .records import (
    emitter_table,
    header_table,
    no_sample,
    triangle_map_table,
    triangle_offset_table,
)


@kernel
def sample_light(block, emitter, x, n, u1, u2):
    """Direction towards a light: (wi, distance, radiance, pdf, singular).

    ``pdf`` is per solid angle, without the selection probability. If ``singular`` is true, the light comes from one
    direction alone: ``pdf`` is 1, ``radiance`` is the irradiance across wi, and no ray can hit the light. A pdf of 0
    means that the light does not reach x. The world and suns are at distance ∞. Lamps are sampled by
    ``sdf_lights.emitter``; here they have a pdf of 0. The radiance of a triangle with ``triangle_textured`` is only an
    estimate: shade it at ``triangle_point``.
    """
    row = emitter_table(block)[emitter]
    if row.kind == TRIANGLE:
        return triangle.sample(triangle.rows(block)[row.index], x, u1, u2)
    if row.kind == WORLD:
        wi, pdf = sample_world(block, x, n, u1, u2)
        if not pdf > 0.0:
            return no_sample()
        return wi, math.inf, world_radiance(block, wi), pdf, False
    return kinds.sample(row.kind, block, row.index, x, u1, u2)


@kernel
def light_hits(block, number, o, d, t_max, ray_kind, hits):
    """Lights of finite size that the ray from o along the unit vector d hits before ``t_max``, and suns if that is ∞.

    Writes rows of ``HIT`` into ``hits`` (as long as ``pack.hit_capacity``) and returns their number. Each has the
    radiance along the ray, the distance, and the pdf of ``sample_light`` at o, without selection. Lights do not block
    the ray. ``ray_kind`` holds bits of ``scene.Ray``: lights visible to none of them are left out, and so are those
    outside the light tree ``number`` of the last scattering object (0: all of them). For a path that went straight
    through a transparent surface, pass the o of the last scattering and skip nearer hits.
    """
    header = header_table(block)[0]
    emitters = emitter_table(block)
    count = 0
    for emitter in range(header.lamp_count, header.lamp_count + header.light_count):
        row = emitters[emitter]
        if (
            row.met & ray_kind == 0
            or (row.leaf < 0 and row.infinite < 0)
            or not is_in_light_tree(block, number, emitter)
        ):
            continue
        distance, radiance, pdf = kinds.hit(row.kind, block, row.index, o, d)
        if distance > 0.0 and (distance < t_max or distance == t_max == math.inf) and largest(radiance) > 0.0:
            hit = hits[count]
            hit.emitter, hit.distance, hit.pdf = emitter, distance, pdf
            put(hit.radiance, radiance)
            count += 1
    return count


@kernel
def is_distant(block, emitter):
    """Whether an emitter is the world or a sun."""
    return emitter_table(block)[emitter].infinite >= 0


@kernel
def leave_light(block, emitter, u1, u2, u3, u4):
    """A ray that leaves one of Blender's lights: see ``interfaces.Light``."""
    row = emitter_table(block)[emitter]
    return kinds.leave(row.kind, block, row.index, u1, u2, u3, u4)


@kernel
def distance_to_light(block, emitter, x, d):
    """Distance along d from x to one of Blender's lights that lights x from there; −1 if it does not, or has no
    size."""
    row = emitter_table(block)[emitter]
    return kinds.hit(row.kind, block, row.index, x, d)[0]


@kernel
def is_lamp(block, emitter):
    """Whether the emitter is an SDF lamp; its index is then the lamp's."""
    return emitter_table(block)[emitter].kind == LAMP


@kernel
def is_triangle(block, emitter):
    """Whether the emitter is a triangle of an emissive surface."""
    return emitter_table(block)[emitter].kind == TRIANGLE


@kernel
def emitter_normal(block, emitter, back):
    """Unit normal of a light's surface if it has one, else ``back``, the direction to the viewer."""
    row = emitter_table(block)[emitter]
    return kinds.normal(row.kind, block, row.index, back)


@kernel
def casts_shadow(block, emitter):
    """Whether surfaces hide the emitter's light."""
    return emitter_table(block)[emitter].cast_shadow != 0


@kernel
def blockers(block, emitter):
    """Kind of shadow rays towards the emitter, which are stopped by the opaque surfaces that cast its shadows."""
    return emitter_table(block)[emitter].blockers


@replaced_on_gpu
@kernel
def may_light(block, emitter, bounces):
    """Whether the emitter may light a vertex of a path after so many bounces."""
    return bounces <= emitter_table(block)[emitter].max_bounces


@kernel
def can_be_hit(block, emitter, kinds):
    """Whether rays of all of these kinds of ``scene.Ray`` can hit the emitter as light rays find it."""
    row = emitter_table(block)[emitter]
    return row.met & kinds == kinds and row.alone == 0


@kernel
def camera_brightness(block, emitter):
    """Factor on the radiance of a lamp for camera rays."""
    return emitter_table(block)[emitter].camera_brightness


@kernel
def visibility(block, emitter):
    """Bits of ``scene.Ray``: kinds of rays that see the emitter's light."""
    return emitter_table(block)[emitter].visibility


@kernel
def world_emitter(block):
    """Emitter of the world."""
    return header_table(block)[0].world_emitter


@kernel
def triangle_emitter(block, instance, primitive):
    """Emitter of a triangle of an instance, or −1 if it is not one."""
    offsets = triangle_offset_table(block)
    if instance + 1 >= len(offsets):
        return -1
    at = offsets[instance] + primitive
    if at >= offsets[instance + 1]:
        return -1
    return triangle_map_table(block)[at]


@kernel
def triangle_pdf(block, x, emitter, d, distance):
    """Density of ``sample_light`` at x for a triangle that the ray along d hits at ``distance``, without selection."""
    return triangle.density(triangle.rows(block)[emitter_table(block)[emitter].index], x, d, distance)


@kernel
def triangle_textured(block, emitter):
    """Whether the emitter is a triangle with varying radiance, which must be shaded at the sampled point."""
    row = emitter_table(block)[emitter]
    return row.kind == TRIANGLE and triangle.rows(block)[row.index].textured != 0


@kernel
def is_this_triangle(block, emitter, instance, primitive):
    """Whether the emitter is this triangle of an instance."""
    row = emitter_table(block)[emitter]
    if row.kind != TRIANGLE:
        return False
    found = triangle.rows(block)[row.index]
    return found.instance == instance and found.primitive == primitive


@kernel
def triangle_place(block, emitter):
    """Instance, primitive and area (m²) of an emissive triangle at the time of the path."""
    row = triangle.rows(block)[emitter_table(block)[emitter].index]
    return np.int64(row.instance), np.int64(row.primitive), triangle.area(row)


@kernel
def triangle_point(block, x, emitter, d):
    """Hit of the ray from x along d with an emissive triangle: instance, primitive, weights of corners 1 and 2."""
    row = triangle.rows(block)[emitter_table(block)[emitter].index]
    v, w = triangle.barycentric(row, x, d)
    return row.instance, row.primitive, v, w
