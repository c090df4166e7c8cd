# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Python's search for garbage, while much is made that stays."""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator


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
