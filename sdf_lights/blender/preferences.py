# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's preferences: the device of this computer, the available back end and its limits, compiled kernels,
the log, and the overlay of new files."""

import functools
import importlib.util
import sys
import time

import bpy
from bpy.app.handlers import persistent

from .. import kernel_cache
from ..render.settings import Device, Settings
from . import command_line, compiling, overlay_settings
from .naming import ROOT

_SECONDS = 2.0  # seconds before the size of the cache is measured again


@functools.lru_cache(maxsize=1)
def back_end() -> tuple[bool, str]:
    """(whether Numba is available, a sentence about it). Looks for Numba without importing it, which takes 0.2 s."""
    if all(importlib.util.find_spec(name) for name in ("numba", "llvmlite")):
        return True, "Numba is available: renders run as machine code on all processor cores."
    return False, (
        "Numba is missing: renders run in plain NumPy, about a hundred times slower; install the extension from the "
        f"zip made for this Blender version, whose name ends with {zip_ending()}."
    )


def zip_ending() -> str:
    """The ending of the zip names that contain Numba for this Python."""
    return "-python{}.{}.zip".format(*sys.version_info[:2])


def draw_back_end(layout) -> None:
    """Show the state of the back end in a panel."""
    available, sentence = back_end()
    column = layout.column(align=True)
    for i, line in enumerate(sentence.split(": ", 1)):
        column.label(text=line, icon="NONE" if i else "CHECKMARK" if available else "ERROR")


_sizes: dict[str, tuple[float, int]] = {}


def _cache_size() -> int:
    folder, now = kernel_cache.cache_folder(), time.monotonic()
    since, found = _sizes.get(str(folder), (-_SECONDS, 0))
    if now - since >= _SECONDS:
        found = kernel_cache.size(folder)
        _sizes[str(folder)] = now, found
    return found


def draw_cache(layout) -> None:
    """Draw the folder of compiled kernels, its size, and a button that deletes them."""
    row = layout.split(factor=0.75)
    row.label(text=f"Compiled kernels: {_cache_size() / 1e6:,.0f} MB in {kernel_cache.cache_folder()}")
    row.operator(SDFLIGHTS_OT_kernels_clear.bl_idname, icon="TRASH")
    if kernel_cache.problem():
        layout.label(text=kernel_cache.problem(), icon="ERROR")


class SDFLIGHTS_OT_kernels_clear(bpy.types.Operator):
    """Delete the compiled kernels. The next start of Blender compiles them again as needed"""

    bl_idname = "sdf_lights.kernels_clear"
    bl_label = "Clear"

    def execute(self, context):
        kernel_cache.clear(kernel_cache.cache_folder())
        _sizes.clear()
        return {"FINISHED"}


AS_SCENES = "SCENE"


def own() -> bpy.types.AddonPreferences | None:
    """The user's preferences; None if the add-on is registered without being enabled, as in scripts."""
    addon = bpy.context.preferences.addons.get(ROOT)
    return addon and addon.preferences


def apply(settings: Settings) -> None:
    """Write this computer's preferences for all scenes into ``settings``."""
    wanted = own()
    if wanted is None:
        return
    if wanted.device != AS_SCENES:
        settings.device = Device(wanted.device)
    if wanted.threads:
        settings.threads = min(settings.threads or wanted.threads, wanted.threads)


def _write_log(self, context):
    command_line.write_log(self.log_level.lower())


class SDFLIGHTS_Preferences(bpy.types.AddonPreferences):
    """Preferences of the add-on."""

    bl_idname = ROOT

    log_level: bpy.props.EnumProperty(
        name="Log",
        description="Messages that the add-on writes to the console; --sdf-log on the command line overrides this",
        default="WARNING",
        update=_write_log,
        items=[
            ("ERROR", "Errors", "Errors only"),
            ("WARNING", "Warnings", "Errors and warnings"),
            ("INFO", "Information", "Also the steps of a render and their times"),
            ("DEBUG", "Debug", "All messages"),
        ],
    )

    device: bpy.props.EnumProperty(
        name="Device",
        description="Device that renders on this computer; --sdf-device on the command line overrides this",
        items=[
            (AS_SCENES, "As Scenes Say", "The device that each scene chooses"),
            (Device.CPU.value, "CPU", "The processor, for all scenes"),
            (Device.GPU.value, "GPU", "The graphics card, for all scenes; the processor if there is none"),
        ],
    )
    threads: bpy.props.IntProperty(
        name="Threads",
        description=(
            "Maximum number of threads of renders on this computer. 0: as scenes say; --sdf-threads on the command "
            "line overrides this"
        ),
        min=0,
        max=1024,
    )

    overlay: bpy.props.PointerProperty(
        name="Overlay of New Files",
        description="Settings of the viewport overlay of SDF lamps that new files begin with",
        type=overlay_settings.SDFLIGHTS_OverlaySettings,
    )

    def draw(self, context):
        draw_back_end(self.layout)
        self.layout.prop(self, "device")
        self.layout.prop(self, "threads")
        compiling.draw(self.layout)
        draw_cache(self.layout)
        self.layout.prop(self, "log_level")
        self.layout.label(text="Overlay of New Files:")
        overlay_settings.draw(self.layout, self.overlay)
        self.layout.operator("sdf_lights.report_copy", icon="COPYDOWN")
        self.layout.operator("sdf_lights.asset_library_add", icon="ASSET_MANAGER")


@persistent
def _opened(*_) -> None:
    """Give a new file the overlay of the preferences, except for what the start-up file has set."""
    wanted = own()
    if wanted is None or bpy.data.filepath:
        return
    for scene in bpy.data.scenes:
        settings = scene.sdf_lights_overlay
        for name in overlay_settings.DEFAULTS:
            if wanted.overlay.is_property_set(name) and not settings.is_property_set(name):
                setattr(settings, name, getattr(wanted.overlay, name))


CLASSES = (SDFLIGHTS_OT_kernels_clear, SDFLIGHTS_Preferences)


def register():
    wanted = own()
    if wanted is not None and wanted.log_level != "WARNING":
        command_line.write_log(wanted.log_level.lower())
    bpy.app.handlers.load_post.append(_opened)


def unregister():
    bpy.app.handlers.load_post.remove(_opened)
