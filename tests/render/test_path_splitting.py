# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths that divide: the picture's mean is the same, its noise less, and the number of branches follows the noise."""

import dataclasses

import numpy as np
import pytest

from sdf_lights.render import sample_allocation, session
from sdf_lights.render.film import Film
from sdf_lights.render.scene import Instance, Lamp, Scene
from sdf_lights.render.settings import MOST_BRANCHES, START_BRANCHES, PathReuse
from sdf_lights.sdf.shapes import Torus
from support.scenes import camera, diffuse, material, quad, rotation, scaling, settings, sphere, translation

SIZE = 24


def room(shade: bool = False, **changes) -> Scene:
    """A floor, a wall, a glossy ball and a mirror under a torus: light takes every kind of first bounce.

    ``shade``: a board between the torus and the floor.
    """
    scene = Scene(camera((0.0, -6.5, 2.6), (0.0, 0.2, 1.0), SIZE, SIZE, half_width=0.38), SIZE, SIZE)
    scene.world.strength = 0.1
    scene.meshes = [quad(), sphere("ball", 64, 32)]
    scene.materials = [
        diffuse((0.7, 0.7, 0.6), "floor"),
        material("glossy", "gloss", color=(0.8, 0.7, 0.6), roughness=0.3),
        material("glossy", "mirror", color=(0.9, 0.9, 0.9), roughness=0.0),
    ]
    scene.instances = [
        Instance(0, scaling(4.0, 4.0, 1.0), (0,)),
        Instance(0, translation(0.0, 2.5, 2.0) @ rotation("x", 90) @ scaling(4.0, 2.5, 1.0), (0,)),
        Instance(1, translation(1.2, -1.2, 0.45) @ scaling(0.45, 0.45, 0.45), (1,)),
        Instance(1, translation(-1.3, -1.0, 0.5) @ scaling(0.5, 0.5, 0.5), (2,)),
    ]
    if shade:
        scene.instances.append(Instance(0, translation(0.0, 0.0, 1.0) @ scaling(1.3, 1.3, 1.0), (0,)))
    scene.lamps = [Lamp("torus", Torus(0.8, 0.25), translation(0.0, 0.0, 1.4), power=50.0)]
    scene.settings = settings(max_bounces=3, diffuse_bounces=3, glossy_bounces=3, threads=2, **changes)
    return scene


def pictures(branches: int, seeds: int, samples: int, **changes) -> tuple[np.ndarray, float]:
    """(seeds, height, width, RGB) and the work of one of them, as ``sample_allocation`` counts it."""
    films = [
        session.render(room(samples=samples, indirect_paths=branches, seed=seed, **changes), ())
        for seed in range(seeds)
    ]
    work = np.mean([sample_allocation.own_cost(film) * film.count.sum() + film.divided[:, 2].sum() for film in films])
    return np.array([film.read("Combined")[..., :3] for film in films], np.float64), float(work)


