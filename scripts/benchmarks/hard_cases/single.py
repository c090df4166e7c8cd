# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Single precision compared with double precision: shapes in GLSL, whole pictures of the GPU's path tracer, and hits of
triangles.

Both pictures use the same random numbers, so most samples differ only by rounding. The effect of rounding has no
preferred sign. So means must agree within the remaining noise, which the scatter of the differences of several seeds
shows. Only the numbers of a shape are rounded in the same way in all samples: they may shift its thinnest part.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from sdf_lights.graph import codegen_glsl, interval_evaluation, numpy_evaluation
from sdf_lights.render import session
from sdf_lights.render.scene import Lamp
from sdf_lights.render.settings import Device
from sdf_lights.sdf.shapes import Difference, Shape, Sphere
from sdf_lights.sdf.shapes.orbits import Mandelbulb
from support import glsl
from support.blocks import means
from support.lamps.hard_cases import FACES, HARD_CASES, around
from support.scenes import SCENES

from . import Figure, case
from .cost import MATRIX
from .light import THIN, ball
from .rays import MORE
from .stage import FLOAT32, STANDARD_ERRORS, floor, from_above, settings

SHAPES = (
    "smooth combination",
    "smooth combination, size 1e-3",
    "smooth combination, size 1e4",
    "smooth combination, sheared and mirrored",
    "stretched 1 : 10,000",
    "torus, stretched and twisted",
    "onions 1e-4 thick",
    "coincident faces",
    "thin spokes",
    "Menger sponge of 5 levels",
    "noise",
    "Mandelbulb",
)
POINTS, QUICK_POINTS = 3000, 300
WIDTH, HEIGHT = 32, 24  # pixels of a picture
SEEDS, QUICK_SEEDS = 16, 8
SAMPLES, QUICK_SAMPLES = 32, 8


@case("float32-shapes", opengl=True)
def shapes(quick):
    """error of a field in GLSL, to what the rounding of each of its operations may cause at that point, at most"""
    try:
        glsl.context()
    except pytest.skip.Exception as reason:
        raise RuntimeError(str(reason)) from None
    worst = {}
    for name in SHAPES:
        shape = {**HARD_CASES, **MORE}[name].shape
        origins, toward = around(shape, np.random.default_rng(2), QUICK_POINTS if quick else POINTS)
        along = np.random.default_rng(3).random((len(origins), 1)) * 2.0 * np.linalg.norm(origins, axis=1)[:, None]
        points = (origins + along * toward).astype(np.float32).astype(float)
        formula, numbers = shape.formula(), shape.parameters()
        found = glsl.evaluate(codegen_glsl.function(formula, "field"), "field", points, numbers).astype(float)
        low, high = interval_evaluation.enclose(formula, points, points, numbers, glsl.PRECISION)
        exact = numpy_evaluation.evaluate(formula, points, numbers)
        known = np.isfinite(exact) & (low > -np.inf) & (high < np.inf)
        above, below = (
            (found - exact) / np.maximum(high - exact, 1e-300),
            (exact - found) / np.maximum(exact - low, 1e-300),
        )
        worst[name] = float(np.where(found == exact, 0.0, np.maximum(above, below))[known].max())
    return Figure(max(worst.values()), 1.0, dict(shapes=len(worst)))


def pictures(shape: Shape, device: Device, quick: bool) -> np.ndarray:
    """(seeds, height, width, 1) renders of a room that is lit by a lamp, with direct light."""
    found = []
    for seed in range(QUICK_SEEDS if quick else SEEDS):
        scene = SCENES["torus_room"](WIDTH, HEIGHT)
        scene.lamps = [Lamp("lamp", shape, MATRIX, 60.0)]
        scene.settings = settings(QUICK_SAMPLES if quick else SAMPLES, seed)
        scene.settings.device, scene.settings.indirect_paths = device, 1  # as on the GPU, with the same random numbers
        film = session.render(scene, ("Combined",))
        # The length that float32 leaves unresolved is reported, and the result must still be right on average.
        told = [warning for warning in scene.warnings if "could not be resolved" not in warning]
        if told:
            raise RuntimeError("; ".join(told))
        found.append(film.light()[0].mean(axis=1).reshape(HEIGHT, WIDTH, 1))
    return np.array(found)


def compared(shape: Shape, thinnest: float, quick: bool) -> Figure:
    """Means of pictures and of their blocks on the GPU, compared with those in double precision.

    ``thinnest``: part of the shape, relative to the numbers whose difference it is.
    """
    double, single = (
        np.concatenate(means(pictures(shape, device, quick)), axis=1) for device in (Device.CPU, Device.GPU)
    )
    truth, differences = double.mean(axis=0), single - double
    seeds, count = differences.shape
    errors = differences.std(axis=0, ddof=1) / np.sqrt(seeds)
    # The probability that any of the means is off is the same as for one mean with as many standard errors of a known
    # scatter.
    chance = 2.0 * stats.norm.sf(STANDARD_ERRORS)
    allowed = errors * stats.t.isf(0.5 * chance / count, seeds - 1) + 2.0 * FLOAT32 / thinnest * truth
    off = differences.mean(axis=0)
    return Figure(
        float(np.max(np.abs(off) / allowed)),
        1.0,
        dict(deviation=abs(off[-1]) / truth[-1], standard_error=errors[-1] / truth[-1]),
    )


@case("float32-picture-csg", slow=True, opengl=True)
def picture_of_csg(quick):
    """difference of a picture by the GPU, or of a block of it, to its error bar: boxes with faces that coincide"""
    return compared(FACES, 0.1, quick)


@case("float32-picture-thin-shell", slow=True, opengl=True)
def picture_of_a_shell(quick):
    """the same of a shell 3e-4 of its radius thick"""
    return compared(Difference(Sphere(0.5), Sphere(0.5 * (1.0 - THIN))), THIN, quick)


@case("float32-picture-mandelbulb", slow=True, opengl=True)
def picture_of_a_mandelbulb(quick):
    """the same of a Mandelbulb"""
    return compared(Mandelbulb(), 1.0, quick)


@case("float32-positions")
def positions(quick):
    """height of hits 23 km from the origin over the plane that was hit, relative to their greatest coordinate"""
    at = (12345.678, -23456.789, 3456.789)
    camera = from_above(at, 2.0, 3.0)
    lamps = [Lamp("lamp", Sphere(1.0), ball(0.3, at[0], at[1], at[2] + 5.0))]
    film = session.render(floor(camera, 32, at, 5.0, lamps, settings(1)), ("Position",))
    heights = film.sums["position"].reshape(-1, 3)[:, 2] - at[2]
    return Figure(float(np.abs(heights).max() / np.abs(at).max()), FLOAT32)
