# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays go through faces that lie exactly in the same place as others, and miss none of these: a box of fog on a floor,
boxes of fog side by side, a clear label on it."""

import numpy as np
import pytest

from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.material import Material
from sdf_lights.render.medium import Medium, Scattering
from sdf_lights.render.scene import Scene, World
from support.scenes import media
from support.scenes.matrices import rotation, scaling, translation
from support.scenes.meshes import box, quad
from support.scenes.room import GREY, add, camera, diffuse, settings
from tests.render.test_varying_media import rendered

FOG = Medium((0.05, 0.1, 0.2), (Scattering((0.3, 0.3, 0.3), 0.2),))
APART = 1e-3  # metres: as good as together, but for what this is about
SAMPLES = 256


def outdoors(eye=(0.5, -6.0, 3.0), target=(0.0, 0.0, 0.5)) -> Scene:
    """A grey floor under a sky and a sun."""
    scene = Scene(camera(eye, target, 24, 16, 0.4), 24, 16)
    scene.settings = settings(max_bounces=2, volume_bounces=2, transparent_bounces=8)
    scene.meshes = [quad(), box()]
    scene.meshes[1].slots = None
    scene.world = World((0.4, 0.5, 0.6), 1.0)
    scene.lights = [SunLight("sun", rotation("x", 40.0), (3.0, 2.8, 2.5), 0.1)]
    add(scene, 0, scaling(6.0, 6.0, 1.0), diffuse(GREY), "floor")
    return scene


def fog(scene: Scene, x: float, z: float, factor=None) -> None:
    medium = FOG if factor is None else media.varying(FOG, factor)
    add(scene, 1, translation(x, 0.0, z), Material("fog", media.CLEAR, medium=medium))


def agree(one: Scene, other: Scene) -> None:
    """Pictures are the same within their noise and what ``APART`` shows."""
    first, second = (rendered(scene, SAMPLES) for scene in (one, other))
    found = [picture.reshape(4, 4, 6, 4, 3).mean((1, 3)) for picture in (first, second)]
    np.testing.assert_allclose(*found, rtol=0.04, atol=0.004)
    assert first.mean() == pytest.approx(second.mean(), rel=0.004)


@pytest.mark.parametrize("factor", [None, media.ONE], ids=["homogeneous", "varies"])
@pytest.mark.parametrize("eye", [(0.5, -6.0, 3.0), (0.1, -0.6, 0.9)], ids=["from outside", "from inside"])
def test_fog_that_lies_on_a_floor(eye, factor):
    on, above = outdoors(eye), outdoors(eye)
    fog(on, 0.0, 1.0, factor)
    fog(above, 0.0, 1.0 + APART, factor)
    agree(on, above)


def test_fog_below_a_floor_is_not_seen():
    below, without = outdoors(), outdoors()
    fog(below, 0.0, -1.0)
    agree(below, without)


def test_boxes_side_by_side():
    together, apart = outdoors(), outdoors()
    for scene, between in ((together, 0.0), (apart, APART)):
        fog(scene, -1.0, 1.5)
        fog(scene, 1.0 + between, 1.5)
    agree(together, apart)


def test_a_clear_label_on_a_floor_is_not_seen():
    on, without = outdoors(), outdoors()
    add(on, 0, scaling(5.0, 4.0, 1.0), Material("label", media.CLEAR))
    on.instances.reverse()
    agree(on, without)
