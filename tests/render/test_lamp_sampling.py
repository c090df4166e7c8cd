# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every way of sampling lamps gives the same picture, and cuts give it with the least noise."""

import numpy as np
import pytest

from sdf_lights.render import session
from sdf_lights.render.errors import RenderError
from sdf_lights.render.scene import Lamp, Ray
from sdf_lights.render.settings import Device, LampSampling
from sdf_lights.sdf import shapes
from sdf_lights.sdf.emission import EmissionExpression
from support.rivals import samplers
from support.scenes import SCENES, add, material, rotation, scaling, torus_lamp, translation

WIDTH, HEIGHT, BLOCK = 32, 24, 8
RENDERS = 32

# Points of the lamp alone have no finite variance where a surface is next to a lamp, or in it.
ALONE = {"PROJECTION", "SURFACE", "BOUNDING"}
BESIDE = {"inside_lamp", "two_sided", "hundred_lamps", "glowing"}


def two_sided(width, height):
    """A translucent sheet with a lamp on either side of it, next to one of them."""
    scene = SCENES["torus_room"](width, height)
    add(
        scene,
        0,
        translation(0.0, 0.0, 1.45) @ rotation("x", 20.0) @ scaling(0.7, 0.7, 1.0),
        material("translucent", color=(0.8, 0.7, 0.5)),
    )
    scene.lamps.append(torus_lamp(z=0.9, power=20.0))
    return scene


def hidden(width, height):
    """A lamp that rays scattered by glossy surfaces do not see."""
    scene = SCENES["glossy_metal"](width, height)
    for lamp in scene.lamps:
        lamp.visibility = Ray.ALL & ~Ray.GLOSSY
    return scene


def hundred_lamps(width, height):
    """Small lamps of three shapes all over a room, in the walls too, and a large dim one round many of them."""
    scene = SCENES["torus_room"](width, height)
    random = np.random.default_rng(5)
    kinds = shapes.Sphere(0.06), shapes.Torus(0.1, 0.03), shapes.Box((0.03, 0.05, 0.1))
    scene.lamps = [Lamp("", shapes.Sphere(0.9), translation(0.5, 0.3, 1.2), 30.0)]
    for index in range(99):
        matrix = translation(*random.uniform((-2.0, -1.8, 0.0), (2.0, 2.0, 3.0)))
        matrix = matrix @ rotation("x", random.uniform(0.0, 360.0)) @ rotation("z", random.uniform(0.0, 360.0))
        scene.lamps.append(Lamp("", kinds[index % 3], matrix, random.exponential(2.0), color=tuple(random.random(3))))
    return scene


def glowing(width, height):
    """Lamps that glow in their skin, below, and in stripes: clear of everything, in the floor, and too fine for any
    tree."""
    scene = SCENES["torus_room"](width, height)
    add(
        scene,
        0,
        translation(0.8, 0.4, 0.6) @ rotation("x", 60.0) @ scaling(0.5, 0.5, 1.0),
        material("glossy", color=(0.8, 0.7, 0.5), roughness=0.4),
    )
    emissions = [EmissionExpression(text).emission() for text in ("exp(-20 * depth)", "1 - height", STRIPES)]
    scene.lamps = [
        torus_lamp(power=40.0, emission=emissions[0]),
        Lamp("", shapes.Sphere(0.4), translation(-0.9, 0.5, 0.1), 20.0, emission=emissions[1]),
        Lamp("", shapes.Box((0.1, 0.1, 0.3)), translation(0.9, -0.9, 1.0), 10.0, emission=emissions[2]),
    ]
    return scene


def skin(width, height):
    """A lamp that glows in its skin alone."""
    scene = SCENES["torus_room"](width, height)
    scene.lamps = [torus_lamp(emission=EmissionExpression("exp(-60 * depth)").emission())]
    return scene


