# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU back end for ``session``: a packed scene, one program, and dispatches of pixels."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait

import numpy as np

from ...emitter.building.remarks import unresolved
from ...interruption import Watch, check, watched
from ...interruption import say as say_to_watch
from ..errors import RenderError
from ..film import Film
from ..interfaces import LightPathTracer
from ..motion import at, changes_shape, part_of, time_of
from ..scene import Scene
from . import streamed, thread_arrays
from .bvh import Hierarchy
from .device import DeviceError, device, megabytes
from .packed_scene import TEXTURE_BITS, GpuScene, film_places

POLL_SECONDS = 0.05
SLAB = 1 << 18  # pixels whose sums are on the GPU at a time
SLAB_OF_CARD, SLAB_BYTES = 1 << 20, 1 << 28  # likewise, and the most bytes of them, on a graphics card
TARGET_SECONDS = 0.06  # of a dispatch
FIRST_WORK = 512  # samples of the first dispatch, whose speed is unknown
ARRAYS_BYTES = 1 << 29  # most bytes of the arrays of all threads of a dispatch
MOST_SAMPLES = 1 << 10  # of a thread in a dispatch
# Samples of a thread in a dispatch of a graphics card, as long as there are more pixels: many short threads end at
# about the same time, but a thread with few samples begins its next one seldom while others of its group continue.
LEAST_SAMPLES = 8


def _add(array: np.ndarray, rows, part: np.ndarray) -> None:
    """Add ``part`` (columns, n) to these n rows of ``array``, column by column: all at a time takes longer."""
    for column, numbers in enumerate(part):
        array[rows, column] += numbers


