# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Python's search for garbage, in blocks that make much that stays."""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator

FULL_SEARCHES = 1000  # searches of the middle generation from one of all objects to the next: ``gc.set_threshold``


@contextlib.contextmanager
def rarely_all_searched() -> Iterator[None]:
    """A block that makes very many objects that stay for a while, such as compiling.

    Python looks through all of them again and again, a tenth of the time that compiling takes. Here it looks at new
    objects alone.
    """
    young, middle, old = gc.get_threshold()
    gc.set_threshold(young, middle, max(old, FULL_SEARCHES))
    try:
        yield
    finally:
        gc.set_threshold(young, middle, old)


@contextlib.contextmanager
def nothing_to_collect() -> Iterator[None]:
    """A block that makes many objects and no garbage, such as imports of modules.

    Python looks through new objects for garbage again and again, and then through all that Blender has. That is a tenth
    of a second of a start. Here they become old objects at once.
    """
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        if not gc.get_freeze_count():  # else it would let go what others have frozen
            gc.freeze()
            gc.unfreeze()
        gc.enable()
