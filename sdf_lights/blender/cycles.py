# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies settings from Cycles, the first time that a scene made for Cycles is rendered here.

``scene.sdf_lights.origin`` records the source of the settings, so the copy never overwrites the user's values. It is
UNKNOWN until the scene first has this engine, then OWN or CYCLES. Blender forbids changes while it renders or draws.
Without a window, no event reports a new engine. In these cases, an UNKNOWN scene is read as if ``settle`` had already
written its values.
"""

from __future__ import annotations

import functools
from types import SimpleNamespace
from typing import Any, NamedTuple

import bpy
from bpy.app.handlers import persistent

from . import cycles_table
from .naming import ENGINE, LABEL

UNKNOWN, OWN, CYCLES = "UNKNOWN", "OWN", "CYCLES"

ORIGINS = [
    (UNKNOWN, "Unknown", "This engine has not been used in the scene", 0),
    (OWN, "Own", "The scene was made for this engine", 1),
    (CYCLES, "Cycles", "Settings copied from Cycles", 2),
]


class _Seen(NamedTuple):
    """Known facts about a scene since its file was opened."""

    cycles: bool  # Cycles was its engine at some time
    values: dict[str, Any]  # its first Cycles settings


_seen: dict[int, _Seen] = {}
_owner = object()  # owner of the subscription


def _read(scene) -> dict[str, Any]:
    return cycles_table.read(scene, bpy.app.version)


@functools.cache
def _defaults() -> dict[str, Any]:
    """The result of ``_read`` for a scene with untouched Cycles settings."""
    known = bpy.types.Scene.bl_rna.properties["cycles"].fixed_type.properties
    names = {name for row in cycles_table.ROWS if row.read is not None for name in row.cycles} & set(known.keys())
    return _read(SimpleNamespace(cycles=SimpleNamespace(**{name: known[name].default for name in names})))


def look(scene: bpy.types.Scene) -> None:
    """Record the engine of the scene."""
    known = _seen.get(scene.session_uid)
    is_cycles = scene.render.engine == "CYCLES"
    if known is None:
        _seen[scene.session_uid] = _Seen(is_cycles, _read(scene))
    elif is_cycles and not known.cycles:
        _seen[scene.session_uid] = known._replace(cycles=True)


def comes_from_cycles(scene: bpy.types.Scene) -> bool:
    """Whether the scene had Cycles as its engine before, or its Cycles settings changed since it was first seen. A
    script that switches between engines sends no event."""
    if not hasattr(scene, "cycles"):
        return False
    known = _seen.get(scene.session_uid)
    if known is None:
        return _read(scene) != _defaults()
    return known.cycles or _read(scene) != known.values


def pending(scene: bpy.types.Scene) -> dict[str, Any]:
    """Settings by path that ``settle`` would write; empty if nothing is to be settled. ``scene`` may be evaluated."""
    settings = scene.sdf_lights
    if settings.origin != UNKNOWN or not comes_from_cycles(scene.original):
        return {}
    return {path: value for path, value in _read(scene).items() if not _is_set(settings, path)}


def missing(scene: bpy.types.Scene) -> str:
    """A sentence if Cycles settings are needed but Cycles' add-on is off."""
    known = _seen.get(scene.original.session_uid)
    if scene.sdf_lights.origin == UNKNOWN and not hasattr(scene, "cycles") and known is not None and known.cycles:
        return (
            f"Scene '{scene.name}' was made for Cycles, whose settings cannot be read because its add-on is off: "
            f"the defaults of {LABEL} are used; enable the add-on Cycles Render Engine."
        )
    return ""


def settle(scene: bpy.types.Scene) -> None:
    """Decide the origin of the settings of a scene with this engine. Copy those of Cycles that the user has not set
    here."""
    settings = scene.sdf_lights
    if settings.origin != UNKNOWN or scene.render.engine != ENGINE or not scene.is_editable:
        return
    values = pending(scene)
    settings.origin = CYCLES if values else OWN
    _write(settings, values)


