# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An OpenGL context of this process, in its own thread.

It is never current in another thread, so Blender's contexts are unaffected, whichever thread a render runs in.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

KEPT = 8  # cached programs, the most recently used ones
VERSION = 430
# Threads of a work group. On an NVIDIA H100, groups of 32 were 7 % faster than those of 64, and of 128 a third slower.
# Other cards may run 64 threads in step, of which smaller groups would leave some idle.
GROUP, GROUP_OF_NVIDIA = 64, 32
SOFTWARE = ("llvmpipe", "softpipe", "swr")


class DeviceError(Exception):
    """The GPU cannot be used: the rest of a sentence that begins with the replacement."""


class Device:
    """A context. ``submit`` runs functions in its thread, in sequence; they get the moderngl context."""

    def __init__(self):
        self._pool = ThreadPoolExecutor(1, "GPU of SDF Lights")
        self._programs: OrderedDict[str, object] = OrderedDict()
        try:
            self.context, facts = self._pool.submit(_create).result()
        except DeviceError:
            self._pool.shutdown()
            raise
        self.name = str(facts["GL_RENDERER"])
        # Not a graphics card. See ``GpuScene`` for what is different then.
        self.software = any(name in self.name.lower() for name in SOFTWARE)
        self.group = GROUP_OF_NVIDIA if "nvidia" in str(facts["GL_VENDOR"]).lower() else GROUP
        self.largest_buffer = int(facts["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"])  # bytes
        self.largest_texture = int(facts["GL_MAX_TEXTURE_SIZE"])  # texels per side

    def submit(self, function, *arguments) -> Future:
        """Run ``function(context, *arguments)`` in the thread of the context."""
        return self._pool.submit(function, self.context, *arguments)

    def program(self, context, source: str):
        """A compute shader, compiled unless it is cached. Call this in the context's thread.
        Raises DeviceError if the driver cannot compile it."""
        if source in self._programs:
            self._programs.move_to_end(source)
            return self._programs[source]
        try:
            program = context.compute_shader(source)
        except Exception as error:
            reason = _first_error(str(error))
            raise DeviceError(f"its driver could not compile the scene's program ({reason})") from error
        self._programs[source] = program
        while len(self._programs) > KEPT:
            self._programs.popitem(last=False)[1].release()
        return program

    @staticmethod
    def allocate(context, size: int, make: Callable, *arguments, **options):
        """The result of ``make`` for ``size`` bytes: a buffer or a texture. Call this in the context's thread.
        Raises DeviceError if there is no room."""
        try:
            made, error = make(*arguments, **options), context.error
        except Exception as reason:  # each driver has errors of its own
            raise DeviceError(f"it has no room for {megabytes(size)} more ({reason})") from reason
        if error != "GL_NO_ERROR":
            made.release()
            raise DeviceError(f"it has no room for {megabytes(size)} more ({error})")
        return made


def megabytes(size: int) -> str:
    """A number of bytes in words, rounded up."""
    return f"{-(-size // (1 << 20))} MB"


def _first_error(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if "error" in line.lower()]
    return (lines or text.strip().splitlines() or ["it gives no reason"])[0][:200]


def _create() -> tuple:
    """A context and its properties, which must be read in its own thread."""
    try:
        import moderngl
    except Exception as error:
        raise DeviceError(f"moderngl could not be imported ({error})") from error
    reasons = []
    for options in ({"backend": "egl"}, {}):
        try:
            context = moderngl.create_context(standalone=True, require=VERSION, **options)
            return context, dict(context.info)
        except Exception as error:  # each platform's driver has errors of its own
            reasons.append(str(error))
    raise DeviceError(f"there is no OpenGL 4.3 here ({reasons[-1]})")


_lock = threading.Lock()
_found: list = []


def device() -> Device:
    """The device of this process. Raises ``DeviceError``, with the same reason every time."""
    with _lock:
        if not _found:
            try:
                _found.append(Device())
            except DeviceError as error:
                _found.append(error.with_traceback(None))
        if isinstance(_found[0], DeviceError):
            raise DeviceError(*_found[0].args)  # a cached error would keep its call stack alive
        return _found[0]
