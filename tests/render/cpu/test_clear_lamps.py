# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lamps no surface stands inside, by boxes around both."""

import numpy as np

from sdf_lights.render.kernels.packing import clear_lamps, instance_boxes
from sdf_lights.render.scene import Camera, Instance, Mesh, Scene
from support.scenes import rotation, scaling, translation

TRIANGLE = Mesh("Triangle", np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0]], np.float32), np.array([[0, 1, 2]], np.int32))
NOTHING = Mesh("Nothing", np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))


def clear(*matrices):
    """Of balls with radius 1, at the origin and at x = 10."""
    rows = np.zeros(2, [("center", float, 3), ("half", float, 3)])
    rows["center"][1, 0], rows["half"] = 10.0, 1.0
    scene = Scene(Camera(np.eye(4)), 8, 6, meshes=[TRIANGLE, NOTHING], instances=[Instance(1, np.eye(4), (0,))])
    scene.instances += [Instance(0, matrix, (0,)) for matrix in matrices]
    return clear_lamps(rows, *instance_boxes(scene)).tolist()


def test_only_what_meets_a_lamp_counts():
    assert clear() == [True, True]
    assert clear(translation(0.0, 0.0, 1.1)) == [True, True]
    assert clear(translation(0.0, 0.0, 0.9)) == [False, True]
    assert clear(translation(0.0, 0.0, 1.1) @ rotation("x", 30.0)) == [False, True]
    assert clear(translation(0.0, 0.0, 0.9), translation(8.5, 0.0, 0.0)) == [False, False]
    assert clear(scaling(9.5, 1.0, 1.0)) == [False, False]