def copy(scene: bpy.types.Scene) -> None:
    """Copy all settings of Cycles."""
    scene.sdf_lights.origin = CYCLES
    _write(scene.sdf_lights, _read(scene))


def _write(settings: bpy.types.PropertyGroup, values: dict[str, Any]) -> None:
    for path, value in values.items():
        group, name = _place(settings, path)
        setattr(group, name, value)


def _place(settings: bpy.types.PropertyGroup, path: str) -> tuple[bpy.types.PropertyGroup, str]:
    """The property group of a path, and the last name in the path."""
    group, _, name = path.rpartition(".")
    return (getattr(settings, group) if group else settings), name


def _is_set(settings: bpy.types.PropertyGroup, path: str) -> bool:
    group, name = _place(settings, path)
    return group.is_property_set(name)


def _has_own_settings(settings: bpy.types.PropertyGroup) -> bool:
    groups = (settings, settings.viewport)
    return any(
        group.is_property_set(name)
        for group in groups
        for name in group.bl_rna.properties.keys()
        if name not in {"rna_type", "name", "viewport", "version"}
    )


def changed(self, context) -> None:
    """Callback of every setting. Blender tags the scene for the dependency graph. An open origin is settled."""
    settle(self.id_data)


# -- when --------------------------------------------------------------------------------------------------------------


def _engine_changed() -> None:
    for scene in bpy.data.scenes:
        look(scene)
        settle(scene)


@persistent
def _loaded(*_) -> None:
    _seen.clear()
    for scene in bpy.data.scenes:
        look(scene)
        settings = scene.sdf_lights
        if settings.origin == UNKNOWN and scene.is_editable:
            _update_caustics(settings)
            # A version without origins: the values in the file stay.
            if scene.render.engine == ENGINE or _has_own_settings(settings):
                settings.origin = OWN


def _update_caustics(settings: bpy.types.PropertyGroup) -> None:
    """Older files have one switch for both kinds of caustics."""
    stored = settings.bl_system_properties_get() if hasattr(settings, "bl_system_properties_get") else settings
    if stored is not None and stored.get("caustics") is not None:
        settings.caustics_reflective = settings.caustics_refractive = bool(stored["caustics"])
        del stored["caustics"]


@persistent
def _saving(*_) -> None:
    for scene in bpy.data.scenes:
        settle(scene)


def settle_soon() -> None:
    """Settle all scenes as soon as Blender allows changes. Panels call this, because they may not change anything while
    they are drawn."""
    if not bpy.app.timers.is_registered(_engine_changed):
        bpy.app.timers.register(_engine_changed, first_interval=0.0)


class SDFLIGHTS_OT_cycles_settings_copy(bpy.types.Operator):
    """Copy samples, noise threshold, bounces, clamps, filter, exposure and other settings from Cycles"""

    bl_idname = "sdf_lights.cycles_settings_copy"
    bl_label = "Copy Cycles Settings"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if not hasattr(context.scene, "cycles"):
            cls.poll_message_set("The add-on Cycles Render Engine is off")
            return False
        return True

    def execute(self, context):
        copy(context.scene)
        return {"FINISHED"}


CLASSES = (SDFLIGHTS_OT_cycles_settings_copy,)

_HANDLERS = ((bpy.app.handlers.load_post, _loaded), (bpy.app.handlers.save_pre, _saving))


def register():
    for handlers, handler in _HANDLERS:
        handlers.append(handler)
    bpy.msgbus.subscribe_rna(
        key=(bpy.types.RenderSettings, "engine"), owner=_owner, args=(), notify=_engine_changed, options={"PERSISTENT"}
    )
    for scene in getattr(bpy.data, "scenes", ()):  # Blender has no data while it starts
        look(scene)


def unregister():
    bpy.msgbus.clear_by_owner(_owner)
    if bpy.app.timers.is_registered(_engine_changed):
        bpy.app.timers.unregister(_engine_changed)
    for handlers, handler in _HANDLERS:
        if handler in handlers:
            handlers.remove(handler)
    _seen.clear()
    _defaults.cache_clear()
