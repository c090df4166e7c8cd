# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render tells of lamps whose intervals are not certain."""

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.render import session
from sdf_lights.render.scene import Camera, Lamp, Scene
from sdf_lights.render.settings import Settings
from sdf_lights.sdf.expression import Expression
from sdf_lights.sdf.shapes import Difference, Sphere
from sdf_lights.sdf.shapes.solids import HalfSpace

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")


def warnings_of(shape):
    matrix = np.eye(4)
    matrix[2, 3] = -3.0
    lamp = Lamp("Lantern", shape, matrix)
    scene = Scene(Camera(np.eye(4)), 8, 6, lamps=[lamp], settings=Settings(samples=2, threads=2))
    film = session.render(scene, ("Combined",))
    assert np.isfinite(film.read("Combined")).all()
    return scene.warnings


def test_certain_lamps_are_quiet():
    assert not warnings_of(Difference(Sphere(0.5), Sphere(0.3)))
    assert not warnings_of(Expression("smooth_union(sphere(0.3), torus(0.5, 0.1), radius=0.1)").shape({}))


def test_what_could_not_be_resolved_is_told():
    """Some thousand slices, more than a ray has room for."""
    (sentence,) = warnings_of(Expression("field(max(length(p) - 0.5, sin(2e4 * p.z)))").shape({}))
    assert sentence.startswith("Lamp “Lantern”: ") and "could not be resolved" in sentence and sentence.endswith(".")


def test_a_field_without_bounds_is_told():
    sentence, *_ = warnings_of(Expression("field(length(p) - 0.5 + 0.1 * abs(p.x) ** 0.5)").shape({}))
    assert sentence.startswith("Lamp “Lantern”: its field has no known bound of its slope")


def test_a_lamp_without_limits_is_left_out():
    (sentence,) = warnings_of(HalfSpace())
    assert sentence == "Lamp “Lantern”: its shape has no limits: intersect it with a box or another shape."
