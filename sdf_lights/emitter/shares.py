# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that work on a shape, in threads: on the same shares whatever the machine, so results do not depend on it."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

SHARES = 4

Result = TypeVar("Result")


def in_shares(work: Callable[[int], Result]) -> list[Result]:
    """Results of ``work(share)`` for each of the ``SHARES`` shares.

    It should call kernels, which leave Python to other threads, and only such that were called before: else each thread
    would compile them.
    """
    with ThreadPoolExecutor(min(SHARES, os.cpu_count() or 1)) as pool:
        return list(pool.map(work, range(SHARES)))
