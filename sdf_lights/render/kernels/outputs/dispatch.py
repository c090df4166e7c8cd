# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of the kernels that fill passes. They are compiled separately, if a film has such a pass, and the path tracer
calls them by address. Check ``block.outputs`` before a call.
"""

from __future__ import annotations

from ....jit import call_part, kernel
from .records import code_table

# Indices of the addresses, which are 0 for passes that the film lacks.
PLACES = CLEAR, LIGHT, DIVIDE, SURFACE, MISS, ADD, CATCH, RELEASE, BARE, VECTOR, BACKGROUND = range(11)


@kernel
def clear(block, workspace):
    """Set all sums of the sample to 0."""
    call_part(code_table(block)[CLEAR], block, workspace, (0.0,), 1)


@kernel
def add_light(block, workspace, value, emitter, scatters):
    """See ``light.add_light``."""
    call_part(code_table(block)[LIGHT], block, workspace, (value[0], value[1], value[2], emitter, scatters), 1)


@kernel
def divide(block, workspace, wi, kind, kinds, row):
    """See ``light.divide``."""
    call_part(code_table(block)[DIVIDE], block, workspace, (wi[0], wi[1], wi[2], kind, kinds, row), 1)


@kernel
def add_surface(block, workspace, first):
    """See ``data.add_surface``."""
    call_part(code_table(block)[SURFACE], block, workspace, (first,), 1)


@kernel
def add_miss(block, workspace):
    """See ``data.add_miss``."""
    call_part(code_table(block)[MISS], block, workspace, (0.0,), 1)


@kernel
def add_sample(block, workspace, pixel):
    """See ``sums.add_sample``."""
    call_part(code_table(block)[ADD], block, workspace, (pixel,), 1)


@kernel
def catch(block, workspace):
    """See ``catchers.catch``."""
    call_part(code_table(block)[CATCH], block, workspace, (0.0,), 1)


@kernel
def release(block, workspace):
    """See ``catchers.release``."""
    (found,) = call_part(code_table(block)[RELEASE], block, workspace, (0.0,), 1)
    return found != 0.0


@kernel
def add_bare(block, workspace):
    """See ``catchers.add_bare``."""
    call_part(code_table(block)[BARE], block, workspace, (0.0,), 1)


@kernel
def add_vector(block, workspace):
    """See ``vectors.add_vector``."""
    call_part(code_table(block)[VECTOR], block, workspace, (0.0,), 1)


@kernel
def add_background_vector(block, workspace):
    """See ``vectors.add_background_vector``."""
    call_part(code_table(block)[BACKGROUND], block, workspace, (0.0,), 1)
