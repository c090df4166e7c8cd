# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera rays against projection by hand, the lens, and the pixel filter."""

import math

import numpy as np
import pytest
from scipy import special, stats

from sdf_lights.emitter.primitives.disk import disk_point
from sdf_lights.jit import block_dtype, fill_table, kernel
from sdf_lights.render.kernels.camera import (
    FILTER_CELLS,
    SCALARS,
    TABLES,
    camera_ray,
    camera_scalars,
    filter_inverse_cdf,
    filter_offset,
    filter_radius,
    filter_weight,
    pack_camera,
    panorama_place,
    sample_blades,
    view_depth,
)
from sdf_lights.render.reference.camera_rays import Camera as ReferenceCamera
from sdf_lights.render.scene import FULL_SPHERE, Camera, Eye, Projection, Scene
from sdf_lights.render.settings import Filter, Settings

BLOCK = block_dtype(TABLES, SCALARS)


class Packed:
    """A block of the camera alone. ``block`` points into the tables, so the object must outlive its use."""

    def __init__(self, camera, width=160, height=90, **settings):
        scene = Scene(camera, width, height, settings=Settings(**settings))
        self.tables = pack_camera(scene)
        self.array = np.zeros(1, BLOCK)
        for name, table in self.tables.items():
            fill_table(self.array, name, table)
        for name, value in camera_scalars(scene).items():
            self.array[name] = value
        self.block = self.array[0]


def placed(**fields):
    """A camera somewhere, turned about all axes."""
    a, b, c = 0.7, -0.4, 2.1
    rotation = (
        np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
        @ np.array([[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]])
        @ np.array([[math.cos(c), 0, math.sin(c)], [0, 1, 0], [-math.sin(c), 0, math.cos(c)]])
    )
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, (3.0, -2.0, 1.5)
    return Camera(matrix, **fields)


def local(camera, ray):
    """(origin, direction) of a ray in camera space."""
    rotation, position = camera.matrix[:3, :3], camera.matrix[:3, 3]
    return rotation.T @ (np.array(ray[0]) - position), rotation.T @ np.array(ray[1])


WINDOW = (-0.3, 0.7, -0.25, 0.35)
PIXELS = [(0.0, 0.0), (160.0, 0.0), (0.0, 90.0), (160.0, 90.0), (80.0, 45.0), (12.25, 71.5)]


@pytest.mark.parametrize("px, py", PIXELS)
def test_perspective(px, py):
    camera = placed(window=WINDOW, clip=(0.5, 20.0))
    packed = Packed(camera)
    ray = camera_ray(packed.block, px, py, 0.5, 0.5)
    origin, direction = local(camera, ray)
    sx, sy = WINDOW[0] + px / 160, WINDOW[2] + 0.6 * py / 90
    np.testing.assert_allclose(origin, 0.0, atol=1e-14)
    np.testing.assert_allclose(direction, np.array([sx, sy, -1.0]) / math.sqrt(sx**2 + sy**2 + 1), atol=1e-14)
    for t, clip in zip(ray[2:], (0.5, 20.0)):
        assert t * -direction[2] == pytest.approx(clip, rel=1e-14)
        point = tuple(np.array(ray[0]) + t * np.array(ray[1]))
        assert view_depth(packed.block, point) == pytest.approx(clip, rel=1e-13)


@pytest.mark.parametrize("px, py", PIXELS)
def test_orthographic(px, py):
    camera = placed(projection=Projection.ORTHOGRAPHIC, window=WINDOW, clip=(0.5, 20.0))
    packed = Packed(camera)
    ray = camera_ray(packed.block, px, py, 0.5, 0.5)
    origin, direction = local(camera, ray)
    np.testing.assert_allclose(origin, [WINDOW[0] + px / 160, WINDOW[2] + 0.6 * py / 90, 0.0], atol=1e-14)
    np.testing.assert_allclose(direction, [0, 0, -1], atol=1e-14)
    assert ray[2:] == (0.5, 20.0)


