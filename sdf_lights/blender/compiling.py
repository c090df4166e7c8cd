# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels compile beside the session as soon as the add-on is enabled; this module shows their progress."""

from __future__ import annotations

import threading

import bpy

from ..render.cpu import background

BEGIN_SECONDS = 0.5  # after the add-on is enabled, so that Blender's window is there first
SHOW_SECONDS = 5.0  # from one redraw to the next, each of which takes 50 ms in a window that the processor draws
PAUSE_SECONDS = 0.1  # compilation pauses for at least so long, and until the window has been redrawn


def short() -> str:
    """The progress as a short line; "" if nothing is compiling."""
    if not background.running():
        return ""
    done, total = background.progress()
    return f"Kernels: {done} of {total}" if total else "Kernels: …"


def draw(layout) -> None:
    """Show the progress of the kernels in the preferences."""
    done, total = background.progress()
    if background.running():
        text = f"{done} of {total} kernels are compiled" if total else "Kernels are being compiled"
        layout.progress(text=text, factor=done / total if total else 0.0)


def _draw_status(self, context):
    text = short()
    if text:
        self.layout.label(text=text, icon="SORTTIME")


def _redraw() -> None:
    manager = bpy.context.window_manager
    for window in manager.windows if manager else ():
        for area in window.screen.areas:
            if area.type == "PREFERENCES":
                area.tag_redraw()
        if not len(getattr(window, "modal_operators", ())):  # these have their own status text
            with bpy.context.temp_override(window=window):
                bpy.context.workspace.status_text_set(None)  # Blender has no other way to redraw that bar


def _show() -> float | None:
    """A timer, while something is compiled and once after it."""
    text = short()
    if text != _shown[0]:
        _shown[0] = text
        background.pause()
        _redraw()
        bpy.app.timers.register(background.proceed, first_interval=PAUSE_SECONDS, persistent=True)
    return SHOW_SECONDS if background.running() or any(each.is_alive() for each in _starting) else None


_shown = [""]  # what the windows show
_starting: list[threading.Thread] = []


def _begin() -> None:
    """A timer: starts in a thread, because a disk may be slow."""
    _starting[:] = [threading.Thread(target=background.start, daemon=True)]
    _starting[0].start()
    bpy.app.timers.register(_show, first_interval=SHOW_SECONDS, persistent=True)


CLASSES = ()


def register():
    if bpy.app.background:
        return
    bpy.types.STATUSBAR_HT_header.append(_draw_status)
    bpy.app.timers.register(_begin, first_interval=BEGIN_SECONDS, persistent=True)


def unregister():
    background.stop()
    for timer in (_begin, _show, background.proceed):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    bpy.types.STATUSBAR_HT_header.remove(_draw_status)
