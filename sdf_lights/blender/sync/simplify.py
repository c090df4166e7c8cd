# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of Simplify that Blender's dependency graph does not do: Cycles' culling, and the size of textures."""

from __future__ import annotations

import bpy
import numpy as np

from ...render.scene import Camera, Projection


def _settings(depsgraph: bpy.types.Depsgraph):
    """Settings of Cycles; None if Simplify is off. They do not tag evaluated copies, so the original's are read."""
    scene = depsgraph.scene
    return getattr(scene, "cycles", None) if scene.render.use_simplify else None


def texture_limit(depsgraph: bpy.types.Depsgraph) -> int:
    """The greatest width or height of a texture; 0 if there is no limit."""
    settings = _settings(depsgraph)
    name = "texture_limit" if depsgraph.mode == "VIEWPORT" else "texture_limit_render"
    limit = getattr(settings, name, "OFF")
    return int(limit) if limit.isdecimal() else 0


def texture_share(depsgraph: bpy.types.Depsgraph) -> float | None:
    """The factor on the size of all textures, in versions that have it; None in older versions, which halve them."""
    settings = _settings(depsgraph)
    name = "texture_resolution" if depsgraph.mode == "VIEWPORT" else "texture_resolution_render"
    share = getattr(settings, name, None)
    return None if share is None else float(share)


class Culling:
    """Objects that are left out, if they ask for it: outside the view of the ``camera``, or far from it."""

    def __init__(self, depsgraph: bpy.types.Depsgraph, camera: Camera | None):
        settings = _settings(depsgraph)
        flat = camera is not None and camera.projection in (Projection.PERSPECTIVE, Projection.ORTHOGRAPHIC)
        possible = settings is not None and flat and not depsgraph.scene.render.use_multiview
        self._by_camera = possible and getattr(settings, "use_camera_cull", False)
        self._by_distance = possible and getattr(settings, "use_distance_cull", False)
        self._margin = getattr(settings, "camera_cull_margin", 0.0)
        self._distance = getattr(settings, "distance_cull_margin", 0.0)
        self._by_distance = self._by_distance and self._distance != 0.0
        self._camera = camera

    def leaves_out(self, obj: bpy.types.Object, matrix: np.ndarray) -> bool:
        """Whether an object with this matrix (4 × 4) is left out."""
        if not (self._by_camera or self._by_distance):
            return False
        asks = getattr(obj.original, "cycles", None)
        by_camera = self._by_camera and getattr(asks, "use_camera_cull", False)
        by_distance = self._by_distance and getattr(asks, "use_distance_cull", False)
        if not (by_camera or by_distance):
            return False
        corners = np.array(obj.bound_box) @ matrix[:3, :3].T + matrix[:3, 3]
        # With both tests on, an object must be outside and far.
        return (not by_camera or self._is_outside(corners)) and (not by_distance or self._is_far(corners))

    def _is_outside(self, corners: np.ndarray) -> bool:
        camera, margin = self._camera, self._margin
        back = np.linalg.inv(camera.matrix)
        x, y, z = (corners @ back[:3, :3].T + back[:3, 3]).T
        near, far = camera.clip
        ahead, left, right, bottom, top = -z, *camera.window
        if camera.projection == Projection.PERSPECTIVE:
            depth = (ahead - near) * far / (far - near)
            ahead = np.where(ahead == 0.0, 1e-30, ahead)
            x, y = x / ahead, y / ahead
        else:
            depth = (ahead - near) / (far - near)
        if (depth < -margin).all():
            return True
        place = np.stack([(x - left) / (right - left), (y - bottom) / (top - bottom)])
        place = np.where(depth < 0.0, 1.0 - place, place)  # points behind the camera are mirrored
        return bool((place.min(1) >= 1.0 + margin).any() or (place.max(1) <= -margin).any())

    def _is_far(self, corners: np.ndarray) -> bool:
        eye = self._camera.matrix[:3, 3]
        nearest = np.clip(eye, corners.min(0), corners.max(0))
        return float(np.linalg.norm(eye - nearest)) > self._distance
