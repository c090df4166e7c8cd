# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress of a benchmark: a bar on one line of the terminal, or, in a file, a line for each part."""

from __future__ import annotations

import sys
import time

WIDTH = 30


class Progress:
    """Of ``parts`` equal parts."""

    def __init__(self, parts: int, stream=sys.stderr):
        self._parts, self._stream, self._done = parts, stream, 0
        self._terminal, self._started, self._last = stream.isatty(), time.perf_counter(), ""

    def show(self, text: str) -> None:
        """Name the present step."""
        part = self._done / self._parts
        elapsed = time.perf_counter() - self._started
        left = f", {elapsed * (1.0 - part) / part / 60.0:.0f} min left" if 0.0 < part < 1.0 else ""
        full = int(part * WIDTH)
        line = f"[{'█' * full}{'·' * (WIDTH - full)}] {100.0 * part:3.0f} %{left}  {text}"
        if self._terminal:
            self._stream.write(f"\r{line}\x1b[K")
        elif text != self._last:
            self._stream.write(line + "\n")
        self._last = text
        self._stream.flush()

    def step(self) -> None:
        """One part is done."""
        self._done = min(self._done + 1, self._parts)

    def close(self) -> None:
        if self._terminal:
            self._stream.write("\r\x1b[K")
