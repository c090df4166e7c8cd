# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels read as GLSL, in float32, against what Numba makes of them, in float64."""

import numpy as np
import pytest

from sdf_lights import jit, vec
from sdf_lights.emitter.emission import varying as emission
from sdf_lights.emitter.primitives import box, capsule, cylinder, disk, frustum, sphere, torus
from sdf_lights.emitter.sampling import cut
from sdf_lights.render.kernels import samplers, textures
from sdf_lights.render.kernels.lights import cone, ellipse, rectangle
from sdf_lights.render.kernels.lights import triangle as triangles
from sdf_lights.render.kernels.shading import diffuse, fresnel, microfacet
from tests.gpu.support import on_cpu, on_gpu

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

COUNT = 400


def uniform(rng, low=0.0, high=1.0):
    return rng.uniform(low, high, COUNT)


def vectors(rng, size=1.0):
    return rng.uniform(-size, size, (COUNT, 3))


def units(rng):
    v = rng.normal(size=(COUNT, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


# Kernel, columns of arguments, and by how much float32 may be off: absolute, and relative.
FUNCTIONS = {
    "normalize": (vec.normalize, lambda r: [vectors(r)], 1e-6, 0.0),
    "frame": (vec.frame, lambda r: [units(r)], 2e-6, 0.0),
    "to_world": (vec.to_world, lambda r: [vectors(r), units(r), units(r), units(r)], 2e-6, 0.0),
    "lerp": (vec.lerp, lambda r: [vectors(r), vectors(r), uniform(r)], 1e-6, 0.0),
    "cone": (cone.sample_cone, lambda r: [units(r), uniform(r, 0.01, 1.0), uniform(r), uniform(r)], 3e-6, 0.0),
    "disk": (disk.disk_point, lambda r: [uniform(r), uniform(r)], 2e-6, 0.0),
    "ball": (sphere.ball_point, lambda r: [uniform(r), uniform(r), uniform(r)], 4e-6, 0.0),
    "torus point": (
        torus.torus_point,
        lambda r: [uniform(r), uniform(r), uniform(r), uniform(r, 0.5, 1.0), uniform(r, 0.01, 0.4)],
        2e-4,
        0.0,
    ),
    "sphere span": (sphere.sphere_span, lambda r: [vectors(r, 0.4), units(r), uniform(r, 0.8, 1.0)], 1e-5, 0.0),
    "box span": (
        box.box_span,
        lambda r: [vectors(r, 0.4), units(r), *(uniform(r, 0.5, 1.0) for _ in range(3))],
        1e-5,
        1e-5,
    ),
    "capsule span": (
        capsule.capsule_span,
        lambda r: [vectors(r, 0.2), units(r), uniform(r, 0.4, 1.0), uniform(r, 0.2, 1.0)],
        1e-5,
        1e-5,
    ),
    "cylinder span": (
        cylinder.cylinder_span,
        lambda r: [vectors(r, 0.2), units(r), uniform(r, 0.4, 1.0), uniform(r, 0.3, 1.0)],
        1e-5,
        1e-5,
    ),
    "frustum span": (
        frustum.frustum_span,
        lambda r: [vectors(r, 0.1), units(r), uniform(r, 0.5, 1.0), uniform(r, 0.3, 0.5), uniform(r, 0.3, 1.0)],
        2e-5,
        2e-5,
    ),
    "place of a point": (emission.place_point, lambda r: [uniform(r)], 2e-6, 0.0),
    "dielectric": (fresnel.dielectric, lambda r: [uniform(r), uniform(r, 1.1, 2.0)], 2e-6, 0.0),
    "F82": (fresnel.f82, lambda r: [uniform(r), uniform(r), uniform(r, 0.0, 4.0)], 2e-6, 0.0),
    "GGX": (microfacet.distribution, lambda r: [uniform(r, 0.01, 1.0), uniform(r)], 1e-5, 1e-4),
    "masking": (microfacet.masking, lambda r: [uniform(r, 0.01, 1.0), uniform(r, 0.01, 1.0)], 1e-6, 1e-5),
    "cosine": (diffuse.cosine_hemisphere, lambda r: [uniform(r), uniform(r)], 1e-3, 0.0),  # flat at the rim
    "rectangle pdf": (
        rectangle.rectangle_pdf,
        lambda r: [
            uniform(r, -1.0, -0.2),
            uniform(r, 0.1, 1.0),
            uniform(r, -1.0, -0.2),
            uniform(r, 0.1, 1.0),
            uniform(r, 0.1, 1.0),
            uniform(r, -0.2, 0.1),
            uniform(r, -0.2, 0.1),
        ],
        0.0,
        1e-4,
    ),
    "rectangle": (
        rectangle.sample_rectangle,
        lambda r: [
            uniform(r, -1.0, -0.2),
            uniform(r, 0.1, 1.0),
            uniform(r, -1.0, -0.2),
            uniform(r, 0.1, 1.0),
            uniform(r, 0.3, 1.0),
            uniform(r),
            uniform(r),
        ],
        1e-4,
        1e-4,
    ),
    "ellipse pdf": (
        ellipse.ellipse_pdf,
        lambda r: [
            uniform(r, -0.5, 0.5),
            uniform(r, -0.5, 0.5),
            uniform(r, 0.3, 1.0),
            uniform(r, 0.3, 1.0),
            uniform(r, 0.3, 1.0),
            uniform(r, -0.1, 0.1),
            uniform(r, -0.1, 0.1),
        ],
        0.0,
        2e-3,
    ),
    "solid angle": (triangles.solid_angle, lambda r: [units(r), units(r), units(r)], 5e-6, 1e-4),
    "cubic": (textures.cubic_weight, lambda r: [uniform(r), r.integers(0, 4, COUNT)], 1e-6, 0.0),
    "place in a box": (
        cut._place_in,
        lambda r: [
            uniform(r, -1.0, 0.0),
            uniform(r, 0.5, 1.0),
            uniform(r, 0.5, 1.0),
            uniform(r, -0.3, 0.3),
            uniform(r),
        ],
        2e-6,
        0.0,
    ),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_function(name):
    kernel, make, absolute, relative = FUNCTIONS[name]
    columns = make(np.random.default_rng(1))
    expected, found = on_cpu(kernel, *columns), on_gpu(kernel, *columns)
    # Both say of the same rays that they miss.
    assert np.array_equal(np.isfinite(expected), np.isfinite(found))
    np.testing.assert_allclose(found, expected, rtol=relative, atol=absolute + 1e-30)


def test_torus_to_the_precision_of_float32():
    """The quartic loses half of the digits of thin tori, which the polish gives back but for rays that touch."""
    rng = np.random.default_rng(2)
    columns = [vectors(rng, 0.7), units(rng), uniform(rng, 0.5, 1.0), uniform(rng, 0.05, 0.4)]
    expected, found = on_cpu(torus.torus_spans, *columns), on_gpu(torus.torus_spans, *columns)
    same = expected[:, 0] == found[:, 0]
    assert same.mean() > 0.99
    lengths = [(rows[:, 2] - rows[:, 1]) + (rows[:, 4] - rows[:, 3]) for rows in (expected, found)]
    error = np.abs(lengths[0] - lengths[1])
    assert np.median(error[same]) < 2e-6 and np.quantile(error, 0.99) < 5e-3


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4])
def test_sampling_pattern_is_the_same(dimensions):
    rng = np.random.default_rng(3)
    kernel = (samplers.get_1d, samplers.get_2d, samplers.get_3d, samplers.get_4d)[dimensions - 1]
    index, dimension = rng.integers(0, 1 << 20, COUNT), rng.integers(0, 200, COUNT)
    seeds = rng.integers(0, 1 << 31, COUNT)
    expected = on_cpu(lambda i, seed, d: kernel(i, np.uint32(seed), d), index, seeds, dimension)
    found = on_gpu(kernel, index, seeds, dimension)
    assert np.abs(found - expected).max() <= 2.0**-24 and found.max() < 1.0


def test_seeds_of_pixels_are_the_same():
    rng = np.random.default_rng(4)
    columns = [rng.integers(0, 10_000, COUNT) for _ in range(3)]
    expected, found = on_cpu(samplers.pixel_seed, *columns), on_gpu(samplers.pixel_seed, *columns)
    assert np.abs(found - expected).max() <= 128.0  # float32 shows 24 digits of the 32
