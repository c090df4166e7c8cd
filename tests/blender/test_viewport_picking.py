# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the ray under the mouse enters a lamp."""

import numpy as np
import pytest

from sdf_lights.blender.viewport.picking import entry
from sdf_lights.render.scene import Lamp
from sdf_lights.sdf.shapes import Sphere, Torus

DOWN = np.array([0.0, 0.0, -1.0])


def placed(shape, *scale: float, at=(0.0, 0.0, 0.0)) -> Lamp:
    matrix = np.diag([*scale, 1.0])
    matrix[:3, 3] = at
    return Lamp("Lamp", shape, matrix)


@pytest.mark.parametrize(
    "lamp, x, distance",
    [
        (placed(Sphere(0.5), 1.0, 1.0, 1.0), 0.0, 4.5),
        (placed(Sphere(0.5), 1.0, 1.0, 1.0), 0.6, None),
        (placed(Sphere(0.5), 1.0, 1.0, 3.0), 0.0, 3.5),
        (placed(Sphere(0.5), -2.0, 1.0, 1.0), 0.9, 5.0 - 0.5 * 0.19**0.5),
        (placed(Torus(1.0, 0.2), 1.0, 1.0, 1.0), 0.0, None),
        (placed(Torus(1.0, 0.2), 1.0, 1.0, 1.0), 1.0, 4.8),
        (placed(Sphere(0.5), 1.0, 1.0, 1.0, at=(0.0, 0.0, 8.0)), 0.0, None),
        (placed(Sphere(0.5), 1.0, 1.0, 1.0, at=(0.0, 0.0, 5.0)), 0.0, 0.0),
    ],
)
def test_distance_to_a_lamp(lamp, x, distance):
    """Looked at from 5 m above; the eye may stand inside it, or beyond."""
    found = entry(lamp, np.array([x, 0.0, 5.0]), DOWN)
    assert found == (None if distance is None else pytest.approx(distance, abs=2e-3))
