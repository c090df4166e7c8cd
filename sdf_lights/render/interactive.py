# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A render that runs in a thread and restarts whenever the scene changes, for viewports.

The first picture after a change is coarse, so that it is ready within a fraction of a second. Finer ones follow, then
samples at full resolution. Unchanged parts are not built again: a move of the camera keeps the scene, an edit of a lamp
keeps the meshes.
"""

from __future__ import annotations

import dataclasses
import enum
import math
import threading
import time
from collections.abc import Callable

import numpy as np

from ..frozen import frozen
from ..interruption import Interrupted, Watch, watched
from . import sample_allocation
from .denoised_film import denoise_film
from .errors import RenderError
from .film import Film
from .interfaces import InteractiveBackEnd
from .scene import Camera, Ray, Scene
from .session import check_size, choose_back_end
from .settings import LARGEST_BATCH

# Seconds: maximum time of the first coarse picture, time between two published pictures, and maximum time of a batch of
# samples, which a pause does not interrupt.
FIRST_PICTURE, PUBLISH_INTERVAL, BATCH = 0.05, 0.15, 0.3
# Seconds that a scene has for its first picture before a newer scene replaces it: otherwise a continuously changing
# scene would never be seen.
OWED = 2.0 * FIRST_PICTURE
# The same for building lamps: while a slider is dragged, only lamps that take longer than this wait for its end.
LAMPS_OWED = 1.0
# Pixels along one pixel of a coarse picture: the maximum; the value while the speed is unknown; the factor from one
# picture to the next.
COARSEST, UNKNOWN, REFINEMENT = 16, 8, 4
# Pixels read between two checks for a newer scene.
BAND = 1 << 16
# Number of branches of paths in coarse pictures: they are seen only for a moment.
COARSE_BRANCHES = 8
# Largest value in a picture: viewports hold half floats.
GREATEST = 65000.0
# Number of samples at the first denoising; then at four times as many, and so on, and at the end.
FIRST_DENOISING = 4


class Change(enum.IntEnum):
    """The change since the previous scene. Each includes those before it."""

    VIEW = 0  # camera, size, border, settings
    LIGHTS = 1  # lamps and lights
    ALL = 2


@frozen
class Picture:
    """``pixels`` (height, width, RGBA) float32, contiguous, scene-linear, premultiplied, within the range of half
    floats, row 0 at the bottom. They show the part ``window`` (x0, y0, x1, y1) of a frame of ``size`` pixels; each
    covers ``divider`` pixels of the frame in both directions. ``camera``: the rendered camera. ``lamps``: whether it
    contains SDF lamps that the camera sees. ``number`` increases from picture to picture."""

    pixels: np.ndarray
    window: tuple[int, int, int, int]
    size: tuple[int, int]
    camera: Camera
    number: int
    divider: int
    samples: int
    lamps: bool


class InteractiveRender:
    """All methods except the thread's own return at once. Only one thread may call them.

    ``coarse_lamps``: whether the camera sees SDF lamps in coarse pictures; False if the owner draws them itself.
    """

    def __init__(self):
        self.coarse_lamps = True
        self._condition = threading.Condition()
        self._thread: threading.Thread | None = None
        self._pending: tuple[Scene, Change] | None = None
        self._stopping = self._held = self._paused = self._without_lamps = False
        self._owed = 0.0  # end of the wait for the first picture of a scene
        self._renderer: InteractiveBackEnd | None = None
        self._picture: Picture | None = None
        self._pace = 0.0  # seconds per sample of a pixel; 0: unknown yet
        self._next_denoising = FIRST_DENOISING
        self.status = ""
        self.error = ""
        self.warnings: list[str] = []
        self.finished = False

    # -- for the owner ------------------------------------------------------------------------------------------------

    def update(self, scene: Scene, change: Change) -> None:
        """Render ``scene`` from now on. It must not be changed afterwards."""
        with self._condition:
            if self._pending is not None:
                change = max(change, self._pending[1])
            self._pending, self._held = (scene, change), False
            self.finished, self.error = False, ""
            if self._thread is None:
                self._stopping = False
                self._thread = threading.Thread(target=self._work, name="SDF Lights: viewport", daemon=True)
                self._thread.start()
            self._condition.notify_all()
        self._interrupt()

    def hold(self) -> None:
        """Leave the processor to the owner, who is about to call ``update``."""
        if self._thread is None:
            return
        with self._condition:
            self._held = True
            self._condition.notify_all()
        self._interrupt()

    @property
    def picture(self) -> Picture | None:
        """The latest picture."""
        return self._picture

    @property
    def paused(self) -> bool:
        """Whether sampling waits until this is False again."""
        return self._paused

    @paused.setter
    def paused(self, value: bool) -> None:
        """Whether it waits with its present picture for ``resume``."""
        with self._condition:
            self._paused = value
            self._condition.notify_all()

    @property
    def active(self) -> bool:
        """Whether there may be a new picture before the scene changes."""
        return self._thread is not None and not self.finished and not self._paused

    def stop(self) -> None:
        """End the thread and wait for it. Its data is freed; ``update`` with ``Change.ALL`` starts again."""
        thread = self._thread
        if thread is None:
            return
        with self._condition:
            self._stopping, self._held = True, False
            self._pending = None
            self._condition.notify_all()
        self._interrupt()
        thread.join()
        self._thread = None

    # -- in the thread ------------------------------------------------------------------------------------------------

    def _interrupt(self) -> None:
        renderer = self._renderer
        if renderer is not None and self._outdated():
            renderer.interrupt()

    def _say(self, text: str) -> None:
        self.status = text

    def _outdated(self) -> bool:
        changed = self._held or self._pending is not None
        return self._stopping or (changed and time.perf_counter() > self._owed)

    def _useless(self) -> bool:
        """Whether the present build is useless for the waiting scene."""
        pending = self._pending
        return self._stopping or (pending is not None and pending[1] is Change.ALL and self._outdated())

    def _work(self) -> None:
        while True:
            with self._condition:
                while self._pending is None and not self._stopping:
                    self._condition.wait()
                if self._stopping:
                    break
                (scene, change), self._pending = self._pending, None
            try:
                self._render(scene, change)
            except RenderError as error:
                self._fail(str(error))
            except MemoryError:
                self._fail("The viewport ran out of memory: use fewer or smaller textures and meshes.")
            except Exception as error:
                self._fail(
                    f"Rendering in the viewport failed ({type(error).__name__}: {error}): start Blender with "
                    "--debug-python to see where, and report it."
                )
        self._drop()

    def _fail(self, sentence: str) -> None:
        self._drop()
        with self._condition:
            if self._pending is None:
                self.error = self.status = sentence
                self.finished = True
            else:
                self._pending = self._pending[0], Change.ALL

    def _drop(self) -> None:
        renderer, self._renderer = self._renderer, None
        if renderer is not None:
            renderer.finish()

    def _render(self, scene: Scene, change: Change) -> None:
        self._next_denoising, self._owed = FIRST_DENOISING, time.perf_counter() + OWED
        self._without_lamps = not self.coarse_lamps  # the owner may change that meanwhile
        divider = self._first_divider(scene)
        part, film = self._at_resolution(scene, divider)
        if not self._prepare(part, film, change):
            return
        self._owed = time.perf_counter() + OWED
        self.warnings = scene.warnings
        self.status = f"Sample 0/{scene.settings.samples}"
        while divider > 1:
            if not self._sample(film, 0, 1):
                return
            self._publish(scene, film, divider)
            divider //= REFINEMENT
            part, film = self._at_resolution(scene, divider)
            self._renderer.update_camera(part, film)
        self._refine(scene, film)

    def _prepare(self, scene: Scene, film: Film, change: Change) -> bool:
        """Update the back end to a scene. Returns False if a newer scene is waiting."""
        if self._renderer is None or change is Change.ALL:
            self._drop()
            check_size(scene)
            renderer = choose_back_end(scene)(scene, film, self._useless, self._say)
            if not renderer.ready:
                with self._condition:
                    # it may report a smaller change, relative to the scene that is not built
                    if self._pending is not None:
                        self._pending = self._pending[0], Change.ALL
                return False
            self._renderer = renderer
        else:
            if change is Change.LIGHTS and not self._update_lights(scene):
                return False
            self._renderer.update_camera(scene, film)
        return True

    def _update_lights(self, scene: Scene) -> bool:
        """Update the back end's lamps and lights. Returns False if newer ones are waiting and these take long."""
        owed = time.perf_counter() + LAMPS_OWED

        def stop() -> bool:
            return self._stopping or (self._pending is not None and time.perf_counter() > owed)

        try:
            with watched(Watch(stop)):
                self._renderer.update_lights(scene)
        except Interrupted:
            with self._condition:
                # it may report a smaller change, relative to the lamps that are not built
                if self._pending is not None:
                    self._pending = self._pending[0], max(self._pending[1], Change.LIGHTS)
            return False
        return True

    def _refine(self, scene: Scene, film: Film) -> None:
        """All samples at full resolution."""
        settings = scene.settings
        deadline = time.perf_counter() + settings.time_limit if settings.time_limit > 0.0 else math.inf
        first, going_on = 0, True
        while going_on and self._wait_while_paused():
            self.status = f"Sample {first}/{settings.samples}"
            count = min(self._batch(film), settings.samples - first, sample_allocation.samples_left(film))
            # Until every pixel has a sample, the coarse picture is better.
            if not self._sample(film, first, count, (lambda: self._publish(scene, film)) if first else lambda: None):
                return
            first += count
            going_on = first < settings.samples and time.perf_counter() < deadline
            sample_allocation.update(film, settings)
            if settings.noise_threshold > 0.0 and first >= settings.min_samples:
                going_on = film.update_active(settings.noise_threshold) and going_on
            if settings.denoise and (not going_on or first >= self._next_denoising):
                self._denoise(film, first)
            self._publish(scene, film)
        if not going_on:
            self.status = f"Sample {first}/{settings.samples}"
            with self._condition:
                self.finished = self._pending is None

    def _sample(self, film: Film, first: int, count: int, show: Callable[[], None] = lambda: None) -> bool:
        """Add samples, and show the picture from time to time. Returns False if the scene is outdated."""
        started = published = time.perf_counter()

        def report(done: float) -> None:
            nonlocal published
            if time.perf_counter() - published >= PUBLISH_INTERVAL:
                show()
                published = time.perf_counter()

        if not self._renderer.sample(first, count, self._outdated, report):
            return False
        taken = time.perf_counter() - started
        self._pace = taken / max(int(film.active.sum()) * count, 1)
        return True

    def _first_divider(self, scene: Scene) -> int:
        """Pixels along one pixel of the first coarse picture."""
        pixels = scene.width * scene.height
        if not self._pace:
            return UNKNOWN
        return min(max(math.ceil(math.sqrt(pixels * self._pace / FIRST_PICTURE)), 1), COARSEST)

    def _batch(self, film: Film) -> int:
        """Samples that take about ``BATCH`` seconds."""
        pixels = max(int(film.active.sum()), 1)
        return min(max(int(BATCH / (pixels * self._pace)), 1), LARGEST_BATCH) if self._pace else 1

    def _wait_while_paused(self) -> bool:
        """Returns False if the scene is outdated."""
        with self._condition:
            while self._paused and not self._outdated():
                self.status = "Paused"
                self._condition.wait()
        return not self._outdated()

    def _denoise(self, film: Film, samples: int) -> None:
        self._next_denoising = 4 * samples
        try:
            denoise_film(film, self._outdated)
        except RenderError as error:
            if str(error) not in self.warnings:
                self.warnings.append(str(error))

    def _publish(self, scene: Scene, film: Film, divider: int = 1) -> None:
        """Publish the film's picture. A large one is abandoned for a newer scene."""
        pixels = np.empty((film.height, film.width, 4), np.float32)
        rows = max(BAND // film.width, 1)
        for row in range(0, film.height, rows):
            if row and self._outdated():
                return
            band = slice(row, row + rows)
            np.clip(film.read("Combined", band), -GREATEST, GREATEST, out=pixels[band])
        window = tuple(divider * edge for edge in film.window)
        self._owed = 0.0
        number = self._picture.number + 1 if self._picture is not None else 1
        self._picture = Picture(
            pixels,
            window,
            (scene.width, scene.height),
            scene.camera,
            number,
            divider,
            film.samples,
            divider <= 1 or not self._without_lamps,
        )

    def _at_resolution(self, scene: Scene, divider: int) -> tuple[Scene, Film]:
        """The scene with pixels that are ``divider`` times as large, and a film for it. Its frame may reach beyond the
        right and the upper edge of the scene's, to end with a whole pixel."""
        if divider <= 1:
            return scene, Film(scene)
        width, height = -(-scene.width // divider), -(-scene.height // divider)
        border = None
        if scene.border is not None:
            x0, y0, x1, y1 = scene.border
            border = x0 // divider, y0 // divider, -(-x1 // divider), -(-y1 // divider)
        grown = width * divider / scene.width, height * divider / scene.height
        settings = dataclasses.replace(
            scene.settings, samples=1, denoise=False, indirect_paths=scene.settings.indirect_paths or COARSE_BRANCHES
        )
        lamps = scene.lamps
        if self._without_lamps:
            lamps = [dataclasses.replace(lamp, visibility=lamp.visibility & ~Ray.CAMERA) for lamp in lamps]
        part = dataclasses.replace(
            scene,
            camera=_widened(scene.camera, *grown),
            width=width,
            height=height,
            border=border,
            settings=settings,
            lamps=lamps,
        )
        return part, Film(part)


def _widened(camera: Camera, across: float, up: float) -> Camera:
    """The camera with a frame enlarged by these factors to the right and to the top."""

    def grow(low: float, high: float, factor: float) -> tuple[float, float]:
        return low, low + factor * (high - low)

    left, right, bottom, top = camera.window
    return dataclasses.replace(camera, window=(*grow(left, right, across), *grow(bottom, top, up)))
