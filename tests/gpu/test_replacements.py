# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the GPU has in the place of kernels: each of those says so where it is defined, and takes the same arguments."""

import inspect

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.render.gpu import replacements, special
from sdf_lights.render.gpu.translate import Native
from sdf_lights.render.kernels import shading
from sdf_lights.replaced import all_replaced

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")


def taken() -> dict:
    """Every kernel that something of the GPU takes the place of in some scene, with what does."""
    written = dict.fromkeys(replacements.WRITTEN)
    return replacements.together(*replacements.GROUPS, special.natives(np.zeros(0, shading.TABLES["lobes"])), written)


def of_the_gpu(function) -> bool:
    return function.__module__.startswith("sdf_lights.render.gpu.")


def test_every_kernel_that_is_replaced_says_so():
    unmarked = [function for function in taken() if function not in all_replaced() and not of_the_gpu(function)]
    assert [f"{function.__module__}.{function.__name__}" for function in unmarked] == []


def test_every_kernel_that_says_so_is_replaced():
    idle = [function for function in all_replaced() if function not in taken()]
    assert [f"{function.__module__}.{function.__name__}" for function in idle] == []


def test_what_takes_its_place_has_the_same_parameters():
    for function, value in taken().items():
        if value is None or isinstance(value, Native):
            continue
        ours, theirs = (list(inspect.signature(inspect.unwrap(f)).parameters) for f in (value, function))
        assert len(ours) == len(theirs), function


@pytest.mark.parametrize("key", replacements.ROUNDING, ids=lambda key: f"{key[0].__name__}.{key[1]}")
def test_constants_that_are_overridden_exist(key):
    """And are read by some kernel of that module."""
    module, name = key
    assert isinstance(getattr(module, name), float)
    kernels = [inspect.unwrap(value) for value in vars(module).values() if hasattr(value, "__wrapped__")]
    assert any(name in kernel.__code__.co_names for kernel in kernels if kernel.__module__ == module.__name__)
