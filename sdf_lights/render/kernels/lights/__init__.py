# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All lights except SDF lamps: see README.md in this folder."""

from .along import select_along
from .emitters import (
    blockers,
    camera_brightness,
    can_be_hit,
    casts_shadow,
    distance_to_light,
    emitter_normal,
    is_distant,
    is_lamp,
    is_this_triangle,
    is_triangle,
    leave_light,
    light_hits,
    may_light,
    sample_light,
    triangle_emitter,
    triangle_pdf,
    triangle_place,
    triangle_point,
    triangle_textured,
    visibility,
    world_emitter,
)
from .environment import pdf_in_cycles, world_pdf, world_radiance
from .linking import emission_is_linked, is_in_light_tree, open_tree, shadow_bits, tree_of
from .pack import TABLES, hit_capacity, pack_lights, pack_near
from .records import HIT, WORKSPACE_COUNTS, WORKSPACE_TABLES, light_cut_table
from .tree import irradiance, select, selection_probability
from .tree_build import Bounds
from .triangle import Triangles

__all__ = [
    "HIT",
    "TABLES",
    "WORKSPACE_COUNTS",
    "WORKSPACE_TABLES",
    "Bounds",
    "Triangles",
    "blockers",
    "camera_brightness",
    "casts_shadow",
    "can_be_hit",
    "distance_to_light",
    "emission_is_linked",
    "emitter_normal",
    "hit_capacity",
    "irradiance",
    "is_distant",
    "is_lamp",
    "is_this_triangle",
    "is_triangle",
    "leave_light",
    "light_cut_table",
    "light_hits",
    "is_in_light_tree",
    "open_tree",
    "pack_lights",
    "pack_near",
    "pdf_in_cycles",
    "may_light",
    "sample_light",
    "select",
    "select_along",
    "selection_probability",
    "shadow_bits",
    "tree_of",
    "triangle_emitter",
    "triangle_pdf",
    "triangle_place",
    "triangle_point",
    "triangle_textured",
    "visibility",
    "world_emitter",
    "world_pdf",
    "world_radiance",
]
