# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What code of kernels has that Numba's own code has not, and the reverse."""

import numpy as np
import pytest

from sdf_lights.jit import kernel

numba = pytest.importorskip("numba")

VALUES = np.array([3.0, 5.0, 7.0])


@kernel
def _ends(values):
    return values[-1] + 10.0 * values[-2] + 100.0 * values[0]


def test_written_negative_indices_count_from_the_end():
    assert _ends(VALUES) == 357.0


def test_other_code_keeps_all_negative_indices():
    _ends(VALUES)  # compiled or loaded

    @numba.njit
    def at(values, index):
        return values[index]

    assert [at(VALUES, index) for index in (-1, -3)] == [7.0, 3.0]
