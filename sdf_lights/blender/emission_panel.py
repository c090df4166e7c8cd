# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The emission of a lamp in panels."""

import bpy

from ..render.errors import RenderError
from ..sdf.syntax import ExpressionError
from . import emission, labels, parameters
from .context import LampOperator, light_of
from .lamp import pattern_of


class SDFLIGHTS_OT_emission_to_text(LampOperator, bpy.types.Operator):
    """Put the lamp's emission into a new text block for editing"""

    bl_idname = "sdf_lights.emission_to_text"
    bl_label = "Edit Emission as Text"

    def execute(self, context):
        light = light_of(context)
        settings = light.sdf_lamp.emission
        settings.text = parameters.new_text(f"{light.name} Emission", emission.text_of(settings))
        settings.source = emission.EXPRESSION
        return {"FINISHED"}


def draw(layout, light, width: int) -> None:
    """Draw the preset or text of the emission, its parameters, and its mistakes in lines of ``width`` letters."""
    lamp = light.sdf_lamp
    if parameters.emission_is_in_nodes(lamp):
        layout.label(text="Set by the node tree", icon="NODETREE")
    else:
        _draw_pattern(layout, light)
    try:
        pattern_of(lamp)
    except RenderError as error:
        labels.draw_problem(layout, error, width)
        if isinstance(error.__cause__, ExpressionError) and lamp.emission.text is not None:
            layout.operator("sdf_lights.expression_show", text="Go to the Line", icon="TEXT").emission = True


def _draw_pattern(layout, light) -> None:
    lamp = light.sdf_lamp
    settings = lamp.emission
    layout.prop(settings, "source", text="Pattern")
    if settings.source == emission.EXPRESSION:
        layout.template_ID(settings, "text", new=SDFLIGHTS_OT_emission_to_text.bl_idname, open="text.open")
        if settings.text is None:
            labels.draw_expression(layout, settings, is_emission=True)
        else:
            layout.operator("sdf_lights.expression_show", icon="TEXT").emission = True
    if parameters.missing(lamp):
        parameters.update_soon(light)  # drawing may not change data
    column = layout.column()
    for declared in emission.declarations(settings):
        if parameters.exists(light, declared):
            column.prop(light, parameters.path(declared), text=parameters.label_of(declared))
    if settings.source not in ("UNIFORM", emission.EXPRESSION):
        layout.operator(SDFLIGHTS_OT_emission_to_text.bl_idname, text="Edit as Text", icon="TEXT")


CLASSES = (SDFLIGHTS_OT_emission_to_text,)
