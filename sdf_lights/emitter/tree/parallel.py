# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that work on a shape, in threads: on the same shares whatever the machine, so results do not depend on it."""

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

    It should call kernels, which leave Python to other threads, and only such that were called before: else each thread
    would compile them. Who watches the caller (``interruption``) watches them too.
    """
    contexts = [contextvars.copy_context() for _ in range(TASKS)]  # a context is in one thread at a time
    with ThreadPoolExecutor(min(TASKS, os.cpu_count() or 1)) as pool:
        return list(pool.map(lambda share: contexts[share].run(work, share), range(TASKS)))
