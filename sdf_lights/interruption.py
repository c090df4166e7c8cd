# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work that someone waits for: it asks between its steps whether to go on, and says what it is at.

Who starts the work watches it (``watched``). Everything below calls ``check`` and ``say``, which cost nothing where nobody
watches. Threads that are started with a copy of the context, as ``emitter.tree.parallel`` does, are watched too.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from contextvars import ContextVar

SLICE = 0.02e9  # ns that the parts of work take, between which it asks; rough, so that cancelling takes less than 0.5 s


class Interrupted(Exception):
    """Who watches the work does not want it any more."""


class Watch:
    """``stop()`` says whether the work is of no use any more; ``doing`` is what it is at, a line for the user.

    ``stop`` is called by the threads that work.
    """

    def __init__(self, stop: Callable[[], bool] = lambda: False):
        self.stop, self.doing = stop, ""


_watch: ContextVar[Watch | None] = ContextVar("sdf_lights_watch", default=None)


@contextlib.contextmanager
def watched(watch: Watch) -> Iterator[Watch]:
    """What runs within is watched."""
    token = _watch.set(watch)
    try:
        yield watch
    finally:
        _watch.reset(token)


def check() -> None:
    """Raise ``Interrupted`` if the work is not wanted any more."""
    watch = _watch.get()
    if watch is not None and watch.stop():
        raise Interrupted


def say(text: str) -> None:
    """Tell who watches what the work is at."""
    watch = _watch.get()
    if watch is not None:
        watch.doing = text
