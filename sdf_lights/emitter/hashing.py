# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Uniform numbers from a counter, for draws outside the fixed dimensions of the sampler.

The finalizer of SplitMix64: Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators".
"""

import numpy as np

from ..jit import kernel
from ..replaced import replaced_on_gpu

_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)


@replaced_on_gpu
@kernel
def following(state):
    """The state after ``state`` (uint64)."""
    return state + _STEP


@kernel
def bits(state):
    """The 64 random bits of a state."""
    z = state
    z = (z ^ (z >> np.uint64(30))) * _FIRST
    z = (z ^ (z >> np.uint64(27))) * _SECOND
    return z ^ (z >> np.uint64(31))


@replaced_on_gpu
@kernel
def uniform(state):
    """The number in [0, 1) of a state, with 53 random bits."""
    return (bits(state) >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@replaced_on_gpu
@kernel
def uniform_point(state):
    """Three numbers in [0, 1) of a state, with 21 random bits each."""
    number = bits(state)
    scale = 1.0 / 2097152.0
    return (
        (number >> np.uint64(43)) * scale,
        (number >> np.uint64(22) & np.uint64(2097151)) * scale,
        (number & np.uint64(2097151)) * scale,
    )


@replaced_on_gpu
@kernel
def seeded(u1, u2, u3):
    """A state that depends on every bit of three numbers in [0, 1)."""
    state = np.uint64(u1 * 9007199254740992.0) * _FIRST
    state = (state ^ (state >> np.uint64(29))) + np.uint64(u2 * 9007199254740992.0) * _SECOND
    state = (state ^ (state >> np.uint64(32))) + np.uint64(u3 * 9007199254740992.0) * _STEP
    return (state ^ (state >> np.uint64(31))) * _FIRST
