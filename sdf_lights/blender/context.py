# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What an operator or panel is about."""

import bpy

from .naming import ENGINE, LABEL


def light_of(context) -> bpy.types.Light | None:
    """The light that a panel is about: that of the Properties editor, which may be pinned, or of the active object."""
    light = getattr(context, "light", None)
    if light is None and context.object is not None and context.object.type == "LIGHT":
        light = context.object.data
    return light


def lamp_of(context) -> bpy.types.Light | None:
    """The light that a panel is about, if it is an SDF lamp."""
    light = light_of(context)
    return light if light is not None and light.sdf_lamp.use else None


class LampTab:
    """A panel in the lamps' tab of the 3D view: with other engines it is there for lamps, which glow all the same."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = LABEL

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE or lamp_of(context) is not None


class LampOperator:
    """An operator on the light that the panel is about."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        light = light_of(context)
        return light is not None and light.is_editable
