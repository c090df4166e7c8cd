# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where numbers have single precision, against the same in double: shapes as GLSL reads them, and hits of triangles."""

from __future__ import annotations

import numpy as np
import pytest

from sdf_lights.render import session
from sdf_lights.render.scene import Lamp
from sdf_lights.sdf import read_glsl, read_interval, read_numpy
from sdf_lights.sdf.shapes import Sphere
from tests import glsl
from tests.emitter.hard_cases import HARD_CASES, around

from . import Figure, case
from .light import ball
from .rays import MORE
from .stage import FLOAT32, floor, from_above, settings

SHAPES = ("smooth combination", "smooth combination, size 1e-3", "smooth combination, size 1e4",
          "smooth combination, sheared and mirrored", "stretched 1 : 10,000", "torus, stretched and twisted",
          "onions 1e-4 thick", "coincident faces", "thin spokes", "Menger sponge of 5 levels", "noise", "Mandelbulb")
POINTS, QUICK_POINTS = 3000, 300


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
        found = glsl.evaluate(read_glsl.function(formula, "field"), "field", points, numbers).astype(float)
        low, high = read_interval.enclose(formula, points, points, numbers, glsl.PRECISION)
        exact = read_numpy.evaluate(formula, points, numbers)
        known = np.isfinite(exact) & (low > -np.inf) & (high < np.inf)
        above, below = (found - exact) / np.maximum(high - exact, 1e-300), (exact - found) / np.maximum(exact - low, 1e-300)
        worst[name] = float(np.where(found == exact, 0.0, np.maximum(above, below))[known].max())
    return Figure(max(worst.values()), 1.0, dict(shapes=len(worst)))


@case("float32-positions")
def positions(quick):
    """height of hits 23 km from the origin over the plane that was hit, relative to their greatest coordinate"""
    at = (12345.678, -23456.789, 3456.789)
    camera = from_above(at, 2.0, 3.0)
    lamps = [Lamp("lamp", Sphere(1.0), ball(0.3, at[0], at[1], at[2] + 5.0))]
    film = session.render(floor(camera, 32, at, 5.0, lamps, settings(1)), ("Position",))
    heights = film.sums["position"].reshape(-1, 3)[:, 2] - at[2]
    return Figure(float(np.abs(heights).max() / np.abs(at).max()), FLOAT32)
