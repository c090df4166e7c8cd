# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The facts needed to solve a problem, as text for the clipboard."""

from __future__ import annotations

import dataclasses
import os
import pathlib
import platform
import sys
import tomllib

import bpy

from .. import kernel_cache
from ..kernel_code import version
from ..render.settings import Settings
from . import feedback, preferences
from .naming import ENGINE, LABEL
from .properties import BLENDERS_OWN

_PACKAGES = ("numpy", "numba", "llvmlite")


def report(scene: bpy.types.Scene) -> str:
    """Versions, the machine, the scene's settings that differ from the defaults, and the warnings of the last
    render."""
    lines = [
        f"{LABEL} {_version()}, Blender {bpy.app.version_string} ({bpy.app.build_hash.decode(errors='replace')})",
        f"{platform.platform()}, {platform.machine()}, {os.cpu_count()} processor cores, Python {platform.python_version()}",
        ", ".join(f"{name} {version(name) or 'missing'}" for name in _PACKAGES),
        preferences.back_end()[1],
        _cache(),
        f"Scene “{scene.name}”: engine {scene.render.engine}, {len(scene.objects):,} objects",
        *_changed(scene),
    ]
    warnings = feedback.of_last_render(scene.name)
    made_by = feedback.made_by(scene.name)
    lines.append(f"Last render: {made_by or 'none'}, {feedback.counted(warnings) if warnings else 'no warnings'}")
    lines += [f"  {sentence}" for sentence in warnings]
    return "\n".join(lines) + "\n"


def _version() -> str:
    manifest = pathlib.Path(__file__).resolve().parents[2] / "blender_manifest.toml"
    try:
        return str(tomllib.loads(manifest.read_text(encoding="utf-8"))["version"])
    except (OSError, KeyError, ValueError):
        return "of an unknown version"


def _cache() -> str:
    folder = kernel_cache.cache_folder()
    problem = kernel_cache.problem()
    return f"Compiled kernels: {kernel_cache.size(folder) / 1e6:.0f} MB in {folder}" + (
        f". {problem}" if problem else ""
    )


def _changed(scene: bpy.types.Scene) -> list[str]:
    """A line for each setting that differs from the default."""
    if scene.render.engine != ENGINE:
        return []
    group, found = scene.sdf_lights, []
    for field in dataclasses.fields(Settings):
        if field.name not in BLENDERS_OWN and group.is_property_set(field.name):
            found.append(f"  {group.bl_rna.properties[field.name].name}: {getattr(group, field.name)}")
    return found


class SDFLIGHTS_OT_report_copy(bpy.types.Operator):
    """Copy versions, settings and warnings to the clipboard, for a report of a problem"""

    bl_idname = "sdf_lights.report_copy"
    bl_label = "Copy Report"

    def execute(self, context):
        text = report(context.scene)
        if bpy.app.background:  # has no clipboard
            sys.stdout.write(text)
        else:
            context.window_manager.clipboard = text
            self.report({"INFO"}, "The report is on the clipboard")
        return {"FINISHED"}


CLASSES = (SDFLIGHTS_OT_report_copy,)
