# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The amount of memory, so that a render without enough memory is refused before it begins."""

from __future__ import annotations

import ctypes
import os
import sys

GIGABYTE = 1 << 30

# Bytes of the CPU back end for one, in addition to its own data, rounded down: ``./scripts/bench trust --parts
# scenes``.
TRIANGLE_BYTES, INSTANCE_BYTES = 100, 900


def available() -> int | None:
    """Bytes that programs can use without swapping others out; None if the platform does not tell."""
    if sys.platform.startswith("linux"):
        return _available_on_linux()
    if sys.platform == "win32":
        return _available_on_windows()
    try:  # macOS compresses and swaps automatically: all memory counts
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (ValueError, OSError):
        return None


def trim_heap() -> None:
    """Return freed memory to the system. On Linux, the C library keeps it for each thread, up to the peak of the
    thread, and other programs cannot use it. Takes some milliseconds."""
    if sys.platform.startswith("linux"):
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # only glibc has it
        if trim is not None:
            trim(0)


def _available_on_linux() -> int | None:
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            for line in file:
                name, _, value = line.partition(":")
                if name == "MemAvailable":
                    return int(value.split()[0]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return None


def _available_on_windows() -> int | None:
    class Status(ctypes.Structure):
        _fields_ = [("length", ctypes.c_ulong), ("load", ctypes.c_ulong)] + [
            (name, ctypes.c_ulonglong)
            for name in ("total", "available", "page_total", "page_available", "virtual", "free_virtual", "extended")
        ]

    status = Status(length=ctypes.sizeof(Status))
    if not ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status)):  # type: ignore[attr-defined]
        return None
    return status.available


def in_words(size: float) -> str:
    """``3.2 GB`` or ``320 MB``."""
    return f"{size / GIGABYTE:.1f} GB" if size >= 0.95 * GIGABYTE else f"{size / (1 << 20):.0f} MB"
