# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene Report: a list of everything that is not rendered as the scene says, made without rendering."""

from __future__ import annotations

from typing import NamedTuple

import bpy

from ..render.errors import RenderError
from . import feedback, labels
from .findings import grouped
from .guard import sentence as sentence_of
from .naming import ENGINE

_BUTTON = 6  # width in letters of the button beside a sentence
_MOST_SHOWN = 200


class _Report(NamedTuple):
    groups: dict[str, list[tuple[str, str]]]  # by title: (object to select, or empty; sentence)
    hidden: int  # objects that are rendered, but not checked


_reports: dict[int, _Report] = {}


def check(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> list[str]:
    """All sentences about a scene, each once. Nothing is rendered."""
    from .sync import sync

    found = []
    try:
        found += sync(depsgraph).warnings
    except RenderError as error:
        found.append(str(error))
    left_out = tuple(sentence for sentence in found if sentence.startswith("Lamp '"))
    return found + [
        sentence
        for name, sentence in feedback.of_lamps(scene)
        if not any(said.startswith(f"Lamp '{name}'") for said in left_out)
    ]


def _unseen(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> int:
    """The number of objects that are in the render but not in the viewport. The check reads only the viewport's
    data."""
    seen = {obj.original.session_uid for obj in depsgraph.objects}
    return sum(
        not obj.hide_render and obj.session_uid not in seen and obj.type not in {"EMPTY", "ARMATURE", "LATTICE"}
        for obj in scene.objects
    )


class SDFLIGHTS_OT_scene_check(bpy.types.Operator):
    """List everything that is not rendered as the scene says, without rendering"""

    bl_idname = "sdf_lights.scene_check"
    bl_label = "Check Scene"

    def execute(self, context):
        scene = context.scene
        if context.window is not None:
            context.window.cursor_set("WAIT")
        try:
            depsgraph = context.evaluated_depsgraph_get()
            found = check(scene, depsgraph)
            groups = {
                title: [(feedback.culprit(sentence), sentence) for sentence in sentences]
                for title, sentences in grouped(found).items()
            }
            _reports[scene.session_uid] = _Report(groups, _unseen(scene, depsgraph))
        except Exception as error:  # nothing may reach Blender
            self.report({"ERROR"}, sentence_of(error))
            return {"CANCELLED"}
        finally:
            if context.window is not None:
                context.window.cursor_set("DEFAULT")
        things = {0: "Nothing", 1: "1 thing"}.get(len(found), f"{len(found)} items")
        self.report({"INFO"}, f"{things} in the report of this scene")
        return {"FINISHED"}


class SDFLIGHTS_PT_scene_report(bpy.types.Panel):
    """Lists what would not render as the scene says."""

    bl_label = "Scene Report"
    bl_order = 1
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE

    def draw(self, context):
        layout = self.layout
        layout.operator(SDFLIGHTS_OT_scene_check.bl_idname, icon="VIEWZOOM")
        report = _reports.get(context.scene.session_uid)
        if report is None:
            return
        width = labels.letters(context) - _BUTTON
        if not report.groups:
            layout.label(text="No differences found", icon="CHECKMARK")
        left = _MOST_SHOWN
        for title, rows in report.groups.items():
            layout.label(text=f"{title} ({len(rows)})")
            feedback.draw_rows(layout, rows[:left], width)
            left -= len(rows[:left])
        if report.hidden:
            number = "1 object is" if report.hidden == 1 else f"{report.hidden} objects are"
            labels.draw_sentence(
                layout, f"{number} hidden in the viewport, and checked only when rendered", width, "INFO"
            )


CLASSES = (SDFLIGHTS_OT_scene_check, SDFLIGHTS_PT_scene_report)


def unregister():
    _reports.clear()
