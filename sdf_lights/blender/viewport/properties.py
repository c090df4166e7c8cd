# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``Scene.sdf_lights_overlay``: the display of lamps in the viewport, with a panel among Blender's overlays. Also the
pause of the Rendered viewport, with a button in its header."""

import bpy

from .. import overlay_settings
from ..naming import ENGINE


class SDFLIGHTS_PT_overlay(bpy.types.Panel):
    """Overlay settings of SDF lamps."""

    bl_label = "SDF Lamps"
    bl_space_type, bl_region_type = "VIEW_3D", "HEADER"
    bl_parent_id = "VIEW3D_PT_overlay"

    def draw(self, context):
        overlay_settings.draw(self.layout, context.scene.sdf_lights_overlay)


def draw_pause(self, context):
    """The button in the header of a viewport with the path tracer."""
    if context.engine == ENGINE and context.space_data.shading.type == "RENDERED":
        settings = context.scene.sdf_lights_overlay
        self.layout.prop(settings, "pause", icon="PLAY" if settings.pause else "PAUSE", text="")


CLASSES = (SDFLIGHTS_PT_overlay,)


def register():
    kind = overlay_settings.SDFLIGHTS_OverlaySettings
    bpy.types.Scene.sdf_lights_overlay = bpy.props.PointerProperty(name="SDF Lamps", type=kind)
    bpy.types.VIEW3D_HT_header.append(draw_pause)


def unregister():
    bpy.types.VIEW3D_HT_header.remove(draw_pause)
    del bpy.types.Scene.sdf_lights_overlay
