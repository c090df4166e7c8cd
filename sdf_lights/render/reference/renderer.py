# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference for ``session``: waves of samples, traced and added to the film."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..film import CAUGHT_LIGHT, DISCARDED, HALF_BIT, Film
from ..motion import at, part_of, time_of
from ..passes import CATCHER_SUMS
from ..scene import Scene
from .integrator import Integrator
from .paths import Samples

# Rays of one wave: large enough for NumPy, small enough to be stopped within a fraction of a second.
WAVE = 8192


class ReferenceRenderer:
    """Renders ``scene`` into ``film``; an ``interfaces.InteractiveBackEnd``.

    ``use_embree`` as in ``Geometry``: None uses Embree for all but small scenes.
    """

    name = "NumPy reference"

    def __init__(
        self,
        scene: Scene,
        film: Film,
        cancelled: Callable[[], bool] = lambda: False,
        say: Callable[[str], None] = lambda text: None,
        use_embree: bool | None = None,
    ):
        say("Building the scene")
        self._film, self._seed, self._scene = film, scene.settings.seed, scene
        scene.warnings += film.beyond("The NumPy reference")
        self._use_embree = use_embree
        self._integrator = Integrator(scene, use_embree)
        self.ready = True

    def update_lights(self, scene: Scene) -> None:
        """Take the lamps and lights of ``scene``, which is otherwise unchanged."""
        self._scene = scene
        self._integrator = Integrator(scene, self._use_embree)

    def update_camera(self, scene: Scene, film: Film) -> None:
        """Take the camera, the settings and the ray visibility of lamps of ``scene``, and another film."""
        self._film, self._seed, self._scene = film, scene.settings.seed, scene
        self._integrator = Integrator(scene, self._use_embree)

    def interrupt(self) -> None:
        """Nothing to do: ``stop`` is polled often enough."""

    def sample(self, first: int, count: int, stop: Callable[[], bool], report: Callable[[float], None]) -> bool:
        """Add samples ``first`` to ``first + count − 1`` to every active pixel. Returns False if stopped before the
        end.

        The picture depends only on the seed and on ``first`` and ``count`` of the calls.
        """
        film, shutter = self._film, self._scene.shutter
        active = np.flatnonzero(film.active)
        if shutter is None:
            if not self._sample(active, first, count, stop, report):
                return False
        else:
            rows = active // film.width
            # All pixels of a sample share one time; with a rolling shutter, those of a line.
            groups = [active] if shutter.rolling is None else [active[rows == row] for row in np.unique(rows)]
            for index in range(first, first + count):
                for pixels in groups:
                    height = (pixels[0] // film.width + film.window[1]) / self._scene.height
                    part = part_of(self._seed, self._scene.settings.sample_offset + index)
                    time = time_of(shutter, part, height)
                    self._integrator = Integrator(at(self._scene, time), self._use_embree)
                    if not self._sample(pixels, index, 1, stop, lambda part: report((index - first) / count)):
                        return False
        film.samples = first + count
        return True

    def _sample(
        self, active: np.ndarray, first: int, count: int, stop: Callable[[], bool], report: Callable[[float], None]
    ) -> bool:
        """As ``sample``, for the pixels ``active``."""
        film = self._film
        total, taken = len(active) * count, self._scene.settings.sample_offset + first
        for start in range(0, total, WAVE):
            index, place = np.divmod(np.arange(start, min(start + WAVE, total)), len(active))
            pixel = active[place]
            row, column = np.divmod(pixel, film.width)
            rng = np.random.Generator(np.random.Philox(np.random.SeedSequence([self._seed, taken, start])))
            samples = self._integrator.trace(column + film.window[0], row + film.window[1], rng, stop)
            if samples is None:
                return False
            self._add(pixel, first + index, samples)
            report(min((start + WAVE) / total, 1.0))
        return True

    def _add(self, pixel: np.ndarray, index: np.ndarray, samples: Samples) -> None:
        """Add one sample of each of the pixels, which may repeat; ``index`` is the number of the sample in its
        pixel."""
        film = self._film
        total = samples.combined.sum(axis=1) + samples.alpha
        finite = np.isfinite(total)
        for kind, is_kind in enumerate((np.isnan, np.isinf)):
            np.add.at(film.discarded, len(DISCARDED) * pixel[is_kind(total)] + kind, 1)
        np.add.at(film.count, pixel, 1)
        rows = np.flatnonzero(finite)
        half = np.flatnonzero(finite & (index & HALF_BIT != 0))
        surface = np.flatnonzero(finite & samples.found)
        self._sum("combined", pixel[rows], np.concatenate([samples.combined, samples.alpha[:, None]], 1)[rows])
        self._sum("half", pixel[half], samples.combined[half])
        for name in ("lamps", "emission", "environment", "diffuse_albedo"):
            self._sum(name, pixel[rows], getattr(samples, name)[rows])
        if film.catches:
            self._add_catchers(pixel[rows], rows, samples)
        for name in ("normal", "albedo"):
            self._sum(name, pixel[surface], getattr(samples, name)[surface])
        # Distances are those of the first sample that hit a surface.
        new, where = np.unique(pixel[surface], return_index=True)
        where = surface[where[film.surfaces[new] == 0]]
        new = pixel[where]
        self._sum("position", new, samples.position[where])
        self._sum("depth", new, self._integrator.data.camera.depth(samples.position[where])[:, None])
        np.add.at(film.surfaces, pixel[surface], 1)

    def _add_catchers(self, pixel: np.ndarray, rows: np.ndarray, samples: Samples) -> None:
        film = self._film
        np.add.at(
            film.light_sums, (pixel[:, None], film.light_places[CAUGHT_LIGHT] + np.arange(3)), samples.light[rows]
        )
        for name in CATCHER_SUMS:
            values = getattr(samples, name)[rows].reshape(len(rows), -1)
            np.add.at(film.data_sums, (pixel[:, None], film.data_places[name] + np.arange(values.shape[1])), values)

    def _sum(self, name: str, pixel: np.ndarray, values: np.ndarray) -> None:
        sums = self._film.sums[name]
        if sums.size:
            np.add.at(sums.reshape(-1, values.shape[1]), pixel, values)

    def finish(self) -> None:
        """Free data that the render no longer needs; the film keeps its own arrays."""
        self._integrator = None
