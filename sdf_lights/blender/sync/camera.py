# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera, and which pixels are rendered."""

from __future__ import annotations

import bpy
import numpy as np

from ...render.errors import RenderError
from ...render.scene import Camera, Projection
from .common import Warnings, is_finite, is_flat, matrix_of

# Cycles' limit, against division by zero.
SMALLEST_F_NUMBER = 1e-5


def camera_of(
    obj: bpy.types.Object | None, depsgraph: bpy.types.Depsgraph, width: int, height: int, warn: Warnings) -> Camera:
    """The camera object ``obj`` (evaluated) for a frame of ``width`` × ``height`` pixels.

    Raises RenderError where there is none, or where it has no usable place in the world.
    """
    if obj is None or obj.type != "CAMERA":
        raise RenderError("The scene has no camera: add one and choose it in the properties of the scene.")
    matrix = matrix_of(obj.matrix_world)
    if not is_finite(matrix) or is_flat(matrix):
        raise RenderError(f"Camera '{obj.name}' has a transform that is not finite or has a scale of zero: "
                          "clear its location, rotation and scale.")
    matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)  # a camera's scale is for display only
    data = obj.data
    camera = Camera(matrix, clip=(data.clip_start, data.clip_end))
    if data.type == "PANO":
        camera.projection = Projection.EQUIRECTANGULAR
        camera.latitude = data.latitude_min, data.latitude_max
        camera.longitude = data.longitude_min, data.longitude_max
        if data.panorama_type != "EQUIRECTANGULAR":
            warn(f"Camera '{obj.name}' is a panorama of a kind that is not supported: "
                 "it is rendered as equirectangular.")
    else:
        if data.type == "ORTHO":
            camera.projection = Projection.ORTHOGRAPHIC
        elif data.type != "PERSP":
            warn(f"Camera '{obj.name}' is of a kind that is not supported: it is rendered as a perspective camera.")
        render = depsgraph.scene_eval.render
        camera.window = window(data, width * render.pixel_aspect_x, height * render.pixel_aspect_y)
    if data.dof.use_dof:
        _focus(camera, obj)
    return camera


def window(data: bpy.types.Camera, width: float, height: float) -> tuple[float, float, float, float]:
    """``Camera.window`` for a frame of these proportions: pixels times their aspect.

    The sensor spans the side that the fit chooses, the longer one for AUTO; the shift is in units of that side.
    """
    if data.sensor_fit == "AUTO":
        horizontal, sensor = width >= height, data.sensor_width
    else:
        horizontal = data.sensor_fit == "HORIZONTAL"
        sensor = data.sensor_width if horizontal else data.sensor_height
    extent = data.ortho_scale if data.type == "ORTHO" else sensor / data.lens
    pixel = extent / (width if horizontal else height)
    x, y = data.shift_x * extent, data.shift_y * extent
    return (x - 0.5 * width * pixel, x + 0.5 * width * pixel, y - 0.5 * height * pixel, y + 0.5 * height * pixel)


def _focus(camera: Camera, obj: bpy.types.Object) -> None:
    data, dof = obj.data, obj.data.dof
    # An orthographic camera has no focal length: Blender takes one metre for it. `lens` is in millimetres.
    focal_length = 1.0 if data.type == "ORTHO" else data.lens * 1e-3
    camera.aperture = focal_length / (2.0 * max(dof.aperture_fstop, SMALLEST_F_NUMBER))
    camera.focus = dof.focus_distance
    if dof.focus_object is not None:
        target = matrix_of(dof.focus_object.matrix_world)
        bone = dof.focus_subtarget and dof.focus_object.pose and dof.focus_object.pose.bones.get(dof.focus_subtarget)
        if bone:
            target = target @ matrix_of(bone.matrix)
        offset = target[:3, 3] - camera.matrix[:3, 3]
        camera.focus = abs(float(offset @ camera.matrix[:3, 2]))
    camera.focus = max(camera.focus, camera.clip[0] * 1e-3, 1e-6)
    camera.blades = dof.aperture_blades
    camera.blade_rotation = dof.aperture_rotation
    camera.blade_ratio = dof.aperture_ratio


def frame_size(render: bpy.types.RenderSettings) -> tuple[int, int]:
    """Pixels of the whole frame, rounded as Blender rounds them."""
    return (render.resolution_x * render.resolution_percentage // 100,
            render.resolution_y * render.resolution_percentage // 100)


def border_of(render: bpy.types.RenderSettings, width: int, height: int) -> tuple[int, int, int, int] | None:
    """Pixels (x0, y0, x1, y1) of the render region in a frame of this size, None for all of it."""
    if not render.use_border:
        return None
    # Blender computes in single precision and cuts off.
    x0, x1 = (int(np.float32(value) * np.float32(width)) for value in (render.border_min_x, render.border_max_x))
    y0, y1 = (int(np.float32(value) * np.float32(height)) for value in (render.border_min_y, render.border_max_y))
    return x0, y0, x1, y1
