# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Look-ups of textures on every back end, against texels that are weighed one by one."""

import itertools

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.render.images import Image, Texture, colors, mean_color
from sdf_lights.render.reference.images import lookup
from sdf_lights.render.scene import Scene

EXTENSIONS = "REPEAT", "EXTEND", "CLIP", "MIRROR"
INTERPOLATIONS = "Linear", "Closest", "Cubic", "Smart"
FORMATS = "u1", "u2", "f2", "f4"
PLACES = np.random.default_rng(2).uniform(-2.2, 3.2, (40, 2))


def image(kind: str = "f4", channels: int = 4, encoded: bool = False, seed: int = 1) -> Image:
    """Five rows of seven texels."""
    pixels = np.random.default_rng(seed).uniform(0.05, 1.0, (5, 7, channels))
    if kind == "f2":
        pixels[0, 0] = 6e-8 * np.arange(1, channels + 1)  # the least numbers of halves
        pixels[1, 1, :3] *= -1000.0
    stored = np.round(pixels * np.iinfo(kind).max) if kind[0] == "u" else pixels
    return Image(kind, stored.astype(kind), encoded)


def decode(code: float) -> float:
    return max(code, 0.0) / 12.92 if code < 0.04045 else ((code + 0.055) / 1.055) ** 2.4


def _spline(t: float) -> list[float]:
    """Uniform cubic B-spline by de Boor's recursion on the four neighbouring knots."""
    knots = np.arange(-3.0, 5.0)
    basis = [1.0 if knots[i] <= t < knots[i + 1] else 0.0 for i in range(7)]
    for k in range(1, 4):
        basis = [
            (t - knots[i]) / k * basis[i] + (knots[i + k + 1] - t) / k * basis[i + 1] for i in range(len(basis) - 1)
        ]
    return basis


def _outside(i: int, size: int, extension: str) -> int | None:
    """Index of the texel that is seen at index i, going from texel to texel; None for no texel."""
    if extension == "CLIP":
        return i if 0 <= i < size else None
    if extension == "EXTEND":
        return sorted((0, i, size - 1))[1]
    way = [*range(size), *reversed(range(size))] if extension == "MIRROR" else [*range(size)]
    return way[i % len(way)]


def expected(
    source: Image, u: float, v: float, interpolation: str, extension: str, straight: bool = False
) -> list[float]:
    pixels = source.pixels.astype(float) / {"u1": 255, "u2": 65535}.get(source.pixels.dtype.str[1:], 1)
    height, width, channels = pixels.shape
    axes = []
    for x, size in ((u, width), (v, height)):
        x *= size
        if interpolation == "Closest":
            axes.append([(int(np.floor(x)), 1.0)])
            continue
        left = int(np.floor(x - 0.5))
        t = x - 0.5 - left
        weights = [(0, 1.0 - t), (1, t)] if interpolation == "Linear" else list(zip(range(-1, 3), _spline(t)))
        axes.append([(left + i, weight) for i, weight in weights])
    total = np.zeros(4)
    for (i, s), (j, t) in itertools.product(*axes):
        column, row = _outside(i, width, extension), _outside(j, height, extension)
        if column is not None and row is not None:
            stored = pixels[row, column]
            total += s * t * np.array([*np.broadcast_to(stored[:3], 3), stored[3] if channels == 4 else 1.0])
    if channels == 1:
        total[3] = 1.0
    if straight and total[3] not in (0.0, 1.0):
        total[:3] /= total[3]
    return [*(map(decode, total[:3]) if source.encoded else total[:3]), total[3]]


if jit.AVAILABLE:
    from sdf_lights.jit import block_dtype, fill_table, kernel
    from sdf_lights.render.kernels import textures

    @kernel
    def _look_up(block, place, uv, found):
        for i in range(len(uv)):
            rgba = textures.texture_lookup(block, block, place, uv[i, 0], uv[i, 1])
            for channel in range(4):
                found[i, channel] = rgba[channel]


def on_cpu(images, texture, uv):
    if not jit.AVAILABLE:
        pytest.skip("Numba is not installed")
    scene = Scene(None, 1, 1, images=images)
    tables = textures.pack_textures(scene, [Texture(), texture])
    block = np.zeros(1, block_dtype(textures.TABLES))
    for name, array in tables.items():
        fill_table(block, name, array)
    found = np.zeros((len(uv), 4))
    _look_up(block[0], 1.0, np.ascontiguousarray(uv), found)
    return found


def by_reference(images, texture, uv):
    return lookup(images, texture, uv[:, 0], uv[:, 1])


