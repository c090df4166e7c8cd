# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own Embree 4 and OpenImageDenoise 2, found on disk and loaded with ctypes.

Every Blender from 4.2 on ships both as shared libraries, so the extension bundles neither. Their positions:

- bpy from a wheel: ``bpy/lib/libembree4.so.4`` beside the module;
- Blender for Linux from blender.org: ``lib/`` beside the binary;
- Windows: ``blender.shared/`` beside the binary;
- macOS: ``Blender.app/Contents/Resources/lib/``, the binary being in ``Contents/MacOS/``;
- Linux distributions: the folders of the system's loader.

A library that the process has already loaded comes first, because two copies of one library would each start their own
threads. Nothing here imports bpy.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import os
import pathlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass

from .errors import RenderError

# From a folder with Blender's binary, Python or modules (or a parent of it) to its shared libraries.
_SUBFOLDERS = ("lib", "blender.shared", "Resources/lib", "")
# Blender's Python is at most four folders below the binary: 5.2/python/bin/python3.13.
_PARENTS = 5

_search_folders: list[pathlib.Path] = []


@dataclass(frozen=True, eq=False)
class _Library:
    title: str
    sonames: dict[str, tuple[str, ...]]  # sys.platform -> names for the system's loader, best first
    pattern: dict[str, str]  # sys.platform -> file name pattern
    symbol: str  # a function of the wanted major version
    without: str  # the consequence for the user


_EMBREE = _Library(
    "Embree 4",
    {"linux": ("libembree4.so.4",), "win32": ("embree4.dll",), "darwin": ("libembree4.4.dylib", "libembree4.dylib")},
    {"linux": "libembree4.so*", "win32": "embree4.dll", "darwin": "libembree4*.dylib"},
    "rtcIntersect1",
    "the CPU device cannot trace rays",
)

_DENOISE = _Library(
    "OpenImageDenoise 2",
    {
        "linux": ("libOpenImageDenoise.so.2",),
        "win32": ("OpenImageDenoise.dll",),
        "darwin": ("libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"),
    },
    {"linux": "libOpenImageDenoise.so*", "win32": "OpenImageDenoise.dll", "darwin": "libOpenImageDenoise[.]*dylib"},
    "oidnGetNumPhysicalDevices",
    "the picture stays noisy",
)


def add_search_folder(path: str | os.PathLike) -> None:
    """Search for libraries in ``path`` and its usual subfolders too, for example the folder of Blender's binary."""
    folder = pathlib.Path(path)
    if folder not in _search_folders:
        _search_folders.append(folder)


def load_embree() -> ctypes.CDLL:
    """Embree 4. Raises RenderError if there is none."""
    return _load(_EMBREE)


def load_denoise() -> ctypes.CDLL:
    """OpenImageDenoise 2. Raises RenderError if there is none."""
    return _load(_DENOISE)


def _platform() -> str:
    return sys.platform if sys.platform in ("win32", "darwin") else "linux"


def search_folders() -> Iterator[pathlib.Path]:
    """Existing folders that may hold Blender's libraries, the most certain first, without duplicates."""
    starts = list(_search_folders)
    bpy = sys.modules.get("bpy")
    if getattr(bpy, "__file__", None):
        starts.append(pathlib.Path(bpy.__file__).parent)
    elif bpy is None:
        wheel = _bpy_wheel()
        if wheel is not None:
            starts.append(wheel)
    if sys.executable:
        starts.append(pathlib.Path(sys.executable).resolve().parent)
    seen = set()
    for start in starts:
        for parent in (start, *start.parents)[:_PARENTS]:
            for subfolder in _SUBFOLDERS:
                folder = parent / subfolder
                if folder not in seen and folder.is_dir():
                    seen.add(folder)
                    yield folder


def _bpy_wheel() -> pathlib.Path | None:
    """Folder of the bpy module of this Python, found without importing it."""
    try:
        spec = importlib.util.find_spec("bpy")
    except (ImportError, ValueError):
        return None
    return pathlib.Path(spec.origin).parent if spec is not None and spec.origin else None


def _loaded(name: str) -> ctypes.CDLL | None:
    """The library ``name``, if this process has loaded it."""
    try:
        if sys.platform == "win32":
            get_handle = ctypes.windll.kernel32.GetModuleHandleW
            get_handle.restype = ctypes.c_void_p
            handle = get_handle(name)
            return ctypes.CDLL(name, handle=handle) if handle else None
        return ctypes.CDLL(name, mode=os.RTLD_NOLOAD | os.RTLD_NOW)
    except OSError:
        return None


def _open(name: str, failures: list[str]) -> ctypes.CDLL | None:
    try:
        return ctypes.CDLL(name)
    except OSError as error:
        failures.append(str(error))
        return None


def _candidates(library: _Library, failures: list[str]) -> Iterator[ctypes.CDLL | None]:
    names = library.sonames[_platform()]
    for name in names:
        yield _loaded(name)
    for folder in search_folders():
        for path in sorted(folder.glob(library.pattern[_platform()])):
            yield _open(str(path), failures)
    if sys.platform != "win32":  # otherwise the loader would search the folders of other programs
        for name in names:
            yield _open(name, failures)


@functools.cache
def _load(library: _Library) -> ctypes.CDLL:
    failures: list[str] = []
    for candidate in _candidates(library, failures):
        if candidate is not None and hasattr(candidate, library.symbol):
            return candidate
    reason = f" ({failures[0]})" if failures else ""
    raise RenderError(
        f"{library.title} was not found, so {library.without}: use Blender 4.5 or newer from blender.org, or install "
        f"{library.title} with the system's package manager{reason}."
    )
