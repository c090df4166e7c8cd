# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of emitters, and the modules of those that are Blender's lights."""

from __future__ import annotations

from types import ModuleType
from typing import NamedTuple

from ...scene import AreaLight, PointLight, SunLight
from . import area, ball, records, sun, triangle

LAMP, BALL, AREA, SUN, WORLD, TRIANGLE = range(6)


class Kind(NamedTuple):
    """A kind of Blender's lights: its class in a scene, a module that is an ``interfaces.Light``, and its table."""

    scene: type
    module: ModuleType
    table: str


KINDS = {
    BALL: Kind(PointLight, ball, "light_balls"),
    AREA: Kind(AreaLight, area, "light_areas"),
    SUN: Kind(SunLight, sun, "light_suns"),
}

TABLES = {
    **records.TABLES,
    "light_triangles": triangle.RECORD,
    "light_portals": area.RECORD,
    **{kind.table: kind.module.RECORD for kind in KINDS.values()},
}
