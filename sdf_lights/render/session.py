# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A render from start to finish: the back end, its steps, when to stop, and messages to the user."""

from __future__ import annotations

import functools
import math
import sys
import time
from collections.abc import Callable, Iterator

from .. import jit
from ..frozen import frozen
from . import memory, sample_allocation
from .errors import RenderError
from .film import Film, bytes_of_a_pixel
from .gpu.device import DeviceError
from .interfaces import BackEnd, InteractiveBackEnd
from .scene import Scene
from .settings import LARGEST_BATCH, Device, Settings

# Seconds until the first picture is shown, and between two pictures.
FIRST_UPDATE, UPDATE_INTERVAL = 0.25, 1.0


@frozen
class Progress:
    """State of a render: ``fraction`` in [0, 1], ``remaining`` seconds (None: not known yet), ``memory`` of the process
    in bytes, ``noise`` as ``Film.noise`` defines it (None: too few samples), ``text`` for the status line."""

    text: str
    fraction: float = 0.0
    samples: int = 0
    elapsed: float = 0.0
    remaining: float | None = None
    memory: int = 0
    noise: float | None = None


def batches(samples: int) -> Iterator[tuple[int, int]]:
    """(first sample, count) of each batch: 1, 1, 2, 4, … up to ``LARGEST_BATCH``.

    The schedule depends only on the number of samples. So adaptive sampling, which decides between batches, gives the
    same picture on any machine.
    """
    first, count = 0, 1
    while first < samples:
        count = min(count, samples - first)
        yield first, count
        first += count
        count = min(first, LARGEST_BATCH)


def process_memory() -> int:
    """Peak resident memory of this process in bytes, 0 if the platform does not tell."""
    try:
        import resource
    except ImportError:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def choose_back_end(scene: Scene) -> Callable[..., InteractiveBackEnd]:
    """The renderer class for ``scene.settings.device`` among those for the processor. Falls back to the NumPy
    reference, with a warning, if Numba cannot be imported."""
    if scene.settings.device is not Device.REFERENCE:
        if jit.AVAILABLE:
            from .cpu.renderer import CpuRenderer

            return CpuRenderer
        scene.warnings.append(
            f"{jit.REASON}; the slow NumPy renderer takes over: install the extension from the zip made for this "
            "Blender version."
        )
    from .reference.renderer import ReferenceRenderer

    return ReferenceRenderer


def wants_gpu(settings: Settings) -> bool:
    """Whether to try the GPU: only on request, until it has been tested on graphics cards (docs/gpu.md)."""
    return jit.AVAILABLE and settings.device is Device.GPU


def render(
    scene: Scene,
    passes: tuple[str, ...],
    cancelled: Callable[[], bool] = lambda: False,
    on_progress: Callable[[Progress], None] = lambda progress: None,
    on_update: Callable[[Film], None] = lambda film: None,
) -> Film:
    """Render ``scene`` and return its film, even if cancelled (then with the samples so far).

    ``cancelled`` is polled at least ten times a second; ``on_progress`` and ``on_update`` (a new picture, about once a
    second) are called in this thread too. ``passes`` are names in ``passes.PASSES``; Combined is always included.
    Raises RenderError with one sentence for the user.
    """
    on_progress(Progress("Preparing", memory=process_memory()))
    check_size(scene, passes)
    if wants_gpu(scene.settings):
        from .gpu.renderer import GpuRenderer
        from .light_paths import traced_by_cpu

        told = list(scene.warnings)
        back_end = functools.partial(GpuRenderer, trace=traced_by_cpu)
        try:
            return _render(back_end, scene, passes, cancelled, on_progress, on_update)
        except DeviceError as error:
            scene.warnings[:] = [*told, f"The GPU cannot render this: {error}. The CPU has rendered it."]
    return _render(choose_back_end(scene), scene, passes, cancelled, on_progress, on_update)


