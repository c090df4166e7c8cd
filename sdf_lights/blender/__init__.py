# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All code that imports bpy: the add-on's registration, its properties and panels, sync, and the render engine.

Nothing here imports a kernel before the first render, so enabling the add-on does not wait for Numba.
"""

import os

import bpy

from ..garbage import nothing_to_collect
from .naming import IS_EXTENSION, ROOT

_CACHE = "SDF_LIGHTS_CACHE"


def _modules():
    """Modules with ``CLASSES`` and, if they need more, ``register()`` and ``unregister()``, in order."""
    from . import (
        assets,
        beside_cycles,
        command_line,
        compiling,
        cycles,
        emission_panel,
        engine,
        fallback,
        feedback,
        gizmos,
        lamp_panels,
        lamp_presets,
        lamp_transforms,
        live_text,
        nodes,
        object_lamps,
        operators,
        overlay_settings,
        panels,
        passes,
        preferences,
        preset_browser,
        preset_pictures,
        problem_report,
        properties,
        readout,
        render_job,
        sampling_presets,
        scene_panels,
        scene_report,
        versions,
        viewport,
        whole_files,
    )

    return (
        overlay_settings,
        preferences,
        compiling,
        properties,
        versions,
        cycles,
        *nodes.modules(),
        passes,
        viewport,
        engine,
        lamp_presets,
        lamp_transforms,
        operators,
        assets,
        readout,
        sampling_presets,
        panels,
        scene_panels,
        lamp_panels,
        scene_report,
        emission_panel,
        preset_pictures,
        preset_browser,
        feedback,
        problem_report,
        gizmos,
        live_text,
        object_lamps,
        fallback,
        beside_cycles,
        command_line,
        render_job,
        whole_files,
    )


def _nothing() -> None:
    pass


def register():
    """Register everything. Further calls do nothing."""
    if hasattr(bpy.types.Scene, "sdf_lights"):
        return
    if IS_EXTENSION:
        # The extension's own folder may be read-only, and updates empty it. A folder chosen by the user stays.
        os.environ.setdefault(_CACHE, bpy.utils.extension_path_user(ROOT, path="kernels", create=True))
    with nothing_to_collect():
        from .nodes.tree import set_registered

        for module in _modules():
            for kind in module.CLASSES:
                bpy.utils.register_class(kind)
            getattr(module, "register", _nothing)()
    set_registered(True)


def unregister():
    """Undo ``register()``, in reverse order."""
    from .nodes.tree import set_registered

    if not hasattr(bpy.types.Scene, "sdf_lights"):
        return
    set_registered(False)
    for module in reversed(_modules()):
        getattr(module, "unregister", _nothing)()
        for kind in reversed(module.CLASSES):
            bpy.utils.unregister_class(kind)
    if IS_EXTENSION and os.environ.get(_CACHE) == bpy.utils.extension_path_user(ROOT, path="kernels"):
        del os.environ[_CACHE]
