# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sampling by surface area: areas are those of closed forms, and directions have the density that they claim."""

import math

import numpy as np
import pytest

from sdf_lights.emitter import lamps
from sdf_lights.emitter.building import build, pack
from sdf_lights.jit import kernel
from sdf_lights.sdf.shapes import Box, BoxFrame, Sphere, Torus
from sdf_lights.sdf.shapes.fractals import MengerSponge
from support.chi2 import chi2_sphere, sphere_integral
from support.lamps.shapes_under_test import COMPOSITES, FIELDS, PLACEMENTS, FieldOf, scaled
from support.rivals import baselines, surfaces
from support.rivals.baselines import LampBlock, Technique

AREAS = {  # shape, matrix, area and most crossings of a line
    "sphere": (Sphere(0.8), np.eye(4), 4.0 * math.pi * 0.64, 2),
    "torus": (Torus(1.0, 0.35), np.eye(4), 4.0 * math.pi**2 * 0.35, 4),
    "torus as a field": (FieldOf(Torus(1.0, 0.35)), np.eye(4), 4.0 * math.pi**2 * 0.35, 4),
    "stretched box": (Box((1.0, 1.0, 1.0)), scaled(0.7, -0.4, 0.2), 8.0 * (0.28 + 0.14 + 0.08), 2),
    "sponge": (MengerSponge(0.5, 1.0), np.eye(4), 8.0, 6),
    "shell": (COMPOSITES["thin"], np.eye(4), 4.0 * math.pi * (0.8**2 + 0.78**2), 4),
}
SHAPES = {
    "torus": Torus(0.7, 0.2),
    "box": Box((0.7, 0.4, 0.2)),
    "frame": BoxFrame((0.6, 0.5, 0.4), 0.08),
    "nested": COMPOSITES["nested"],
    "blob": FIELDS["blob"],
    "rings": FIELDS["rings"],
}
QUICK = ("torus", "above"), ("box", "close"), ("nested", "middle")
POINTS = {"above": (0.3, 0.2, 1.6), "close": (0.75, 0.0, 0.3), "middle": (0.02, 0.01, 0.03)}


@kernel
def _sample(blocks, x, u, spans):
    out = np.empty((len(u), 3))
    for i in range(len(u)):
        out[i] = surfaces.sample(blocks[0], 0, x, spans, u[i, 0], u[i, 1], u[i, 2])
    return out


@kernel
def _density(blocks, x, directions, spans):
    out = np.empty(len(directions))
    for i in range(len(directions)):
        d = (directions[i, 0], directions[i, 1], directions[i, 2])
        out[i] = surfaces.density(blocks[0], 0, x, d, spans, lamps.trace(blocks[0], 0, x, d, spans))
    return out


class Aim:
    """Directions to a lamp's surface from a point."""

    def __init__(self, shape, x, matrix=np.eye(4)):
        self.lamp, self.x = LampBlock(shape, matrix, surface=True), tuple(map(float, x))
        self.spans = pack.new_spans(int(self.lamp.blocks["lamp_rows"][0]), 1)
        row = self.lamp.built.row[0]
        self.axis = row["center"] - self.x
        part = row["bounding_radius"] / np.linalg.norm(self.axis)
        self.least = math.sqrt(1.0 - part * part) if part < 1.0 else -1.0

    def sample(self, u):
        return _sample(self.lamp.blocks, self.x, u, self.spans)

    def density(self, directions):
        return _density(self.lamp.blocks, self.x, np.ascontiguousarray(directions), self.spans)

    def agrees(self):
        """χ² of the directions below a limit of their density, as no quadrature can tell a density without limit."""
        limit = np.quantile(self.density(self.sample(np.random.default_rng(1).random((10_000, 3)))), 0.9)

        def sample(u):
            directions = self.sample(u)
            return np.where(self.density(directions)[:, None] < limit, directions, np.nan)

        def density(directions):
            found = self.density(directions)
            return np.where(found < limit, found, 0.0)

        return chi2_sphere(
            sample, density, n=50_000, seed=5, axis=self.axis, quadrature=64, confidence=0.9999, least=self.least
        )


def check(aim):
    """∫p = 1 within the quadrature's own error, which is that of a few rays that graze the surface; and χ²."""
    total, error = sphere_integral(aim.density, 200_000, seed=3, axis=aim.axis)
    assert error < 2e-2 and abs(total - 1.0) < 4.0 * error + 1e-3
    result = aim.agrees()
    assert result.passed, result


@pytest.mark.parametrize("name", AREAS)
def test_areas(name):
    shape, matrix, area, most = AREAS[name]
    found, crossings = surfaces.measure(build.build_lamp(name, shape, matrix))
    assert found == pytest.approx(area, rel=1e-3) and crossings == most


@pytest.mark.parametrize(
    "shape, point",
    [
        pytest.param(shape, point, marks=[pytest.mark.slow] * ((shape, point) not in QUICK))
        for shape in SHAPES
        for point in POINTS
    ],
)
def test_directions_have_their_density(shape, point):
    check(Aim(SHAPES[shape], POINTS[point]))


@pytest.mark.parametrize(
    "placement",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name != "sheared"))
        for name in PLACEMENTS
        if name not in ("far", "stretched")
    ],
)
def test_transforms(placement):
    """An affine map changes what is uniform by area: a lamp is turned, stretched unevenly, sheared, mirrored, small."""
    matrix = PLACEMENTS[placement]
    check(Aim(SHAPES["nested"], (matrix @ [0.8, 0.3, 1.5, 1.0])[:3], matrix))


@pytest.mark.parametrize(
    "shape", [pytest.param(shape, marks=[pytest.mark.slow] * (shape not in ("torus", "nested"))) for shape in SHAPES]
)
def test_unbiased(shape):
    """The same irradiance as projection sampling gives, within 4.5 standard errors and what areas are known to."""
    block, x, n = LampBlock(SHAPES[shape], np.eye(4), surface=True), POINTS["above"], (0.0, 0.0, -1.0)
    found = baselines.run(Technique.SURFACE, block.blocks, 0, x, n, 40_000, 7)
    expected = baselines.run(Technique.PROJECTION, block.blocks, 0, x, n, 100_000, 8)
    assert abs(found.mean - expected.mean) < 4.5 * np.hypot(found.error, expected.error) + 1e-3 * expected.mean
