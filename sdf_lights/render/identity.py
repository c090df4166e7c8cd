# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays as parts of keys."""

from __future__ import annotations

import numpy as np


class Same:
    """An array that is equal only to itself, and stays alive so that no other gets its address."""

    def __init__(self, array: np.ndarray | None):
        self._array = array

    def __eq__(self, other):
        return self._array is other._array

    def __hash__(self):
        return id(self._array)
