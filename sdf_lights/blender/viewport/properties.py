# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``Scene.sdf_lights_overlay``: the display of lamps in the viewport, with a panel among Blender's overlays. Also the
pause of the Rendered viewport, with a button in its header."""

import bpy

from ..naming import ENGINE


def redraw(self, context):
    """Callback of the settings: redraw every 3D viewport."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


class SDFLIGHTS_OverlaySettings(bpy.types.PropertyGroup):
    """Viewport overlay of SDF lamps."""

    __slots__ = ()

    show_lamps: bpy.props.BoolProperty(
        name="SDF Lamps",
        description="Show the glow of SDF lamps in the viewport, with any render engine",
        default=True,
        update=redraw,
    )
    brightness: bpy.props.EnumProperty(
        name="Brightness",
        description="Brightness of lamps in Solid and Wireframe shading",
        default="SHAPE",
        update=redraw,
        items=[
            ("SHAPE", "Shape", "A brightness that shows the shape clearly at any power", 0),
            ("LIGHT", "Light", "The brightness of the render", 1),
        ],
    )
    resolution: bpy.props.EnumProperty(
        name="Resolution",
        description="Resolution of lamps, as a fraction of that of the viewport",
        default="1",
        update=redraw,
        items=[
            ("1", "Full", "Every pixel", 1),
            ("2", "Half", "Every second pixel, in both directions", 2),
            ("4", "Quarter", "Every fourth pixel, in both directions", 4),
        ],
    )
    coarse_motion: bpy.props.BoolProperty(
        name="Coarser in Motion",
        description="Draw lamps with a quarter of the pixels while the view or a lamp moves",
        default=True,
        update=redraw,
    )
    pause: bpy.props.BoolProperty(
        name="Pause", description="Pause the render in the viewport", default=False, update=redraw
    )


class SDFLIGHTS_PT_overlay(bpy.types.Panel):
    """Overlay settings of SDF lamps."""

    bl_label = "SDF Lamps"
    bl_space_type, bl_region_type = "VIEW_3D", "HEADER"
    bl_parent_id = "VIEW3D_PT_overlay"

    def draw(self, context):
        settings, layout = context.scene.sdf_lights_overlay, self.layout
        layout.prop(settings, "show_lamps")
        column = layout.column()
        column.active = settings.show_lamps
        column.prop(settings, "brightness")
        column.prop(settings, "resolution")
        column.prop(settings, "coarse_motion")


def draw_pause(self, context):
    """The button in the header of a viewport with the path tracer."""
    if context.engine == ENGINE and context.space_data.shading.type == "RENDERED":
        settings = context.scene.sdf_lights_overlay
        self.layout.prop(settings, "pause", icon="PLAY" if settings.pause else "PAUSE", text="")


CLASSES = (SDFLIGHTS_OverlaySettings, SDFLIGHTS_PT_overlay)


def register():
    bpy.types.Scene.sdf_lights_overlay = bpy.props.PointerProperty(name="SDF Lamps", type=SDFLIGHTS_OverlaySettings)
    bpy.types.VIEW3D_HT_header.append(draw_pause)


def unregister():
    bpy.types.VIEW3D_HT_header.remove(draw_pause)
    del bpy.types.Scene.sdf_lights_overlay
