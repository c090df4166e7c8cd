# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Editors that a button opens: one that is already open, else half of the largest area, else a new window."""

from __future__ import annotations

import bpy

_LEAST_WIDTH = 600  # pixels; smaller areas are not split


def area_of(context, kind: str, fits=lambda area: True) -> bpy.types.Area | None:
    """An area of this type, in any window, for which ``fits`` is true. The one with the largest value of ``fits``
    wins."""
    found = [
        (fits(area), area)
        for window in context.window_manager.windows
        for area in window.screen.areas
        if area.type == kind
    ]
    best = max((rank for rank, _ in found), default=False)
    return next((area for rank, area in found if rank and rank == best), None)


def opened(context, ui_type: str) -> bpy.types.Area | None:
    """A new editor of this type, split off the largest area of the window. None if there is no window."""
    window = context.window
    if window is None or not window.screen.areas:
        return None
    largest = max(window.screen.areas, key=lambda area: area.width * area.height)
    if largest.width < _LEAST_WIDTH * context.preferences.system.ui_scale:
        with context.temp_override(window=window):
            bpy.ops.wm.window_new()
        area = context.window_manager.windows[-1].screen.areas[0]
    else:
        known = {area.as_pointer() for area in window.screen.areas}
        region = next(region for region in largest.regions if region.type == "WINDOW")
        with context.temp_override(window=window, area=largest, region=region):
            bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
        area = next(area for area in window.screen.areas if area.as_pointer() not in known)
    area.ui_type = ui_type
    return area
