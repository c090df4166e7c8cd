# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps that are sunk in other things: what nothing sees of them is seldom sampled, and the light is the same."""

import numpy as np

from sdf_lights.emitter.sampling import hidden
from sdf_lights.render import session
from sdf_lights.render.cpu import renderer
from sdf_lights.render.cpu.block import PackedScene, Workspace
from sdf_lights.render.cpu.hidden_parts import find_hidden_parts
from sdf_lights.render.film import Film
from sdf_lights.render.scene import Instance, Lamp, Scene
from sdf_lights.render.settings import LampSampling
from sdf_lights.sdf.shapes import Box, Torus
from support.scenes import camera, diffuse, quad, rotation, scaling, settings, translation

SIZE = 24
SEEDS = 12


def room(height: float, shape=Torus(1.0, 0.35), **changes) -> Scene:
    """A floor, a wall behind it, and a lamp around a point so high above the floor."""
    scene = Scene(camera((0.0, -6.5, 2.6), (0.0, 0.2, 0.6), SIZE, SIZE, half_width=0.38), SIZE, SIZE)
    scene.meshes, scene.materials = [quad()], [diffuse((0.7, 0.7, 0.6), "floor")]
    scene.instances = [
        Instance(0, scaling(4.0, 4.0, 1.0), (0,)),
        Instance(0, translation(0.0, 2.5, 2.0) @ rotation("x", 90) @ scaling(4.0, 2.5, 1.0), (0,)),
    ]
    scene.lamps = [Lamp("lamp", shape, translation(0.0, 0.0, height), power=50.0)]
    scene.settings = settings(max_bounces=0, samples=8, threads=2, **changes)
    return scene


def found(scene: Scene) -> list:
    packed = PackedScene(scene, Film(scene, ()))
    return find_hidden_parts(scene, packed, Workspace(packed))


def pictures(height: float) -> np.ndarray:
    """(seeds, height, width, RGB)"""
    return np.array([session.render(room(height, seed=seed), ()).read("Combined")[..., :3] for seed in range(SEEDS)])


def test_a_sunk_lamp_has_less_noise_and_the_same_light(monkeypatch):
    """Means of the whole picture agree within 4 standard errors."""
    sunk = pictures(0.0)
    monkeypatch.setattr(renderer, "find_hidden_parts", lambda scene, packed, workspace: [None])
    other = pictures(0.0)
    means = [each.mean(axis=(1, 2, 3)) for each in (sunk, other)]
    error = np.sqrt(sum(each.var(ddof=1) for each in means) / SEEDS)
    assert abs(means[0].mean() - means[1].mean()) < 4.0 * error
    assert sunk.var(axis=0, ddof=1).mean() < 0.7 * other.var(axis=0, ddof=1).mean()


def test_cells_below_the_floor_count_least():
    (sums,) = found(room(0.0))
    volume, seen = (
        np.diff(sums[name].reshape((hidden.CORNERS,) * 3)[-1, -1]) for name in ("volume", "seen")
    )  # of the layers
    part = seen / volume
    assert np.allclose(part[: hidden.SIDE // 2], hidden.LEAST_WEIGHT) and np.all(part[hidden.SIDE // 2 :] > 0.9)


def test_other_lamps_are_sampled_as_they_are():
    assert found(room(1.5)) == [None]
    assert found(room(0.0, lamp_sampling=LampSampling.PROJECTION)) == [None]


def test_a_flat_lamp_is_no_problem():
    assert len(found(room(0.0, Box((0.5, 0.5, 1e-6))))) == 1


def test_a_view_of_nothing_tells_nothing():
    scene = room(0.0)
    scene.camera = camera((0.0, -6.5, 2.6), (0.0, -9.0, 9.0), SIZE, SIZE, half_width=0.1)
    assert found(scene) == [None]