def test_equirectangular():
    """Longitude grows to the right and is 0 straight ahead; latitude grows upwards; clipping is by radius."""
    camera = placed(projection=Projection.EQUIRECTANGULAR, window=FULL_SPHERE, clip=(0.5, 20.0))
    packed = Packed(camera)
    for (px, py), expected in {
        (80, 45): (0, 0, -1),
        (120, 45): (1, 0, 0),
        (40, 45): (-1, 0, 0),
        (0, 45): (0, 0, 1),
        (80, 90): (0, 1, 0),
        (80, 0): (0, -1, 0),
        (100, 67.5): (0.5, math.sqrt(0.5), -0.5),
    }.items():
        ray = camera_ray(packed.block, px, py, 0.5, 0.5)
        np.testing.assert_allclose(local(camera, ray)[1], expected, atol=1e-14)
        assert ray[2:] == (0.5, 20.0)
        point = tuple(np.array(ray[0]) + 3.0 * np.array(ray[1]))
        assert view_depth(packed.block, point) == pytest.approx(3.0, rel=1e-14)


def test_limits_of_a_panorama():
    camera = Camera(np.eye(4), Projection.EQUIRECTANGULAR, (-1.0, 0.5, -0.2, 0.6))
    packed = Packed(camera)
    for px, py, longitude, latitude in ((0, 0, -1.0, -0.2), (160, 90, 0.5, 0.6), (80, 45, -0.25, 0.2)):
        direction = camera_ray(packed.block, px, py, 0.5, 0.5)[1]
        assert math.atan2(direction[0], -direction[2]) == pytest.approx(longitude)
        assert math.asin(direction[1]) == pytest.approx(latitude)


@pytest.mark.parametrize("projection", list(Projection))
def test_depth_of_field(projection):
    """Rays of one film point meet where the pinhole's ray is in focus; their origins fill the lens, across the axis."""
    fields = dict(projection=projection, window=WINDOW, focus=4.0, lens=(0.0, -0.9, 0.0, 0.01, 0.0))
    is_panorama = projection >= Projection.EQUIRECTANGULAR
    sharp, camera = placed(**fields), placed(aperture=0.3, **fields)
    pinhole, lens = Packed(sharp), Packed(camera)
    for px, py in PIXELS[:4] + PIXELS[5:]:
        origin, direction = local(sharp, camera_ray(pinhole.block, px, py, 0.5, 0.5))
        along = 1.0 if is_panorama else -direction[2]
        focus = origin + direction * 4.0 / along
        for u1, u2 in ((0.0, 0.0), (0.9, 0.2), (0.5, 0.99)):
            start, towards = local(camera, camera_ray(lens.block, px, py, u1, u2))
            to_focus = focus - start
            np.testing.assert_allclose(towards, to_focus / np.linalg.norm(to_focus), atol=1e-13)
            offset = start - origin
            assert np.linalg.norm(offset) <= 0.3 + 1e-12
            axis = direction if is_panorama else np.array([0, 0, -1.0])
            assert abs(offset @ axis) < 1e-13
        assert np.linalg.norm(local(camera, camera_ray(lens.block, px, py, 0.0, 0.0))[0] - origin) == pytest.approx(0.3)


def test_panorama_with_a_lens_at_the_poles():
    camera = Camera(np.eye(4), Projection.EQUIRECTANGULAR, FULL_SPHERE, aperture=0.2)
    packed = Packed(camera)
    for py in (0.0, 90.0):
        origin, direction, _, _ = camera_ray(packed.block, 80.0, py, 0.8, 0.3)
        assert np.isfinite(origin + direction).all() and np.linalg.norm(direction) == pytest.approx(1.0)


SIDE = 256


@kernel
def _lens(blades, rotation, u, out):
    for i in range(len(u)):
        out[i] = sample_blades(blades, rotation, u[i, 0], u[i, 1]) if blades > 0 else disk_point(u[i, 0], u[i, 1])


