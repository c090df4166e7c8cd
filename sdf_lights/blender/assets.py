# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps as assets: marked with their own picture, and the presets as a library in the asset browser."""

from __future__ import annotations

import pathlib

import bpy
import numpy as np

from ..render.errors import RenderError
from ..render.scene import Ray
from . import lamp_preview, parameters, preset_sources
from .lamp_presets import load_preset
from .naming import IS_EXTENSION, LABEL, ROOT
from .presets import presets

LIBRARY = f"{LABEL} Presets"
_FILE = "lamps.blend"
_SIZE = 128  # pixels


def _is_lamp(obj: bpy.types.Object) -> bool:
    return obj.type == "LIGHT" and obj.data.sdf_lamp.use


def show_picture(obj: bpy.types.Object, picture: np.ndarray) -> None:
    """Use (height, width, 4) display values, row 0 at the bottom, as the preview of an object."""
    preview = obj.preview_ensure()
    preview.image_size = picture.shape[1], picture.shape[0]
    preview.image_pixels_float.foreach_set(np.ascontiguousarray(picture, np.float32).ravel())


class SDFLIGHTS_OT_lamp_mark_asset(bpy.types.Operator):
    """Mark the selected lamps as assets, with pictures of their shapes"""

    bl_idname = "sdf_lights.lamp_mark_asset"
    bl_label = "Mark SDF Lamp as Asset"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return any(_is_lamp(obj) and obj.library is None for obj in context.selected_objects)

    def execute(self, context):
        from .sync.common import matrix_of  # not at the top: these import Numba
        from .sync.lights import light_of

        depsgraph, made = context.evaluated_depsgraph_get(), 0
        for obj in context.selected_objects:
            if not _is_lamp(obj) or obj.library is not None:
                continue
            evaluated = obj.evaluated_get(depsgraph)
            try:
                lamp = light_of(evaluated, np.eye(4), Ray.ALL, depsgraph, print, None, matrix_of(obj.matrix_world))
                picture = lamp_preview.picture_of(lamp, _SIZE)
            except RenderError as error:
                self.report({"WARNING"}, f"Lamp '{obj.name}' has no picture. {error}")
                picture = None
            obj.asset_mark()
            obj.asset_data.description = "A lamp of SDF Lights"
            obj.asset_data.tags.new("Light", skip_if_exists=True)
            if picture is not None:
                show_picture(obj, picture)
            made += 1
        return {"FINISHED"} if made else {"CANCELLED"}


def write_library(path: pathlib.Path) -> None:
    """Write a file with every preset as an asset, each with its picture."""
    made, texts, things = set(), set(bpy.data.texts), set()
    try:
        for name, preset in presets().items():
            light = bpy.data.lights.new(preset.title, "POINT")
            load_preset(light, name)
            parameters.update(light)
            things |= parameters.things_of(light)
            obj = bpy.data.objects.new(preset.title, light)
            made.add(obj)
            obj.asset_mark()
            obj.asset_data.description = "A lamp of SDF Lights"
            obj.asset_data.tags.new("Light", skip_if_exists=True)
            image = bpy.data.images.load(str(preset.picture))
            width, height = image.size
            pixels = np.empty(4 * width * height, np.float32)
            image.pixels.foreach_get(pixels)
            bpy.data.images.remove(image)
            show_picture(obj, pixels.reshape(height, width, 4))
        path.parent.mkdir(parents=True, exist_ok=True)
        bpy.data.libraries.write(str(path), made, fake_user=True)
    finally:
        for obj in made:
            bpy.data.lights.remove(obj.data)  # and the object with it
        preset_sources.remove(things)
        for text in set(bpy.data.texts) - texts:
            bpy.data.texts.remove(text)


def folder() -> pathlib.Path:
    """Path of the library."""
    if IS_EXTENSION:
        return pathlib.Path(bpy.utils.extension_path_user(ROOT, path="assets", create=True))
    return pathlib.Path(bpy.utils.user_resource("DATAFILES", path="sdf_lights/assets", create=True))


class SDFLIGHTS_OT_asset_library_add(bpy.types.Operator):
    """Add the presets as an asset library, so that they can be dragged from the asset browser"""

    bl_idname = "sdf_lights.asset_library_add"
    bl_label = "Add Presets as Asset Library"

    def execute(self, context):
        place = folder()
        try:
            write_library(place / _FILE)
        except (OSError, RuntimeError) as error:
            self.report({"ERROR"}, f"The library cannot be written into {place}: {error}")
            return {"CANCELLED"}
        libraries = context.preferences.filepaths.asset_libraries
        if not any(pathlib.Path(library.path) == place for library in libraries):
            libraries.new(name=LIBRARY, directory=str(place))
            context.preferences.is_dirty = True
        self.report({"INFO"}, f"Asset Browser > {LIBRARY} has {len(presets())} lamps")
        return {"FINISHED"}


def draw_menu(self, context):
    """Entry in Object > Asset."""
    if SDFLIGHTS_OT_lamp_mark_asset.poll(context):
        self.layout.separator()
        self.layout.operator(SDFLIGHTS_OT_lamp_mark_asset.bl_idname, icon="ASSET_MANAGER")


CLASSES = (SDFLIGHTS_OT_lamp_mark_asset, SDFLIGHTS_OT_asset_library_add)


def register():
    bpy.types.VIEW3D_MT_object_asset.append(draw_menu)


def unregister():
    bpy.types.VIEW3D_MT_object_asset.remove(draw_menu)
