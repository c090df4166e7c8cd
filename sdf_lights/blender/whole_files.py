# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of a render without a window get their names only when they are complete.

Blender writes a frame directly under its own name. A process that is killed meanwhile would leave half a file, and
*Overwrite* off would keep it. So a frame is written under another name in the same folder, and renamed.
"""

from __future__ import annotations

import os

import bpy
from bpy.app.handlers import persistent

from .command_line import LOG
from .naming import ENGINE

UNFINISHED = ".unfinished-"  # before the names of files

_wanted: dict[str, str] = {}  # the output path of the user, by the name of the scene


def _hidden(path: str) -> str:
    """An output path with the prefix before its file name, which may be empty."""
    start = max(path.rfind("/"), path.rfind(os.sep)) + 1
    return path[:start] + UNFINISHED + path[start:]


def _files(scene: bpy.types.Scene) -> list[str]:
    """The files that Blender writes for the current frame: one, or one for each view."""
    render = scene.render
    whole = os.path.abspath(bpy.path.abspath(render.frame_path(frame=scene.frame_current)))
    if not render.use_multiview or render.image_settings.views_format != "INDIVIDUAL":
        return [whole]
    stem, ending = os.path.splitext(whole)
    return [whole, *(f"{stem}{view.file_suffix}{ending}" for view in render.views if view.use)]


@persistent
def _begin(scene, *_) -> None:
    """Before a frame is rendered."""
    render = scene.render
    if not bpy.app.background or render.engine != ENGINE or render.is_movie_format:
        return
    expected = [_hidden(path) for path in _files(scene)]
    _wanted[scene.name] = render.filepath
    render.filepath = _hidden(render.filepath)
    if _files(scene) != expected:  # of a path whose variables contain folders
        _restore(scene)


@persistent
def _finish(scene, *_) -> None:
    """After a frame was written. A single frame from a script has its own name already."""
    unfinished = _files(scene)
    if not _restore(scene):
        return
    for part, path in zip(unfinished, _files(scene)):
        try:
            os.replace(part, path)
            print(f"Saved: '{path}'")  # as Blender says it: farms look for the names in this line
        except FileNotFoundError:
            pass
        except OSError as error:
            LOG.error("%s cannot be written (%s): the frame is in %s.", path, error.strerror, part)


@persistent
def _restore(scene, *_) -> bool:
    """Give the scene its own output path again. Returns whether it had another."""
    wanted = _wanted.pop(scene.name, None)
    if wanted is not None:
        scene.render.filepath = wanted
    return wanted is not None


CLASSES = ()
_HANDLERS = (
    ("render_pre", _begin),
    ("render_write", _finish),
    ("render_complete", _restore),
    ("render_cancel", _restore),
)


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