STRIPES = "1 if sin(400 * p.z) > 0.9 else 0"
BUILDERS = {name: SCENES[name] for name in ("torus_room", "frame_lamp", "inside_lamp", "veiled")}
BUILDERS |= {"two_sided": two_sided, "hidden": hidden, "hundred_lamps": hundred_lamps, "glowing": glowing, "skin": skin}


def _render(name, sampling, samples, seed, bounces=2):
    scene = BUILDERS[name](WIDTH, HEIGHT)
    scene.settings.samples, scene.settings.seed, scene.settings.max_bounces = samples, seed, bounces
    with samplers.registered(sampling) as scene.settings.lamp_sampling:
        return session.render(scene, ("Combined",)).read("Combined")[:, :, :3].astype(float).mean(axis=2)


def _blocks(picture):
    return picture.reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK).mean(axis=(1, 3)).ravel()


@pytest.mark.slow
@pytest.mark.parametrize("name", BUILDERS)
def test_unbiased(name):
    """32 renders of a single sample, by blocks of 8 × 8 pixels: within 4 standard errors of what many samples give.

    Of the 12 blocks of 9 scenes and 3 to 6 samplings that is exceeded by chance once in 50 runs with other seeds.
    """
    reference = [_blocks(_render(name, "MIS", 128, 1000 + seed)) for seed in range(4)]
    truth, doubt = np.mean(reference, axis=0), np.std(reference, axis=0, ddof=1) / 2.0
    for sampling in samplers.SAMPLERS:
        if sampling in ALONE and name in BESIDE or sampling == "BSDF" and name == "hidden":
            continue
        found = [_blocks(_render(name, sampling, 1, seed)) for seed in range(RENDERS)]
        error = np.hypot(np.std(found, axis=0, ddof=1) / np.sqrt(RENDERS), doubt)
        deviation = (np.mean(found, axis=0) - truth) / error
        assert np.abs(deviation).max() < 4.0, (sampling, deviation.round(1))


@pytest.mark.parametrize("name, gain", [("torus_room", 3.0), ("frame_lamp", 3.0), ("inside_lamp", 1.2), ("skin", 3.0)])
def test_cuts_are_less_noisy(name, gain):
    """Direct light, 16 samples: the median square difference of two renders; edges of objects are as noisy for both."""

    def noise(sampling):
        pairs = [[_render(name, sampling, 16, 2 * pair + which, bounces=0) for which in range(2)] for pair in range(4)]
        return np.median([(a - b) ** 2 for a, b in pairs])

    assert noise("CUT") * gain < noise("MIS")


def test_the_picture_does_not_depend_on_threads():
    """Boxes that a thread has found before are those that it would find again."""
    pictures = []
    for threads in (1, 3):
        scene = SCENES["field_lamps"](WIDTH, HEIGHT)
        scene.settings.samples, scene.settings.threads = 4, threads
        pictures.append(session.render(scene, ("Combined",)).read("Combined"))
    assert np.array_equal(*pictures)


def test_an_external_sampling_has_to_be_registered():
    scene = SCENES["torus_room"](WIDTH, HEIGHT)
    scene.settings.lamp_sampling, scene.settings.device = LampSampling.EXTERNAL, Device.CPU
    with pytest.raises(RenderError, match="none is registered"):
        session.render(scene, ("Combined",))


@pytest.mark.parametrize("name", ["BOUNDING", pytest.param("SURFACE", marks=pytest.mark.slow)])
def test_external_samplings_light_the_room_as_ours_does(name):
    """The mean of a picture of direct light, within 4 standard errors of eight renders."""
    found, ours = (
        [_render("torus_room", sampling, 4, seed, bounces=0).mean() for seed in range(8)] for sampling in (name, "CUT")
    )
    error = np.hypot(np.std(found, ddof=1), np.std(ours, ddof=1)) / np.sqrt(8.0)
    assert abs(np.mean(found) - np.mean(ours)) < 4.0 * error