class GpuRenderer:
    """Renders ``scene`` into ``film``. ``cancelled`` and ``say`` are for the set-up, which compiles for some seconds.
    ``trace`` finds the light paths of a scene, if it has some: see ``render/light_paths.py``.

    Raises ``DeviceError`` if the CPU must take over; so does ``sample``.
    """

    def __init__(
        self,
        scene: Scene,
        film: Film,
        cancelled: Callable[[], bool],
        say: Callable[[str], None],
        trace: Callable[..., LightPathTracer | None] = lambda scene, film, cancelled, say: None,
    ):
        changing = next((lamp.name for lamp in scene.lamps if scene.shutter is not None and changes_shape(lamp)), None)
        if changing is not None:
            raise DeviceError(f"it cannot blur lamp “{changing}”, whose shape changes while the shutter is open")
        self._film, self._warnings = film, scene.warnings
        self._device = device()
        self._made: list = []
        self._arrays: list = []  # the buffer of ``thread_arrays``, if there is one
        self._streamed: list = []  # that of ``streamed``, likewise
        self._places, self._size = film_places(film)
        bytes_, slab = self._device.largest_buffer, SLAB
        if not self._device.software:
            bytes_, slab = min(bytes_, SLAB_BYTES), SLAB_OF_CARD
        self._slab = min(slab, len(film.active), max(bytes_ // (4 * self._size), 1))
        self._work, self._longest = FIRST_WORK, MOST_SAMPLES
        self._seed, self._offset = scene.settings.seed, scene.settings.sample_offset
        self._scene, self._shutter, self._loaded = scene, scene.shutter, []
        self._index = 0  # of the sample at whose time everything is
        if scene.shutter is not None and scene.shutter.rolling is not None:
            scene.warnings.append(
                "The GPU has no rolling shutter: all lines of the frame have the same exposure; choose the CPU as the device "
                "to have it."
            )
            self._shutter = dataclasses.replace(scene.shutter, rolling=None)
        self._tracer = trace(scene, film, cancelled, say)
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
            packed = self._packed_at(0)
            check()
            source = packed.source()
            check()
            say_to_watch("Compiling the scene's program for the GPU")
            self._program = self._device.program(context, source)
            check()
        self._load(context, packed)
        self._reserve_arrays(context)
        self._sums = self._buffer(context, np.zeros(self._slab * self._size, np.float32))
        self._pixels = self._buffer(context, np.zeros(1 + self._slab, np.uint32))
        self._lengths = self._buffer(context, np.zeros((max(len(packed.lamps), 1), 2), np.float32))

    def _reserve_arrays(self, context) -> None:
        """Memory for the arrays of the threads of a dispatch. It limits how many threads there are."""
        for made in self._arrays:
            made.release()
        self._arrays = []
        group, each = self._packed.group, 4 * self._packed.tables.arrays.words
        self._threads = -(-self._slab // group) * group
        if each:
            self._threads = min(self._threads, max(ARRAYS_BYTES // (each * group), 1) * group)
            size = each * self._threads
            self._arrays = [self._device.allocate(context, size, context.buffer, reserve=size)]

    def _packed_at(self, index: int, hierarchy: Hierarchy | None = None) -> GpuScene:
        """The scene at the time of a sample: one time for all pixels (Haeberli and Akeley 1990, "The accumulation
        buffer"). If nothing moves, it is always the same."""
        scene = self._scene
        if self._shutter is not None:
            time_ = time_of(self._shutter, part_of(self._seed, self._offset + index), 0.0)
            scene = at(scene, time_)
            if index:
                scene = dataclasses.replace(scene, warnings=[])
        device, moves = self._device, self._shutter is not None
        room, group = device.largest_buffer, device.group
        return GpuScene(scene, self._film, device.software, room, hierarchy, moves, group, self._tracer)

    def _move(self, context, index: int) -> None:
        """Put everything where it is at the time of a sample."""
        if index == self._index:
            return
        self._index = index
        scene, hierarchy = self._scene, self._packed.hierarchy
        moves = [instance.motion is not None for instance in scene.instances]
        moves += [mesh.motion is not None for mesh in scene.meshes]
        packed = self._packed_at(index, None if any(moves) else hierarchy)
        shared = self._packed.shares_program_with(packed)
        if shared:
            packed.tables.use_program_of(self._packed.tables)
        else:
            self._program = self._device.program(context, packed.source())
        for made in self._loaded:
            made.release()
        self._load(context, packed)
        if not shared:
            self._reserve_arrays(context)
        self._bind()

    def _connect(self, context, tables: dict[str, np.ndarray]) -> None:
        """Connect the next paths with the vertices of light paths in these tables."""
        for made in self._streamed:
            made.release()
        self._streamed = []
        self._streamed = [self._filled(context, self._packed.tables.streamed.words(tables))]
        self._streamed[0].bind_to_storage_buffer(streamed.BINDING)

    def _load(self, context, packed: GpuScene) -> None:
        """Put a scene's tables and triangles on the GPU."""
        words, second, uniforms = packed.tables.pack(packed.scalars)
        hierarchy, before = packed.hierarchy, list(self._made)
        self._packed = packed
        self._uniforms = self._buffer(context, uniforms)
        self._words, self._second = self._buffer(context, words), self._buffer(context, second)
        self._textures = [self._texture(context, array) for array in (hierarchy.nodes, hierarchy.items)]
        self._made, self._loaded = before, [self._uniforms, self._words, self._second, *self._textures]

    def _buffer(self, context, array: np.ndarray):
        return self._kept(self._filled(context, array))

    def _filled(self, context, array: np.ndarray):
        """A buffer with these words."""
        if array.nbytes > self._device.largest_buffer:
            raise DeviceError(
                f"the scene needs {megabytes(array.nbytes)} in one buffer, and it allows "
                f"{megabytes(self._device.largest_buffer)}"
            )
        words = np.ascontiguousarray(array).view(np.uint8).reshape(-1)
        return self._device.allocate(context, array.nbytes, context.buffer, words)

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
        for arrays in self._arrays:
            for binding in thread_arrays.KINDS.values():
                arrays.bind_to_storage_buffer(binding)
        for unit, texture in enumerate(self._textures):
            if self._device.software:
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
        if "mattes" in self._places:  # the slots of a pixel go on from what it has
            sums = np.zeros((self._size, self._slab), np.float32)
            sums[self._of("mattes"), : len(pixels)] = self._film.matte_sums[pixels].reshape(len(pixels), -1).T
            self._sums.write(sums)

    def _of(self, name: str) -> slice:
        """Columns of the passes of ``kernels/outputs`` in the sums of a pixel."""
        arrays = {"light": self._film.light_sums, "data": self._film.data_sums, "mattes": self._film.matte_sums}
        return slice(self._places[name], self._places[name] + arrays[name][0].size)

    def _run(self, context, place: int, count: int, first: int, end: int) -> tuple[float, bool]:
        """One dispatch, for the missing samples before ``end`` of a batch from ``first`` on. Returns its seconds, and
        whether all threads have finished. Unfinished threads leave no results."""
        started = time.perf_counter()
        self._program["work"] = place, count, first, end
        self._program.run(-(-count // self._packed.group))
        context.finish()
        finished = not np.frombuffer(self._pixels.read(4), np.uint32)[0]
        if not finished:
            self._pixels.write(np.zeros(1, np.uint32))
        return time.perf_counter() - started, finished

    def _collect(self, context, pixels: np.ndarray) -> None:
        """Add the GPU's sums to the film."""
        film = self._film
        sums = np.frombuffer(self._sums.read(), np.float32).reshape(self._size, -1)[:, : len(pixels)]
        # A slice is ten times as fast as a list of pixels.
        rows = slice(pixels[0], pixels[-1] + 1) if pixels[-1] - pixels[0] + 1 == len(pixels) else pixels
        seen = sums[self._places["surfaces"]].astype(np.int32)
        fresh = (seen > 0) & (film.surfaces[rows] == 0)
        for name, array in film.sums.items():
            if name in self._places:
                array = array.reshape(len(film.active), -1)
                part = sums[self._places[name] : self._places[name] + array.shape[1]]
                if name in ("position", "depth"):  # of the first sample that hit a surface
                    array[pixels[fresh]] = part[:, fresh].T
                else:
                    _add(array, rows, part)
        discarded = film.discarded.reshape(len(film.active), -1)
        for column, name in enumerate(("nan", "infinite")):
            number = sums[self._places[name]]
            if number.any():
                discarded[rows, column] += number.astype(np.int32)
        if "light" in self._places:
            _add(film.light_sums, rows, sums[self._of("light")])
        if "data" in self._places:
            part = sums[self._of("data")].copy()
            part[np.ix_(self._packed.first_alone, film.count[rows] > 0)] = 0.0
            _add(film.data_sums, rows, part)
        if "mattes" in self._places:
            film.matte_sums[rows] = sums[self._of("mattes")].T.reshape(len(pixels), *film.matte_sums.shape[1:])
        film.count[rows] += sums[self._places["count"]].astype(np.int32)
        film.surfaces[rows] += seen

    def sample(self, first: int, count: int, stop: Callable[[], bool], report: Callable[[float], None]) -> bool:
        """Add samples ``first`` to ``first + count − 1`` to every active pixel. Returns False if stopped before the
        end."""
        if not self.ready:
            return False
        active = np.flatnonzero(self._film.active)
        total, done = len(active) * count, 0
        for start in range(0, len(active), self._slab):
            pixels = active[start : start + self._slab]
            self._call(self._begin, pixels)
            stopped = False
            for begin, many in self._together(first, first + count):
                place = 0
                while place < len(pixels) and not stopped:
                    most = min(len(pixels) - place, self._threads)
                    each, group = self._samples_of_thread(most, many), self._packed.group
                    threads = min(max(self._work // each // group, 1) * group, most)
                    sample = begin
                    while sample < begin + many and not stopped:
                        end = min(sample + min(max(self._work // threads, 1), self._longest), begin + many)
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
                if stopped:
                    break
            self._call(self._collect, pixels)
            if stopped:
                return False
        self._film.samples = first + count
        return True

    def _together(self, first: int, end: int) -> Iterator[tuple[int, int]]:
        """First sample and number of those that are taken together: of one time if anything moves, of one set of light
        paths, or all. Everything is ready for them then."""
        at = first
        while at < end:
            to = end
            if self._shutter is not None:
                to = at + 1
                self._call(self._move, at)
            if self._tracer is not None:
                of_set, tables = self._tracer.use(at)
                to = min(to, of_set)
                self._call(self._connect, tables)
            yield at, to - at
            at = to

    def _samples_of_thread(self, pixels: int, many: int) -> int:
        """How many of ``many`` samples a thread takes in a dispatch, if so many pixels are left."""
        if self._device.software:  # software runs few threads at a time
            return many
        return min(max(self._work // pixels, LEAST_SAMPLES), many)

    def _adapt(self, samples: int, seconds: float) -> None:
        """Choose the size of dispatches by the time of the last one."""
        aim = samples * TARGET_SECONDS / max(seconds, 1e-4)
        self._work = int(min(max(aim, self._packed.group), 4 * self._work, 1 << 26))

    def _shorten(self, samples: int) -> None:
        """Make dispatches shorter: the driver has ended the loops of one with so many samples."""
        if samples == 1:
            raise DeviceError("its driver stops loops that are as long as rays through these lamps and volumes need")
        self._longest = max(samples // 4, 1)

    def finish(self) -> None:
        """Warn about lamps with unresolved rays, and free the memory of the render; the film stays."""

        def release(context) -> np.ndarray:
            lengths = np.frombuffer(self._lengths.read(), np.float32).reshape(-1, 2) if self.ready else np.zeros((0, 2))
            for made in (*self._made, *self._loaded, *self._arrays, *self._streamed):
                made.release()
            self._made, self._loaded, self._arrays, self._streamed = [], [], [], []
            return lengths

        if self._tracer is not None:
            self._tracer.finish()
        released = self._device.submit(release)
        if self.ready:  # otherwise a compiler may be running, and a cancelled render does not wait for it
            self._warnings += unresolved(self._packed.lamps, self._result(released).astype(np.float64))
