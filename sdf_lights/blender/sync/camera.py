# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera, and the pixels to render."""

from __future__ import annotations

import bpy
import numpy as np

from ...render.errors import RenderError
from ...render.scene import Camera, Eye, Projection
from .common import Warnings, is_finite, is_flat, matrix_of

# Cycles' limit, against division by zero.
SMALLEST_F_NUMBER = 1e-5


_PROJECTIONS = {
    "EQUIRECTANGULAR": Projection.EQUIRECTANGULAR,
    "FISHEYE_EQUIDISTANT": Projection.FISHEYE_EQUIDISTANT,
    "FISHEYE_EQUISOLID": Projection.FISHEYE_EQUISOLID,
    "FISHEYE_LENS_POLYNOMIAL": Projection.FISHEYE_POLYNOMIAL,
    "MIRRORBALL": Projection.MIRROR_BALL,
    "EQUIANGULAR_CUBEMAP_FACE": Projection.CUBEMAP_FACE,
    "CENTRAL_CYLINDRICAL": Projection.CYLINDER,
}


def camera_of(
    obj: bpy.types.Object | None,
    depsgraph: bpy.types.Depsgraph,
    width: int,
    height: int,
    warn: Warnings,
    engine: bpy.types.RenderEngine | None = None,
) -> Camera:
    """The camera object ``obj`` (evaluated) for a frame of ``width`` × ``height`` pixels.

    With several views (stereo), it is the camera of the active view in ``engine``. Raises RenderError if there is no
    camera, or if its transform is unusable.
    """
    if obj is None or obj.type != "CAMERA":
        raise RenderError("The scene has no camera: add one and choose it in the properties of the scene.")
    several = engine is not None and depsgraph.scene_eval.render.use_multiview
    spherical = several and engine.use_spherical_stereo(obj)
    matrix, shift = matrix_of(obj.matrix_world), obj.data.shift_x
    if several:
        matrix = matrix_of(engine.camera_model_matrix(obj, use_spherical_stereo=spherical))
        shift = engine.camera_shift_x(obj, use_spherical_stereo=spherical)
    if not is_finite(matrix) or is_flat(matrix):
        raise RenderError(
            f"Camera '{obj.name}' has a transform that is not finite or has a scale of zero: "
            "clear its location, rotation and scale."
        )
    matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)  # a camera's scale is for display only
    data = obj.data
    camera = Camera(matrix, clip=(data.clip_start, data.clip_end))
    render = depsgraph.scene_eval.render
    size = width * render.pixel_aspect_x, height * render.pixel_aspect_y
    if data.type == "PANO":
        camera.projection = _PROJECTIONS.get(data.panorama_type, Projection.EQUIRECTANGULAR)
        if data.panorama_type not in _PROJECTIONS:
            warn(
                f"Camera '{obj.name}' is a panorama of a kind that is not supported: it is rendered as equirectangular."
            )
        _panorama(camera, data, size, shift)
        if spherical:
            camera.eye = _eye(data.stereo, engine)
    else:
        if data.type == "ORTHO":
            camera.projection = Projection.ORTHOGRAPHIC
        elif data.type != "PERSP":
            warn(f"Camera '{obj.name}' is of a kind that is not supported: it is rendered as a perspective camera.")
        camera.window = window(data, *size, shift)
    if data.dof.use_dof:
        _focus(camera, obj)
    return camera


def _sensor(data: bpy.types.Camera, width: float, height: float) -> tuple[bool, float]:
    """Whether the sensor spans the width of the frame, and its size (mm) along that side. The fit chooses the side;
    AUTO chooses the longer one."""
    if data.sensor_fit == "AUTO":
        return width >= height, data.sensor_width
    horizontal = data.sensor_fit == "HORIZONTAL"
    return horizontal, data.sensor_width if horizontal else data.sensor_height


