# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How urgent a process is for the operating system. A process is named by its number."""

from __future__ import annotations

import contextlib
import os
import pathlib
import signal
import sys

_LOWEST_NICE = 19
_SET_INFORMATION, _IDLE_CLASS, _NORMAL_CLASS = 0x200, 0x40, 0x20  # of Windows


def _threads(process: int) -> list[int]:
    """All threads of a process, because Linux schedules each by itself; elsewhere the process."""
    folder = pathlib.Path(f"/proc/{process}/task")
    return [int(each.name) for each in folder.iterdir()] if folder.is_dir() else [process]


def lower(process: int) -> None:
    """Let a process run only while nothing else needs the processor."""
    if sys.platform == "win32":
        _set_class(process, _IDLE_CLASS)
        return
    with contextlib.suppress(OSError):  # a thread, or the process, may have ended
        for thread in _threads(process):
            _lower_thread(thread)


def _lower_thread(thread: int) -> None:
    if sys.platform == "linux":  # here a waking process preempts an idle one at once
        with contextlib.suppress(PermissionError):  # a container may forbid it
            os.sched_setscheduler(thread, os.SCHED_IDLE, os.sched_param(0))
            return
    os.setpriority(os.PRIO_PROCESS, thread, _LOWEST_NICE)


def restore(process: int) -> bool:
    """Give a process the priority of this one. Returns whether the system allows it: most systems do not allow it to
    ordinary users."""
    if sys.platform == "win32":
        return _set_class(process, _NORMAL_CLASS)
    try:
        for thread in _threads(process):
            if sys.platform == "linux":
                os.sched_setscheduler(thread, os.sched_getscheduler(0), os.sched_getparam(0))
            os.setpriority(os.PRIO_PROCESS, thread, os.getpriority(os.PRIO_PROCESS, 0))
    except OSError:
        return False
    return True


def pause(process: int) -> None:
    """Stop a process until ``proceed``. Windows has no call for it."""
    _send(process, "SIGSTOP")


def proceed(process: int) -> None:
    """Let a process go on."""
    _send(process, "SIGCONT")


def _send(process: int, name: str) -> None:
    if hasattr(signal, name):
        with contextlib.suppress(OSError):  # it may have ended
            os.kill(process, getattr(signal, name))


def _set_class(process: int, number: int) -> bool:
    """Set the priority class of a process of Windows."""
    import ctypes

    kernel32 = ctypes.WinDLL("kernel32")  # type: ignore[attr-defined]
    kernel32.OpenProcess.restype = ctypes.c_void_p
    handle = ctypes.c_void_p(kernel32.OpenProcess(_SET_INFORMATION, False, process))
    done = bool(handle.value and kernel32.SetPriorityClass(handle, number))
    kernel32.CloseHandle(handle)
    return done


def processor_seconds(process: int) -> float | None:
    """Processor time that a process has had; None where the system does not tell."""
    try:
        words = pathlib.Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return None
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")  # proc(5): utime and stime
