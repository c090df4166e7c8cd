# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The version of settings in files, so that files of all versions open for ever.

Scenes and lights record the version of the settings that saved them. Version 0, before this record existed, counts as
1. Older settings are updated when a file is opened or when data is appended from it. ``tests/blender/files`` has files
of each version.

To change the meaning of a property, raise ``VERSION`` by one, add a step to ``STEPS`` that updates a scene or light
from the version before, and save files of the new version with ``scripts/version_files.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import bpy
from bpy.app.handlers import persistent

from .naming import LABEL

VERSION = 1

# By the version of the scene or light.
STEPS: dict[int, Callable[[bpy.types.Scene | bpy.types.Light], None]] = {}


def _settings() -> Iterator[tuple[bpy.types.Scene | bpy.types.Light, bpy.types.PropertyGroup]]:
    yield from ((scene, scene.sdf_lights) for scene in bpy.data.scenes)
    yield from ((light, light.sdf_lamp) for light in bpy.data.lights)


def bring_up() -> None:
    """Update everything in the open file, and linked data, to this version."""
    for owner, settings in _settings():
        for version in range(settings.version, VERSION):
            if version in STEPS:
                STEPS[version](owner)
        if owner.library is None:  # linked data is read again from its own file each time
            settings.version = max(settings.version, VERSION)


def newer(depsgraph: bpy.types.Depsgraph) -> str:
    """A sentence if a later version has saved the scene or one of its lamps, else empty."""
    scene = depsgraph.scene
    later = [scene.sdf_lights.version > VERSION and f"Scene '{scene.name}'"]
    later += [
        obj.data.sdf_lamp.version > VERSION and f"Light '{obj.data.name}'"
        for obj in scene.objects
        if obj.type == "LIGHT"
    ]
    name = next(filter(None, later), "")
    return name and (
        f"{name} was saved by a later version of {LABEL}: unknown settings are ignored; update the extension."
    )


@persistent
def _opened(*_):
    bring_up()


@persistent
def _saving(*_):
    for owner, settings in _settings():
        if owner.library is None:
            settings.version = max(settings.version, VERSION)


CLASSES = ()


def _handlers() -> list[tuple[list, Callable]]:
    found = [(bpy.app.handlers.load_post, _opened), (bpy.app.handlers.save_pre, _saving)]
    return [*found, (bpy.app.handlers.blend_import_post, _opened)]


def register():
    for handlers, handler in _handlers():
        handlers.append(handler)


def unregister():
    for handlers, handler in _handlers():
        if handler in handlers:
            handlers.remove(handler)
