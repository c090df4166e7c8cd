# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps as the viewport draws them, against the path tracer's direct view of the same lamps."""

import bpy
import gpu
import numpy as np
import pytest

from sdf_lights.render import session
from sdf_lights.render.scene import Camera, Lamp, Scene
from sdf_lights.render.settings import Filter, Settings
from sdf_lights.sdf import formula as f
from sdf_lights.sdf.shapes import Box, Sphere, Torus, Union
from tests.sdf import samples

pytestmark = pytest.mark.skipif(
    not hasattr(gpu, "init"), reason=f"Blender {bpy.app.version_string} draws in a window alone")

SIZE, FINER = 48, 4
SAMPLES = 64
NEAR, FAR = 0.05, 1000.0


@pytest.fixture(scope="module")
def painter():
    gpu.init()
    from sdf_lights.blender.viewport.painter import Painter

    return Painter()


def looking_at(low: np.ndarray, high: np.ndarray, direction=(0.5, -0.8, 0.4)) -> tuple[np.ndarray, float]:
    """Camera to world (4, 4), and half the window at distance 1, of a camera that sees all of a box."""
    center, radius = 0.5 * (low + high), 0.5 * np.linalg.norm(high - low)
    back = np.array(direction) / np.linalg.norm(direction)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    matrix[:3, 3] = center + 4.0 * radius * back
    return matrix, 0.27


def traced(lamp: Lamp, camera: np.ndarray, half: float) -> np.ndarray:
    settings = Settings(
        samples=SAMPLES, noise_threshold=0.0, max_bounces=0, filter=Filter.BOX, filter_width=1.0, threads=2)
    scene = Scene(
        Camera(camera, window=(-half, half, -half, half), clip=(NEAR, FAR)), SIZE, SIZE, lamps=[lamp],
        settings=settings)
    return session.render(scene, ()).read("Combined")[..., :3].astype(np.float64)


def drawn(painter, lamp: Lamp, camera: np.ndarray, half: float, size: int = SIZE * FINER, depth=None) -> np.ndarray:
    """The proxy, with ``FINER``² points in a pixel, (SIZE, SIZE, 3)."""
    from sdf_lights.blender.viewport import painter as painting
    from sdf_lights.blender.viewport.facts import FactFinder

    facts = FactFinder().find("", lamp.shape, wait=True)
    assert not facts.problem
    painter.compile(lamp)
    assert not painter.problem(lamp)
    projection = np.array([
        [1.0 / half, 0.0, 0.0, 0.0], [0.0, 1.0 / half, 0.0, 0.0],
        [0.0, 0.0, -(FAR + NEAR) / (FAR - NEAR), -2.0 * FAR * NEAR / (FAR - NEAR)], [0.0, 0.0, -1.0, 0.0]])
    view = painting.View(np.linalg.inv(camera), projection, (size, size))
    glow, mask = (gpu.types.GPUTexture((size, size), format=kind) for kind in ("RGBA32F", "RGBA8"))
    buffer = gpu.types.GPUFrameBuffer(color_slots=(glow, mask))
    with buffer.bind():
        buffer.clear(color=(0.0, 0.0, 0.0, 0.0))
        painter.draw([painting.Drawn(lamp, facts)], view, depth)
    values = glow.read()
    values.dimensions = size * size * 4
    picture = np.array(values, np.float64).reshape(size, size, 4)[..., :3]
    finer = size // SIZE
    return picture.reshape(SIZE, finer, SIZE, finer, 3).mean(axis=(1, 3))


def difference(painter, shape, matrix=None) -> float:
    """Mean absolute difference of proxy and path tracer, as a part of the mean."""
    matrix = np.eye(4) if matrix is None else matrix
    lamp = Lamp("Lamp", shape, matrix, power=100.0, color=(1.0, 0.6, 0.3))
    camera, half = looking_at(*shape.bounds(matrix))
    expected = traced(lamp, camera, half)
    found = drawn(painter, lamp, camera, half)
    assert expected.mean() > 0.0
    return np.abs(found - expected).mean() / expected.mean()


QUICK = ["sphere", "torus", "box_frame", "gyroid", "menger_sponge", "smooth union", "twisted"]
BOUNDED = [name for name, shape in samples.SHAPES_TO_TRY.items() if np.isfinite(shape.bounds()).all()]


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in BOUNDED])
def test_looks_as_in_the_render(painter, name):
    assert difference(painter, samples.SHAPES_TO_TRY[name]) < 0.02
