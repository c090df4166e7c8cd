# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of sampling in the headers of the panels, as in Blender's own engines. Preview, Default and Final come with
the add-on; others are the user's."""

from __future__ import annotations

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .naming import ENGINE
from .presets import FOLDER
from .properties import VIEWPORT

_FINAL = ("samples", "noise_threshold", "min_samples", "time_limit", "guided_samples", "denoise")


class _Presets(PresetPanel):
    preset_operator = "script.execute_preset"
    COMPAT_ENGINES = {ENGINE}


class SDFLIGHTS_PT_sampling_presets(_Presets, bpy.types.Panel):
    """Presets of render samples."""

    bl_label = "Sampling Presets"
    preset_subdir = "sdf_lights/sampling"
    preset_add_operator = "sdf_lights.sampling_preset_add"


class SDFLIGHTS_PT_viewport_sampling_presets(_Presets, bpy.types.Panel):
    """Presets of viewport samples."""

    bl_label = "Viewport Sampling Presets"
    preset_subdir = "sdf_lights/viewport_sampling"
    preset_add_operator = "sdf_lights.viewport_sampling_preset_add"


class SDFLIGHTS_OT_sampling_preset_add(AddPresetBase, bpy.types.Operator):
    """Add a preset of sampling, or remove the chosen preset"""

    bl_idname = "sdf_lights.sampling_preset_add"
    bl_label = "Add Sampling Preset"
    preset_menu = "SDFLIGHTS_PT_sampling_presets"
    preset_subdir = SDFLIGHTS_PT_sampling_presets.preset_subdir
    preset_defines = ["settings = bpy.context.scene.sdf_lights"]
    preset_values = [f"settings.{name}" for name in _FINAL]


class SDFLIGHTS_OT_viewport_sampling_preset_add(AddPresetBase, bpy.types.Operator):
    """Add a preset of viewport sampling, or remove the chosen preset"""

    bl_idname = "sdf_lights.viewport_sampling_preset_add"
    bl_label = "Add Viewport Sampling Preset"
    preset_menu = "SDFLIGHTS_PT_viewport_sampling_presets"
    preset_subdir = SDFLIGHTS_PT_viewport_sampling_presets.preset_subdir
    preset_defines = ["settings = bpy.context.scene.sdf_lights.viewport"]
    preset_values = [f"settings.{name}" for name in VIEWPORT]


CLASSES = (
    SDFLIGHTS_PT_sampling_presets,
    SDFLIGHTS_PT_viewport_sampling_presets,
    SDFLIGHTS_OT_sampling_preset_add,
    SDFLIGHTS_OT_viewport_sampling_preset_add,
)

_FOLDER = str(FOLDER.parent)  # Blender looks in its folder "presets"


def register():
    bpy.utils.register_preset_path(_FOLDER)


def unregister():
    bpy.utils.unregister_preset_path(_FOLDER)
