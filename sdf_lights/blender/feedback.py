# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Warnings and errors of all lamps and of renders, in one panel. A button selects the object of each."""

from __future__ import annotations

import re

import bpy
import numpy as np

from ..render.errors import RenderError
from . import labels, sources, viewport
from .context import LampTab
from .findings import grouped
from .lamp import pattern_of, shape_of
from .naming import ENGINE

_MOST_SHOWN = 30
_POPUP_WIDTH, _POPUP_LETTERS = 640, 84
_BUTTON = 6  # width in letters of the button beside a sentence

_last: dict[str, list[str]] = {}
_made_by: dict[str, str] = {}


def record(scene: str, sentences: list[str], made_by: str) -> None:
    """Store the warnings and the device of a render of this scene, in place of those of the previous render."""
    _last[scene], _made_by[scene] = list(sentences), made_by


def of_last_render(scene: str) -> list[str]:
    """The warnings of the last render of a scene."""
    return list(_last.get(scene, []))


def made_by(scene: str) -> str:
    """The device of the last render of a scene; empty if there is none."""
    return _made_by.get(scene, "")


def culprit(sentence: str) -> str:
    """Name of the object that a sentence is about, or of the first object with a material or light of that name; or
    empty."""
    for name in re.findall(r"'([^']+)'", sentence):
        if name in bpy.data.objects:
            return name
        for obj in bpy.data.objects:
            materials = [slot.material.name for slot in obj.material_slots if slot.material]
            if name in materials or obj.data is not None and obj.data.name == name:
                return obj.name
    return ""


def of_lamps(scene: bpy.types.Scene) -> list[tuple[str, str]]:
    """(object, sentence) for each lamp of the scene that is unusable or not certified."""
    from ..emitter.building.build import is_certified  # not at the top: it imports Numba, which takes a second

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
        found += [(obj.name, f"Lamp '{obj.name}': {remark}") for remark in sources.remarks(obj.data.sdf_lamp)]
        if not is_certified(shape):
            found.append(
                (
                    obj.name,
                    f"Lamp '{obj.name}': its field has no known bound, so thin parts may be missing from the picture: "
                    "use shapes or operators whose field has a bound.",
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
    """Clear the warnings of the last render"""

    bl_idname = "sdf_lights.feedback_clear"
    bl_label = "Clear"

    def execute(self, context):
        _last.clear()
        return {"FINISHED"}


def counted(sentences: list[str]) -> str:
    """``44 warnings``."""
    return "1 warning" if len(sentences) == 1 else f"{len(sentences)} warnings"


class SDFLIGHTS_OT_warnings_show(bpy.types.Operator):
    """List the warnings of the last render by subject"""

    bl_idname = "sdf_lights.warnings_show"
    bl_label = "Warnings of the Last Render"

    def invoke(self, context, event):
        return context.window_manager.invoke_popup(self, width=_POPUP_WIDTH)

    def draw(self, context):
        self.layout.label(text=self.bl_label)
        draw_groups(self.layout, _last.get(context.scene.name, []), _POPUP_LETTERS)

    def execute(self, context):
        return {"FINISHED"}


def draw_header(self, context) -> None:
    """In the image editor's header, beside a render: the number of warnings."""
    image = context.space_data.image
    sentences = _last.get(context.scene.name, []) if image is not None and image.type == "RENDER_RESULT" else []
    if sentences and context.scene.render.engine == ENGINE:
        row = self.layout.row()
        row.alert = True
        row.operator(SDFLIGHTS_OT_warnings_show.bl_idname, text=f"{counted(sentences)} – Show", icon="ERROR")


def draw_groups(layout, sentences: list[str], width: int) -> None:
    """Sentences under the titles of their groups, each with a button that selects its subject."""
    left = _MOST_SHOWN
    for title, items in grouped(sentences).items():
        shown = items[:left]
        left -= len(shown)
        if shown:
            layout.label(text=f"{title} ({len(items)})")
            draw_rows(layout, [(culprit(sentence), sentence) for sentence in shown], width)
    if len(sentences) > _MOST_SHOWN:
        layout.label(text=f"and {len(sentences) - _MOST_SHOWN} more, in the console")


def draw_rows(layout, rows: list[tuple[str, str]], width: int) -> None:
    """Sentences in boxes: (object to select, or empty; sentence)."""
    for name, sentence in rows:
        row = layout.box().row()
        labels.draw_sentence(row.column(), sentence, width)
        if name:
            row.operator(SDFLIGHTS_OT_culprit_select.bl_idname, text="", icon="RESTRICT_SELECT_OFF").name = name


class SDFLIGHTS_PT_feedback(LampTab, bpy.types.Panel):
    bl_label = "Warnings"

    def draw(self, context):
        scene = context.scene
        lamps, shown, render = of_lamps(scene), viewport.render_warnings(), of_last_render(scene.name)
        width = labels.letters(context) - _BUTTON
        if not lamps and not shown and not render:
            self.layout.label(text="No warnings", icon="CHECKMARK")
        if lamps:
            self._list("Lamps", lamps, width)
        if shown:
            self.layout.label(text="Rendered Viewport")
            draw_groups(self.layout, shown, width)
        if render:
            self.layout.label(text="Last Render")
            draw_groups(self.layout, render, width)
            self.layout.operator(SDFLIGHTS_OT_feedback_clear.bl_idname)

    def _list(self, title: str, rows: list[tuple[str, str]], width: int) -> None:
        layout = self.layout
        layout.label(text=title)
        draw_rows(layout, rows[:_MOST_SHOWN], width)
        if len(rows) > _MOST_SHOWN:
            layout.label(text=f"and {len(rows) - _MOST_SHOWN} more, in the console")


CLASSES = (
    SDFLIGHTS_OT_culprit_select,
    SDFLIGHTS_OT_feedback_clear,
    SDFLIGHTS_OT_warnings_show,
    SDFLIGHTS_PT_feedback,
)


def register():
    bpy.types.IMAGE_HT_header.append(draw_header)


def unregister():
    bpy.types.IMAGE_HT_header.remove(draw_header)
    _last.clear()
