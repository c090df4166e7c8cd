# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Skies, without Blender: maps, symmetry, the sun's direction, harmless settings, and kernels without Numba."""

import dataclasses
import math
import pathlib
import subprocess
import sys

import numpy as np
import pytest

from sdf_lights.render.sky import MODELS, Sky, radiance, sky_map, sun_of

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]


def sky(model, **changes):
    return dataclasses.replace(Sky(model, sun_direction=(0.4, -0.3, 0.5), sun_rotation=2.2), **changes)


def directions(count=200, seed=1):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


@pytest.mark.parametrize("model", MODELS)
def test_a_map_holds_the_radiance_at_its_pixels(model):
    height, width = 16, 32
    picture = sky_map(sky(model), width, height)
    assert picture.shape == (height, width, 3) and picture.dtype == np.float32
    rows, columns = np.mgrid[:height, :width]
    # Equirectangular as Blender has it: u = 1/2 − φ / 2π, v = 1/2 + θ / π.
    longitude, latitude = 2.0 * np.pi * (0.5 - (columns + 0.5) / width), np.pi * ((rows + 0.5) / height - 0.5)
    d = np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], -1)
    expected = radiance(sky(model), d.reshape(-1, 3), disc=False)
    np.testing.assert_allclose(picture.reshape(-1, 3), expected, rtol=1e-6)


@pytest.mark.parametrize("model", MODELS)
def test_left_and_right_of_the_sun_are_alike(model):
    d = directions()
    east = np.cross(sky(model).sun(), (0.0, 0.0, 1.0))
    east /= np.linalg.norm(east)
    mirrored = d - 2.0 * (d @ east)[:, None] * east
    np.testing.assert_allclose(radiance(sky(model), d), radiance(sky(model), mirrored), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("model", MODELS[2:])
def test_the_disc_is_where_the_sun_is(model):
    found = sun_of(sky(model))
    around = found.direction + 0.9 * found.half_angle * np.eye(3)
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    beside = found.direction + 1.5 * found.half_angle * np.cross(found.direction, np.eye(3)) / 0.7
    beside /= np.linalg.norm(beside, axis=1, keepdims=True)
    assert (radiance(sky(model), around) > 100.0 * radiance(sky(model), around, disc=False)).all()
    away = np.arccos(beside @ found.direction) > found.half_angle
    assert away.any()
    np.testing.assert_array_equal(radiance(sky(model), beside[away]), radiance(sky(model), beside[away], disc=False))
    assert sun_of(sky(model, sun_disc=False)) is None
    assert sun_of(sky(model, sun_elevation=-0.3)) is None


def test_a_sun_past_the_zenith_comes_down_on_the_other_side():
    high = sky(MODELS[4], sun_elevation=2.0)
    low = sky(MODELS[4], sun_elevation=math.pi - 2.0, sun_rotation=2.2 + math.pi)
    np.testing.assert_allclose(high.sun(), low.sun(), atol=1e-12)
    np.testing.assert_allclose(radiance(high, directions()), radiance(low, directions()), rtol=1e-6)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(
    "changes",
    [
        dict(altitude=0.0),
        dict(altitude=1e6),
        dict(sun_size=0.0),
        dict(sun_size=1.57),
        dict(sun_elevation=-1.5),
        dict(air_density=0.0, aerosol_density=0.0, ozone_density=0.0),
        dict(air_density=1000.0, aerosol_density=1000.0),
        dict(turbidity=1.0, ground_albedo=1.0),
        dict(turbidity=10.0),
        dict(sun_direction=(0.0, 0.0, 0.0)),
        dict(sun_direction=(0.0, 0.0, -1.0)),
    ],
    ids=str,
)
def test_every_setting_gives_finite_light(model, changes):
    with np.errstate(all="raise", under="ignore"):
        found = radiance(sky(model, **changes), np.concatenate((directions(50), np.eye(3), -np.eye(3))))
    assert np.isfinite(found).all() and (found >= 0.0).all()


def test_kernels_run_without_numba():
    code = """
        import sys
        sys.modules["numba"] = None
        import numpy as np
        from sdf_lights.render.sky import MODELS, Sky, radiance
        d = np.array([(0.6, 0.0, 0.8), (0.0, 0.6, 0.8), (0.6, 0.64, -0.48)])
        np.save(sys.argv[1], [radiance(Sky(model, sun_direction=(0.4, -0.3, 0.5)), d) for model in MODELS])
    """
    import tempfile
    import textwrap

    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "radiance.npy"
        subprocess.run([sys.executable, "-c", textwrap.dedent(code), str(path)], check=True, cwd=REPOSITORY)
        plain = np.load(path)
    d = np.array([(0.6, 0.0, 0.8), (0.0, 0.6, 0.8), (0.6, 0.64, -0.48)])
    compiled = [radiance(Sky(model, sun_direction=(0.4, -0.3, 0.5)), d) for model in MODELS]
    np.testing.assert_allclose(plain, compiled, rtol=1e-9)