def window(
    data: bpy.types.Camera,
    width: float,
    height: float,
    shift: float | None = None,
) -> tuple[float, float, float, float]:
    """``Camera.window`` for a frame of these proportions: pixels times their aspect.

    The shift is in units of the side that the sensor spans; ``shift`` overrides its x component.
    """
    horizontal, sensor = _sensor(data, width, height)
    extent = data.ortho_scale if data.type == "ORTHO" else sensor / data.lens
    pixel = extent / (width if horizontal else height)
    x, y = (data.shift_x if shift is None else shift) * extent, data.shift_y * extent
    return (x - 0.5 * width * pixel, x + 0.5 * width * pixel, y - 0.5 * height * pixel, y + 0.5 * height * pixel)


def _panorama(camera: Camera, data: bpy.types.Camera, size: tuple[float, float], shift: float) -> None:
    """Window and lens of a panorama. Its shift is in units of the whole frame, along both axes."""
    edges = {
        Projection.EQUIRECTANGULAR: lambda: (
            data.longitude_min,
            data.longitude_max,
            data.latitude_min,
            data.latitude_max,
        ),
        Projection.FISHEYE_EQUIDISTANT: lambda: _around(data.fisheye_fov, data.fisheye_fov),
        # One unit is twice the focal length.
        Projection.FISHEYE_EQUISOLID: lambda: _around(*(0.5 * side / data.fisheye_lens for side in sides)),
        Projection.FISHEYE_POLYNOMIAL: lambda: _around(*sides),
        Projection.MIRROR_BALL: lambda: _around(2.0, 2.0),
        Projection.CUBEMAP_FACE: lambda: _around(0.5 * np.pi, 0.5 * np.pi),
        Projection.CYLINDER: lambda: (
            data.central_cylindrical_range_u_min,
            data.central_cylindrical_range_u_max,
            data.central_cylindrical_range_v_min / data.central_cylindrical_radius,
            data.central_cylindrical_range_v_max / data.central_cylindrical_radius,
        ),
    }
    horizontal, sensor = _sensor(data, *size)
    sides = [sensor * side / (size[0] if horizontal else size[1]) for side in size]
    left, right, bottom, top = edges[camera.projection]()
    x, y = shift * (right - left), data.shift_y * (top - bottom)
    camera.window = left + x, right + x, bottom + y, top + y
    camera.field = data.fisheye_fov
    camera.lens = tuple(getattr(data, f"fisheye_polynomial_k{i}") for i in range(5))


def _around(width: float, height: float) -> tuple[float, float, float, float]:
    """A window of that size about (0, 0)."""
    return -0.5 * width, 0.5 * width, -0.5 * height, 0.5 * height


def _eye(stereo, engine: bpy.types.RenderEngine) -> Eye | None:
    """The eye of the active view of ``engine``, by its name, as in Cycles."""
    side = {"left": -0.5, "right": 0.5}.get(engine.active_view_get())
    if side is None:
        return None
    merge = stereo.use_pole_merge and stereo.pole_merge_angle_to > 0.0
    return Eye(
        side * stereo.interocular_distance,
        np.inf if stereo.convergence_mode == "PARALLEL" else stereo.convergence_distance,
        (stereo.pole_merge_angle_from, stereo.pole_merge_angle_to) if merge else None,
    )


def _focus(camera: Camera, obj: bpy.types.Object) -> None:
    data, dof = obj.data, obj.data.dof
    # An orthographic camera has no focal length: Blender uses one metre. `lens` is in millimetres.
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
    return (
        render.resolution_x * render.resolution_percentage // 100,
        render.resolution_y * render.resolution_percentage // 100,
    )


def border_of(render: bpy.types.RenderSettings, width: int, height: int) -> tuple[int, int, int, int] | None:
    """Pixels (x0, y0, x1, y1) of the render region in a frame of this size; None for the whole frame."""
    if not render.use_border:
        return None
    # Blender computes in single precision and truncates.
    x0, x1 = (int(np.float32(value) * np.float32(width)) for value in (render.border_min_x, render.border_max_x))
    y0, y1 = (int(np.float32(value) * np.float32(height)) for value in (render.border_min_y, render.border_max_y))
    return x0, y0, x1, y1
