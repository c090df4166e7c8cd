# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that scatters below surfaces on the CPU."""

import types

import numpy as np
import pytest

from sdf_lights.render import session
from sdf_lights.render.kernels.subsurface import disk, walk
from sdf_lights.render.material import Material, Node
from sdf_lights.render.reference.subsurface import medium
from sdf_lights.render.scene import Instance, Scene, World
from support.scenes import box, camera, diffuse, material, rotation, scaling, settings, sphere, torus_lamp, translation

COLOR = (0.7, 0.5, 0.3)


def stage(method: str, scale: float, color=COLOR, **changes) -> Scene:
    """A ball of a radius of one metre by itself in a white world, with light that scatters below it."""
    scene = Scene(camera((0.0, -4.0, 0.0), (0.0, 0.0, 0.0), 8, 8, half_width=0.1), 8, 8)
    scene.world = World((1.0, 1.0, 1.0), 1.0)
    scene.meshes = [sphere("ball", 64, 32), box()]
    inputs = dict(color=color, scale=scale, radius=(1.0, 1.0, 1.0))
    scene.materials = [Material("deep", Node("subsurface", inputs, {"subsurface_method": method}))]
    scene.instances = [Instance(0, np.eye(4), (0,))]
    scene.settings = settings(samples=256, max_bounces=0, threads=2, **changes)
    return scene


def picture(scene: Scene) -> np.ndarray:
    film = session.render(scene, ())
    assert not film.discarded.any() and scene.warnings == []
    return film.read("Combined")[..., :3].astype(float)


def reflected(albedo: float) -> float:
    """What a half space that scatters evenly reflects of light that comes straight down: 1 − H(1) √(1 − albedo), from
    Chandrasekhar 1950, "Radiative transfer", chapter 5."""
    mu, weight = np.polynomial.legendre.leggauss(64)
    mu, weight = 0.5 * (mu + 1.0), 0.5 * weight
    h = np.ones(64)
    for _ in range(2000):  # 1 / H(μ) = √(1 − albedo) + albedo / 2 ∫ ν H(ν) / (μ + ν) dν
        h = 1.0 / (np.sqrt(1.0 - albedo) + 0.5 * albedo * (weight * mu * h / (mu[:, None] + mu)).sum(1))
    return 1.0 - np.sqrt(1.0 - albedo) / (np.sqrt(1.0 - albedo) + 0.5 * albedo * (weight * mu * h / (1.0 + mu)).sum())


@pytest.mark.parametrize(("method", "scale"), [("RANDOM_WALK", 0.002), ("RANDOM_WALK_LEGACY", 0.02)])
def test_a_walk_reflects_what_a_half_space_does(method, scale):
    """Of a thick body in a white world, whose boundary is smooth: light goes straight down. Walks of more steps than
    there may be hold next to nothing at these albedos."""
    scene = stage(method, scale)
    scene.materials[0].surface.inputs["roughness"] = 0.0
    scene.settings.samples = 1024
    scene.camera = camera((0.0, -4.0, 0.0), (0.0, 0.0, 0.0), 8, 8, half_width=0.01)
    lobe = types.SimpleNamespace(
        color=np.array([COLOR]),
        radius=np.full((1, 3), scale),
        anisotropy=np.zeros(1),
        ior=np.full(1, 1.4),
        method=method,
    )
    [albedo] = medium(lobe)[1]
    np.testing.assert_allclose(picture(scene).mean((0, 1)), [reflected(value) for value in albedo], rtol=0.01)


def test_paths_shorter_than_a_step_off_the_surface_lose_no_light():
    """That step grows with the distance from the origin."""
    expected = picture(stage("RANDOM_WALK", 0.002)).mean((0, 1))
    scene = stage("RANDOM_WALK", 4e-4)
    scene.instances = [Instance(0, translation(20.0, 0.0, 0.0), (0,))]
    scene.camera = camera((20.0, -4.0, 0.0), (20.0, 0.0, 0.0), 8, 8, half_width=0.1)
    np.testing.assert_allclose(picture(scene).mean((0, 1)), expected, rtol=0.01)


def test_a_profile_reflects_the_colour():
    np.testing.assert_allclose(picture(stage("BURLEY", 0.1)).mean((0, 1)), COLOR, rtol=0.01)


