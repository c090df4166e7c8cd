# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The CPU back end for ``session``: a packed scene, compiled kernels, and threads that take tiles."""

from __future__ import annotations

import itertools
import os
import threading
from collections.abc import Callable

import numpy as np

from ... import emitter as lamps
from ... import jit, kernel_cache
from ...interruption import Interrupted, Watch, check, watched
from .. import sample_allocation
from ..errors import RenderError
from ..film import Film
from ..scene import Scene
from ..settings import MOST_BRANCHES, PathReuse
from . import background
from .block import PackedScene, Workspace
from .caustic_paths import CausticTracer
from .hidden_parts import find_hidden_parts
from .light_paths import LightPaths
from .path_reuse import MOST_STEP, render_tile_reusing, step_for, supports_path_reuse
from .path_splitting import render_tile
from .pilot import (
    EVEN_REUSE_GAIN,
    GAIN,
    LEAST_POTENTIAL,
    LEAST_SAMPLES,
    LEAST_SHARED,
    MOST_OF_ROWS,
    REUSE_GAIN,
    ROWS_BRANCHES,
    SHARED_PROMISE,
    WHOLE_GAIN,
    GainEstimate,
    Pilot,
    ReusePilot,
    brought,
    gain,
    is_affordable,
    may_be_worthwhile,
    pilot_pixels,
)
from .pilot import SAMPLES as PILOT_SAMPLES

TILE = 32
POLL_SECONDS = 0.05
# Of pixels whose samples tell the noise that is not that of caustics: part, and most.
CAUSTIC_PART, CAUSTIC_PIXELS = 0.0625, 1 << 13
GRACE_SECONDS = 0.2  # seconds for a cancelled build to end


