# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps in the viewport: see README.md."""

from __future__ import annotations

import atexit
import sys
import traceback

import bpy
from bpy.app.handlers import persistent

from . import drawn, framing, picking, properties, selecting

CLASSES = (*properties.CLASSES, *picking.CLASSES, *framing.CLASSES, *selecting.CLASSES)

_failures: dict[str, str] = {}  # by the draw handler
_handles: list = []


def proxy_error(light: bpy.types.Light) -> str:
    """Why the lamp is not shown in the viewport, or only as a box: a sentence, or an empty string."""
    if _failures:
        return next(iter(_failures.values()))
    return drawn.overlay.errors.get(light.name_full, "") if drawn.overlay is not None else ""


def _guarded(draw):
    """A draw handler that reports an error once, and leaves the viewport unchanged."""

    def handler():
        try:
            draw()
            _failures.pop(draw.__name__, None)
        except Exception as error:
            if draw.__name__ not in _failures:
                traceback.print_exc()
            _failures[draw.__name__] = (
                f"Lamps could not be drawn in the viewport ({type(error).__name__}: {error}): start Blender with "
                "--debug-python to see where, and report it."
            )

    return handler


def _before_scene():
    if drawn.overlay is None:
        from .overlay import Overlay

        drawn.overlay = Overlay()
    drawn.overlay.before_scene()


def _after_scene():
    drawn.overlay.after_scene(bpy.context)


def _labels():
    drawn.overlay.labels(bpy.context)


@persistent
def _updated(_, depsgraph):
    if drawn.overlay is not None:
        drawn.overlay.changed(depsgraph)


@persistent
def _changed(*_):
    if drawn.overlay is not None:
        drawn.overlay.changed(None)


@persistent
def _forget(*_):
    if _stop is None:  # bpy as a module reports its exit after Python has shut down
        return
    _stop()
    if drawn.overlay is not None:
        drawn.overlay.forget()


@persistent
def _stop(*_):
    """Stop all threads before Blender replaces its data: they may still be copying from it."""
    rendered = sys.modules.get(f"{__name__}.rendered")
    if rendered is not None:
        rendered.stop_all()


def render_warnings() -> list[str]:
    """Sentences about parts that renders in viewports left out or replaced."""
    rendered = sys.modules.get(f"{__name__}.rendered")
    return rendered.warnings() if rendered is not None else []


_HANDLERS = [
    ("depsgraph_update_post", _updated),
    *((name, _changed) for name in ("frame_change_post", "undo_post", "redo_post", "load_post")),
    ("undo_pre", _stop),
    ("redo_pre", _stop),
    ("load_pre", _forget),
    ("exit_pre", _forget),
]


def register():
    properties.register()
    for module in (picking, framing, selecting):
        module.register()
    draw = bpy.types.SpaceView3D.draw_handler_add
    for function, event in ((_before_scene, "PRE_VIEW"), (_after_scene, "POST_VIEW"), (_labels, "POST_PIXEL")):
        _handles.append(draw(_guarded(function), (), "WINDOW", event))
    for name, function in _HANDLERS:
        if hasattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).append(function)
    atexit.register(_forget)


def unregister():
    for handle in _handles:
        bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
    _handles.clear()
    for name, function in _HANDLERS:
        if hasattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).remove(function)
    atexit.unregister(_forget)
    _forget()
    drawn.overlay = None
    _failures.clear()
    for module in (selecting, framing, picking):
        module.unregister()
    properties.unregister()