def test_a_shallow_radius_is_diffuse():
    scene, plain = stage("RANDOM_WALK", 0.0), stage("RANDOM_WALK", 0.0)
    plain.materials = [diffuse(COLOR)]
    np.testing.assert_allclose(picture(scene), picture(plain), rtol=1e-6)


def test_what_stands_inside_does_not_matter():
    """Light meets its own instance alone, baked or not: the picture is the same, bit for bit."""
    scene = stage("RANDOM_WALK", 1.0)
    alone = picture(scene)
    scene.materials.append(diffuse((0.0, 0.0, 0.0)))
    scene.instances.append(Instance(1, scaling(0.4, 0.4, 0.4), (1, 1, 1)))
    np.testing.assert_array_equal(picture(scene), alone)


def test_an_instance_is_as_a_mesh_of_its_own():
    """Turned, stretched and mirrored: where a mesh is used twice, its rays are traced in its own space."""

    def with_others(shared: bool) -> np.ndarray:
        scene = stage("RANDOM_WALK_SKIN", 0.5)
        matrix = rotation("x", 40) @ rotation("z", 20) @ scaling(0.5, -0.9, 0.8)
        scene.instances = [Instance(1, matrix, (0, 0, 0))]
        if shared:
            scene.instances.append(Instance(1, translation(0.0, 50.0, 0.0), (0, 0, 0)))
        return picture(scene)

    ones, twice = with_others(False), with_others(True)
    assert ones.std() > 0.0
    np.testing.assert_allclose(twice, ones, rtol=0.02)  # float32 rays: some end elsewhere
    np.testing.assert_allclose(twice.mean((0, 1)), ones.mean((0, 1)), rtol=1e-3)


@pytest.mark.parametrize("method", [pytest.param("RANDOM_WALK", marks=pytest.mark.slow), "BURLEY"])
def test_branches_change_the_noise_alone(method):
    """Under a gloss paths divide at the entry, and by themselves at the exit: means of 12 renders each agree within 4
    standard errors, also where a lamp is sampled by its cut at either."""

    def pictures(branches: int, gloss: float) -> np.ndarray:
        found = []
        for seed in range(12):
            scene = stage(method, 0.3 if method == "RANDOM_WALK" else 2.0, indirect_paths=branches, seed=seed)
            scene.materials[0] = Material(
                "deep",
                Node(
                    "principled",
                    dict(
                        base_color=COLOR,
                        subsurface_weight=1.0,
                        subsurface_scale=0.5,
                        specular_ior_level=gloss,
                        roughness=0.3,
                    ),
                    {"subsurface_method": method},
                ),
            )
            scene.materials.append(material("diffuse", color=(0.6, 0.6, 0.6)))
            scene.instances.append(Instance(1, translation(0.0, 0.0, -3.0) @ scaling(5.0, 5.0, 2.0), (1, 1, 1)))
            scene.lamps.append(torus_lamp(0.0, -0.5, 1.8))
            scene.world.strength, scene.settings.samples, scene.settings.max_bounces = 0.1, 8, 2
            found.append(picture(scene).mean((0, 1)))
        return np.array(found)

    for gloss in (0.5, 0.0):
        one, eight = (pictures(branches, gloss) for branches in (1, 8))
        error = np.sqrt((one.var(0, ddof=1) + eight.var(0, ddof=1)) / 12)
        assert np.all(np.abs(one.mean(0) - eight.mean(0)) < 4.0 * error)


def test_the_profile_is_a_density():
    r = np.linspace(0.0, disk.TRUNCATED * 0.3, 20_001)
    values = np.array([disk.profile(0.3, x) for x in r])
    assert 0.5 * np.sum((values[1:] + values[:-1]) * np.diff(r)) == pytest.approx(1.0, abs=1e-3)
    u = np.linspace(0.01, 0.999, 50)
    drawn = np.array([disk.profile_distance(x) * 0.3 for x in u])
    parts = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(r))])
    np.testing.assert_allclose(np.interp(drawn, r, parts), u, atol=1e-3)


def test_diffusion_length():
    """It is ν of the equation of transport: 1 = albedo · ν · artanh(1 / ν) (Case and Zweifel 1967)."""
    for albedo in (0.3, 0.6, 0.9, 0.99):
        length = walk.diffusion_length(albedo)
        assert albedo * length * np.arctanh(1.0 / length) == pytest.approx(1.0, rel=0.01)