def lens_points(blades, rotation=0.0, side=SIDE):
    """Images of the centres of a grid of equal cells: an area-preserving map makes their density even."""
    centre = (np.arange(side) + 0.5) / side
    u = np.stack(np.meshgrid(centre, centre), axis=-1).reshape(-1, 2)
    out = np.zeros_like(u)
    _lens(blades, rotation, u, out)
    return out


def test_disk_is_uniform():
    p = lens_points(0)
    radius = np.hypot(*p.T)
    assert radius.max() <= 1.0
    assert np.mean(radius**2) == pytest.approx(0.5, abs=1e-4)
    # The map keeps squares about the centre together, so the distribution has steps of one ring of cells.
    assert stats.kstest(radius**2, "uniform").statistic < 2 / SIDE
    assert stats.kstest(np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi) + 0.5, "uniform").statistic < 0.005


@pytest.mark.parametrize("blades", [3, 5, 8])
def test_polygon_is_uniform(blades):
    rotation = 0.3
    p = lens_points(blades, rotation)
    half = math.pi / blades
    normals = rotation + 2 * half * np.arange(blades)
    reach = p @ np.array([np.cos(normals), np.sin(normals)])
    assert reach.max() <= math.cos(half) + 1e-12 and reach.max() > math.cos(half) - 1e-3
    # Second moment of a regular polygon of circumradius 1 about its centre: (2 + cos 2π/n) / 6.
    assert np.mean(np.sum(p**2, axis=1)) == pytest.approx((2 + math.cos(2 * half)) / 6, abs=1e-4)
    np.testing.assert_allclose(p.mean(axis=0), 0.0, atol=1e-3)
    inner = np.hypot(*p.T) < 0.3
    area = blades / 2 * math.sin(2 * half)
    assert inner.mean() == pytest.approx(math.pi * 0.09 / area, abs=2e-3)


def test_ratio_narrows_the_lens_along_x():
    fields = dict(window=WINDOW, aperture=0.3)
    lenses = [Packed(Camera(np.eye(4), blade_ratio=ratio, **fields)) for ratio in (1.0, 2.0)]
    a, b = (camera_ray(packed.block, 80.0, 45.0, 0.8, 0.3)[0] for packed in lenses)
    assert b == pytest.approx((a[0] / 2, a[1], 0.0))


FILTERS = [
    (Filter.BOX, 1.5),
    (Filter.GAUSSIAN, 1.5),
    (Filter.GAUSSIAN, 0.4),
    (Filter.BLACKMAN_HARRIS, 1.5),
    (Filter.BLACKMAN_HARRIS, 3.0),
]


def filter_cdf(settings, x):
    """Exact distribution function of the filter along one axis."""
    radius = filter_radius(settings)
    if settings.filter is Filter.BOX:
        return x + 0.5
    if settings.filter is Filter.GAUSSIAN:
        sigma = settings.filter_width / 4
        return 0.5 + 0.5 * special.erf(x / (sigma * math.sqrt(2))) / special.erf(radius / (sigma * math.sqrt(2)))
    a = 0.35875, 0.48829, 0.14128, 0.01168
    s = x / radius  # the window is even about its peak: Σ a_k cos(k π s)
    return 0.5 + 0.5 * s + sum(a[k] * np.sin(k * np.pi * s) / (k * np.pi) for k in (1, 2, 3)) / (2 * a[0])


@pytest.mark.parametrize("kind, width", FILTERS)
def test_table_inverts_the_filter(kind, width):
    settings = Settings(filter=kind, filter_width=width)
    offsets = filter_inverse_cdf(settings)
    assert len(offsets) == FILTER_CELLS + 1
    assert offsets[-1] == -offsets[0] == filter_radius(settings)
    np.testing.assert_allclose(filter_cdf(settings, offsets), np.linspace(0, 1, FILTER_CELLS + 1), atol=2e-7)


