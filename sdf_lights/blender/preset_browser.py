# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets as pictures, in the 3D view and in the properties of a light."""

from __future__ import annotations

import bpy

from .context import LampTab, light_of
from .operators import SDFLIGHTS_OT_lamp_add, SDFLIGHTS_OT_preset_load
from .preset_pictures import icon_of
from .presets import presets

_items: list[tuple] = []  # Blender keeps no reference to the strings that it shows


def items(self=None, context=None) -> list[tuple]:
    """Items of an EnumProperty with the presets' pictures."""
    if not _items:
        for index, (name, preset) in enumerate(presets().items()):
            _items.append((name.upper(), preset.title, "", icon_of(name), index))
    return _items


def draw_browser(layout, context) -> None:
    """Draw the picture of the chosen preset, which opens all of them, and its buttons."""
    manager = context.window_manager
    layout.template_icon_view(manager, "sdf_lights_preset", show_labels=True, scale=5.0, scale_popup=4.5)
    chosen = manager.sdf_lights_preset
    layout.label(text=presets()[chosen.lower()].title, translate=False)
    row = layout.row(align=True)
    operator = row.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text="Add Lamp", icon="ADD")
    operator.source, operator.preset = "PRESET", chosen
    if light_of(context) is not None:
        row.operator(SDFLIGHTS_OT_preset_load.bl_idname, text="Use Here", icon="CHECKMARK").preset = chosen


class SDFLIGHTS_PT_presets(LampTab, bpy.types.Panel):
    bl_label = "Presets"

    def draw(self, context):
        draw_browser(self.layout, context)


CLASSES = (SDFLIGHTS_PT_presets,)


def register():
    bpy.types.WindowManager.sdf_lights_preset = bpy.props.EnumProperty(
        name="Preset", description="Lamp to start from", items=items
    )


def unregister():
    del bpy.types.WindowManager.sdf_lights_preset
    _items.clear()
