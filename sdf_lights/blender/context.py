# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What an operator or panel is about."""

import bpy


def light_of(context) -> bpy.types.Light | None:
    """The light that a panel is about: that of the Properties editor, which may be pinned, or of the active object."""
    light = getattr(context, "light", None)
    if light is None and context.object is not None and context.object.type == "LIGHT":
        light = context.object.data
    return light


class LampOperator:
    """An operator on the light that the panel is about."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        light = light_of(context)
        return light is not None and light.is_editable
