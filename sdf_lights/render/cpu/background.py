# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that compile in processes beside a session, at a low priority, so that its window never waits for them.

A process each for the path tracer and for lamps; what few scenes have follows the latter. They write into the cache that the
session reads. Imports no Numba.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable

from ... import kernel_cache

PACKAGE = pathlib.Path(__file__).resolve().parents[2]
# Groups of ``ahead``, by process. The first of each are needed before any picture.
PROCESSES = (("paths",), ("lamps", "parts"))
NEEDED = tuple(groups[:1] for groups in PROCESSES)
POLL_SECONDS = 0.05
_READY = "ready-"


class _Process:
    """One that compiles, and how far it is."""

    def __init__(self, groups: tuple[str, ...], low: bool):
        paths = [path for path in sys.path if path]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "PYTHONDONTWRITEBYTECODE": "1"}
        environment["SDF_LIGHTS_CACHE"] = str(kernel_cache.cache_folder())
        self.groups, self.finished = groups, set[str]()
        self.done, self.total = 0, 0
        self._process = subprocess.Popen(
            [sys.executable, "-m", f"{PACKAGE.name}.render.cpu.ahead", "--beside", *(["--low"] * low), *groups],
            cwd=PACKAGE.parent,
            env=environment,
            stdin=subprocess.PIPE,  # whose end tells that the session is gone
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            found = re.fullmatch(r"(\d+) of (\d+)\n", line)
            if found:
                self.done, self.total = int(found[1]), int(found[2])
            elif line.startswith("finished "):
                self.finished.add(line.split()[1])
                _remember(line.split()[1])
        self._process.wait()

    @property
    def running(self) -> bool:
        return self._process.poll() is None

    def stop(self) -> None:
        with contextlib.suppress(OSError):
            self._process.terminate()


_processes: list[_Process] = []


def _sources() -> str:
    """Tells these sources from others without reading them."""
    digest = hashlib.sha256(sys.version.encode())
    for path in sorted(PACKAGE.rglob("*.py")):
        status = path.stat()
        digest.update(f"{path} {status.st_size} {status.st_mtime_ns}".encode())
    return digest.hexdigest()[:16]


def _mark(group: str) -> pathlib.Path:
    """A file that is there when all kernels of a group are, and goes with them."""
    return kernel_cache.writable_folder() / f"{_READY}{group}-{_sources()}{kernel_cache.SUFFIX}"


def _remember(group: str) -> None:
    """Note that all kernels of a group are there."""
    with contextlib.suppress(OSError):
        for old in kernel_cache.writable_folder().glob(f"{_READY}{group}-*"):
            old.unlink()
        _mark(group).touch()


def needed(processes: tuple[tuple[str, ...], ...] = PROCESSES) -> bool:
    """Whether kernels have still to be compiled, as far as is known."""
    return not all(_mark(group).is_file() for groups in processes for group in groups)


def start(low: bool = True, processes: tuple[tuple[str, ...], ...] = PROCESSES) -> None:
    """Compile kernels, unless that has been done or is being done. ``low``: only while nothing else wants the processor."""
    able = pathlib.Path(sys.executable or "").name.lower().startswith("python")
    if not able or not importlib.util.find_spec("numba") or running() or not needed(processes):
        return
    _processes.clear()
    try:
        _processes.extend(_Process(groups, low) for groups in processes)
    except OSError:  # then the first render compiles
        stop()


def stop() -> None:
    """End what is running."""
    for process in _processes:
        process.stop()
    _processes.clear()


def running() -> bool:
    """Whether kernels are being compiled."""
    return any(process.running for process in _processes)


def progress() -> tuple[int, int]:
    """(kernels that are ready, all)."""
    return sum(each.done for each in _processes), sum(each.total for each in _processes)


def text() -> str:
    """How far it is, in words; "" where nothing runs or its extent is not known yet."""
    done, total = progress()
    if not running() or not all(each.total for each in _processes):
        return ""
    return sentence(done, total)


def sentence(done: int, total: int) -> str:
    """What users are told meanwhile."""
    return f"Compiling kernels, once for this installation: {done} of {total}"


def wait(check: Callable[[], None]) -> None:
    """Return when all that a picture needs is there, or when nobody compiles it. ``check`` may raise, to end the wait."""
    while any(process.running and process.groups[0] not in process.finished for process in list(_processes)):
        check()
        time.sleep(POLL_SECONDS)
