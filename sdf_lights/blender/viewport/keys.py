# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a key belongs to one of Blender's operators, in the user's key map."""

from __future__ import annotations

import bpy


def is_of(context, event: bpy.types.Event, operator: str) -> bool:
    """Whether Blender would run this operator in a 3D viewport on this event, without the add-on."""
    keymap = context.window_manager.keyconfigs.user.keymaps.get("3D View")
    found = keymap.keymap_items.match_event(event) if keymap is not None else None
    return found is not None and found.idname == operator
