# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising with Blender's own OpenImageDenoise 2, through its C API (``oidn.h``)."""

from __future__ import annotations

import contextlib
import ctypes
import threading
from collections.abc import Callable, Iterator

import numpy as np

from .errors import RenderError
from .libraries import load_denoise

POLL_SECONDS = 0.05

_CPU = 1
_FLOAT3 = 3
_CANCELLED = 6

_PROGRESS = ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.c_void_p, ctypes.c_double)

_POINTER, _TEXT, _SIZE = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t
_SIGNATURES = {
    "oidnNewDevice": (_POINTER, [ctypes.c_int]),
    "oidnCommitDevice": (None, [_POINTER]),
    "oidnReleaseDevice": (None, [_POINTER]),
    "oidnGetDeviceError": (ctypes.c_int, [_POINTER, ctypes.POINTER(_TEXT)]),
    "oidnSetDeviceBool": (None, [_POINTER, _TEXT, ctypes.c_bool]),
    "oidnNewFilter": (_POINTER, [_POINTER, _TEXT]),
    "oidnReleaseFilter": (None, [_POINTER]),
    "oidnSetSharedFilterImage": (None, [_POINTER, _TEXT, _POINTER, ctypes.c_int, _SIZE, _SIZE, _SIZE, _SIZE, _SIZE]),
    "oidnSetFilterBool": (None, [_POINTER, _TEXT, ctypes.c_bool]),
    "oidnSetFilterProgressMonitorFunction": (None, [_POINTER, _PROGRESS, _POINTER]),
    "oidnCommitFilter": (None, [_POINTER]),
    "oidnExecuteFilter": (None, [_POINTER]),
}


class _Denoiser:
    """A CPU device of the library. If another thread sets ``stop``, the running filter is cancelled."""

    def __init__(self):
        library = load_denoise()
        for name, (result, arguments) in _SIGNATURES.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
        self._api = library
        self.stop = threading.Event()
        self._progress = _PROGRESS(lambda user, done: not self.stop.is_set())
        self._device = library.oidnNewDevice(_CPU)
        if not self._device:
            reason = self._error(None)[1]
            raise RenderError(f"OpenImageDenoise has no CPU device here ({reason}), so the picture stays noisy.")
        # Otherwise threads pinned to cores would stay pinned for the rest of Blender too.
        library.oidnSetDeviceBool(self._device, b"setAffinity", False)
        library.oidnCommitDevice(self._device)
        self._check()

    def close(self) -> None:
        self._api.oidnReleaseDevice(self._device)

    def _error(self, device) -> tuple[int, str]:
        message = _TEXT()
        code = self._api.oidnGetDeviceError(device, ctypes.byref(message))
        return code, (message.value or b"unknown reason").decode(errors="replace")

    def _check(self) -> bool:
        """False if cancelled. Raises RenderError for an error."""
        code, message = self._error(self._device)
        if code not in (0, _CANCELLED):
            raise RenderError(f"OpenImageDenoise failed ({message}), so the picture stays noisy.")
        return code == 0

    def filter(self, images: dict[str, np.ndarray], **options: bool) -> np.ndarray | None:
        """The first of ``images`` (name -> (H, W, 3) float32, contiguous) denoised; None if cancelled."""
        output = np.empty_like(next(iter(images.values())))
        height, width, _ = output.shape
        handle = self._api.oidnNewFilter(self._device, b"RT")
        try:
            for name, array in {**images, "output": output}.items():
                self._api.oidnSetSharedFilterImage(
                    handle, name.encode(), array.ctypes.data, _FLOAT3, width, height, 0, 0, 0
                )
            for name, value in options.items():
                self._api.oidnSetFilterBool(handle, name.encode(), value)
            self._api.oidnSetFilterProgressMonitorFunction(handle, self._progress, None)
            self._api.oidnCommitFilter(handle)
            self._api.oidnExecuteFilter(handle)
            return output if self._check() and not self.stop.is_set() else None
        finally:
            self._api.oidnReleaseFilter(handle)

    def denoise(self, colors: list[np.ndarray], guides: dict[str, np.ndarray]) -> list[np.ndarray] | None:
        """Each of ``colors`` (height, width, 3) denoised with guides that are first denoised separately. The library's
        documentation recommends this for noisy guides: lens blur, rough glass. None if cancelled."""
        clean: dict[str, np.ndarray] = {}
        for name, guide in guides.items():
            found = self.filter({name: guide})
            if found is None:
                return None
            clean[name] = found
        results: list[np.ndarray] = []
        for color in colors:
            found = self.filter({"color": color, **clean}, hdr=True, cleanAux=bool(clean))
            if found is None:
                return None
            results.append(found)
        return results


@contextlib.contextmanager
def _denoiser() -> Iterator[_Denoiser]:
    denoiser = _Denoiser()
    try:
        yield denoiser
    finally:
        denoiser.close()


def denoise(
    color: np.ndarray,
    albedo: np.ndarray | None = None,
    normal: np.ndarray | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> np.ndarray | None:
    """Denoised picture (H, W, 3) float32; None if cancelled. See ``denoise_each``."""
    found = denoise_each([color], albedo, normal, cancelled)
    return None if found is None else found[0]


def denoise_each(
    colors: list[np.ndarray],
    albedo: np.ndarray | None = None,
    normal: np.ndarray | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> list[np.ndarray] | None:
    """Denoised pictures (H, W, 3) float32, each by itself; None if cancelled.

    ``colors``: (H, W, 3) scene-linear radiance; ``albedo`` in [0, 1] and ``normal`` in [−1, 1] of the same shape guide
    the filter; the library uses normals only together with albedo. The calling thread polls ``cancelled`` while another
    thread filters. Raises RenderError if the library is missing or fails.
    """
    colors = [np.ascontiguousarray(color, np.float32) for color in colors]
    guides = {"albedo": albedo, "normal": normal} if albedo is not None else {}
    guides = {name: np.ascontiguousarray(guide, np.float32) for name, guide in guides.items() if guide is not None}
    shape = colors[0].shape
    if any(array.shape != shape for array in (*colors, *guides.values())) or len(shape) != 3 or shape[2] != 3:
        raise ValueError(f"colours and guides must all be (height, width, 3), not {shape}")
    if colors[0].size == 0:
        return colors
    with _denoiser() as denoiser:
        outcome: list = [None, None]

        def work() -> None:
            try:
                outcome[0] = denoiser.denoise(colors, guides)
            except Exception as error:
                outcome[1] = error

        thread = threading.Thread(target=work, name="denoise")
        thread.start()
        try:
            while thread.is_alive():
                if not denoiser.stop.is_set() and cancelled():
                    denoiser.stop.set()
                thread.join(POLL_SECONDS)
        finally:
            # Also if ``cancelled`` raises: the arrays must outlive the filter.
            if thread.is_alive():
                denoiser.stop.set()
                thread.join()
    result, error = outcome
    if error is not None:
        raise error
    return result
