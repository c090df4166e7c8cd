# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera of a 3D viewport, read from its matrices. They already contain the zoom and offset of the camera view,
sensor fit, shift and pixel aspect."""

from __future__ import annotations

import bpy
import numpy as np

from ...affine import inverse
from ...render.errors import RenderError
from ...render.scene import Camera, Projection
from ..sync.camera import camera_of
from ..sync.common import matrix_of

Border = tuple[int, int, int, int]


def view_camera(context, depsgraph: bpy.types.Depsgraph, width: int, height: int) -> tuple[Camera, Border | None]:
    """Camera of the viewport of ``context``, with so many pixels, and the pixels (x0, y0, x1, y1) to render."""
    data = context.region_data
    view, projection = matrix_of(data.view_matrix), matrix_of(data.window_matrix)
    obj = _looked_through(context, depsgraph)
    if obj is not None and obj.data.type == "PANO":
        frame = _frame(obj, depsgraph, projection)
        camera = camera_of(obj, depsgraph, width, height, lambda warning: None)
        left, right, bottom, top = camera.window
        camera.window = *_beyond(frame[0], (left, right)), *_beyond(frame[1], (bottom, top))
        return camera, _border(context, frame, width, height)
    camera = camera_from_matrices(view, projection)
    if obj is None:
        frame = np.array([[-1.0, 1.0], [-1.0, 1.0]])
    else:
        frame = _frame(obj, depsgraph, projection)
        if obj.data.dof.use_dof:
            lens = camera_of(obj, depsgraph, width, height, lambda warning: None)
            for name in ("aperture", "focus", "blades", "blade_rotation", "blade_ratio"):
                setattr(camera, name, getattr(lens, name))
    return camera, _border(context, frame, width, height)


def camera_from_matrices(view: np.ndarray, projection: np.ndarray) -> Camera:
    """The camera with these matrices (4 × 4), in OpenGL's convention. Raises RenderError if they are not finite."""
    if not np.isfinite([view, projection]).all() or abs(np.linalg.det(view)) < 1e-30:
        raise RenderError("The viewport's view is not finite: reset it with View > Frame All.")
    matrix = inverse(view)
    matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)
    (a, b), (c, d) = projection[2:, 2:]
    near, far = (-(ndc * d - b) / (a - ndc * c) for ndc in (-1.0, 1.0))
    edges = np.array([-1.0, 1.0])
    if d == 0.0:
        # x_clip = P00 x + P02 z and w = −z: on the plane z = −1 the edges x_clip = ±w are these.
        x, y = (edges + projection[0, 2]) / projection[0, 0], (edges + projection[1, 2]) / projection[1, 1]
        return Camera(matrix, window=(*x, *y), clip=(near, far))
    x, y = (edges - projection[0, 3]) / projection[0, 0], (edges - projection[1, 3]) / projection[1, 1]
    # Orthographic views also see objects behind their origin: rays start at the near plane.
    matrix[:3, 3] -= near * matrix[:3, 2]
    return Camera(matrix, Projection.ORTHOGRAPHIC, (*x, *y), (0.0, far - near))


def _looked_through(context, depsgraph) -> bpy.types.Object | None:
    """The camera object (evaluated), in camera view."""
    space = context.space_data
    if context.region_data.view_perspective != "CAMERA":
        return None
    camera = space.camera if space.use_local_camera else context.scene.camera
    camera = camera and camera.evaluated_get(depsgraph)
    return camera if camera is not None and camera.type == "CAMERA" else None


def _frame(obj: bpy.types.Object, depsgraph, projection: np.ndarray) -> np.ndarray:
    """The rectangle of the camera's frame in the viewport: (x, y) × (low, high), −1 to 1."""
    corners = np.array([(*corner, 1.0) for corner in obj.data.view_frame(scene=depsgraph.scene)]) @ projection.T
    ndc = corners[:, :2] / corners[:, 3:]
    return np.stack([ndc.min(axis=0), ndc.max(axis=0)], axis=1)


def _beyond(frame: np.ndarray, limits: tuple[float, float]) -> tuple[float, float]:
    """Edges of the window at −1 and 1, for a panorama whose ``limits`` are the edges of the frame."""
    rate = (limits[1] - limits[0]) / (frame[1] - frame[0])
    return tuple(limits[0] + rate * (edge - frame[0]) for edge in (-1.0, 1.0))


def _border(context, frame: np.ndarray, width: int, height: int) -> Border | None:
    """Pixels of the render region: of the camera's frame in camera view, else the viewport's own."""
    space, render = context.space_data, context.scene.render
    through_camera = context.region_data.view_perspective == "CAMERA"
    source = render if through_camera and render.use_border else space
    if source is space and (through_camera or not space.use_render_border):
        return None
    names = "border" if source is render else "render_border"
    parts = np.array([[getattr(source, f"{names}_{end}_{axis}") for end in ("min", "max")] for axis in "xy"])
    edges = 0.5 * (frame[:, :1] + parts * (frame[:, 1:] - frame[:, :1])) + 0.5
    pixels = np.rint(edges * [[width], [height]]).astype(int)
    (x0, x1), (y0, y1) = np.clip(pixels, 0, [[width], [height]])
    return (int(x0), int(y0), int(max(x1, x0)), int(max(y1, y0)))
