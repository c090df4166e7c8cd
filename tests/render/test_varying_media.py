# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Media whose coefficients vary in space: beside homogeneous ones, and beside closed forms."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from sdf_lights.graph.formula import Vector, constant, exp, log, select, sin
from sdf_lights.render.film import Film
from sdf_lights.render.kernels.media import grids
from sdf_lights.render.material import Material
from sdf_lights.render.medium import Medium, Scattering
from sdf_lights.render.nodes.variables import POSITION
from sdf_lights.render.reference import varying_media
from sdf_lights.render.reference.renderer import ReferenceRenderer
from sdf_lights.render.scene import Ray, Scene, World
from support.scenes import media
from support.scenes.matrices import scaling, translation
from support.scenes.meshes import box
from support.scenes.room import add, camera, settings
from tests.render.test_agreement import WITH_MEDIA, agree, pictures

pytest.importorskip("numba")

FOG = 0.4 * exp(-1.5 * POSITION.z)  # 1/m


def cpu(*arguments):
    from sdf_lights.render.cpu.renderer import CpuRenderer

    return CpuRenderer(*arguments)


def rendered(scene: Scene, samples: int) -> np.ndarray:
    """(height, width, RGB) of one render on one thread."""
    scene.settings.threads = 1
    film = Film(scene, ("Combined",))
    back_end = cpu(scene, film, lambda: False, lambda text: None)
    assert back_end.sample(0, samples, lambda: False, lambda part: None)
    back_end.finish()
    assert not film.discarded.any()
    return film.read("Combined").astype(float)[..., :3]


def in_white(medium: Medium | None, world: Medium | None = None) -> Scene:
    """A long box with a medium before a white world, which only the camera sees."""
    scene = Scene(camera((0.0, -8.0, 1.0), (0.0, 0.0, 1.4), 8, 8, 0.1, clip=(1e-6, 1e3)), 8, 8)
    scene.world = World((1.0, 1.0, 1.0), 1.0, visibility=Ray.CAMERA, medium=world)
    scene.settings = settings(max_bounces=0)
    if medium is not None:
        scene.meshes.append(box())
        scene.meshes[0].slots = None
        scene.materials = []
        add(scene, 0, translation(0.3, 0.0, 1.0) @ scaling(4.0, 2.0, 3.0), Material("fog", media.CLEAR, medium=medium))
    return scene


def closed_form(scene: Scene, near: float, far: float) -> np.ndarray:
    """(height, rays) exp(−∫ 0.4 exp(−1.5 z) dt) for many rays of each row of pixels, between planes y."""
    rows = (np.arange(8 * 64) + 0.5) / (8 * 64) * 2.0 - 1.0
    matrix = scene.camera.matrix
    columns = (np.arange(64) + 0.5) / 64 * 2.0 - 1.0
    u, v = np.meshgrid(columns * scene.camera.window[1], rows * scene.camera.window[3])
    d = np.stack([u, v, -np.ones_like(u)], -1) @ np.asarray(matrix)[:3, :3].T
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    first, last = ((plane + 8.0) / d[..., 1] for plane in (near, far))
    z, slope = 1.0 + d[..., 2] * first, d[..., 2]
    with np.errstate(over="ignore"):  # below the horizon it is dark
        depth = 0.4 * np.exp(-1.5 * z) * -np.expm1(-1.5 * slope * (last - first)) / (1.5 * slope)
    return np.exp(-depth).reshape(8, -1)


@pytest.mark.parametrize("scatters", [False, True])
@pytest.mark.parametrize("where", ["mesh", "world"])
def test_fog_that_thins_out_with_height_has_its_closed_form(where, scatters):
    color = (1.0, 0.5, 0.25)
    medium = Medium(scattering=(Scattering(color),)) if scatters else Medium(absorption=color)
    medium = media.varying(medium, FOG)
    scene = in_white(medium) if where == "mesh" else in_white(None, medium)
    samples = 1024
    found = rendered(scene, samples).mean(1)
    near, far = (-2.0, 2.0) if where == "mesh" else (-8.0, 1e9)
    for channel, share in enumerate(color):
        wanted = (closed_form(scene, near, far) ** share).mean(1)
        assert wanted.min() < 0.95
        # A path that may scatter arrives or does not: a binomial distribution. Else its weight hardly varies.
        error = np.sqrt(wanted / (8 * samples)) if scatters else 0.002 * wanted
        np.testing.assert_array_less(np.abs(found[:, channel] - wanted), 4.5 * error + 1e-9)
        assert found[:, channel].mean() == pytest.approx(wanted.mean(), abs=4.0 * error.mean() / math.sqrt(8.0))


