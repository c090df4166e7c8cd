# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of hard lamps compared with easy ones in the same scene: ratios of render time at equal samples.

Huang et al. 2026 report 60 s with a high-frequency field and 12 s with the smooth one, and 20 s with a thin box frame
compared with 10 s with its box, because they reject points. For us the smooth field takes a fifth of the evaluations of
their rule. So with noise the ratio of our own times cannot be compared with theirs. There the evaluations of both are
compared, and the time must not grow more than the evaluations. In a close-up every sample looks through the lamp, and
lights the surface behind it: that is a ray from just before the surface, and one from farther away.
"""

from __future__ import annotations

import functools
import math
import time

import numpy as np

from sdf_lights.emitter.intersection.cover import RESOLUTION
from sdf_lights.render import session
from sdf_lights.render.scene import Camera, Lamp, Scene
from sdf_lights.sdf.shapes import Box, BoxFrame, Shape, Sphere, Transformed
from sdf_lights.sdf.shapes.blends import SmoothUnion
from sdf_lights.sdf.shapes.displacement import NoiseDisplacement
from sdf_lights.sdf.shapes.orbits import Mandelbulb
from support.lamps import oracle
from support.lamps.hard_cases import around
from support.lamps.rays import Traced
from support.lamps.shapes_under_test import FieldOf, moved
from support.rivals import marching
from support.scenes import SCENES, look_at, rotation, translation

from . import Figure, case
from .stage import settings

NOISE, FRAME = 60.0 / 12.0, 20.0 / 10.0  # of the paper
SIZE, QUICK_SIZE = 64, 24
TURNS, QUICK_TURNS = 5, 4
TURN, QUICK_TURN = 3.0, 0.3  # target time in seconds of the additional samples of a turn
FEWEST, MOST = 4, 4096  # additional samples of a turn
RAYS = 1000
COARSE = 1e-3  # shortest step of the paper's rule, relative to the size
CLOSE = 0.02  # distance of a close-up, relative to the size
EYE = np.array([0.36, -0.8, 0.48])  # direction of its camera from the middle of the lamp
HALF_WIDTH = 0.4  # tangent of half its angle of view
STEPS = 100_000  # unit of its distance
MATRIX = translation(0.0, 0.0, 1.8) @ rotation("z", 20.0) @ rotation("x", 35.0)

SMOOTH = SmoothUnion(Transformed(Sphere(0.4), moved(-0.3)), Transformed(Sphere(0.3), moved(0.3, 0.1)), radius=0.3)
# With these numbers the paper's rule takes about five times as long as with the smooth field, as it did there.
NOISY = NoiseDisplacement(SMOOTH, 0.05, 0.2, 3.0)
FINER = NoiseDisplacement(SMOOTH, 0.05, 0.06, 4.0)
FRAME_HALF = (0.6, 0.5, 0.4)
BAR = 0.02


def seconds(scene: Scene, samples: int) -> float:
    """Processor time of a render, of all threads."""
    scene.settings.samples = samples
    started = time.process_time()
    session.render(scene, ("Combined",))
    return time.process_time() - started


def close_camera(shape: Shape) -> Camera:
    """A camera ``CLOSE`` of its size in front of the surface of a lamp with ``MATRIX``, which fills the picture."""
    low, high = shape.bounds()
    center, size = 0.5 * (low + high), float(np.linalg.norm(high - low))
    line = center + np.linspace(size, 0.0, STEPS)[:, None] * EYE
    eye = line[np.argmax(shape.distance(line) <= 0.0)] + CLOSE * size * EYE
    eye, center = (MATRIX[:3, :3] @ point + MATRIX[:3, 3] for point in (eye, center))
    return Camera(look_at(eye, center), window=(-HALF_WIDTH, HALF_WIDTH) * 2, clip=(1e-3 * size, 1e3 * size))


def close_rays(shape: Shape, rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3), (n, 3) rays of ``close_camera`` in the space of the shape."""
    view = np.linalg.inv(MATRIX) @ close_camera(shape).matrix
    toward = np.column_stack([rng.uniform(-HALF_WIDTH, HALF_WIDTH, (count, 2)), np.full(count, -1.0)]) @ view[:3, :3].T
    return np.tile(view[:3, 3], (count, 1)), toward / np.linalg.norm(toward, axis=1, keepdims=True)


