# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that meet lights, flags, and input that is degenerate or not finite."""

import math

import numpy as np
import pytest

from sdf_lights.jit import kernel
from sdf_lights.render.kernels import lights
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.scene import Ray, World
from tests.render.lights.harness import NONE, UP, Packed, place, scene_of

DOWN = np.array([[0.0, 0.0, -1.0]])
ABOVE = np.array([[0.0, 0.0, 1.0]])
ORIGIN = (0.0, 0.0, 0.0)


def test_lights_are_met_only_before_the_surface():
    packed = Packed(
        scene_of(
            PointLight("", place(0, 0, 2), 1.0, radius=0.5, soft_falloff=False), AreaLight("", place(0, 0, 3), 1.0)
        )
    )
    assert packed.hits(0, ORIGIN, ABOVE)[0] == pytest.approx(1.5)
    assert packed.hits(1, ORIGIN, ABOVE)[0] == pytest.approx(3.0)
    assert packed.hits(0, ORIGIN, ABOVE, t_max=1.4)[2] == 0.0
    assert packed.hits(1, ORIGIN, ABOVE, t_max=2.9)[2] == 0.0
    assert packed.hits(0, ORIGIN, DOWN)[2] == 0.0


def test_suns_are_met_only_by_rays_that_leave_the_scene():
    packed = Packed(scene_of(SunLight("", place(axis=(0, 0, 1)), 2.0, angle=0.1)))
    distance, radiance, _ = packed.hits(0, ORIGIN, ABOVE)
    assert np.isinf(distance[0])
    assert radiance[0, 0] == pytest.approx(2.0 / (math.pi * math.sin(0.05) ** 2))
    assert packed.hits(0, ORIGIN, ABOVE, t_max=1e9)[2] == 0.0
    edge = np.array([[math.sin(a), 0.0, math.cos(a)] for a in (0.0499, 0.0501)])
    assert (packed.hits(0, ORIGIN, edge)[2] > 0.0).tolist() == [True, False]


def test_area_lights_shine_to_one_side():
    packed = Packed(scene_of(AreaLight("", place(0, 0, 1), 1.0)))
    assert packed.hits(0, (0.0, 0.0, 2.0), DOWN)[2] == 0.0
    assert not np.isfinite(packed.sample(0, (0.0, 0.0, 2.0), np.full((1, 2), 0.5))[0]).any()


def test_rays_see_the_lights_that_are_visible_to_their_kind():
    hidden = Ray.ALL & ~Ray.CAMERA
    packed = Packed(scene_of(AreaLight("", place(0, 0, 1), 1.0, visibility=hidden)))
    assert packed.hits(0, ORIGIN, ABOVE, kind=int(Ray.CAMERA))[2] == 0.0
    assert packed.hits(0, ORIGIN, ABOVE, kind=int(Ray.DIFFUSE))[2] > 0.0


@kernel
def _flags(blocks, emitter):
    block = blocks[0]
    return (
        lights.is_lamp(block, emitter),
        lights.casts_shadow(block, emitter),
        lights.visibility(block, emitter),
        lights.world_emitter(block),
    )


def test_flags():
    packed = Packed(
        scene_of(
            PointLight("", place(), 1.0, cast_shadow=False, visibility=Ray.DIFFUSE),
            world=World((1, 1, 1), visibility=Ray.CAMERA),
        ),
        lamp_bounds=np.zeros((1, 2, 3)),
        lamp_power=np.ones((1, 3)),
    )
    assert _flags(packed.blocks, 0) == (True, True, int(Ray.ALL), 2)
    assert _flags(packed.blocks, 1) == (False, False, int(Ray.DIFFUSE), 2)
    assert _flags(packed.blocks, 2) == (False, True, int(Ray.CAMERA), 2)


NOT_FINITE = place()
NOT_FINITE[0, 3] = np.nan
FLAT = place(0, 0, 1, scale=(1.0, 0.0, 1.0))
ODD = [
    PointLight("a", NOT_FINITE, 1.0),
    PointLight("b", place(), math.inf),
    AreaLight("c", NOT_FINITE, 1.0),
    SunLight("d", NOT_FINITE, 1.0, angle=0.1),
    SpotLight("e", NOT_FINITE, 1.0, radius=0.1),
    AreaLight("f", FLAT, 1.0),
    AreaLight("g", FLAT, 1.0, ellipse=True),
    AreaLight("h", place(), 1.0, size=(0.0, 0.0)),
    SpotLight("i", FLAT, 1.0),
    SpotLight("j", np.zeros((4, 4)), 1.0, radius=0.2),
    SunLight("k", np.zeros((4, 4)), 1.0),
    SpotLight("l", place(), 1.0, angle=math.pi, blend=0.0, radius=0.5),
    SpotLight("m", place(), 1.0, angle=0.0, blend=1.0, radius=0.5),
    AreaLight("n", place(), 1.0, spread=1e-4),
    AreaLight("o", place(), 1.0, spread=0.0, ellipse=True),
    AreaLight("p", place(), 1.0, size=(1e-12, 1e9), ellipse=True),
    AreaLight("q", place(), 1.0, size=(1e-12, 1e9)),
    PointLight("r", place(), 1.0, radius=1e-12, soft_falloff=False),
    PointLight("s", place(), 1.0, radius=1e6),
    SunLight("t", place(), 1.0, angle=1e-9),
    SunLight("u", place(), 1.0, angle=math.pi),
]


@pytest.mark.parametrize("light", ODD, ids=lambda light: light.name)
def test_odd_lights_and_places_give_finite_numbers(light):
    packed = Packed(scene_of(light))
    rng = np.random.default_rng(1)
    u = np.concatenate([rng.random((40, 2)), [(0.0, 0.0), (0.0, 1 - 1e-16), (1 - 1e-16, 0.0), (1 - 1e-16, 1 - 1e-16)]])
    d = rng.normal(size=(60, 3))
    d = np.concatenate([d / np.linalg.norm(d, axis=1, keepdims=True), np.eye(3), -np.eye(3)])
    for x in [
        ORIGIN,
        (0.0, 0.0, 1.0),
        (0.2, 0.1, 0.0),
        (0.5, 0.5, 0.0),
        (3.0, 0.0, 0.0),
        (0.1, 0.1, -1e-12),
        (0.0, 0.0, -1.0),
        (0.1, 0.2, -1e9),
    ]:
        wi, distance, radiance, pdf, _ = packed.sample(0, x, u)
        lit = np.isfinite(wi[:, 0])
        assert np.isfinite(pdf).all() and np.isfinite(radiance).all() and not np.isnan(distance).any()
        np.testing.assert_allclose(np.linalg.norm(wi[lit], axis=1), 1.0, rtol=1e-9)
        hit_distance, hit_radiance, hit_pdf = packed.hits(0, x, d)
        assert np.isfinite(hit_radiance).all() and np.isfinite(hit_pdf).all() and not np.isnan(hit_distance).any()
        for n in (UP, NONE):
            p = packed.probabilities(x, n)
            assert np.isfinite(p).all() and abs(p.sum() - p.any()) < 1e-9


def test_lights_that_are_not_finite_are_named():
    scene = scene_of(*ODD[:2])
    Packed(scene)
    assert len(scene.warnings) == 2 and "“a”" in scene.warnings[0] and "“b”" in scene.warnings[1]
