# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures of lamps show their shape and colour, whatever their size and power."""

import numpy as np
import pytest

from sdf_lights.blender.lamp_preview import picture_of
from sdf_lights.render.scene import Lamp
from sdf_lights.sdf.expression import evaluate

SIZE = 24


@pytest.fixture(scope="module")
def ring():
    return picture(expression="rotate_x(torus(0.4, 0.08), 90)", color=(1.0, 0.2, 0.05))


def picture(expression="sphere(0.5)", **about):
    return picture_of(Lamp("Lamp", evaluate(expression), np.eye(4), **about), SIZE, samples=4)


def test_the_shape_is_in_the_middle_of_the_picture_and_has_its_colour(ring):
    assert ring.shape == (SIZE, SIZE, 4) and (ring[..., 3] == 1.0).all()
    lit = ring[..., 0] > 0.5
    rows, columns = np.nonzero(lit)
    assert 4 < rows.min() + 1 < 12 and 12 < rows.max() < 20 + 4 and abs(rows.mean() - 11.5) < 2.0
    assert abs(columns.mean() - 11.5) < 2.0
    assert not lit[SIZE // 2, SIZE // 2]  # the hole of the ring
    assert (ring[lit][:, 0] > ring[lit][:, 2] + 0.2).all()


@pytest.mark.parametrize(
    "about", [dict(power=1e-3), dict(power=1e6), dict(density=50.0), dict(expression="sphere(500)")]
)
def test_size_and_power_change_no_picture(about):
    assert np.allclose(picture(**about), picture(), atol=0.02)
