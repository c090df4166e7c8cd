# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Value nodes against NumPy: images, mapping, normal maps, bump."""

import numpy as np
import pytest

from sdf_lights.render.material import Node
from tests.render.shading.surfaces import Surface

PIXELS = np.random.default_rng(1).random((5, 7, 4)).astype(np.float32)
WRAPS = {
    "REPEAT": lambda i, n: i % n,
    "EXTEND": lambda i, n: np.clip(i, 0, n - 1),
    "CLIP": lambda i, n: np.where((i >= 0) & (i < n), i, -1),
    "MIRROR": lambda i, n: np.where(i % (2 * n) < n, i % (2 * n), 2 * n - 1 - i % (2 * n)),
}


def emitted(value, images=(PIXELS,), **fields):
    surface = Surface(Node("emission", {"color": value}), images)
    return np.array(surface.shade(1.0, **fields).hit["emission"])


def at(u, v):
    return {"uv": np.tile((u, v), (4, 1))}


def reference_lookup(pixels, u, v, interpolation, extension):
    height, width, _ = pixels.shape
    x, y = u * width, v * height
    if interpolation == "Closest":
        columns, rows, wx, wy = [np.floor(x)], [np.floor(y)], [1.0], [1.0]
    else:
        x, y = x - 0.5, y - 0.5
        s, t = x - np.floor(x), y - np.floor(y)
        offsets, weights = ([0, 1], lambda t: [1 - t, t]) if interpolation == "Linear" else ([-1, 0, 1, 2], _spline)
        columns, rows = [np.floor(x) + o for o in offsets], [np.floor(y) + o for o in offsets]
        wx, wy = weights(s), weights(t)
    wrap, total = WRAPS[extension], np.zeros(4)
    for row, b in zip(rows, wy):
        for column, a in zip(columns, wx):
            i, j = int(wrap(int(column), width)), int(wrap(int(row), height))
            if i >= 0 and j >= 0:
                total += a * b * pixels[j, i]
    return total


def _spline(t):
    """Uniform cubic B-spline by de Boor's recursion on the four neighbouring knots."""
    knots = np.arange(-3.0, 5.0)
    basis = [1.0 if knots[i] <= t < knots[i + 1] else 0.0 for i in range(7)]
    for k in range(1, 4):
        basis = [
            (t - knots[i]) / k * basis[i] + (knots[i + k + 1] - t) / k * basis[i + 1] for i in range(len(basis) - 1)]
    return basis


@pytest.mark.parametrize("extension", WRAPS)
@pytest.mark.parametrize("interpolation", ["Linear", "Closest", "Cubic"])
def test_image_lookup(interpolation, extension):
    settings = {"image": 0, "interpolation": interpolation, "extension": extension}
    color = Surface(Node("emission", {"color": Node("image", {}, settings)}), [PIXELS])
    alpha = Surface(Node("emission", {"color": Node("image", {}, {**settings, "output": "alpha"})}), [PIXELS])
    for u, v in np.random.default_rng(2).uniform(-2.2, 3.2, (60, 2)):
        expected = reference_lookup(PIXELS, u, v, interpolation, extension)
        np.testing.assert_allclose(color.shade(1.0, **at(u, v)).hit["emission"], expected[:3], atol=1e-9)
        np.testing.assert_allclose(alpha.shade(1.0, **at(u, v)).hit["emission"], expected[3], atol=1e-9)


def test_associated_colour_is_multiplied_by_alpha():
    node = Node("image", {}, {"image": 0, "interpolation": "Closest", "associated": True})
    np.testing.assert_allclose(emitted(node, **at(0.01, 0.01)), PIXELS[0, 0, :3] * PIXELS[0, 0, 3], rtol=1e-6)


@pytest.mark.parametrize("index", [None, 7, 1])
def test_missing_images_are_magenta(index):
    node = Node("image", {}, {"image": index})
    assert emitted(node, (PIXELS, np.zeros((0, 0, 4)))) == pytest.approx((1.0, 0.0, 1.0))


@pytest.mark.parametrize("uv", [(np.nan, 0.5), (1e300, -1e300), (np.inf, 0.0)])
def test_wild_coordinates_are_harmless(uv):
    for extension in WRAPS:
        assert np.all(np.isfinite(emitted(Node("image", {}, {"image": 0, "extension": extension}), **at(*uv))))


def test_projections():
    flat = emitted(Node("image", {"vector": (0.25, 0.75, 0.0)}, {"image": 0}))
    # The point of the cube's surface that lies at those coordinates of the sphere and of the tube.
    on_sphere = tuple(0.5 + 0.5 * np.array([np.sin(np.pi / 4), 0.0, -np.cos(0.75 * np.pi)]))
    for point, projection in ((on_sphere, "SPHERE"), ((1.0, 0.5, 0.75), "TUBE")):
        node = Node("image", {"vector": point}, {"image": 0, "projection": projection})
        assert emitted(node) == pytest.approx(flat)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR", "NORMAL"])
