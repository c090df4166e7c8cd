# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One progress bar for a command with several stages, with the time left for all of them.

The time of a stage on an idle machine with two cores is known in advance. The speed of this machine follows from the
finished stages, and from the progress of the present one.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

TRUST = 20.0  # seconds after which the measured speed counts as much as the prior


def clock(seconds: float) -> str:
    minutes, seconds = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"


class Stages:
    """A bar on one line of the terminal, or, in a file, a line now and then."""

    WIDTH = 30

    def __init__(self, expected: dict[str, float], stream=sys.stdout, now: Callable[[], float] = time.perf_counter):
        """``expected``: seconds of each stage, in order."""
        self._expected, self._stream, self._now = dict(expected), stream, now
        self.terminal = stream.isatty()
        self._interval = 0.1 if self.terminal else 10.0
        self._started = self._stage_started = now()
        self._stage, self._fraction = next(iter(expected)), 0.0
        self._taken: dict[str, float] = {}
        self._shown, self._shown_stage = -1e9, ""

    def begin(self, stage: str) -> None:
        """End the present stage, and all up to ``stage``, if that is a later one."""
        names = list(self._expected)
        if stage == self._stage or names.index(stage) < names.index(self._stage):
            return
        now = self._now()
        self._taken[self._stage] = now - self._stage_started
        for skipped in names[names.index(self._stage) + 1 : names.index(stage)]:
            self._taken[skipped] = self._expected[skipped] = 0.0
        self._stage, self._stage_started, self._fraction = stage, now, 0.0

    def left(self) -> float:
        """Seconds left for all stages."""
        expected, spent = self._expected[self._stage], self._now() - self._stage_started
        known = sum(self._expected[name] for name in self._taken) + self._fraction * expected
        # In the first seconds, an idle machine with two cores is the best guess.
        pace = (sum(self._taken.values()) + spent * (self._fraction > 0.0) + TRUST) / (known + TRUST)
        if self._fraction > 0.1:
            here = spent * (1.0 - self._fraction) / self._fraction
        else:
            # a stage that has hardly begun is not nearly done
            here = max(pace * expected - spent, 0.75 * pace * expected)
        names = list(self._expected)
        return here + pace * sum(self._expected[name] for name in names[names.index(self._stage) + 1 :])

    def show(self, text: str, fraction: float = 0.0) -> None:
        """Show ``text`` for the present stage, of which ``fraction`` is done."""
        self._fraction = max(self._fraction, min(fraction, 1.0))
        now = self._now()
        if now - self._shown < self._interval and self._stage == self._shown_stage:
            return
        self._shown, self._shown_stage = now, self._stage
        left, elapsed = self.left(), now - self._started
        part = elapsed / max(elapsed + left, 1e-9)
        full = int(part * self.WIDTH)
        line = f"[{'█' * full}{'·' * (self.WIDTH - full)}] {100.0 * part:3.0f} %  {clock(left)} left  {text}"
        self._stream.write(f"\r{line}\x1b[K" if self.terminal else line + "\n")
        self._stream.flush()

    def say(self, text: str) -> None:
        """Print a line that stays."""
        self._stream.write(f"\r{text}\x1b[K\n" if self.terminal else text + "\n")
        self._stream.flush()
        self._shown = -1e9 if self.terminal else self._shown

    def close(self) -> None:
        if self.terminal:
            self._stream.write("\r\x1b[K")
