# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns exceptions that would reach Blender into sentences for the user. This is the only place that does."""

import contextlib
import traceback

import bpy

from ..render.errors import RenderError
from .naming import LABEL


def sentence(error: BaseException) -> str:
    """The sentence for the user about ``error``."""
    if isinstance(error, RenderError):
        return str(error)
    if isinstance(error, MemoryError):
        return f"{LABEL} ran out of memory: render at a lower resolution or with fewer or smaller textures and meshes."
    return (
        f"{LABEL} stopped at an unexpected error ({type(error).__name__}: {error}): "
        "start Blender with --debug-python to see where, and report it."
    )


@contextlib.contextmanager
def guarded(engine: bpy.types.RenderEngine):
    """Wraps all methods of an engine that Blender calls. ``error_set`` and ``report`` show an exception.

    The traceback goes to the console only if Blender runs with ``--debug`` or ``--debug-python``; users read one
    sentence. This is a context, not a decorator, because Blender counts the arguments of a method in its code.
    """
    try:
        yield
    except Exception as error:
        if bpy.app.debug or bpy.app.debug_python:
            traceback.print_exc()
        text = sentence(error)
        engine.report({"ERROR"}, text)
        if not bpy.app.background:
            # For the header of the image editor. In the background Blender would only print it twice.
            engine.error_set(text)