def on_gpu(images, texture, uv):
    if not jit.AVAILABLE:
        pytest.skip("Numba is not installed")
    from tests.gpu.support import with_textures

    return with_textures(images, [Texture(), texture], 1, uv)


BACK_ENDS = pytest.mark.parametrize("back_end, tolerance", [(on_cpu, 4e-7), (by_reference, 1e-9), (on_gpu, 2e-4)])


@BACK_ENDS
@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_interpolation_and_extension(back_end, tolerance, interpolation, extension):
    source = image("u1")
    found = back_end([source], Texture(0, interpolation, extension), PLACES)
    truth = [expected(source, u, v, interpolation, extension) for u, v in PLACES]
    np.testing.assert_allclose(found, truth, atol=tolerance, rtol=tolerance)


@BACK_ENDS
@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("encoded", [False, True])
def test_formats(back_end, tolerance, kind, channels, encoded):
    source = image(kind, channels, encoded)
    for texture in Texture(0, "Linear", "CLIP", True), Texture(0, "Closest", "REPEAT"):
        found = back_end([source], texture, PLACES)
        truth = [expected(source, u, v, texture.interpolation, texture.extension, texture.straight) for u, v in PLACES]
        np.testing.assert_allclose(found, truth, atol=tolerance, rtol=max(tolerance, 2e-4 if encoded else 0.0))


@BACK_ENDS
def test_udim_tiles(back_end, tolerance):
    images = [image("u1", seed=seed) for seed in range(3)]
    texture = Texture(0, "Linear", "REPEAT", tiles=((1001, 2), (1012, 0), (1002, 1)))
    places = np.array(
        [[0.3, 0.4], [1.3, 0.9], [1.2, 1.4], [0.2, 1.4], [2.5, 0.5], [10.5, 0.2], [-0.3, 0.3], [-1.5, 0.2], [0.1, -2.0]]
    )
    known = {0: (2, 0.3, 0.4), 1: (1, 0.3, 0.9), 2: (0, 0.2, 0.4), 6: (2, -0.3, 0.3)}
    truth = [
        expected(images[known[i][0]], *known[i][1:], "Linear", "REPEAT") if i in known else (1.0, 0.0, 1.0, 1.0)
        for i in range(len(places))
    ]
    np.testing.assert_allclose(back_end(images, texture, places), truth, atol=tolerance)


@BACK_ENDS
@pytest.mark.parametrize("index", [None, 1, 7])
def test_missing_images_are_magenta(back_end, tolerance, index):
    images = [image(), Image("empty", np.zeros((0, 0, 4)))]
    found = back_end(images, Texture(index, extension="CLIP"), PLACES)
    np.testing.assert_allclose(found, np.tile((1.0, 0.0, 1.0, 1.0), (len(PLACES), 1)))


@pytest.mark.parametrize("back_end", [on_cpu, by_reference])
@pytest.mark.parametrize("extension", EXTENSIONS)
def test_wild_coordinates_are_harmless(back_end, extension):
    wild = np.array([(np.nan, 0.5), (1e300, -1e300), (np.inf, 0.0)])
    for texture in Texture(0, extension=extension), Texture(0, extension=extension, tiles=((1001, 0),)):
        assert np.all(np.isfinite(back_end([image()], texture, wild)))


def test_bytes_are_decoded_exactly():
    """Where texels are not mixed, the table that decodes has the very values."""
    source = Image("ramp", np.arange(256, dtype=np.uint8).reshape(1, 256, 1), True)
    places = np.stack([(np.arange(256) + 0.5) / 256, np.full(256, 0.5)], 1)
    truth = [decode(code / 255.0) for code in range(256)]
    np.testing.assert_allclose(on_cpu([source], Texture(0, "Closest"), places)[:, 0], truth, rtol=1e-6)


@pytest.mark.parametrize("kind", FORMATS)
def test_whole_images(kind):
    for channels, encoded in ((1, True), (3, False), (4, True)):
        source = image(kind, channels, encoded)
        truth = np.array(
            [[expected(source, (x + 0.5) / 7, (y + 0.5) / 5, "Closest", "REPEAT") for x in range(7)] for y in range(5)]
        )
        np.testing.assert_allclose(colors(source), truth[..., :3], rtol=1e-5, atol=1e-7)
        np.testing.assert_allclose(mean_color(source), truth[..., :3].mean((0, 1)), rtol=1e-5)


@pytest.mark.parametrize("shape", [(2, 2), (2, 2, 2), (2, 2, 5), (0, 3, 4)])
def test_pixels_of_other_shapes_are_missing(shape):
    assert colors(Image("odd", np.ones(shape, np.uint8))).tolist() == [[[1.0, 0.0, 1.0]]]
