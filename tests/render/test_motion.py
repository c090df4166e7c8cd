# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses between poses, exposures, and pictures of what moves. ``test_agreement.py`` compares them with the
reference."""

from dataclasses import replace

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.render import motion
from sdf_lights.render.film import Film
from sdf_lights.render.lights.point import PointLight
from sdf_lights.render.scene import Ray, Shutter
from sdf_lights.render.settings import LampPaths, PathReuse
from sdf_lights.sdf.shapes import Box, Difference, Sphere, Torus
from support import scenes


def test_rotations_follow_their_arc():
    start = scenes.translation(1.0, 0.0, 0.0) @ scenes.scaling(2.0, 1.0, 1.0)
    found = motion.poses(np.stack([start, scenes.rotation("z", 90.0) @ scenes.scaling(3.0, 1.0, 1.0)]))
    middle = motion.between(found, 0.5)
    np.testing.assert_allclose(middle[:3, 3], (0.5, 0.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(
        middle[:3, :3], (scenes.rotation("z", 45.0) @ scenes.scaling(2.5, 1.0, 1.0))[:3, :3], atol=1e-9
    )
    assert np.array_equal(found[0], start) and 129 >= len(found) > 64
    # Between poses of the arc it is straight lines, which are nowhere far from it.
    quarter = motion.between(found, 0.2503)
    expected = scenes.rotation("z", 0.2503 * 90.0) @ scenes.scaling(2.2503, 1.0, 1.0)
    np.testing.assert_allclose(quarter[:3, :3], expected[:3, :3], atol=3e-5)


def test_half_a_turn_and_mirrored_poses():
    for matrix in (scenes.rotation("x", 180.0), scenes.rotation("y", 180.0), scenes.scaling(-1.0, 1.0, 1.0)):
        found = motion.poses(np.stack([scenes.scaling(1.0, 1.0, 1.0), matrix]))
        np.testing.assert_allclose(found[-1], matrix, atol=1e-12)
        assert np.isfinite(found).all()
    mirrored = motion.poses(
        np.stack([scenes.scaling(-1.0, 1.0, 1.0), scenes.rotation("z", 40.0) @ scenes.scaling(-1.0, 1.0, 1.0)])
    )
    assert (np.linalg.det(mirrored[:, :3, :3]) < -0.99).all()


def test_what_only_slides_has_its_own_poses():
    matrices = np.stack([scenes.translation(x, 0.0, 0.0) for x in (0.0, 1.0, 5.0)])
    assert np.array_equal(motion.poses(matrices), matrices)


def test_an_exposure_has_its_density():
    times = motion.exposure(np.array([0.0, 0.0, 1.0, 1.0, 0.0]))
    u = (np.arange(100000) + 0.5) / 100000
    drawn = np.interp(u, np.linspace(0.0, 1.0, len(times)), times)
    expected = np.array([0.0, 0.25, 0.5, 0.25])  # of a density that rises, stays and falls
    np.testing.assert_allclose(np.histogram(drawn, 4, (0.0, 1.0))[0] / 100000, expected, atol=2e-3)


def test_a_shutter_that_never_opens_counts_as_open():
    assert np.array_equal(motion.exposure(np.zeros(5)), (0.0, 1.0))


@pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")
class TestPictures:
    @staticmethod
    def picture(scene, samples: int = 8) -> np.ndarray:
        from sdf_lights.render.cpu.renderer import CpuRenderer

        scene.settings.threads = 2
        film = Film(scene, ("Combined",))
        renderer = CpuRenderer(scene, film, lambda: False, lambda text: None)
        assert renderer.sample(0, samples, lambda: False, lambda part: None)
        renderer.finish()
        assert not scene.warnings
        return film.read("Combined")

    @pytest.mark.parametrize(("path_reuse", "rolling"), [(PathReuse.NEVER, 0.5), (PathReuse.ALWAYS, None)])
    def test_what_stands_still_has_the_same_bits_by_any_shutter(self, path_reuse, rolling):
        plain, open_long = scenes.torus_room(24, 16), scenes.torus_room(24, 16)
        for scene in (plain, open_long):
            scene.settings.lamp_paths, scene.settings.path_reuse = LampPaths.NEVER, path_reuse
        open_long.shutter = Shutter(motion.exposure(np.array([0.0, 1.0])), rolling)
        assert np.array_equal(self.picture(plain), self.picture(open_long))

    def test_threads_have_times_of_their_own(self):
        """A picture does not depend on who has rendered what."""
        first, second = self.picture(scenes.moving(72, 40), 2), self.picture(scenes.moving(72, 40), 2)
        assert np.array_equal(first, second)

    def test_the_picture_is_the_mean_of_those_at_all_times(self):

        def build():
            scene = scenes.moving(16, 12)
            scene.shutter = Shutter()
            for light in scene.lights:  # seen by the camera they would be small and bright, and noisy
                for each in (light, *light.motion):
                    each.visibility = Ray.ALL & ~Ray.CAMERA
            return scene

        blurred = self.picture(build(), 256)[..., :3].astype(float)
        times = (np.arange(16) + 0.5) / 16
        still = [self.picture(motion.at(build(), time), 32)[..., :3].astype(float) for time in times]
        assert blurred.mean() == pytest.approx(np.mean(still), rel=0.01)

    def test_a_lamp_that_moves_off_does_not_light_what_it_has_left(self):
        """All of its light comes from where it is at the time of a ray: seen by itself, on a black ground."""
        scene = scenes.torus_room(24, 16)
        scene.instances, scene.camera = [], scenes.camera((0.0, -5.5, 1.8), (0.0, 0.0, 1.8), 24, 16, 0.42)
        lamp = scene.lamps[0]
        far = scenes.translation(1.2, 0.0, 0.0) @ lamp.matrix
        lamp.motion = motion.resampled((lamp, replace(lamp, matrix=far)))
        scene.shutter = Shutter()
        blurred = self.picture(scene, 512)[..., :3]
        mean = 0.0
        for x in (np.arange(64) + 0.5) / 64 * 1.2:
            still = scenes.torus_room(24, 16)
            still.instances, still.camera = [], scene.camera
            still.lamps[0].matrix = scenes.translation(x, 0.0, 0.0) @ still.lamps[0].matrix
            mean = mean + self.picture(still, 16)[..., :3] / 64
        np.testing.assert_allclose(blurred, mean, atol=0.03 * mean.max())

    @staticmethod
    def change(shapes, **other):
        """A torus room whose lamp has these shapes, with no surface, so that only the camera sees it."""
        scene = scenes.torus_room(24, 16)
        scene.instances, scene.camera = [], scenes.camera((0.0, -5.5, 1.8), (0.0, 0.0, 1.8), 24, 16, 0.42)
        lamp = scene.lamps[0]
        states = [replace(lamp, shape=shape) for shape in shapes]
        states[-1] = replace(states[-1], **other)
        lamp.shape, lamp.motion, scene.shutter = shapes[0], motion.resampled(tuple(states)), Shutter()
        return scene

    def compare_with_stills(self, scene):
        """Means of blocks of four by four pixels: noise is 1 %."""
        stills = []
        for index in range(64):
            still = motion.at(scene, (index + 0.5) / 64)
            still.settings = replace(scene.settings, seed=index)
            stills.append(self.picture(still, 16)[..., :3])
        found, expected = (
            each.astype(float).reshape(4, 4, 6, 4, 3).mean(axis=(1, 3))
            for each in (self.picture(scene, 1024)[..., :3], np.mean(stills, axis=0))
        )
        np.testing.assert_allclose(found, expected, atol=0.02 * expected.max())
        assert found.mean() == pytest.approx(expected.mean(), rel=0.01)

    @pytest.mark.parametrize(
        "shapes",
        [
            *(
                pytest.param(shapes, marks=pytest.mark.slow)
                for shapes in (
                    (Torus(0.3, 0.1), Torus(0.8, 0.05), Torus(0.5, 0.2)),
                    (Difference(Box(0.3), Sphere(0.35)), Difference(Box(0.6), Sphere(0.75))),
                )
            ),
            (Torus(0.3, 0.1), Box(0.4)),
        ],
    )
    def test_a_lamp_that_changes_its_shape_is_the_mean_of_those_at_all_times(self, shapes):
        self.compare_with_stills(self.change(shapes, power=30.0))

    @pytest.mark.slow
    def test_a_lamp_that_grows_by_its_transform_has_all_of_its_light(self):
        """Its volume, matrix and inverse are not linear in time."""
        lamp = self.change((Torus(0.3, 0.1), Torus(0.3, 0.1))).lamps[0]
        scene = self.change((lamp.shape,) * 2, matrix=lamp.matrix @ scenes.scaling(3.0, 2.0, 1.0))
        self.compare_with_stills(scene)

    @pytest.mark.slow
    def test_a_light_that_grows_has_all_of_its_light(self):
        scene = scenes.torus_room(24, 16)
        scene.lamps, scene.shutter = [], Shutter()
        light = PointLight("grows", scenes.translation(0.0, -0.5, 1.2), 10.0, radius=0.05)
        scene.lights.append(replace(light, motion=motion.resampled((light, replace(light, radius=0.5)))))
        self.compare_with_stills(scene)

    @pytest.mark.slow
    def test_the_room_is_lit_by_a_lamp_that_changes(self):
        scene = scenes.changing_lamps(16, 12)
        times = (np.arange(32) + 0.5) / 32
        scene.shutter = Shutter()
        still = np.mean([self.picture(motion.at(scene, time), 16)[..., :3] for time in times])
        assert self.picture(scene, 256)[..., :3].mean() == pytest.approx(still, rel=0.01)

    def test_a_lamp_that_is_empty_at_some_times_is_dark_then(self):
        """The box lies inside the ball in the first half, at the frame, too."""
        shapes = Difference(Box(0.1), Sphere(0.7)), Difference(Box(0.9), Sphere(0.7))
        scene = self.change(shapes)
        whole = self.change((shapes[1], shapes[1]))
        seen, bright = (self.picture(each, 64)[..., :3].mean() for each in (scene, whole))
        assert 0.2 * bright < seen < 0.8 * bright
