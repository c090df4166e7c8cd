# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights of the CPU back end: see README.md in this folder."""

from .emitters import (
    casts_shadow,
    is_lamp,
    light_hits,
    sample_light,
    triangle_emitter,
    triangle_pdf,
    triangle_point,
    triangle_textured,
    visibility,
    world_emitter,
)
from .environment import world_pdf, world_radiance
from .pack import Triangles, hit_capacity, pack_lights
from .records import HIT, TABLES, WORKSPACE_COUNTS, WORKSPACE_TABLES, light_cut_table
from .tree import irradiance, select, selection_probability

__all__ = [
    "HIT",
    "TABLES",
    "WORKSPACE_COUNTS",
    "WORKSPACE_TABLES",
    "Triangles",
    "casts_shadow",
    "hit_capacity",
    "irradiance",
    "is_lamp",
    "light_cut_table",
    "light_hits",
    "pack_lights",
    "sample_light",
    "select",
    "selection_probability",
    "triangle_emitter",
    "triangle_pdf",
    "triangle_point",
    "triangle_textured",
    "visibility",
    "world_emitter",
    "world_pdf",
    "world_radiance",
]