@pytest.mark.slow
@pytest.mark.parametrize("shade", [False, True])
def test_branches_change_the_noise_alone(shade):
    """Block means of 24 renders each agree within 4 standard errors; pictures of 1 and 8 branches differ in noise.

    Under the shade, the branches that promise the most are dark.
    """
    found = [pictures(branches, 24, 8, shade=shade) for branches in (1, 8, 0)]
    one, eight = found[0][0], found[1][0]
    blocks = [each.reshape(24, 4, SIZE // 4, 4, SIZE // 4, 3).mean(axis=(2, 4, 5)) for each, _ in found]
    for other in blocks[1:]:
        error = np.sqrt((blocks[0].var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / 24)
        assert np.all(np.abs(other.mean(axis=0) - blocks[0].mean(axis=0)) < 4.0 * error)
    assert _noise(eight) < 0.5 * _noise(one)
    alone = dict(shade=shade, path_reuse=PathReuse.NEVER)  # paths that are reused leave less for branches to gain
    one, chosen = (_error(*pictures(branches, 24, 16, **alone)) for branches in (1, 0))
    assert chosen < 0.65 * one


def _error(found: np.ndarray, work: float) -> float:
    """Relative error × work: what the choice of branches is to keep low."""
    mean = found.mean(axis=0)
    return float(np.mean(found.var(axis=0, ddof=1) / (mean**2 + 0.01 * mean.mean() ** 2)) * work)


def _noise(found: np.ndarray) -> float:
    """The median variance of pixels: edges are as noisy as ever."""
    return np.median(found.var(axis=0, ddof=1))


def test_the_picture_does_not_depend_on_threads():
    one, many = (
        session.render(dataclasses.replace(scene, settings=dataclasses.replace(scene.settings, threads=threads)), ())
        for scene, threads in ((room(samples=16), 1), (room(samples=16), 3))
    )
    assert np.array_equal(one.sums["combined"], many.sums["combined"])


def test_branches_are_chosen_by_what_is_noisy():
    film = session.render(room(samples=32, path_reuse=PathReuse.NEVER), ())  # which leaves less of that
    seen = film.surfaces > 0
    mean = film.divided[seen, 0].sum() / film.count[seen].sum()
    assert 2.0 <= mean <= MOST_BRANCHES
    assert len(np.unique(film.branches[seen])) > 2


@pytest.mark.parametrize(
    "noise, scattered, expected",
    [
        (0.0, 0.0, (4, 4)),
        (0.0, 0.3, (6, MOST_BRANCHES)),
        (0.3, 0.3, (3, 5)),
        (0.3, 0.01, (2, 2)),
        (0.05, 0.3, (6, MOST_BRANCHES)),
    ],
)
def test_one_sample_tells_what_is_noisy(noise, scattered, expected):
    """A slope and an edge, which no sample would change, do not count. Nor does what differs from sample to sample
    alone; the best number for the third row is 4."""
    film = Film(room(), ())
    film.samples = 1
    film.count[:], film.divided[:] = 1, (4.0, 0.0, 2.0, 0.25, 1.0)
    rng = np.random.default_rng(5)
    y, x = np.mgrid[:SIZE, :SIZE]
    before = 1.0 + 0.05 * x + 5.0 * (y + x > 30) + noise * rng.standard_normal((SIZE, SIZE))
    film.sums["combined"].reshape(SIZE, SIZE, 4)[..., 0] = before
    branch = 1.0 + 2.0 * scattered * rng.standard_normal((SIZE, SIZE, 4))
    film.sums["scattered"].reshape(SIZE, SIZE, 3)[..., 0] = branch.sum(axis=2)
    film.squares[:, 2] = (before + branch.mean(axis=2)).ravel()
    film.squares[:, 3] = 4.0 * branch.var(axis=2).ravel()
    film.branches[:] = 4
    sample_allocation.divide(film, room(samples=8).settings)
    assert np.all(film.rate == 1.0) and len(set(film.branches)) == 1
    assert expected[0] <= film.branches[0] <= expected[1]


@pytest.mark.parametrize("height", [1, 6, SIZE, 3 * SIZE])
def test_some_rows_tell_into_how_many_branches_the_others_divide(height):
    """From their first sample on, of which every pixel has one; small pictures have such rows, too."""
    scene = room(samples=1, seed=1)
    scene.height = height
    told = sample_allocation.first_pixels(Film(scene, ()), scene.settings).astype(bool)
    rows = told.reshape(height, SIZE)
    assert np.all(rows == rows[:, :1]) and 0.0 < told.mean() < 0.3 or height < 8
    film = session.render(scene, ())
    assert np.all(film.count == 1) and film.samples == 1 and np.all(film.active == 1)
    surfaces = film.surfaces > 0
    assert np.all(film.divided[told & surfaces, 0] == START_BRANCHES)
    assert np.all(film.divided[~told & surfaces, 0] == film.branches[~told & surfaces])
    if height >= SIZE:
        assert film.branches[0] != START_BRANCHES


@pytest.mark.parametrize("changes", [dict(indirect_paths=3), dict(max_bounces=0)])
def test_nothing_is_to_be_told_where_paths_divide_as_set_or_never(changes):
    scene = room()
    scene.settings = dataclasses.replace(scene.settings, **changes)
    assert sample_allocation.first_pixels(Film(scene, ()), scene.settings) is None


def test_a_row_of_pixels_divides():
    scene = dataclasses.replace(room(samples=4), width=2, height=1)
    assert session.render(scene, ()).divided[:, 2].any()


def test_branches_that_promise_little_are_left_out():
    """A single branch has no others to be compared with. Around the room there is a ball, so that all rays meet
    surfaces."""
    films = []
    for branches in (1, 16):
        scene = room(samples=8, indirect_paths=branches, guided_samples=False, path_reuse=PathReuse.NEVER)
        scene.instances.append(Instance(1, scaling(20.0, 20.0, 20.0), (0,)))
        films.append(session.render(scene, ()))
    lit = [film.divided[:, 2].sum() / film.divided[:, 0].sum() for film in films]
    assert 0.5 * lit[0] < lit[1] < 0.9 * lit[0]


def test_nothing_divides_where_no_light_is_scattered_again():
    scene = room(samples=32)
    scene.settings.max_bounces = 0
    film = session.render(scene, ())
    assert film.surfaces.any() and not film.divided[:, 2].any() and not film.sums["scattered"].any()


def test_samples_count_by_their_branches():
    """A pixel's light that was scattered again is the mean over its branches, and so is what lamps sent of it."""
    film = Film(room(), ("SDF Lamps",))
    film.count[:], film.divided[:, 0] = 2, 8.0  # two samples, of one branch and of seven
    for name in ("combined", "lamps"):
        film.sums[name][:] = 2.0
    for name in ("scattered", "scattered_lamps"):
        film.sums[name][:] = 1.0 * 5.0 + 7.0 * 1.0
    for name in ("Combined", "SDF Lamps"):
        assert np.allclose(film.read(name)[..., :3], 1.0 + 12.0 / 8.0)
