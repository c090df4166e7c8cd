# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that leave a light carry the irradiance that light rays find, and all its power."""

import numpy as np
import pytest

from sdf_lights.render.kernels.lights.kinds import KINDS
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from tests.render.lights.harness import UP, Packed, place, scene_of

# name: light at the origin that shines down if it has a direction, and the height of the lit plane
LIGHTS = {
    "point": (PointLight("", place(), 10.0), -0.6),
    "disk": (PointLight("", place(), 10.0, radius=0.5), -0.6),
    "disk, close": (PointLight("", place(), 10.0, radius=0.5), -0.2),
    "sphere": (PointLight("", place(), 10.0, radius=0.4, soft_falloff=False), -0.6),
    "inside the sphere": (PointLight("", place(), 10.0, radius=0.5, soft_falloff=False), -0.1),
    "spot": (SpotLight("", place(), 10.0, radius=0.2, angle=1.2, blend=0.5), -0.6),
    "spot of a sphere": (SpotLight("", place(), 10.0, radius=0.2, soft_falloff=False, angle=1.2, blend=0.5), -0.6),
    "wide spot": (SpotLight("", place(), 10.0, angle=3.1), -0.4),
    "rectangle": (AreaLight("", place(), 10.0, size=(0.8, 0.5)), -0.4),
    "ellipse, spread": (AreaLight("", place(), 10.0, size=(0.8, 0.5), ellipse=True, spread=1.0), -0.4),
    "beam": (AreaLight("", place(), 10.0, size=(0.8, 0.6), spread=0.0), -0.4),
}
CELLS, EXTENT = 4, 0.6  # cells along each side of a square, and half its side
RAYS, POINTS, RAYS_OF_A_POINT = 1 << 18, 256, 64


def arriving(packed, height: float, rng) -> np.ndarray:
    """(CELLS, CELLS, 2) flux through each cell of the plane from above, and its standard error."""
    origin, direction, flux, reach = packed.leave(0, rng.random((RAYS, 4)))
    with np.errstate(divide="ignore"):
        t = (height - origin[:, 2]) / direction[:, 2]
    position = origin + np.where(np.isfinite(t), t, 0.0)[:, None] * direction
    cell = np.floor((position[:, :2] / EXTENT + 1.0) * 0.5 * CELLS).astype(int)
    chosen = (direction[:, 2] < 0.0) & (t > 0.0) & (t <= reach) & ((cell >= 0) & (cell < CELLS)).all(axis=1)
    chosen &= flux[:, 0] > 0.0
    x = position[chosen]
    singular = packed.sample(0, x, np.full((len(x), 2), 0.5), UP)[4]
    chosen[chosen] = singular | (packed.hits(0, x, -direction[chosen])[0] > 0.0)
    found = np.zeros((CELLS, CELLS, 2))
    for x in range(CELLS):
        for y in range(CELLS):
            each = np.where(chosen & (cell == (x, y)).all(axis=1), flux[:, 0], 0.0)
            found[x, y] = each.mean(), each.std() / np.sqrt(RAYS)
    return found


def expected(packed, height: float, rng) -> np.ndarray:
    """As ``arriving``, by light rays from points of the cells."""
    found = np.zeros((CELLS, CELLS, 2))
    side = 2.0 * EXTENT / CELLS
    for x in range(CELLS):
        for y in range(CELLS):
            corner = (x * side - EXTENT, y * side - EXTENT, height)
            at = np.repeat(corner + rng.random((POINTS, 3)) * (side, side, 0.0), RAYS_OF_A_POINT, axis=0)
            wi, _, radiance, pdf, _ = packed.sample(0, at, rng.random((len(at), 2)), UP)
            lit, values = np.isfinite(wi[:, 0]), np.zeros(len(at))
            values[lit] = radiance[lit, 0] * np.maximum(wi[lit, 2], 0.0) / pdf[lit]
            values = values.reshape(POINTS, -1).mean(axis=1)
            found[x, y] = values.mean() * side**2, values.std() / np.sqrt(POINTS) * side**2
    return found


@pytest.mark.parametrize("name", LIGHTS)
def test_what_leaves_arrives(name):
    """Within 4.5 standard errors in each of 16 cells: by chance, one set of seeds in ten thousand would not."""
    light, height = LIGHTS[name]
    packed, rng = Packed(scene_of(light)), np.random.default_rng(5)
    sent, got = arriving(packed, height, rng), expected(packed, height, rng)
    assert got[..., 0].max() > 0.0
    error = np.hypot(sent[..., 1], got[..., 1])
    assert np.all(np.abs(sent[..., 0] - got[..., 0]) < 4.5 * error + 1e-6)


@pytest.mark.parametrize("name", ["point", "disk", "sphere", "rectangle", "ellipse, spread", "beam"])
def test_all_power_leaves(name):
    """``flux`` is what rays carry in the mean, without those that stay inside a sphere."""
    packed = Packed(scene_of(LIGHTS[name][0]))
    _, _, flux, reach = packed.leave(0, np.random.default_rng(6).random((RAYS, 4)))
    kind, index = packed.tables["light_emitters"][["kind", "index"]][0]
    module = KINDS[kind]
    assert module.flux(packed.tables[module.TABLE])[index] == pytest.approx(10.0, rel=1e-6)
    assert (flux[:, 0] * np.isinf(reach)).mean() == pytest.approx(10.0, rel=0.01)


def test_suns_have_no_rays_that_leave_them():
    packed = Packed(scene_of(SunLight("", place(), 3.0)))
    assert not packed.leave(0, np.full((4, 4), 0.5))[2].any()
