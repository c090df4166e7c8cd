# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the viewport overlay of lamps: those of a scene, and those that the preferences give to new files."""

import bpy

# What the preferences have, too.
DEFAULTS = ("show_lamps", "brightness", "resolution", "coarse_motion")


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


def draw(layout, settings: SDFLIGHTS_OverlaySettings) -> None:
    """Draw what a scene and the preferences have."""
    layout.prop(settings, "show_lamps")
    column = layout.column()
    column.active = settings.show_lamps
    for name in DEFAULTS[1:]:
        column.prop(settings, name)


CLASSES = (SDFLIGHTS_OverlaySettings,)