class CpuRenderer:
    """Renders ``scene`` into ``film``. ``cancelled`` and ``say`` are for the set-up, which may compile for a while."""

    name = "CPU"

    def __init__(self, scene: Scene, film: Film, cancelled: Callable[[], bool], say: Callable[[str], None]):
        self._scene, self._film, self._settings = scene, film, scene.settings
        self._warnings = scene.warnings
        self._packed: PackedScene | None = None
        self._light_paths: LightPaths | None = None
        self._caustics: CausticTracer | None = None
        self._may_reuse = self._reuses = False  # whether paths may share branches, and whether they do
        self._workspaces: list[Workspace] = []
        self._tiles = _tiles(film)
        self.ready = self._prepare(scene, cancelled, say)

    def _prepare(self, scene: Scene, cancelled, say) -> bool:
        """Pack the scene, and compile or load the kernels, in a separate thread. Returns False if cancelled."""
        say("Building the scene")
        failures: list[Exception] = []
        ended = threading.Event()
        watch = Watch(ended.is_set)

        def load() -> None:
            try:
                with watched(watch):
                    background.wait(check)
                    packed = PackedScene(scene, self._film)
                    check()
                self._workspaces = _workspaces(packed, scene, len(self._tiles))
                self._packed = packed
                self._find_strategies(scene, packed)
                for step in (MOST_STEP, 0) if self._may_reuse else (0,):
                    self._reuse(step)
                    self._render((0, 0, 0, 0), 0, self._workspaces[0])
            except Interrupted:
                pass
            except Exception as error:
                failures.append(error)

        compiled = jit.compiled_kernels()
        thread = threading.Thread(target=load)
        thread.start()
        thread.join(POLL_SECONDS)
        while thread.is_alive():
            if cancelled():
                ended.set()
                thread.join(GRACE_SECONDS)  # compiling cannot be stopped: it ends by itself
                return False
            say(_compiling(compiled) or watch.doing or "Building the scene")
            thread.join(2 * POLL_SECONDS)
        _raise_first(failures)
        scene.warnings += filter(None, (kernel_cache.problem(), kernel_cache.refused()))
        return True

    def update_lights(self, scene: Scene) -> None:
        """Take the lamps and lights of ``scene``, which is otherwise unchanged."""
        self._packed.update_lights(scene)
        self._scene = scene
        self._warnings = scene.warnings
        self._workspaces = _workspaces(self._packed, scene, len(self._tiles))
        self._find_strategies(scene, self._packed)

    def update_camera(self, scene: Scene, film: Film) -> None:
        """Take the camera, the settings and the ray visibility of lamps of ``scene``, and another film."""
        self._scene, self._film, self._settings, self._tiles = scene, film, scene.settings, _tiles(film)
        before = self._packed.output_counts
        self._packed.update_camera(scene, film)
        if self._packed.output_counts != before:
            self._workspaces = _workspaces(self._packed, scene, len(self._tiles))
        self._find_strategies(scene, self._packed)

    def _find_strategies(self, scene: Scene, packed: PackedScene) -> None:
        """Find out which parts of lamps are hidden, and which strategies for light that surfaces scatter the scene can
        have. None of these is used yet."""
        if packed.set_hidden_parts(find_hidden_parts(scene, packed, self._workspaces[0])):
            for workspace in self._workspaces:
                workspace.forget_regions()
        self._light_paths = LightPaths.of(scene, packed, self._workspaces)
        self._caustics = CausticTracer.of(scene, packed, self._workspaces)
        self._may_reuse = supports_path_reuse(scene, packed)
        self._reuse(0)

    def _reuse(self, step: int, connects: bool = False) -> None:
        """Let the paths of neighbouring pixels share their branches from now on, as ``PackedScene.set_path_reuse``."""
        self._reuses = step > 0
        self._packed.set_path_reuse(step, connects)

    @property
    def packed(self) -> PackedScene:
        """The scene as kernels read it, after a set-up that was not cancelled."""
        return self._packed

    def light_paths_of_whole_paths(self, stop: Callable[[], bool]) -> LightPaths | None:
        """Light paths for another back end, whose paths do not split: as the settings say, or if a pilot promises that
        they pay. None, too, if stopped before the end. The film stays as it is."""
        light_paths = self._light_paths
        if light_paths is None or not light_paths.automatic:
            return light_paths
        pixels = self._pilot_pixels(light_paths)
        without = self._trial(pixels, PILOT_SAMPLES, stop) if pixels is not None else None
        if without is None:
            return None
        found = self._try_light_paths(light_paths, pixels, without, stop, splits=False)
        return light_paths if found is not None and found.gain > 0.0 else None

    def interrupt(self) -> None:
        """Stop sampling within milliseconds, if ``stop`` also returns True then. Other threads may call this."""
        packed = self._packed
        if packed is not None:
            packed.control[0] = 1

    def _render(self, tile, samples: int, workspace: Workspace) -> None:
        render = render_tile_reusing if self._reuses else render_tile
        render(workspace.scene, workspace.block, *tile, samples)

    def sample(self, first: int, count: int, stop: Callable[[], bool], report: Callable[[float], None]) -> bool:
        """Add samples ``first`` to ``first + count − 1`` to every active pixel whose rate is 1. Returns False if
        stopped before the end.

        A tile is always complete or not begun, unless it is stopped, so every pixel knows its number of samples.
        """
        if not self.ready:
            return False
        film, begun = self._film, 0.0
        if first == 0 and self._caustics is not None and not self._begin_caustics(stop):
            return False
        if first == 0 and self._light_paths is not None and not self._light_paths.automatic:
            self._light_paths.use(first)
        before = sample_allocation.first_pixels(film, self._settings) if first == 0 else None
        if before is not None:
            begun = before.mean()
            if not self._sample_pixels(before, 1, stop, lambda part: report(begun * part)):
                return False
            sample_allocation.divide(film, self._settings)
        if first == 0 and not self._choose(stop):
            return False
        at, end = first, first + count
        while at < end:
            to: int | None = min(self._light_paths.use(at), end) if self._light_paths is not None else end
            if self._caustics is not None:
                to = self._caustics.use(film, at, to, stop)
            if to is None:
                return False

            def report_part(part: float, at: int = at, to: int = to) -> None:
                report(begun + (1.0 - begun) * (at - first + part * (to - at)) / count)

            if not self._sample_active(to, stop, report_part):
                return False
            at = to
        film.samples = end
        return True

    def _begin_caustics(self, stop: Callable[[], bool]) -> bool:
        """Use caustic paths, as the settings say, or where they pay. Returns False if stopped before the end."""
        active = self._film.active
        part = min(CAUSTIC_PART, CAUSTIC_PIXELS / len(active))
        pixels = (sample_allocation.golden_ratio_sequence(len(active)) < part).astype(active.dtype)
        if not self._caustics.begin(lambda: self._trial(pixels, PILOT_SAMPLES, stop)):
            self._caustics = None
        return not stop()

    def _choose(self, stop: Callable[[], bool]) -> bool:
        """Use light paths, path reuse or both, as the settings say, or where they pay. The film begins anew if a
        measurement decides for any. Returns False if stopped before the end."""
        light_paths, self._light_paths = self._light_paths, None
        self._reuse(0)
        if light_paths is not None and not light_paths.automatic:
            self._light_paths = light_paths
            if self._may_reuse and self._settings.path_reuse is PathReuse.ALWAYS:
                self._reuse(MOST_STEP, True)
            return True
        pixels = self._pilot_pixels(light_paths) if light_paths is not None else None
        rows = self._rows_to_reuse()
        wanted = [each for each in (pixels, rows) if each is not None]
        if not wanted:
            return True
        without = self._first_samples(np.any(wanted, axis=0), stop)
        if without is None:
            return False
        connected = GainEstimate() if pixels is None else self._try_light_paths(light_paths, pixels, without, stop)
        if connected is None:
            return False
        alone = ReusePilot(without, self._settings) if rows is not None else None
        reused = GainEstimate() if rows is None else self._try_reuse(rows, alone, stop)
        if reused is None:
            return False
        shared = GainEstimate()
        if connected.gain > 0.0 and reused.gain > LEAST_SHARED:
            shared = self._share(rows, alone, reused.step, stop, light_paths)
            if shared is None:
                return False
        best = max(shared, reused, key=lambda estimate: estimate.gain)
        least = EVEN_REUSE_GAIN if best.step == 1 else REUSE_GAIN
        if best.gain > max(least, connected.gain):
            self._film.clear()
            self._film.shares = best is reused
            sample_allocation.begin_with(self._film, self._settings, best.branches)
            self._reuse(best.step, best is shared)
            self._light_paths = light_paths if best is shared else None
        elif connected.gain > 0.0:
            self._film.clear()
            self._light_paths = light_paths
        return True

    def _pilot_pixels(self, light_paths: LightPaths) -> np.ndarray | None:
        """The pixels that try light paths; None if they are not worth that."""
        film, samples = self._film, self._settings.samples
        pixels = pilot_pixels(film, samples)
        return pixels if pixels is not None and is_affordable(pixels, light_paths, film, samples) else None

    def _rows_to_reuse(self) -> np.ndarray | None:
        """The pixels that try path reuse; None if it is not tried."""
        settings = self._settings
        tried = self._may_reuse and (settings.samples >= LEAST_SAMPLES or settings.path_reuse is PathReuse.ALWAYS)
        return sample_allocation.bands(self._film, MOST_OF_ROWS) if tried else None

    def _first_samples(self, pixels: np.ndarray, stop: Callable[[], bool]) -> Film | None:
        """A film with as many samples of these pixels as tell their noise: the picture's, unless it is to have fewer.
        None if stopped before the end."""
        if self._settings.samples < PILOT_SAMPLES:
            return self._trial(pixels, PILOT_SAMPLES, stop)
        return self._film if self._sample_pixels(pixels, PILOT_SAMPLES, stop, lambda part: None) else None

    def _try_light_paths(
        self, light_paths: LightPaths, pixels: np.ndarray, without: Film, stop: Callable[[], bool], splits: bool = True
    ) -> GainEstimate | None:
        """The gain of light paths, by these pixels, for paths that split or not; None if stopped before the end."""
        alone = Pilot.of(without, pixels)
        if not may_be_worthwhile(alone):
            return GainEstimate()
        connected = self._trial(pixels, PILOT_SAMPLES, stop, light_paths)
        if connected is None:
            return None
        promise = gain(alone, Pilot.of(connected, pixels), splits)
        least = GAIN if splits else WHOLE_GAIN
        return GainEstimate(brought(promise, light_paths.has_lamps()) if promise > least else 0.0)

    def _try_reuse(self, rows: np.ndarray, alone: ReusePilot, stop: Callable[[], bool]) -> GainEstimate | None:
        """The gain of path reuse, by these rows of pixels; None if stopped before the end."""
        always = self._settings.path_reuse is PathReuse.ALWAYS
        if not always and alone.potential() < LEAST_POTENTIAL:
            return GainEstimate()
        for workspace in self._workspaces:
            workspace.arrivals()[:] = 0
        step, found = MOST_STEP, self._share(rows, alone, MOST_STEP, stop)
        while found is not None and step != (wanted := step_for(self._arrivals())):
            step = wanted
            if self._arrivals()["uneven"].any():  # else it is the same with any step
                found = self._share(rows, alone, step, stop)
        return None if found is None else GainEstimate(np.inf if always else found.gain, step, found.branches)

    def _share(
        self,
        rows: np.ndarray,
        alone: ReusePilot,
        step: int,
        stop: Callable[[], bool],
        light_paths: LightPaths | None = None,
    ) -> GainEstimate | None:
        """The gain of path reuse with this step, with ``light_paths`` or without; None if stopped before the end."""
        self._reuse(step, light_paths is not None)
        shared = self._trial(rows, 1, stop, light_paths, ROWS_BRANCHES)
        self._reuse(0)
        if shared is None:
            return None
        promise, branches = alone.gain(shared)
        of_lamps = light_paths is not None and light_paths.has_lamps()
        return GainEstimate(promise / SHARED_PROMISE if of_lamps else promise, step, branches)

    def _arrivals(self) -> np.ndarray:
        return np.concatenate([workspace.arrivals() for workspace in self._workspaces])

    def _trial(
        self,
        pixels: np.ndarray,
        samples: int,
        stop: Callable[[], bool],
        light_paths: LightPaths | None = None,
        most_branches: int = MOST_BRANCHES,
    ) -> Film | None:
        """A film of its own, with samples of some pixels, with ``light_paths`` or without; None if stopped before the
        end."""
        trial = Film(self._scene, self._film.passes)
        trial.branches[:] = np.minimum(self._film.branches, most_branches)
        trial.active[:] = self._film.active & pixels
        self._packed.set_film(self._scene, trial)
        done = True
        for sample in range(samples):
            if light_paths is not None:
                light_paths.use_pilot(sample)
            done = done and self._sample_active(sample + 1, stop, lambda part: None)
        if light_paths is not None:
            light_paths.rest()
        self._packed.set_film(self._scene, self._film)
        return trial if done else None

    def _sample_pixels(self, pixels: np.ndarray, samples: int, stop, report: Callable[[float], None]) -> bool:
        """``_sample_active`` for those active pixels where ``pixels`` is 1."""
        active = self._film.active.copy()
        self._film.active &= pixels
        done = self._sample_active(samples, stop, report)
        self._film.active[:] = active
        return done

    def _sample_active(self, samples: int, stop: Callable[[], bool], report: Callable[[float], None]) -> bool:
        """Add samples to the active pixels until those whose rate is 1 have ``samples``. Returns False if stopped
        before the end."""
        control = self._packed.control
        control[:] = 0
        if stop():  # an interrupt before that line has already set this
            return False
        order, failures, finished = itertools.count(), [], itertools.count()
        done = 0

        def work(workspace: Workspace) -> None:
            nonlocal done
            try:
                for index in order:
                    if index >= len(self._tiles) or control[0]:
                        return
                    self._render(self._tiles[index], samples, workspace)
                    done = next(finished) + 1
            except Exception as error:
                failures.append(error)
                control[0] = 1

        threads = [threading.Thread(target=work, args=(workspace,)) for workspace in self._workspaces]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(POLL_SECONDS)
            while thread.is_alive():
                if not control[0]:
                    if stop():
                        control[0] = 1
                    else:
                        report(min(done / len(self._tiles), 1.0))
                thread.join(POLL_SECONDS)
        _raise_first(failures)
        return not control[0] and not stop()

    def finish(self) -> None:
        """Warn about lamps with unresolved rays, and free data that the render no longer needs; the film stays."""
        if self.ready:
            lengths = sum(workspace.lamp_lengths() for workspace in self._workspaces)
            self._warnings += lamps.unresolved(self._packed.lamps, lengths)
            self._packed.release()


