# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Warnings and errors of every lamp and of renders, in one panel, with a button that selects what each is about."""

from __future__ import annotations

import re

import bpy
import numpy as np

from ..render.errors import RenderError
from . import labels, viewport
from .context import LampTab
from .lamp import pattern_of, shape_of

_MOST_SHOWN = 30
_BUTTON = 6  # letters that the button beside a sentence takes

_last: dict[str, list[str]] = {}
_made_by: dict[str, str] = {}


def record(scene: str, sentences: list[str], made_by: str) -> None:
    """Keep what a render of this scene had to say, and what computed it, in place of what the render before it said."""
    _last[scene], _made_by[scene] = list(sentences), made_by


def made_by(scene: str) -> str:
    """What computed the last render of a scene; empty if there is none."""
    return _made_by.get(scene, "")


def culprit(sentence: str) -> str:
    """Name of the object that a sentence is about, or of the first with a material or light of that name; or nothing."""
    for name in re.findall(r"'([^']+)'", sentence):
        if name in bpy.data.objects:
            return name
        for obj in bpy.data.objects:
            materials = [slot.material.name for slot in obj.material_slots if slot.material]
            if name in materials or obj.data is not None and obj.data.name == name:
                return obj.name
    return ""


def of_lamps(scene: bpy.types.Scene) -> list[tuple[str, str]]:
    """(object, sentence) for each lamp of the scene that cannot be used, or not certainly."""
    found = []
    for obj in scene.objects:
        if obj.type != "LIGHT" or not obj.data.sdf_lamp.use:
            continue
        matrix = np.array(obj.matrix_world)
        try:
            shape = shape_of(obj.data.sdf_lamp, matrix)
            pattern_of(obj.data.sdf_lamp, matrix)
        except RenderError as error:
            found.append((obj.name, f"Lamp '{obj.name}': {error}"))
            continue
        if not shape.certified:
            found.append(
                (
                    obj.name,
                    f"Lamp '{obj.name}': no bound of its field is known, so thin parts may be "
                    "missing from the picture.",
                )
            )
        problem = viewport.proxy_error(obj.data)
        if problem:
            found.append((obj.name, f"Lamp '{obj.name}' in the viewport: {problem}"))
    return found


class SDFLIGHTS_OT_culprit_select(bpy.types.Operator):
    """Select the object, and make it the active one"""

    bl_idname = "sdf_lights.culprit_select"
    bl_label = "Select"
    bl_options = {"REGISTER", "UNDO"}

    name: bpy.props.StringProperty(name="Object", description="Object to select")

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        obj = context.view_layer.objects.get(self.name)
        if obj is None:
            self.report(
                {"WARNING"}, f"'{self.name}' is not in this view layer: choose another one, or enable its collection."
            )
            return {"CANCELLED"}
        for other in context.selected_objects:
            other.select_set(False)
        obj.hide_set(False)
        obj.select_set(True)
        context.view_layer.objects.active = obj
        return {"FINISHED"}


class SDFLIGHTS_OT_feedback_clear(bpy.types.Operator):
    """Forget what the last render had to say"""

    bl_idname = "sdf_lights.feedback_clear"
    bl_label = "Clear"

    def execute(self, context):
        _last.clear()
        return {"FINISHED"}


class SDFLIGHTS_PT_feedback(LampTab, bpy.types.Panel):
    bl_label = "Warnings"

    def draw(self, context):
        scene = context.scene
        lamps, shown, render = of_lamps(scene), viewport.render_warnings(), _last.get(scene.name, [])
        width = labels.letters(context) - _BUTTON
        if not lamps and not shown and not render:
            self.layout.label(text="No warnings", icon="CHECKMARK")
        if lamps:
            self._list("Lamps", lamps, width)
        if shown:
            self._list("Rendered Viewport", [(culprit(sentence), sentence) for sentence in shown], width)
        if render:
            self._list("Last Render", [(culprit(sentence), sentence) for sentence in render], width)
            self.layout.operator(SDFLIGHTS_OT_feedback_clear.bl_idname)

    def _list(self, title: str, rows: list[tuple[str, str]], width: int) -> None:
        layout = self.layout
        layout.label(text=title)
        for name, sentence in rows[:_MOST_SHOWN]:
            row = layout.box().row()
            labels.draw_sentence(row.column(), sentence, width)
            if name:
                row.operator(SDFLIGHTS_OT_culprit_select.bl_idname, text="", icon="RESTRICT_SELECT_OFF").name = name
        if len(rows) > _MOST_SHOWN:
            layout.label(text=f"and {len(rows) - _MOST_SHOWN} more, in the console")


CLASSES = (SDFLIGHTS_OT_culprit_select, SDFLIGHTS_OT_feedback_clear, SDFLIGHTS_PT_feedback)


def unregister():
    _last.clear()
