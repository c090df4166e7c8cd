# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs kernels on a shape in threads. The shares are the same on every machine, so results do not depend on it."""

from __future__ import annotations

import contextvars
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

TASKS = 4

Result = TypeVar("Result")


def in_parallel(work: Callable[[int], Result]) -> list[Result]:
    """Results of ``work(share)`` for each of the ``TASKS`` shares.

    It should call only kernels, which release Python's lock, and only those that were called before: otherwise each
    thread would compile them. A watch of the caller (``interruption``) watches the threads too.
    """
    # a context can be active in only one thread at a time
    contexts = [contextvars.copy_context() for _ in range(TASKS)]
    with ThreadPoolExecutor(min(TASKS, os.cpu_count() or 1)) as pool:
        return list(pool.map(lambda share: contexts[share].run(work, share), range(TASKS)))
