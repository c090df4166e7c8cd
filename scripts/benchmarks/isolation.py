# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls in another process with Blender, so that a crash ends only that process, and the benchmark continues."""

from __future__ import annotations

import inspect
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator

import host

SECONDS = 900  # maximum time for one answer


class Isolated:
    """One process that takes call after call. If it ends, or takes too long, the next call starts another one."""

    def __init__(self):
        self._process = None

    def call(self, function: Callable, *arguments):
        """Result of a function of a module. RuntimeError with the reason if the process ended before."""
        answers = self.stream(function, *arguments)
        while True:
            try:
                next(answers)
            except StopIteration as end:
                return end.value

    def stream(self, function: Callable, *arguments) -> Iterator:
        """The values of a generator function of a module, one by one. RuntimeError as in ``call``."""
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "benchmarks.isolation"],
                cwd=host.REPOSITORY / "scripts",
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
            )
        try:
            pickle.dump((function, arguments), self._process.stdin)
            self._process.stdin.flush()
            is_last = False
            while not is_last:
                is_last, answer = self._answer()
                if not is_last:
                    yield answer
            return answer
        except (EOFError, OSError):
            code = self._process.wait()
            self._process = None
            how = f"code {code}" if code >= 0 else signal.Signals(-code).name
            raise RuntimeError(f"the process ended with {how}") from None

    def _answer(self) -> tuple[bool, object]:
        """Whether the next answer is the last one, and the answer."""
        limit = threading.Timer(SECONDS, self._process.kill)
        limit.start()
        try:
            return pickle.load(self._process.stdout)
        finally:
            limit.cancel()

    def close(self) -> None:
        """End the process without Blender's own shutdown, which can hang."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None


def serve() -> None:
    """Answer calls until there are no more. Blender's output goes to the standard error stream."""
    calls, results = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    host.register_extension()
    while True:
        try:
            function, arguments = pickle.load(calls)
        except EOFError:
            host.finish(0)
        answer = function(*arguments)
        if inspect.isgenerator(answer):
            for part in answer:
                _send(results, False, part)
            answer = None
        _send(results, True, answer)


def _send(results, is_last: bool, answer) -> None:
    pickle.dump((is_last, answer), results)
    results.flush()


if __name__ == "__main__":
    serve()