def sample_seconds(hard: Shape, easy: Shape, quick: bool, close: bool = False) -> tuple[float, float]:
    """Processor time of an additional sample with one lamp and with the other, in a room.

    Renders with few and with many samples take turns. Other programs only add time, so the least times count.
    ``close``: with pictures that the lamp fills.
    """
    size, turn = (QUICK_SIZE, QUICK_TURN) if quick else (SIZE, TURN)
    few, scenes, more, least = 2, [], [], [[math.inf, math.inf], [math.inf, math.inf]]
    for shape in (hard, easy):
        scene = SCENES["torus_room"](size, size)
        scene.lamps, scene.settings = [Lamp("lamp", shape, MATRIX, 60.0)], settings(1)
        if close:
            scene.camera = close_camera(shape)
        seconds(scene, 1)  # compiles
        each = max(seconds(scene, few + FEWEST) - seconds(scene, few), 1e-9) / FEWEST
        scenes.append(scene)
        more.append(min(max(round(turn / each), FEWEST), MOST))
    for _ in range(QUICK_TURNS if quick else TURNS):
        for scene, further, times in zip(scenes, more, least):
            for column, samples in enumerate((few, few + further)):
                times[column] = min(times[column], seconds(scene, samples))
    return tuple((longer - shorter) / further / size**2 for (shorter, longer), further in zip(least, more))


def compared(hard: Shape, easy: Shape, limit: float, quick: bool, close: bool = False) -> Figure:
    slow, fast = sample_seconds(hard, easy, quick, close)
    return Figure(slow / fast, limit, dict(hard_ns_per_sample=1e9 * slow, easy_ns_per_sample=1e9 * fast))


@functools.lru_cache(maxsize=16)
def evaluations(shape: Shape, close: bool = False) -> dict[str, float]:
    """Evaluations on a ray: of our search, of the paper's rule with our resolution, and of the published rule; and the
    processor time of one evaluation, with all lanes in use. ``close``: every other ray is one of a close-up."""
    traced = Traced(shape)
    origins, toward = around(SMOOTH, np.random.default_rng(5), RAYS)
    if close:
        origins, toward = map(np.concatenate, zip((origins, toward), close_rays(shape, np.random.default_rng(6), RAYS)))
    found = dict(ours=traced.trace(origins, toward)[:, 3].mean())
    for name, least, bound in (("fine", RESOLUTION, oracle.steepness(shape)), ("published", COARSE, 1.0)):
        traced.march(marching.PUBLISHED, origins[:1], toward[:1], least, bound)  # compiles
        started = time.thread_time()
        found[name] = traced.march(marching.PUBLISHED, origins, toward, least, bound)[:, 2].mean()
        found["each"] = (time.thread_time() - started) / len(origins) / found[name]
    return found


def by_evaluations(hard: Shape, quick: bool, close: bool = False) -> Figure:
    """Time relative to that with the smooth field; the limit comes from the number and time of evaluations."""
    costly, cheap = evaluations(hard, close), evaluations(SMOOTH, close)
    figure = compared(hard, SMOOTH, costly["ours"] * costly["each"] / (cheap["ours"] * cheap["each"]), quick, close)
    figure.more["published_time_ratio"] = costly["published"] * costly["each"] / (cheap["published"] * cheap["each"])
    return figure


@case("noise-evaluations")
def noise_evaluations(quick):
    """evaluations on a ray through a noisy field, to those of the paper's rule through the smooth one; 5 in the
    paper"""
    noisy, smooth = evaluations(NOISY), evaluations(SMOOTH)
    return Figure(
        noisy["ours"] / smooth["fine"],
        NOISE,
        dict(ours_to_ours=noisy["ours"] / smooth["ours"], rule_to_rule=noisy["fine"] / smooth["fine"]),
    )


@case("finer-noise-evaluations")
def finer_noise_evaluations(quick):
    """the same with noise three times finer, of one more octave"""
    noisy, smooth = evaluations(FINER), evaluations(SMOOTH)
    return Figure(
        noisy["ours"] / smooth["fine"],
        NOISE,
        dict(ours_to_ours=noisy["ours"] / smooth["ours"], rule_to_rule=noisy["fine"] / smooth["fine"]),
    )


@case("noise-cost", slow=True)
def noise(quick):
    """render time with a noisy field to that with the smooth one: no more than what is evaluated"""
    return by_evaluations(NOISY, quick)


@case("finer-noise-cost", slow=True)
def finer_noise(quick):
    """the same with noise three times finer, of one more octave"""
    return by_evaluations(FINER, quick)


@case("mandelbulb-cost", slow=True)
def mandelbulb(quick):
    """render time with a Mandelbulb to that with the smooth field: no more than what is evaluated"""
    return by_evaluations(Mandelbulb(), quick)


@case("mandelbulb-close-up-cost", slow=True)
def mandelbulb_close_up(quick):
    """the same where the lamp fills the picture, from 1/50 of its size in front of its surface"""
    return by_evaluations(Mandelbulb(), quick, close=True)


@case("sparse-frame-cost", slow=True)
def frame(quick):
    """render time with a thin box frame to that with its box; 20 s to 10 s in the paper"""
    return compared(BoxFrame(FRAME_HALF, BAR), Box(FRAME_HALF), FRAME, quick)


@case("sparse-frame-field-cost", slow=True)
def frame_field(quick):
    """the same where both are traced as fields, as in the paper"""
    return compared(FieldOf(BoxFrame(FRAME_HALF, BAR)), FieldOf(Box(FRAME_HALF)), FRAME, quick)
