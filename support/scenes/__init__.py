# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes on which all back ends must agree.

``SCENES`` maps a name to a function ``(width=48, height=36) -> Scene``. Each scene tests one feature, has at most 2,000
triangles, and converges in few samples. It uses a box filter one pixel wide and no adaptive sampling, so pixel values
are plain means. ``media`` and ``strands`` have more scenes of this kind.
"""

from __future__ import annotations

from .cameras import depth_of_field, fisheye, orthographic, panorama
from .lamps import (
    colored_lamps,
    cove,
    data_lamps,
    field_lamps,
    frame_lamp,
    inside_lamp,
    network_lamp,
    torus_room,
    varying_lamps,
    veiled,
)
from .lights import (
    blender_lights,
    emissive_mesh,
    environment,
    glowing_bubble,
    light_control,
    shadow_catcher,
    sky_image,
    skylight,
    world_color,
)
from .matrices import look_at, rotation, scaling, translation
from .meshes import box, quad, sphere
from .moving_objects import changing_lamps, moving, rolling
from .room import GREEN, GREY, HEIGHT, RED, WHITE, WIDTH, add, camera, diffuse, material, room, settings, torus_lamp
from .subsurface_scattering import subsurface, subsurface_profile
from .surfaces import (
    facets,
    filtered_glossy,
    glass,
    glossy_metal,
    only_reflective_caustics,
    only_refractive_caustics,
    principled_without_caustics,
    rare,
    stopped_light,
    transparent,
)
from .textured_surfaces import checker_image, instances, probed, textured

SCENES = {
    builder.__name__: builder
    for builder in (
        torus_room,
        cove,
        blender_lights,
        world_color,
        environment,
        skylight,
        emissive_mesh,
        glowing_bubble,
        light_control,
        glossy_metal,
        facets,
        rare,
        glass,
        subsurface,
        subsurface_profile,
        only_reflective_caustics,
        principled_without_caustics,
        only_refractive_caustics,
        filtered_glossy,
        shadow_catcher,
        textured,
        probed,
        instances,
        frame_lamp,
        field_lamps,
        data_lamps,
        network_lamp,
        colored_lamps,
        varying_lamps,
        inside_lamp,
        veiled,
        transparent,
        stopped_light,
        depth_of_field,
        panorama,
        fisheye,
        orthographic,
        moving,
        changing_lamps,
        rolling,
    )
}
