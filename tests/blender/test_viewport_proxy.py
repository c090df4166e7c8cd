# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps as the viewport draws them, against the path tracer's direct view of the same lamps."""

from typing import NamedTuple

import bpy
import gpu
import numpy as np
import pytest

from sdf_lights.blender.viewport.facts import FactFinder
from sdf_lights.render import session
from sdf_lights.render.scene import Camera, Lamp, Scene
from sdf_lights.render.settings import Filter, Settings
from sdf_lights.sdf.data.outline import Outline
from sdf_lights.sdf.data.tube import Tube
from sdf_lights.sdf.emission import EmissionExpression
from sdf_lights.sdf.emission_presets import presets
from sdf_lights.sdf.resolver import Arrays
from sdf_lights.sdf.shapes import SHAPES, Box, Sphere, Torus, Union
from sdf_lights.sdf.shapes.swept import Extrusion
from support.shapes import samples

pytestmark = pytest.mark.skipif(
    not hasattr(gpu, "init"), reason=f"Blender {bpy.app.version_string} draws in a window alone"
)

SIZE = 48
NEAR, FAR = 0.05, 1000.0


class Points(NamedTuple):
    """Points in a pixel: of the proxy ``finer``², of the path tracer ``samples``."""

    finer: int
    samples: int


USUAL, MANY = Points(4, 64), Points(8, 256)


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


def traced(lamp: Lamp, camera: np.ndarray, half: float, samples: int) -> np.ndarray:
    settings = Settings(
        samples=samples, noise_threshold=0.0, max_bounces=0, filter=Filter.BOX, filter_width=1.0, threads=2
    )
    scene = Scene(
        Camera(camera, window=(-half, half, -half, half), clip=(NEAR, FAR)), SIZE, SIZE, lamps=[lamp], settings=settings
    )
    return session.render(scene, ()).read("Combined")[..., :3].astype(np.float64)


def drawn(painter, lamp: Lamp, camera: np.ndarray, half: float, finer: int = USUAL.finer, depth=None) -> np.ndarray:
    """The proxy, (SIZE, SIZE, 3)."""
    from sdf_lights.blender.viewport import painter as painting

    facts = FactFinder().find("", lamp.shape, lamp.emission, wait=True)
    assert not facts.problem
    painter.compile(lamp)
    assert not painter.problem(lamp)
    projection = np.array(
        [
            [1.0 / half, 0.0, 0.0, 0.0],
            [0.0, 1.0 / half, 0.0, 0.0],
            [0.0, 0.0, -(FAR + NEAR) / (FAR - NEAR), -2.0 * FAR * NEAR / (FAR - NEAR)],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )
    size = SIZE * finer
    view = painting.View(np.linalg.inv(camera), projection, (size, size))
    glow, mask = (gpu.types.GPUTexture((size, size), format=kind) for kind in ("RGBA32F", "RGBA8"))
    buffer = gpu.types.GPUFrameBuffer(color_slots=(glow, mask))
    with buffer.bind():
        buffer.clear(color=(0.0, 0.0, 0.0, 0.0))
        painter.draw([painting.Drawn(lamp, facts)], view, depth)
    values = glow.read()
    values.dimensions = size * size * 4
    picture = np.array(values, np.float64).reshape(size, size, 4)[..., :3]
    return picture.reshape(SIZE, finer, SIZE, finer, 3).mean(axis=(1, 3))


def difference(painter, shape, emission=None, points: Points = USUAL) -> float:
    """Mean absolute difference of proxy and path tracer, as a part of the mean."""
    matrix = np.eye(4)
    lamp = Lamp("Lamp", shape, matrix, power=100.0, color=(1.0, 0.6, 0.3), emission=emission)
    camera, half = looking_at(*shape.bounds(matrix))
    expected = traced(lamp, camera, half, points.samples)
    found = drawn(painter, lamp, camera, half, points.finer)
    assert expected.mean() > 0.0
    return np.abs(found - expected).mean() / expected.mean()


QUICK = ["sphere", "torus", "box_frame", "gyroid", "menger_sponge", "smooth union", "twisted"]
BOUNDED = [
    name
    for name, shape in samples.SHAPES_TO_TRY.items()
    if (name in SHAPES or name in QUICK) and np.isfinite(shape.bounds()).all()
]
# A pixel has so many edges that the usual points alone differ by 2 % from more of them, in either picture.
DUST = {"sierpinski_tetrahedron", "mandelbox"}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK)) for name in BOUNDED]
)
def test_looks_as_in_the_render(painter, name):
    assert difference(painter, samples.SHAPES_TO_TRY[name], points=MANY if name in DUST else USUAL) < 0.02


_TURN = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
_RING = np.column_stack([np.cos(_TURN), np.sin(_TURN)]) * (0.4 + 0.1 * np.cos(4.0 * _TURN))[:, None]


@pytest.mark.parametrize(
    "shape",
    [
        Extrusion(Outline.of([_RING, 0.4 * _RING]), 0.2, 0.02),
        Union(Tube.of([(np.column_stack([_RING, _TURN / 9.0]), 0.05 + _TURN / 99.0, False)]), Sphere(0.2)),
    ],
    ids=["outline", "tube"],
)
@pytest.mark.parametrize("name", ["", "skin"])
def test_shapes_of_tables_look_as_in_the_render(painter, shape, name):
    assert difference(painter, shape, EmissionExpression(EMISSIONS[name]).emission() if name else None) < 0.03


