# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls in another process with Blender, so that what ends a process ends that one, and a benchmark goes on."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable

import host

SECONDS = 900  # most time for one call


class Isolated:
    """One process that takes call after call; where it ends, or takes too long, the next call has another one."""

    def __init__(self):
        self._process = None

    def call(self, function: Callable, *arguments):
        """Result of a function of a module. RuntimeError where the process ended before there was any."""
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "benchmarks.isolation"],
                cwd=host.REPOSITORY / "scripts",
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
            )
        limit = threading.Timer(SECONDS, self._process.kill)
        limit.start()
        try:
            pickle.dump((function, arguments), self._process.stdin)
            self._process.stdin.flush()
            return pickle.load(self._process.stdout)
        except (EOFError, OSError):
            code = self._process.wait()
            self._process = None
            raise RuntimeError(f"the process ended with code {code}") from None
        finally:
            limit.cancel()

    def close(self) -> None:
        """End the process, without what Blender does at its end, which can hang."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None


def serve() -> None:
    """Answer calls, until there are no more. What Blender prints goes to the standard error stream."""
    calls, results = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    host.register_extension()
    while True:
        try:
            function, arguments = pickle.load(calls)
        except EOFError:
            host.finish(0)
        pickle.dump(function(*arguments), results)
        results.flush()


if __name__ == "__main__":
    serve()
