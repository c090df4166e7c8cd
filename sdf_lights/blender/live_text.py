# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Updates lamps while their text blocks are edited. Blender sends no event for changes of a text."""

from __future__ import annotations

import bpy

from . import parameters
from .naming import NODE_TREE

_INTERVAL = 0.3  # seconds between two checks

_seen: dict[int, int] = {}  # hash of the text, by the identity of the text block


def _texts(light: bpy.types.Light) -> list[bpy.types.Text]:
    """Text blocks of the lamp's shape and of its emission."""
    lamp = light.sdf_lamp
    return [text for text in (lamp.text, lamp.emission.text) if text is not None]


def changed_texts() -> set[int]:
    """Identities of the text blocks of lamps that changed since the last call."""
    used = {text for light in bpy.data.lights for text in _texts(light)}
    used |= {
        node.text
        for tree in bpy.data.node_groups
        if tree.bl_idname == NODE_TREE
        for node in tree.nodes
        if getattr(node, "text", None) is not None
    }
    now = {text.session_uid: hash(text.as_string()) for text in used}
    changed = {uid for uid, text in now.items() if _seen.get(uid, text) != text}
    _seen.clear()
    _seen.update(now)
    return changed


def look() -> float:
    """Updates the lamps whose text has changed."""
    changed = changed_texts()
    if changed:
        for light in bpy.data.lights:
            if any(text.session_uid in changed for text in _texts(light)):
                parameters.update(light)
                light.update_tag()
        for tree in bpy.data.node_groups:
            for node in tree.nodes if tree.bl_idname == NODE_TREE else ():
                text = getattr(node, "text", None)
                if text is not None and text.session_uid in changed:
                    node.match_interface()
                    tree.update_tag()
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type in {"PROPERTIES", "VIEW_3D", "NODE_EDITOR"}:
                    area.tag_redraw()
    return _INTERVAL


CLASSES = ()


def register():
    if not bpy.app.background:
        bpy.app.timers.register(look, first_interval=_INTERVAL, persistent=True)


def unregister():
    if bpy.app.timers.is_registered(look):
        bpy.app.timers.unregister(look)
    _seen.clear()