def test_emission_that_varies_has_its_closed_form():
    glow = Vector(constant(0.0), exp(-1.5 * POSITION.z), constant(0.2))
    medium = media.varying(Medium(absorption=(0.5, 0.5, 0.5), emission=(0.1, 0.1, 0.1)))
    medium = replace(medium, varying=replace(medium.varying, emission=glow))
    scene = in_white(medium)
    scene.world = World((0.0, 0.0, 0.0))
    found = rendered(scene, 1024).mean((0, 1))
    # Along the middle of the picture: z changes little, so the mean over pixels is that of straight rays.
    rays = np.linspace(-1.0, 1.0, 401)
    direction = np.asarray(scene.camera.matrix)[:3, :3] @ np.array([0.0, 0.0, -1.0])
    up = np.asarray(scene.camera.matrix)[:3, 1]
    wanted = []
    for v in rays * scene.camera.window[3]:
        d = direction + v * up
        length = 4.0 * np.linalg.norm(d) / d[1]
        t = (np.arange(4000) + 0.5) / 4000 * length
        z = 1.0 + d[2] / d[1] * 6.0 + d[2] / np.linalg.norm(d) * t
        wanted.append((np.exp(-1.5 * z - 0.5 * t)).mean() * length)
    assert found[0] == 0.0
    assert found[1] == pytest.approx(np.mean(wanted), rel=0.01)
    assert found[2] == pytest.approx(0.2 * -math.expm1(-0.5 * 4.0) / 0.5, rel=0.02)


def compare(name: str, samples: int) -> None:
    make = media.MEDIA_SCENES[name]
    found = pictures(cpu, lambda *size: media.with_varying_media(make(*size)), samples, WITH_MEDIA)
    agree(found, pictures(cpu, make, samples, WITH_MEDIA), WITH_MEDIA)


def test_formulas_of_one_value_are_a_homogeneous_medium():
    compare("fog_lamp", 8)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["smoke", "linked_media"])
def test_formulas_of_one_value_are_a_homogeneous_medium_closely(name):
    compare(name, 16)


@pytest.mark.slow
def test_majorants_that_are_too_small_only_add_noise(monkeypatch):
    def make(*size):
        return media.with_varying_media(media.smoke(*size), media.WAVES)

    right = pictures(cpu, make, 8, WITH_MEDIA)
    monkeypatch.setattr(grids, "MARGIN", -0.2)
    agree(pictures(cpu, make, 8, WITH_MEDIA), right, WITH_MEDIA)


BAD = {
    "nothing": constant(0.0) * POSITION.x,
    "not a number": log(POSITION.x - 1e3),
    "infinite": 1.0 / (POSITION.x - POSITION.x * 1.0),
    "negative": -exp(POSITION.x),
    "huge": 1e12 * exp(POSITION.x),
    "sparks": select(sin(917.0 * POSITION.x) * sin(911.0 * POSITION.y) < 0.999, 0.0, 1e12),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_coefficients_neither_last_nor_spread(name):
    medium = Medium((0.1, 0.2, 0.3), (Scattering((0.5, 0.5, 0.5), 0.3),), (0.0, 0.0, 0.0))
    start = time.perf_counter()
    found = rendered(in_white(media.varying(medium, BAD[name])), 4)
    assert np.isfinite(found).all() and time.perf_counter() - start < 60.0
    if name in ("nothing", "not a number", "negative"):
        np.testing.assert_allclose(found, 1.0, atol=1e-6)
    if name in ("infinite", "huge"):
        assert found[:, :, :].mean() < 0.05


def test_coefficients_of_almost_nothing_leave_pictures_finite():
    """High above the fog they are less than the reciprocal of the greatest number."""
    scene = media.with_varying_media(media.fog_lamp(32, 24), FOG)
    scene.settings.seed = 100
    found = rendered(scene, 32)
    assert np.isfinite(found).all()
    scene = media.with_varying_media(media.fog_lamp(32, 24), 1e-315 * media.ONE)
    assert np.isfinite(rendered(scene, 32)).all()


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "voxel_cloud")) for name in media.VARYING_SCENES]
)
def test_path_tracer_agrees_with_reference(name):
    make = media.VARYING_SCENES[name]
    agree(pictures(cpu, make, 4, WITH_MEDIA), pictures(ReferenceRenderer, make, 4, WITH_MEDIA), WITH_MEDIA)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["smoke", "submerged"])
def test_path_tracer_agrees_with_reference_where_all_media_vary(name):
    def make(*size):
        return media.with_varying_media(media.MEDIA_SCENES[name](*size), media.WAVES)

    agree(pictures(cpu, make, 4, WITH_MEDIA), pictures(ReferenceRenderer, make, 4, WITH_MEDIA), WITH_MEDIA)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["varying_smoke", "thinning_fog"])
def test_majorants_of_the_reference_that_are_too_small_only_add_noise(name, monkeypatch):
    make = media.VARYING_SCENES[name]
    monkeypatch.setattr(varying_media, "MARGIN", -0.4)
    agree(pictures(cpu, make, 4, WITH_MEDIA), pictures(ReferenceRenderer, make, 4, WITH_MEDIA), WITH_MEDIA)