def check_size(scene: Scene, passes: tuple[str, ...] = ()) -> None:
    """Raise ``RenderError`` if there is not enough memory for the picture, or for the scene in addition."""
    x0, y0, x1, y1 = scene.border or (0, 0, scene.width, scene.height)
    needed, free = (x1 - x0) * (y1 - y0) * bytes_of_a_pixel(scene, passes), memory.available()
    if free is not None and needed > free:
        raise RenderError(
            f"A picture of {x1 - x0:,} × {y1 - y0:,} pixels with {len(passes)} passes takes "
            f"{memory.in_words(needed)}, but only {memory.in_words(free)} of memory are free: choose a lower "
            "resolution, a render region, or fewer passes."
        )
    triangles, instances = sum(len(mesh.triangles) for mesh in scene.meshes), len(scene.instances)
    geometry = triangles * memory.TRIANGLE_BYTES + instances * memory.INSTANCE_BYTES
    if free is not None and needed + geometry > free:
        raise RenderError(
            f"The scene's {triangles:,} triangles and {instances:,} instances take {memory.in_words(geometry)} beside "
            f"the picture's {memory.in_words(needed)}, but only {memory.in_words(free)} of memory are free: subdivide "
            "less, hide objects, or make copies instances of one mesh."
        )


def _render(
    back_end: Callable[..., BackEnd], scene: Scene, passes: tuple[str, ...], cancelled, on_progress, on_update
) -> Film:
    """``render`` with one back end."""
    settings = scene.settings
    started = time.perf_counter()
    film = Film(scene, passes)
    renderer = back_end(scene, film, cancelled, lambda text: on_progress(Progress(text, memory=process_memory())))
    film.made_by = renderer.name
    memory.trim_heap()
    sampling_started = time.perf_counter()
    next_update = sampling_started + FIRST_UPDATE
    deadline = sampling_started + settings.time_limit if settings.time_limit > 0.0 else math.inf
    out_of_time = False

    def stop() -> bool:
        nonlocal out_of_time
        out_of_time = out_of_time or (film.samples > 0 and time.perf_counter() > deadline)
        return out_of_time or cancelled()

    def report(first: int, count: int, noise: float | None, part: float) -> None:
        """``part``: the finished fraction of the batch of ``count`` samples after the ``first``."""
        nonlocal next_update
        now = time.perf_counter()
        done = (first + part * count) / settings.samples
        elapsed = now - sampling_started
        remaining = elapsed * (1.0 - done) / done if done > 0.0 and elapsed > 0.2 else None
        if remaining is not None:
            remaining = min(remaining, max(deadline - now, 0.0))
        on_progress(
            Progress(
                f"Sample {first}/{settings.samples}", done, first, now - started, remaining, process_memory(), noise
            )
        )
        if now > next_update:
            on_update(film)
            next_update = time.perf_counter() + UPDATE_INTERVAL

    noise, next_noise = None, 0.0
    for first, count in batches(settings.samples):
        if first and time.perf_counter() > next_noise:  # on a fast device it takes as long as a batch
            noise = film.noise()
            next_noise = time.perf_counter() + UPDATE_INTERVAL
        if not renderer.sample(first, count, stop, functools.partial(report, first, count, noise)):
            break
        sample_allocation.update(film, settings)
        if settings.noise_threshold > 0.0 and first + count >= settings.min_samples:
            if not film.update_active(settings.noise_threshold):
                break
    renderer.finish()
    discarded = film.discarded_report()
    if discarded:
        scene.warnings.append(discarded)
    if settings.denoise and not cancelled():
        on_progress(Progress("Denoising", 1.0, film.samples, memory=process_memory(), noise=film.noise()))
        from .denoised_film import denoise_film

        try:
            denoise_film(film, cancelled)
        except RenderError as error:
            scene.warnings.append(str(error))
    elapsed = time.perf_counter() - started
    on_progress(
        Progress(
            f"Sample {film.samples}/{settings.samples}", 1.0, film.samples, elapsed, 0.0, process_memory(), film.noise()
        )
    )
    return film
