# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the presets as icons, in menus and in the browser of presets."""

from __future__ import annotations

import bpy.utils.previews

from .presets import presets

_pictures = None


def icon_of(name: str) -> int:
    """Icon number of a preset."""
    global _pictures
    if _pictures is None:
        _pictures = bpy.utils.previews.new()
    if name not in _pictures:
        _pictures.load(name, str(presets()[name].picture), "IMAGE")
    return _pictures[name].icon_id


CLASSES = ()


def unregister():
    global _pictures
    if _pictures is not None:
        bpy.utils.previews.remove(_pictures)
        _pictures = None