@pytest.mark.parametrize("text", ["ramp(along, 0, (1, 0, 0), 1, (0, 0.2, 1))", "image_color('Stripes', u, v)"])
def test_colours_along_a_curve_and_of_a_picture_look_as_in_the_render(painter, text):
    stripes = np.kron([[(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]], np.ones((8, 8, 1)))
    emission = EmissionExpression(text).emission(resolver=Arrays(images={"Stripes": stripes}))
    path = np.column_stack([_RING, _TURN / 9.0])
    assert difference(painter, Union(Tube.of([(path, 0.1, False)]), Sphere(0.2)), emission) < 0.03


EMISSIONS = {
    "even": "(2, 1, 0.5)",
    "height": "height",
    "skin": "exp(-12 * depth)",
    "waves": "1 + sin(25 * p.x)",
    "ramp": "exp(-4 * depth) * ramp(height, 0, (1, 0.2, 0), 0.4, (1, 0.8, 0.4), 1, (0.1, 0.2, 1))",
    "negative": "p.x",
} | {name: preset.text for name, preset in presets().items()}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name not in ("even", "ramp", "waves"))) for name in EMISSIONS],
)
@pytest.mark.parametrize("shape", [Torus(0.6, 0.25), samples.SHAPES_TO_TRY["smooth union"]], ids=["torus", "union"])
def test_emission_glows_as_in_the_render(painter, shape, name):
    emission = EmissionExpression(EMISSIONS[name]).emission()
    assert difference(painter, shape, emission) < 0.02


def test_a_dark_emission_is_told(painter):
    for text in ("0", "-1 - depth"):
        facts = FactFinder().find("", Sphere(1.0), EmissionExpression(text).emission(), wait=True)
        assert "emission is zero" in facts.problem


MATRICES = {
    "scaled": np.diag([2.0, 0.5, 1.0, 1.0]),
    "mirrored": np.diag([-1.0, 1.0, 1.0, 1.0]),
    "sheared": np.array([[1.0, 0.6, 0.0, 0.3], [0.0, 1.0, 0.0, -0.2], [0.2, 0.0, 1.5, 0.1], [0.0, 0.0, 0.0, 1.0]]),
    "far away": np.array([[1.0, 0.0, 0.0, 1e4], [0.0, 1.0, 0.0, -1e4], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]),
}


def center(picture: np.ndarray) -> float:
    return picture[SIZE // 2 - 1 : SIZE // 2 + 1, SIZE // 2 - 1 : SIZE // 2 + 1, 0].mean()


def chords(painter, matrix, depth=None, distance: float = 4.0, radius: float = 0.5) -> np.ndarray:
    """Lengths inside a ball at the origin, looked at along −z from that distance."""
    camera = np.eye(4)
    camera[2, 3] = distance
    return drawn(painter, Lamp("Ball", Sphere(radius), matrix, density=1.0), camera, 0.2, depth=depth)


@pytest.mark.parametrize("name", MATRICES)
def test_lengths_are_those_of_the_world(painter, name):
    """The length inside along the line of sight through the centre of an ellipsoid."""
    matrix = MATRICES[name]
    camera = np.eye(4)
    camera[:3, 3] = matrix[:3, 3] + (0.0, 0.0, 5.0)
    found = drawn(painter, Lamp("Ball", Sphere(0.5), matrix, density=1.0), camera, 0.2)
    direction = np.linalg.inv(matrix)[:3, :3] @ (0.0, 0.0, 1.0)
    assert center(found) == pytest.approx(1.0 / np.linalg.norm(direction), rel=5e-3)


def test_eye_inside_a_lamp(painter):
    assert center(chords(painter, np.eye(4), distance=0.0)) == pytest.approx(0.5 - NEAR, rel=1e-3)


def test_objects_end_the_light(painter):
    """A depth buffer in which a plane at the ball's centre covers the left half."""
    from sdf_lights.blender.viewport.painter import Depth

    size = SIZE * USUAL.finer
    ndc = (FAR + NEAR) / (FAR - NEAR) - 2.0 * FAR * NEAR / (FAR - NEAR) / 4.0
    values = np.ones((size, size), np.float32)
    values[:, : size // 2] = 0.5 * ndc + 0.5
    texture = gpu.types.GPUTexture(
        (size, size), format="R32F", data=gpu.types.Buffer("FLOAT", values.size, values.ravel())
    )
    found = chords(painter, np.eye(4), Depth(texture, (0, 0), 1.0))[SIZE // 2, :, 0]
    assert found[SIZE // 2 - 2] == pytest.approx(0.5, rel=0.02)
    assert found[SIZE // 2 + 1] == pytest.approx(1.0, rel=0.02)


def test_numbers_compile_nothing(painter):
    lamps = [Lamp("Ring", Torus(0.5, radius), np.eye(4)) for radius in (0.1, 0.2)]
    painter.compile(lamps[0])
    assert painter.is_compiled(lamps[1])
    assert not painter.is_compiled(Lamp("Other", Union(Torus(), Box(), Sphere(0.1), Torus()), np.eye(4)))


def test_too_many_numbers_are_told(painter):
    shape = Union(*(Sphere(0.1) for _ in range(5000)))
    lamp = Lamp("Many", shape, np.eye(4))
    painter.compile(lamp)
    assert "5,000 numbers" in painter.problem(lamp)


def test_facts_that_take_time_are_estimated_first(painter):
    news = []
    finder, shape = FactFinder(lambda: news.append(True)), samples.SHAPES_TO_TRY["gyroid"]
    estimate = finder.find("Lamp", shape)
    assert np.all(estimate.low <= estimate.high) and estimate.volume > 0.0
    finder._thread.join()
    assert news and not finder.busy
    measured = finder.find("Lamp", shape)
    assert measured.volume == pytest.approx(finder.find("Other", shape, wait=True).volume)
    unbounded = finder.find("Endless", samples.SHAPES_TO_TRY["half_space"], wait=True)
    assert "no limits" in unbounded.problem