def test_mapping_by_a_matrix_and_step_by_step_agree(kind):
    inputs = {
        "vector": (0.3, -1.2, 2.0), "location": (0.5, 0.1, -1.0), "rotation": (0.3, -0.8, 2.1),
        "scale": (2.0, 0.5, 1.5)}
    constant = emitted(Node("mapping", inputs, {"type": kind}))
    # An image of one texel makes an input vary without changing its value.
    pixels = np.ones((1, 1, 4), np.float32)
    pixels[..., :3] = inputs["rotation"]
    varying = {**inputs, "rotation": Node("image", {}, {"image": 0})}
    assert emitted(Node("mapping", varying, {"type": kind}), (pixels,)) == pytest.approx(constant, rel=1e-6)


def test_mapping_of_a_point():
    node = Node("mapping", {
        "vector": (1.0, 2.0, 3.0), "location": (0.5, 0.0, -1.0), "rotation": (0.0, 0.0, np.pi / 2),
        "scale": (2.0, 1.0, 1.0)})
    # Scaled to (2, 2, 3), turned about z to (−2, 2, 3), moved.
    assert emitted(node) == pytest.approx((-1.5, 2.0, 2.0))


def test_normal_map_in_tangent_space():
    color = (0.5 + 0.5 * 0.6, 0.5, 0.5 + 0.5 * 0.8)
    surface = Surface(Node("diffuse", {"normal": Node("normal_map", {"color": color})}))
    tangent = np.tile((0.0, 1.0, 0.0, 1.0), (4, 1))
    assert surface.shade(1.0, tangent=tangent).closures[0]["normal"] == pytest.approx((0.0, 0.6, 0.8))
    # Seen from behind, the mapped normal is turned round with the others.
    surface.shade(wo=(0, 0, -1), n=(0, 0, -1), ng=(0, 0, -1), backfacing=True)
    assert surface.closures[0]["normal"] == pytest.approx((0.0, -0.6, -0.8))


def test_normal_map_without_tangents_changes_nothing():
    surface = Surface(Node("diffuse", {"normal": Node("normal_map", {"color": (1.0, 0.5, 0.5)})}))
    assert surface.shade(1.0).closures[0]["normal"] == pytest.approx((0.0, 0.0, 1.0))


def test_object_space_normal_map_turns_with_the_object():
    surface = Surface(Node("diffuse", {"normal": Node("normal_map", {"color": (1.0, 0.5, 0.5)}, {"space": "OBJECT"})}))
    turned = np.zeros((3, 4))
    turned[:, :3] = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]  # world y is the object's x
    assert surface.shade(1.0, world_to_object=turned).closures[0]["normal"] == pytest.approx((0.0, 1.0, 0.0))


@pytest.mark.parametrize("strength, invert", [(1.0, False), (1.0, True), (0.5, False)])
@pytest.mark.parametrize("footprint", [0.0, 0.01])
def test_bump_of_a_ramp_tilts_by_its_slope(strength, invert, footprint):
    ramp = np.zeros((1, 100, 4), np.float32)
    ramp[..., :3] = (np.arange(100.0) / 100.0)[None, :, None]  # height u
    height = Node("image", {}, {"image": 0, "extension": "EXTEND"})
    node = Node("bump", {"height": height, "distance": 0.4, "strength": strength}, {"invert": invert})
    surface = Surface(Node("diffuse", {"normal": node}), [ramp])
    # Two metres a unit of u, on a triangle whose edges are not square: slope 0.4 · 1/2.
    surface.shade(
        1.0, footprint=footprint, dpdu=(2.0, 0.0, 0.0), dpdv=(1.0, 1.0, 0.0), uv_du=np.tile((1.0, 0.0), (4, 1)),
        uv_dv=np.tile((0.5, 1.0), (4, 1)), **at(0.5, 0.5))
    full = np.array([0.2 if invert else -0.2, 0.0, 1.0]) / np.hypot(0.2, 1.0)
    expected = strength * full + (1.0 - strength) * np.array([0.0, 0.0, 1.0])
    assert surface.closures[0]["normal"] == pytest.approx(expected / np.linalg.norm(expected), abs=1e-5)


def test_numbers_from_colours_are_their_luminance():
    node = Node("emission", {"color": (1.0, 1.0, 1.0), "strength": Node("image", {}, {"image": 0})})
    pixels = np.zeros((1, 1, 4), np.float32)
    pixels[..., :3] = (0.5, 0.25, 1.0)
    surface = Surface(node, [pixels]).shade(1.0)
    assert surface.hit["emission"] == pytest.approx([0.2126 * 0.5 + 0.7152 * 0.25 + 0.0722] * 3, rel=1e-6)
