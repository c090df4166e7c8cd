# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU back end for ``session``: a packed scene, one program, and dispatches of pixels."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, wait

import numpy as np

from ...emitter.building.remarks import unresolved
from ...interruption import Watch, check, watched
from ...interruption import say as say_to_watch
from ..errors import RenderError
from ..film import Film
from ..motion import still
from ..scene import Scene
from .device import DeviceError, device, megabytes
from .packed_scene import TEXTURE_BITS, GpuScene, film_places

POLL_SECONDS = 0.05
GROUP = 64  # threads of a work group, as film.glsl has it
SLAB = 1 << 18  # pixels whose sums are on the GPU at a time
TARGET_SECONDS = 0.06  # of a dispatch
FIRST_WORK = 512  # samples of the first dispatch, whose speed is unknown
MOST_SAMPLES = 1 << 10  # of a thread in a dispatch


class GpuRenderer:
    """Renders ``scene`` into ``film``. ``cancelled`` and ``say`` are for the set-up, which compiles for some seconds.

    Raises ``DeviceError`` if the CPU must take over; so does ``sample``.
    """

    def __init__(self, scene: Scene, film: Film, cancelled: Callable[[], bool], say: Callable[[str], None]):
        self._film, self._warnings = film, scene.warnings
        self._device = device()
        scene.warnings += film.beyond("The GPU")
        self._made: list = []
        self._places, self._size = film_places(film)
        self._work, self._longest = FIRST_WORK, MOST_SAMPLES
        self._seed, self._offset = scene.settings.seed, scene.settings.sample_offset
        if scene.shutter is not None:
            scene.warnings.append(
                "Motion blur is not supported on the GPU: the frame is rendered without it; choose the CPU as device."
            )
        say("Building the scene")
        self.ready = self._set_up(scene, cancelled, say)

    @property
    def name(self) -> str:
        """See ``interfaces.BackEnd``."""
        return f"GPU ({self._device.name})"

    def _set_up(self, scene: Scene, cancelled: Callable[[], bool], say: Callable[[str], None]) -> bool:
        """Wait for ``_prepare``, and report its step. Returns False if cancelled. Then a driver's compiler, which
        cannot be stopped, ends by itself."""
        ended = threading.Event()
        watch = Watch(ended.is_set)
        future = self._device.submit(self._prepare, scene, watch)
        told = watch.doing
        while not future.done():
            if cancelled():
                ended.set()
                return False
            if watch.doing != told:
                told = watch.doing
                say(told)
            wait([future], POLL_SECONDS)
        self._result(future)
        return True

    def _call(self, function, *arguments):
        return self._result(self._device.submit(function, *arguments))

    @staticmethod
    def _result(future: Future):
        """The result of a function in the device's thread. After any failure there, the CPU takes over."""
        try:
            return future.result()
        except (DeviceError, RenderError):
            raise
        except Exception as error:
            raise DeviceError(f"it failed ({type(error).__name__}: {error})") from error

    def _prepare(self, context, scene: Scene, watch: Watch) -> None:
        with watched(watch):
            packed = GpuScene(still(scene), self._film, self._device.images, self._device.largest_buffer)
            self._packed = packed
            check()
            source = packed.source()
            check()
            say_to_watch("Compiling the scene's program for the GPU")
            self._program = self._device.program(context, source)
            check()
        words, second, uniforms = packed.tables.pack(packed.scalars)
        hierarchy = packed.hierarchy
        self._uniforms = self._buffer(context, uniforms)
        self._words, self._second = self._buffer(context, words), self._buffer(context, second)
        self._textures = [self._texture(context, array) for array in (hierarchy.nodes, hierarchy.items)]
        slab = min(SLAB, len(self._film.active))
        self._sums = self._buffer(context, np.zeros(slab * self._size, np.float32))
        self._pixels = self._buffer(context, np.zeros(1 + slab, np.uint32))
        self._lengths = self._buffer(context, np.zeros((max(len(packed.lamps), 1), 2), np.float32))

    def _buffer(self, context, array: np.ndarray):
        if array.nbytes > self._device.largest_buffer:
            raise DeviceError(
                f"the scene needs {megabytes(array.nbytes)} in one buffer, and it allows "
                f"{megabytes(self._device.largest_buffer)}"
            )
        return self._kept(
            self._device.allocate(
                context, array.nbytes, context.buffer, np.ascontiguousarray(array).view(np.uint8).reshape(-1)
            )
        )

    def _texture(self, context, array: np.ndarray):
        """Records of whole groups of four words, as rows of a texture of unsigned integers."""
        width = 1 << TEXTURE_BITS
        rows = -(-array.nbytes // (16 * width))
        if max(rows, width) > self._device.largest_texture:
            raise DeviceError(
                f"the scene's triangles need {megabytes(array.nbytes)} in one texture, and it allows "
                f"{megabytes(16 * width * self._device.largest_texture)}"
            )
        words = np.zeros((rows, width, 4), np.uint32)
        words.reshape(-1)[: array.nbytes // 4] = array.view(np.uint32).reshape(-1)
        return self._kept(
            self._device.allocate(context, words.nbytes, context.texture, (width, rows), 4, words, dtype="u4")
        )

    def _kept(self, made):
        """An object on the GPU that is released at the end."""
        self._made.append(made)
        return made

    def _bind(self) -> None:
        self._uniforms.bind_to_uniform_block(0)
        for binding, buffer in enumerate((self._words, self._sums, self._pixels, self._lengths, self._second)):
            buffer.bind_to_storage_buffer(binding)
        for unit, texture in enumerate(self._textures):
            if self._device.images:
                texture.bind_to_image(unit, read=True, write=False)
            else:
                texture.use(unit)
        x, y, _, _ = self._film.window
        self._program["film_place"] = x, y, self._film.width
        self._program["film_seed"], self._program["film_offset"] = self._seed, self._offset

    def _begin(self, context, pixels: np.ndarray) -> None:
        self._bind()
        self._pixels.write(np.concatenate([[0], pixels]).astype(np.uint32))
        self._sums.clear()

    def _run(self, context, place: int, count: int, first: int, end: int) -> tuple[float, bool]:
        """One dispatch, for the missing samples before ``end`` of a batch from ``first`` on. Returns its seconds, and
        whether all threads have finished. Unfinished threads leave no results."""
        started = time.perf_counter()
        self._program["work"] = place, count, first, end
        self._program.run(-(-count // GROUP))
        context.finish()
        finished = not np.frombuffer(self._pixels.read(4), np.uint32)[0]
        if not finished:
            self._pixels.write(np.zeros(1, np.uint32))
        return time.perf_counter() - started, finished

    def _collect(self, context, pixels: np.ndarray) -> None:
        """Add the GPU's sums to the film."""
        film = self._film
        sums = np.frombuffer(self._sums.read(len(pixels) * self._size * 4), np.float32).reshape(len(pixels), self._size)
        sums = sums.astype(np.float64)
        seen = sums[:, self._places["surfaces"]].astype(np.int32)
        fresh = (seen > 0) & (film.surfaces[pixels] == 0)
        for name, array in film.sums.items():
            if name in self._places:
                rows = array.reshape(len(film.active), -1)
                part = sums[:, self._places[name] : self._places[name] + rows.shape[1]]
                if name in ("position", "depth"):  # of the first sample that hit a surface
                    rows[pixels[fresh]] = part[fresh]
                else:
                    rows[pixels] += part
        discarded = film.discarded.reshape(len(film.active), -1)
        for column, name in enumerate(("nan", "infinite")):
            discarded[pixels, column] += sums[:, self._places[name]].astype(np.int32)
        if film.catches:
            first, columns = self._places["outputs"], film.light_sums.shape[1]
            film.light_sums[pixels] += sums[:, first : first + columns]
            film.data_sums[pixels] += sums[:, first + columns : first + columns + film.data_sums.shape[1]]
        film.count[pixels] += sums[:, self._places["count"]].astype(np.int32)
        film.surfaces[pixels] += seen

    def sample(self, first: int, count: int, stop: Callable[[], bool], report: Callable[[float], None]) -> bool:
        """Add samples ``first`` to ``first + count − 1`` to every active pixel. Returns False if stopped before the
        end."""
        if not self.ready:
            return False
        active = np.flatnonzero(self._film.active)
        total, done = len(active) * count, 0
        for start in range(0, len(active), SLAB):
            pixels = active[start : start + SLAB]
            self._call(self._begin, pixels)
            place, stopped = 0, False
            while place < len(pixels) and not stopped:
                threads = min(max(self._work // count // GROUP, 1) * GROUP, len(pixels) - place)
                sample = first
                while sample < first + count and not stopped:
                    end = min(sample + min(max(self._work // threads, 1), self._longest), first + count)
                    seconds, finished = self._call(self._run, place, threads, first, end)
                    if finished:
                        self._adapt(threads * (end - sample), seconds)
                        done += threads * (end - sample)
                        sample = end
                    else:
                        self._shorten(end - sample)
                    stopped = stop()
                    if not stopped:
                        report(done / total)
                place += threads
            self._call(self._collect, pixels)
            if stopped:
                return False
        self._film.samples = first + count
        return True

    def _adapt(self, samples: int, seconds: float) -> None:
        """Choose the size of dispatches by the time of the last one."""
        aim = samples * TARGET_SECONDS / max(seconds, 1e-4)
        self._work = int(min(max(aim, GROUP), 4 * self._work, 1 << 26))

    def _shorten(self, samples: int) -> None:
        """Make dispatches shorter: the driver has ended the loops of one with so many samples."""
        if samples == 1:
            raise DeviceError("its driver ends loops that take as many turns as rays through these lamps")
        self._longest = max(samples // 4, 1)

    def finish(self) -> None:
        """Warn about lamps with unresolved rays, and free the memory of the render; the film stays."""

        def release(context) -> np.ndarray:
            lengths = np.frombuffer(self._lengths.read(), np.float32).reshape(-1, 2) if self.ready else np.zeros((0, 2))
            for made in self._made:
                made.release()
            self._made = []
            return lengths

        released = self._device.submit(release)
        if self.ready:  # otherwise a compiler may be running, and a cancelled render does not wait for it
            self._warnings += unresolved(self._packed.lamps, self._result(released).astype(np.float64))