@pytest.mark.parametrize("kind, width", FILTERS)
def test_an_edge_is_blurred_as_the_filter_says(kind, width):
    """A step edge at distance e from a pixel's centre covers it by the filter's distribution function at e."""
    settings = Settings(filter=kind, filter_width=width)
    packed = Packed(Camera(np.eye(4)), filter=kind, filter_width=width)
    u = (np.arange(4000) + 0.5) / 4000
    x = np.array([filter_offset(packed.block, value, 0.25) for value in u])
    assert np.all(x[:, 1] == x[0, 1])
    for edge in np.array([-0.8, -0.3, -0.05, 0.0, 0.2, 0.6]) * filter_radius(settings):
        assert np.mean(x[:, 0] < edge) == pytest.approx(filter_cdf(settings, edge), abs=1.5e-3)


def test_widths_are_those_of_cycles():
    """Box: one pixel whatever the width. Gaussian: exp(−8 x²/w²) cut at 1.5 w. Blackman–Harris: support 2 w."""
    assert filter_radius(Settings(filter=Filter.BOX, filter_width=3.0)) == 0.5
    gauss = Settings(filter=Filter.GAUSSIAN, filter_width=2.0)
    assert filter_radius(gauss) == 3.0
    assert filter_weight(gauss, np.array([1.0]))[0] == pytest.approx(math.exp(-2.0))
    window = Settings(filter=Filter.BLACKMAN_HARRIS, filter_width=1.5)
    assert filter_radius(window) == 1.5
    assert filter_weight(window, np.array([0.0, 1.5, 1.6])) == pytest.approx([1.0, 6e-5, 0.0], abs=1e-9)


def test_pixel_angle():
    assert camera_scalars(Scene(Camera(np.eye(4), window=WINDOW), 100, 60))["camera_pixel_angle"] == pytest.approx(0.01)
    assert camera_scalars(Scene(Camera(np.eye(4), Projection.ORTHOGRAPHIC), 100, 60))["camera_pixel_angle"] == 0.0
    panorama = Scene(Camera(np.eye(4), Projection.EQUIRECTANGULAR, FULL_SPHERE), 100, 50)
    assert camera_scalars(panorama)["camera_pixel_angle"] == pytest.approx(2 * math.pi / 100)


LENS = (0.0, -0.9, 0.1, -0.02, 0.01)
# x, y of the window, longitude to the right and latitude of the ray there, worked out by hand; None: there is nothing.
RAYS = {
    Projection.FISHEYE_EQUIDISTANT: [(0.7, 0.0, 0.7, 0.0), (0.0, -0.5, 0.0, -0.5), (1.3, 0.0, None, None)],
    Projection.FISHEYE_EQUISOLID: [
        (math.sin(0.35), 0.0, 0.7, 0.0),
        (0.0, -math.sin(0.25), 0.0, -0.5),
        (math.sin(0.65), 0.0, None, None),
    ],
    Projection.FISHEYE_POLYNOMIAL: [
        (0.5, 0.0, 0.45 - 0.025 + 0.0025 - 0.000625, 0.0),
        (0.0, 0.5, 0.0, 0.45 - 0.025 + 0.0025 - 0.000625),
        (2.0, 0.0, None, None),
    ],
    Projection.MIRROR_BALL: [(math.sin(0.35), 0.0, 0.7, 0.0), (0.0, 0.5, 0.0, math.pi / 3), (0.8, 0.8, None, None)],
    Projection.CUBEMAP_FACE: [(0.5, 0.0, 0.5, 0.0), (0.0, -0.4, 0.0, -0.4)],
    Projection.CYLINDER: [(2.0, 0.0, 2.0, 0.0), (-1.0, 0.7, -1.0, math.atan(0.7))],
}


