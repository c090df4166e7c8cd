# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles kernels in processes beside a session, at low priority, so its window never waits for them.

There is one process for the path tracer and one for the rest, which takes as long: lamps, light paths, and last the
kernels of special scenes. They write into the cache that the session reads. While a render waits for them, they have
the priority of the session. This module does not import Numba.
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

from ... import kernel_cache, kernel_code
from . import priority

PACKAGE = pathlib.Path(__file__).resolve().parents[2]
# Groups of ``precompile``, by process: those that a picture waits for, and all. A picture waits for light paths too:
# most pictures with lamps use them, and would otherwise compile them on one core.
NEEDED = ("paths",), ("lamps", "light_paths")
PROCESSES = NEEDED[0], (*NEEDED[1], "special")
POLL_SECONDS = 0.05
STARVED_SECONDS, STARVED_SHARE = 3.0, 0.25  # of these seconds, a starved process had less of a processor
_READY = "ready-"


class _Process:
    """A compiling process, and its progress."""

    def __init__(self, groups: tuple[str, ...], low: bool):
        self.groups, self.finished = groups, set[str]()
        self._low = low
        self._begin(low)

    def _begin(self, low: bool) -> None:
        paths = [path for path in sys.path if path]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "PYTHONDONTWRITEBYTECODE": "1"}
        environment["SDF_LIGHTS_CACHE"] = str(kernel_cache.cache_folder())
        self.done, self.total = 0, 0
        self._hurries = not low
        self._watched: tuple[float, float] | None = None
        self._process = subprocess.Popen(
            [sys.executable, "-m", f"{PACKAGE.name}.render.cpu.precompile", "--beside", *self.groups],
            cwd=PACKAGE.parent,
            env=environment,
            stdin=subprocess.PIPE,  # closing it tells the process that the session has ended
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        if low:
            priority.lower(self._process.pid)
        threading.Thread(target=self._read, args=[self._process], daemon=True).start()

    def _read(self, process: subprocess.Popen) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            found = re.fullmatch(r"(\d+) of (\d+)\n", line)
            if found:
                self.done, self.total = int(found[1]), int(found[2])
            elif line.startswith("finished "):
                self.finished.add(line.split()[1])
                _remember(line.split()[1])
        process.wait()

    @property
    def running(self) -> bool:
        return self._process.poll() is None

    @property
    def is_needed(self) -> bool:
        """Whether it is compiling what pictures need."""
        return self.running and any(group in self.groups and group not in self.finished for group in sum(NEEDED, ()))

    def raise_priority(self) -> None:
        """Give it the priority of the session. Where the system does not allow that and the process is starved by
        others, another one replaces it: kernels that are on disk are not compiled again."""
        if self._hurries:
            return
        if self._watched is None:
            self._hurries = priority.restore(self._process.pid)
        now, had = time.monotonic(), priority.processor_seconds(self._process.pid)
        if self._hurries or had is None:
            return
        since, before = self._watched = self._watched or (now, had)
        if now - since < STARVED_SECONDS:
            return
        self._watched = now, had
        if had - before < STARVED_SHARE * (now - since):
            self.stop()
            with contextlib.suppress(OSError):  # then the render compiles
                self._begin(low=False)

    def lower_priority(self) -> None:
        """Take the lowest priority again, if it had that at the start."""
        if self._low and self._hurries and self.running:
            priority.lower(self._process.pid)
            self._hurries = False
        self._watched = None

    def pause(self) -> None:
        priority.pause(self._process.pid)

    def proceed(self) -> None:
        priority.proceed(self._process.pid)

    def stop(self) -> None:
        with contextlib.suppress(OSError):
            self._process.terminate()
        self.proceed()  # a process that pauses ends only then


_processes: list[_Process] = []


def _sources() -> str:
    """Identifies these sources without reading them."""
    digest = hashlib.sha256(sys.version.encode())
    for path in sorted(PACKAGE.rglob("*.py")):
        status = path.stat()
        digest.update(f"{path} {status.st_size} {status.st_mtime_ns}".encode())
    return digest.hexdigest()[:16]


def _mark(group: str) -> pathlib.Path:
    """A file that exists when all kernels of a group exist, and is deleted with them."""
    return kernel_cache.writable_folder() / f"{_READY}{group}-{_sources()}{kernel_cache.SUFFIX}"


def shipped_mark(group: str, host_hash: str) -> str:
    """Name of a file beside shipped kernels: all those of a group are there, for hosts with this hash."""
    return f"{_READY}{group}-{host_hash}"


def _is_shipped(group: str) -> bool:
    """Whether the extension came with all kernels of a group, for this Python and processor."""
    if not kernel_code.base_processor():
        return False
    return (kernel_cache.SHIPPED / shipped_mark(group, kernel_code.host_hash())).is_file()


def _remember(group: str) -> None:
    """Record that all kernels of a group exist."""
    with contextlib.suppress(OSError):
        for old in kernel_cache.writable_folder().glob(f"{_READY}{group}-*"):
            old.unlink()
        _mark(group).touch()


def needed(processes: tuple[tuple[str, ...], ...] = PROCESSES) -> bool:
    """Whether kernels still need to be compiled, as far as is known."""
    return not all(_mark(group).is_file() or _is_shipped(group) for groups in processes for group in groups)


def start(low: bool = True, processes: tuple[tuple[str, ...], ...] = PROCESSES) -> None:
    """Compile kernels, unless this is done or in progress. ``low``: only while nothing else needs the processor."""
    able = pathlib.Path(sys.executable or "").name.lower().startswith("python")
    if not able or not importlib.util.find_spec("numba") or running() or not needed(processes):
        return
    _processes.clear()
    try:
        _processes.extend(_Process(groups, low) for groups in processes)
    except OSError:  # then the first render compiles
        stop()


def pause() -> None:
    """Stop the processes until ``proceed``: a window that the processor draws is drawn sooner without them."""
    for process in list(_processes):
        process.pause()


def proceed() -> None:
    """Let the processes go on."""
    for process in list(_processes):
        process.proceed()


def stop() -> None:
    """End the running processes."""
    for process in _processes:
        process.stop()
    _processes.clear()


def running() -> bool:
    """Whether kernels are being compiled."""
    return any(process.running for process in _processes)


def progress() -> tuple[int, int]:
    """(number of ready kernels, number of all)."""
    return sum(each.done for each in _processes), sum(each.total for each in _processes)


def text() -> str:
    """The progress in words; "" if nothing runs or its extent is not known yet."""
    done, total = progress()
    if not running() or not all(each.total for each in _processes):
        return ""
    return sentence(done, total)


def sentence(done: int, total: int) -> str:
    """The message for users during compilation."""
    return f"Compiling kernels, once for this installation: {done} of {total}"


def wait(check: Callable[[], None]) -> None:
    """Return when everything for a picture is ready, or when nothing compiles it. ``check`` may raise, to end the
    wait."""
    try:
        proceed()
        while needed := [process for process in list(_processes) if process.is_needed]:
            check()
            for process in needed:
                process.raise_priority()
            time.sleep(POLL_SECONDS)
    finally:
        for process in list(_processes):
            process.lower_priority()
