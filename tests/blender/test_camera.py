# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera against Blender's own ``world_to_camera_view``, and the size of the frame."""

import bpy
import mathutils
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view

from sdf_lights.render.errors import RenderError
from sdf_lights.render.scene import Projection


def project(scene, point) -> np.ndarray:
    """Normalised coordinates of a world point in the frame, from the synced camera alone."""
    x, y, z = np.linalg.inv(scene.camera.matrix)[:3] @ [*point, 1.0]
    left, right, bottom, top = scene.camera.window
    if scene.camera.projection is Projection.PERSPECTIVE:
        x, y = x / -z, y / -z
    return np.array([(x - left) / (right - left), (y - bottom) / (top - bottom)])


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("size", [(640, 360), (360, 640), (400, 400)])
@pytest.mark.parametrize("aspect", [(1.0, 1.0), (2.0, 1.0), (1.0, 1.5)])
def test_projection_agrees_with_blender(file, synced, kind, fit, size, aspect):
    data, render = file.camera.data, file.scene.render
    data.type, data.sensor_fit, data.ortho_scale = kind, fit, 4.0
    data.lens, data.sensor_width, data.sensor_height = 41.0, 32.0, 21.0
    data.shift_x, data.shift_y = 0.13, -0.27
    file.camera.rotation_euler, file.camera.scale = (1.2, 0.3, -0.4), (2.0, 2.0, 2.0)
    render.resolution_x, render.resolution_y = size
    render.pixel_aspect_x, render.pixel_aspect_y = aspect
    scene = synced()
    for point in [(0.0, 0.0, 0.0), (0.7, 2.0, -0.4), (-1.3, 0.5, 2.2)]:
        expected = world_to_camera_view(file.scene, file.camera, mathutils.Vector(point))
        assert project(scene, point) == pytest.approx(expected[:2], abs=2e-5)


def test_panorama(file, synced):
    data = file.camera.data
    data.type, data.panorama_type = "PANO", "EQUIRECTANGULAR"
    data.latitude_min, data.longitude_max = -0.5, 1.25
    camera = synced().camera
    assert camera.projection is Projection.EQUIRECTANGULAR
    assert camera.window == pytest.approx((-np.pi, 1.25, -0.5, np.pi / 2))


def test_every_panorama_of_blender_is_known(file, synced):
    data, found = file.camera.data, set()
    data.type = "PANO"
    for item in data.bl_rna.properties["panorama_type"].enum_items:
        data.panorama_type = item.identifier
        scene = synced()
        assert not scene.warnings
        found.add(scene.camera.projection)
    assert found == {kind for kind in Projection if kind >= Projection.EQUIRECTANGULAR}


def test_depth_of_field(file, synced, add):
    data = file.camera.data
    data.lens = 50.0
    data.dof.use_dof = True
    data.dof.aperture_fstop, data.dof.focus_distance = 2.0, 3.5
    data.dof.aperture_blades, data.dof.aperture_rotation, data.dof.aperture_ratio = 6, 0.3, 1.5
    camera = synced().camera
    assert camera.aperture == pytest.approx(0.0125)
    assert camera.focus == pytest.approx(3.5)
    assert (camera.blades, camera.blade_rotation, camera.blade_ratio) == (6, pytest.approx(0.3), pytest.approx(1.5))
    data.dof.focus_object = add("Target", None, (3.0, 2.0, 1.0))
    assert synced().camera.focus == pytest.approx(7.0)  # along the axis, not the distance to the object
    data.type = "ORTHO"
    assert synced().camera.aperture == pytest.approx(0.25)
    data.dof.use_dof = False
    assert synced().camera.aperture == 0.0


def test_clipping(file, synced):
    file.camera.data.clip_start, file.camera.data.clip_end = 0.25, 40.0
    assert synced().camera.clip == (0.25, 40.0)


@pytest.mark.parametrize(("percentage", "expected"), [(100, (101, 67)), (50, (50, 33)), (33, (33, 22))])
def test_percentage(file, synced, percentage, expected):
    render = file.scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 101, 67, percentage
    scene = synced()
    assert (scene.width, scene.height) == expected


def test_border(file, synced):
    render = file.scene.render
    assert synced().border is None
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1.0
    assert synced().border == (6, 8, 18, 16)


def test_camera_must_be_usable(file, synced):
    file.camera.scale = (0.0, 1.0, 1.0)
    with pytest.raises(RenderError, match="Camera 'Camera'"):
        synced()


def test_mirrored_camera_stays_mirrored(file, synced):
    file.camera.scale = (-2.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    matrix = synced().camera.matrix[:3, :3]
    assert matrix.T @ matrix == pytest.approx(np.eye(3), abs=1e-6)
    assert np.linalg.det(matrix) == pytest.approx(-1.0, abs=1e-6)
