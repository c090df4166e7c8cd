# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of lamps: those of the add-on, and the user's own in Blender's preset system.

A file of Blender's presets is a script. A lamp preset has one line that sets ``sdf_lamp.as_text``, which is JSON. The
add-on reads back only numbers and the languages of shapes and emissions, never code.
"""

from __future__ import annotations

import json
import math
from types import MappingProxyType

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ..render.errors import RenderError
from ..sdf import emission_presets
from . import emission, parameters, preset_sources, properties
from .context import light_of
from .nodes import editor
from .presets import Preset, presets
from .properties import PRIMITIVES

_UNREADABLE = "The preset cannot be read: save it again."
_EMISSION = parameters.PREFIX + emission.PREFIX


def set_expression(light: bpy.types.Light, title: str, expression: str) -> None:
    """Make the light a lamp with this expression. An expression of several lines goes into a new text block."""
    lamp = light.sdf_lamp
    if "\n" in expression.strip():
        text = parameters.new_text(title, expression)
    else:
        text, lamp.expression = None, expression.strip()
    lamp.text, lamp.use, lamp.source = text, True, "EXPRESSION"


def load_preset(light: bpy.types.Light, name: str) -> None:
    """Give the light the shape, colour, emission and power of a preset from the add-on."""
    apply(light, presets()[name.lower()])


def apply(light: bpy.types.Light, preset: Preset) -> None:
    """Give the light the shape, colour, emission and power of a preset."""
    lamp, preset = light.sdf_lamp, preset_sources.with_sources(preset)
    if preset.shape:
        lamp.use, lamp.source, lamp.shape = True, "PRIMITIVE", preset.shape.upper()
        group = getattr(lamp, preset.shape)
        for parameter, value in preset.values.items():
            setattr(group, parameter, value)
    else:
        set_expression(light, preset.title, preset.expression)
    light.energy, light.exposure = preset.power, 0.0
    lamp.camera_brightness = preset.camera_brightness
    lamp.normalize = preset.density is None
    if preset.density is not None:
        lamp.density = preset.density
    light.use_temperature = preset.temperature > 0.0
    if light.use_temperature:
        light.temperature = preset.temperature
    light.color = preset.color
    settings = lamp.emission
    if preset.emission in emission_presets.presets():
        settings.source, settings.text = preset.emission.upper(), None
    else:
        settings.text = parameters.new_text(f"{preset.title} Emission", preset.emission)
        settings.source = emission.EXPRESSION
    parameters.update(light)
    for prefix, values in (
        (parameters.PREFIX, {} if preset.shape else preset.values),
        (_EMISSION, preset.emission_values),
    ):
        for parameter, value in values.items():
            light[prefix + parameter] = value
    parameters.update(light)  # the value had another kind and was converted to the parameter's kind
    parameters.remove_unused(light)


def preset_of(light: bpy.types.Light) -> Preset:
    """The lamp as a preset. Raises RenderError where its nodes cannot be written as text, or need what is in this
    file."""
    lamp = light.sdf_lamp
    for thing in parameters.things_of(light):
        what = "an image" if isinstance(thing, bpy.types.Image) else "an object"
        raise RenderError(
            f"Its shape is that of {what} of this file, which other files do not have: choose another source."
        )
    primitive = lamp.source == "PRIMITIVE"
    shape = lamp.shape.lower() if primitive else ""
    if primitive:
        group = getattr(lamp, shape)
        values = {about.name: _plain(getattr(group, about.name)) for about in PRIMITIVES[shape].fields()}
    else:
        values = _held(light, parameters.declarations(lamp))
    known, text = lamp.emission.source.lower(), ""
    if parameters.emission_is_in_nodes(lamp) or lamp.emission.source == emission.EXPRESSION:
        text = editor.emission_text_of(light)
    return Preset(
        "",
        light.name,
        "" if primitive else editor.expression_of(light),
        light.energy * 2.0**light.exposure,
        light.temperature if light.use_temperature else 0.0,
        tuple(light.color),
        text or known,
        {
            name.removeprefix(emission.PREFIX): value
            for name, value in _held(light, emission.declarations(lamp.emission)).items()
        },
        lamp.camera_brightness,
        shape,
        values,
        None if lamp.normalize else lamp.density * 2.0**light.exposure,
    )


def _held(light: bpy.types.Light, declared) -> dict:
    """The values of declared parameters, as stored in the light."""
    names = [declaration.name for declaration in declared if parameters.exists(light, declaration)]
    return {name: _plain(light[parameters.PREFIX + name]) for name in names}


def _plain(value):
    return value if isinstance(value, (bool, int, float, str)) else [float(component) for component in value]


def to_text(preset: Preset) -> str:
    """A preset as JSON."""
    about = preset._asdict()
    del about["sources"]  # none of the user's own has them
    return json.dumps(about, default=dict)


def from_text(text: str) -> Preset:
    """A preset from the result of ``to_text``. Raises RenderError for anything else."""
    try:
        about = json.loads(text)
        known = {name: about[name] for name in Preset._fields if name in about and name != "sources"}
        known["color"] = tuple(map(float, known.get("color", (1.0, 1.0, 1.0))))
        preset = Preset(**known)
        numbers = preset.power, preset.temperature, preset.camera_brightness, preset.density or 0.0, *preset.color
        if not all(math.isfinite(number) for number in numbers) or len(preset.color) != 3:
            raise ValueError
        preset = preset._replace(
            values=MappingProxyType(dict(preset.values)), emission_values=MappingProxyType(dict(preset.emission_values))
        )
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise RenderError(_UNREADABLE) from error
    if preset.shape and preset.shape not in PRIMITIVES:
        raise RenderError(f"The preset has the shape '{preset.shape}', which does not exist: save it again.")
    if preset.shape and not preset.values.keys() <= {about.name for about in PRIMITIVES[preset.shape].fields()}:
        raise RenderError(_UNREADABLE)
    return preset


def _get_text(lamp) -> str:
    try:
        return to_text(preset_of(lamp.id_data))
    except RenderError:
        return ""


def _set_text(lamp, text: str) -> None:
    before = _get_text(lamp)
    try:
        try:
            apply(lamp.id_data, from_text(text))
        except (AttributeError, TypeError, ValueError, OverflowError) as error:
            if before:
                apply(lamp.id_data, from_text(before))
            raise RenderError(_UNREADABLE) from error
    except RenderError as error:
        said = str(error)
        if bpy.app.background:
            print(said)
        else:  # Blender's preset system shows no errors
            bpy.context.window_manager.popup_menu(
                lambda self, context: self.layout.label(text=said), title="Lamp Preset", icon="ERROR"
            )
    lamp.id_data.update_tag()


class SDFLIGHTS_PT_lamp_presets(PresetPanel, bpy.types.Panel):
    """Presets of lamps."""

    bl_label = "Lamp Presets"
    preset_subdir = "sdf_lights/lamp"
    preset_operator = "script.execute_preset"
    preset_add_operator = "sdf_lights.lamp_preset_add"


class SDFLIGHTS_OT_lamp_preset_add(AddPresetBase, bpy.types.Operator):
    """Add a preset of this lamp, or remove the chosen preset"""

    bl_idname = "sdf_lights.lamp_preset_add"
    bl_label = "Add Lamp Preset"
    preset_menu = "SDFLIGHTS_PT_lamp_presets"
    preset_subdir = SDFLIGHTS_PT_lamp_presets.preset_subdir
    preset_defines = ['lamp = (getattr(bpy.context, "light", None) or bpy.context.object.data).sdf_lamp']
    preset_values = ["lamp.as_text"]

    def execute(self, context):
        light = light_of(context)
        if light is not None and not (self.remove_name or self.remove_active):
            try:
                preset_of(light)
            except RenderError as error:
                self.report({"ERROR"}, f"Light '{light.name}' cannot be saved as a preset. {error}")
                return {"CANCELLED"}
        return super().execute(context)


CLASSES = (SDFLIGHTS_PT_lamp_presets, SDFLIGHTS_OT_lamp_preset_add)


def register():
    properties.SDFLIGHTS_LampSettings.as_text = bpy.props.StringProperty(
        name="As Text",
        description="Settings of the lamp that a preset stores",
        get=_get_text,
        set=_set_text,
        options={"HIDDEN", "SKIP_SAVE"},
    )


def unregister():
    del properties.SDFLIGHTS_LampSettings.as_text
