# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The data that an operator or a panel works on."""

import bpy

from .naming import ENGINE, LABEL


def light_of(context) -> bpy.types.Light | None:
    """The light of a panel: that of the Properties editor, which may be pinned, or of the active object."""
    light = getattr(context, "light", None)
    if light is None and context.object is not None and context.object.type == "LIGHT":
        light = context.object.data
    return light


def lamp_of(context) -> bpy.types.Light | None:
    """The light of a panel, if it is an SDF lamp."""
    light = light_of(context)
    return light if light is not None and light.sdf_lamp.use else None


class LampTab:
    """A panel in the lamps' tab of the 3D view. Other engines show it too for lamps, because their overlay glows
    there."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = LABEL

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE or lamp_of(context) is not None


class LampOperator:
    """An operator on the light of the panel."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        light = light_of(context)
        return light is not None and light.is_editable