@pytest.mark.parametrize("projection", RAYS)
def test_panoramas(projection):
    """One pixel of a frame of 100 × 100 is 0.04 units of the window here."""
    camera = placed(projection=projection, window=(-2.0, 2.0, -2.0, 2.0), field=2.4, lens=LENS)
    packed = Packed(camera, 100, 100)
    for x, y, longitude, latitude in RAYS[projection]:
        ray = camera_ray(packed.block, 25.0 * (x + 2.0), 25.0 * (y + 2.0), 0.5, 0.5)
        if longitude is None:
            assert ray[3] < 0.0
            continue
        direction = local(camera, ray)[1]
        assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-12) and ray[2:] == camera.clip
        assert math.atan2(direction[0], -direction[2]) == pytest.approx(longitude, abs=1e-9)
        assert math.asin(direction[1]) == pytest.approx(latitude, abs=1e-9)


@pytest.mark.parametrize("eye", [None, Eye(0.03), Eye(-0.03, 2.0), Eye(0.05, 1.5, (0.4, 0.9))])
@pytest.mark.parametrize("projection", [kind for kind in Projection if kind >= Projection.EQUIRECTANGULAR])
def test_panoramas_of_both_renderers(projection, eye):
    """The NumPy reference, which shares no code with it, has the same rays."""
    camera = placed(projection=projection, window=(-1.4, 1.5, -1.3, 1.2), field=2.6, lens=LENS, eye=eye)
    settings = dict(filter=Filter.BOX)
    reference = ReferenceCamera(Scene(camera, 24, 20, settings=Settings(**settings)))
    reference.filter_offsets = lambda rng, count: np.zeros((count, 2))
    y, x = map(np.ravel, np.mgrid[0:20, 0:24])
    origins, directions, near, far = reference.rays(x, y, None)
    packed = Packed(camera, 24, 20, **settings)
    found = [camera_ray(packed.block, a + 0.5, b + 0.5, 0.5, 0.5) for a, b in zip(x, y)]
    np.testing.assert_allclose([ray[3] for ray in found], far)
    seen = far > 0.0
    assert seen.any() and (projection not in RAYS or projection >= Projection.CUBEMAP_FACE or not seen.all())
    for values, index in ((origins, 0), (directions, 1)):
        np.testing.assert_allclose(np.array([ray[index] for ray in found])[seen], values[seen], atol=1e-12)
    scene = Scene(camera, 24, 20)
    assert camera_scalars(scene)["camera_pixel_angle"] == pytest.approx(reference.pixel_angle, rel=1e-4)


@pytest.mark.parametrize("projection", [kind for kind in Projection if kind >= Projection.EQUIRECTANGULAR])
def test_places_in_panoramas(projection):
    """What the window shows at a point has its place there, in both renderers."""
    camera = Camera(np.eye(4), projection, (-0.7, 0.65, -0.6, 0.62), field=6.0, lens=LENS)
    packed, reference = Packed(camera, 12, 10), ReferenceCamera(Scene(camera, 12, 10))
    for px, py in np.ndindex(13, 11):
        direction = np.array(camera_ray(packed.block, float(px), float(py), 0.5, 0.5)[1])
        x, y, z = 3.0 * direction * (1.0, 1.0, -1.0)
        place = panorama_place(packed.tables["camera"][0], x, y, z)
        assert place == pytest.approx((1.35 * px / 12 - 0.7, 1.22 * py / 10 - 0.6), abs=1e-9)
        frame = reference.window_place(3.0 * direction[None])
        assert (frame[0][0], frame[1][0]) == pytest.approx((px / 12, py / 10), abs=1e-9)


def test_eyes_stand_apart_and_see_the_same_where_they_converge():
    eyes = [
        Packed(Camera(np.eye(4), Projection.EQUIRECTANGULAR, FULL_SPHERE, eye=Eye(offset, 2.0)))
        for offset in (-0.1, 0.1)
    ]
    rays = [camera_ray(packed.block, 80.0, 45.0, 0.5, 0.5) for packed in eyes]
    np.testing.assert_allclose([ray[0] for ray in rays], [[-0.1, 0, 0], [0.1, 0, 0]], atol=1e-12)
    for origin, direction, *_ in rays:
        met = np.array(origin) - origin[0] / direction[0] * np.array(direction)
        np.testing.assert_allclose(met, [0, 0, -2.0], atol=1e-12)
