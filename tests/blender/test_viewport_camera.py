# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras from the matrices of a view: those that Blender makes of a camera object give that camera back."""

import bpy
import numpy as np
import pytest

from sdf_lights.blender.sync.camera import camera_of
from sdf_lights.blender.sync.common import matrix_of
from sdf_lights.render.errors import RenderError
from sdf_lights.render.scene import Projection

WIDTH, HEIGHT = 320, 180


@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("aspect", [(1.0, 1.0), (2.0, 1.0), (1.0, 4.0)])
def test_matrices_of_a_camera_give_it_back(file, kind, fit, aspect):
    from sdf_lights.blender.viewport.viewport_camera import camera_from_matrices

    data = file.camera.data
    data.type, data.sensor_fit, data.lens, data.ortho_scale = kind, fit, 35.0, 7.0
    data.shift_x, data.shift_y, data.clip_start, data.clip_end = 0.2, -0.1, 0.5, 80.0
    file.camera.rotation_euler = (1.2, 0.3, -0.4)
    file.scene.render.pixel_aspect_x, file.scene.render.pixel_aspect_y = aspect
    depsgraph = bpy.context.evaluated_depsgraph_get()
    depsgraph.update()
    evaluated = file.camera.evaluated_get(depsgraph)
    expected = camera_of(evaluated, depsgraph, WIDTH, HEIGHT, lambda warning: None)
    projection = matrix_of(
        file.camera.calc_matrix_camera(depsgraph, x=WIDTH, y=HEIGHT, scale_x=aspect[0], scale_y=aspect[1])
    )
    found = camera_from_matrices(np.linalg.inv(matrix_of(evaluated.matrix_world)), projection)
    assert found.projection is expected.projection
    np.testing.assert_allclose(found.window, expected.window, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(found.matrix[:3, :3], expected.matrix[:3, :3], atol=1e-6)
    # Rays of an orthographic view start where it begins; there are none behind their origin.
    start = found.matrix[:3, 3] - found.clip[0] * found.matrix[:3, 2]
    end = found.matrix[:3, 3] - found.clip[1] * found.matrix[:3, 2]
    np.testing.assert_allclose(start, expected.matrix[:3, 3] - 0.5 * expected.matrix[:3, 2], atol=1e-3)
    np.testing.assert_allclose(end, expected.matrix[:3, 3] - 80.0 * expected.matrix[:3, 2], rtol=1e-3, atol=0.1)
    assert found.clip[0] >= 0.0


def test_orthographic_views_look_behind_their_origin():
    from sdf_lights.blender.viewport.viewport_camera import camera_from_matrices

    projection = np.diag([0.1, 0.2, -2.0 / 200.0, 1.0])  # from 100 m behind to 100 m before
    camera = camera_from_matrices(np.eye(4), projection)
    assert camera.projection is Projection.ORTHOGRAPHIC
    np.testing.assert_allclose(camera.matrix[:3, 3], (0.0, 0.0, 100.0))
    np.testing.assert_allclose(camera.clip, (0.0, 200.0))
    np.testing.assert_allclose(camera.window, (-10.0, 10.0, -5.0, 5.0))


def test_a_view_that_is_no_view_is_told():
    from sdf_lights.blender.viewport.viewport_camera import camera_from_matrices

    with pytest.raises(RenderError, match="not finite"):
        camera_from_matrices(np.full((4, 4), np.nan), np.eye(4))
