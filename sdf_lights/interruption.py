# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work that can be cancelled: it checks between its steps whether to go on, and reports what it does.

The caller of the work watches it (``watched``). All code below calls ``check`` and ``say``, which cost nothing without
a watch. Threads that start with a copy of the context, as in ``emitter.tree.parallel``, are watched too.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from contextvars import ContextVar

SLICE = 0.02e9  # ns of work between two checks; rough, so that cancelling takes less than 0.5 s


class Interrupted(Exception):
    """The work was cancelled by its watch."""


class Watch:
    """``stop()`` returns whether the work is cancelled. ``doing`` is its present step, a line for the user.

    The working threads call ``stop``.
    """

    def __init__(self, stop: Callable[[], bool] = lambda: False):
        self.stop, self.doing = stop, ""


_watch: ContextVar[Watch | None] = ContextVar("sdf_lights_watch", default=None)


@contextlib.contextmanager
def watched(watch: Watch) -> Iterator[Watch]:
    """Watch the work inside this context."""
    token = _watch.set(watch)
    try:
        yield watch
    finally:
        _watch.reset(token)


def check() -> None:
    """Raise ``Interrupted`` if the work is cancelled."""
    watch = _watch.get()
    if watch is not None and watch.stop():
        raise Interrupted


def say(text: str) -> None:
    """Report the present step to the watch."""
    watch = _watch.get()
    if watch is not None:
        watch.doing = text
