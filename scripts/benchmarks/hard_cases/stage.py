# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes whose light is known, and their renders, without Blender."""

from __future__ import annotations

import numpy as np

from sdf_lights.emitter.building.build import build_lamp
from sdf_lights.emitter.sampling.similar import similar
from sdf_lights.emitter.tree import interior, moments
from sdf_lights.graph import numpy_evaluation
from sdf_lights.render import session
from sdf_lights.render.scene import Camera, Instance, Lamp, Projection, Scene
from sdf_lights.render.settings import Device, Filter, LampSampling, Settings
from support.scenes import diffuse, look_at, quad, scaling, translation

from . import Figure

ALBEDO = 0.8
STANDARD_ERRORS = 4.0  # standard errors by which a mean may be off; the probability of more is 1 in 16,000
FLOAT32 = 2.0**-24  # relative rounding
FILL_POINTS = 32  # random points in each box, for the fraction of boxes that is inside


def settings(samples: int, seed: int = 0, sampling: LampSampling = LampSampling.CUT, bounces: int = 0) -> Settings:
    """Plain means of as many ``samples`` for each pixel, on the processor."""
    return Settings(
        device=Device.CPU,
        samples=samples,
        seed=seed,
        noise_threshold=0.0,
        lamp_sampling=sampling,
        guided_samples=False,
        filter=Filter.BOX,
        max_bounces=bounces,
        diffuse_bounces=bounces,
        glossy_bounces=bounces,
    )


def from_above(at, height: float, width: float) -> Camera:
    """Orthographic camera, ``height`` above the point ``at`` or below it, that sees a square of ``width`` metres of a
    floor."""
    half = 0.5 * width
    eye = np.asarray(at, float) + (0.0, 0.0, height)
    return Camera(
        look_at(eye, at, (0.0, 1.0, 0.0)),
        Projection.ORTHOGRAPHIC,
        (-half, half, -half, half),
        (1e-3 * abs(height), 2.0 * abs(height)),
    )


def floor(camera: Camera, pixels: int, at, half: float, lamps: list[Lamp], settings: Settings) -> Scene:
    """A horizontal diffuse square of half size ``half`` around ``at``."""
    return Scene(
        camera,
        pixels,
        pixels,
        meshes=[quad()],
        materials=[diffuse((ALBEDO,) * 3)],
        lamps=lamps,
        instances=[Instance(0, translation(*at) @ scaling(half, half, 1.0), (0,), "floor")],
        settings=settings,
    )


def places(at, width: float, pixels: int) -> np.ndarray:
    """(pixels², 3) points of the floor in the middle of each pixel, rows from the bottom."""
    steps = ((np.arange(pixels) + 0.5) / pixels - 0.5) * width
    x, y = np.meshgrid(steps, steps)
    return np.asarray(at, float) + np.stack([x.ravel(), y.ravel(), np.zeros(pixels * pixels)], axis=1)


def picture(scene: Scene) -> np.ndarray:
    """(height, width) mean of the channels, float64, from the sums of the film; raises if the render has warned."""
    film = session.render(scene, ("Combined",))
    if scene.warnings:
        raise RuntimeError("; ".join(scene.warnings))
    return film.light()[0].mean(axis=1).reshape(film.height, film.width)


def volumes_unknown(lamp: Lamp, point, normal) -> float:
    """Standard deviation (W/m²) of the light of a uniform lamp at a point by cuts, from the error of the volumes in
    boxes.

    Boxes on the boundary are sampled once, by one point in each of side³ parts. A surface crosses at most 3 side² of
    these, each of which then has a variance of 1/6 on average, because the fraction f inside may be anything. The
    variance of a part is also f (1 − f), so that of a box is at most its mean f by side³: less, if the inside is thin.
    The smaller bound is chosen for all boxes together, so the choice has no bias.
    """
    built = build_lamp(lamp.name, lamp.shape, lamp.matrix, lamp.power, lamp.density)
    shape, matrix = (lamp.shape, lamp.matrix) if built.tree is not None else similar(lamp.shape, lamp.matrix)
    tree = interior.tree(shape)
    boxes = tree.boxes[(tree.nodes["first"] < 0) & (tree.nodes["state"] == interior.BOUNDARY)]
    side = (moments.SIDES if len(boxes) < moments.FEW else moments.COARSE_SIDES)[0]
    sizes = (boxes[:, 3:] - boxes[:, :3]) @ np.abs(matrix[:3, :3]).T
    volumes = (boxes[:, 3:] - boxes[:, :3]).prod(axis=1) * abs(np.linalg.det(matrix[:3, :3]))
    offsets = (0.5 * (boxes[:, 3:] + boxes[:, :3]) + tree.center) @ matrix[:3, :3].T + matrix[:3, 3] - point
    # Boxes next to the point count by their content, not by their estimated volume.
    distances = np.maximum(np.linalg.norm(offsets, axis=1), np.linalg.norm(sizes, axis=1))
    weights = np.maximum(offsets @ normal, 0.0) / distances**3
    # All volumes are scaled so that their sum is right.
    weights -= np.average(weights, weights=volumes)
    # The mean f from random points: errors of single boxes average out over all of them.
    rng = np.random.default_rng(1)
    filled = np.zeros(len(boxes))
    for _ in range(FILL_POINTS):
        inside = boxes[:, :3] + rng.random((len(boxes), 3)) * (boxes[:, 3:] - boxes[:, :3]) + tree.center
        filled += numpy_evaluation.evaluate(shape.formula(), inside, shape.parameters()) <= 0.0
    bounds = np.full(len(boxes), 1.0 / (2.0 * side**4)), filled / FILL_POINTS / side**3
    variance = min(float(np.sum((weights * volumes) ** 2 * bound)) for bound in bounds)
    return float(built.row["emission"][0, 0] * np.sqrt(variance))


def deviation(found: np.ndarray, expected: np.ndarray, rounding: float) -> Figure:
    """Deviation of the mean of pixels from their true values, relative to these.

    Pixels are independent, so their scatter gives the standard error; ``rounding`` is an additional tolerance.
    """
    ratios = (found / expected).ravel()
    error = float(ratios.std(ddof=1) / np.sqrt(len(ratios)))
    return Figure(abs(float(ratios.mean()) - 1.0), STANDARD_ERRORS * error + rounding, dict(standard_error=error))