def _compiling(before: int) -> str:
    """The progress of the kernels, in words; "" if none are compiling. ``before``: ``jit.compiled_kernels()`` at the
    start."""
    if jit.compiled_kernels() - before <= 1:
        return background.text()
    return background.sentence(*jit.progress([render_tile, *jit.begun()]))


def _tiles(film: Film) -> list[tuple[int, int, int, int]]:
    x0, y0, x1, y1 = film.window
    return [(x, y, min(x + TILE, x1), min(y + TILE, y1)) for y in range(y0, y1, TILE) for x in range(x0, x1, TILE)]


def _workspaces(packed: PackedScene, scene: Scene, tiles: int) -> list[Workspace]:
    """One workspace for each thread: at most as many as tiles, and as many as memory allows."""
    wanted = min(scene.settings.threads or os.cpu_count() or 1, max(tiles, 1))
    found = [Workspace(packed)]
    try:
        while len(found) < wanted:
            found.append(Workspace(packed))
    except MemoryError:
        del found[max(len(found) // 2, 1) :]  # the rest of the render needs memory, too
        scene.warnings.append(
            f"There is no memory for {wanted} threads, so only {len(found)} render: choose fewer threads in the "
            "performance settings."
        )
    return found


def _raise_first(failures: list[Exception]) -> None:
    if failures and isinstance(failures[0], RenderError):
        raise failures[0]
    if failures:
        raise RenderError(
            f"The CPU back end failed ({type(failures[0]).__name__}: {failures[0]}): start Blender with "
            "--debug-python to see where, and report it."
        ) from failures[0]
