# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of the kernels for media. They are compiled separately, if a scene has any (``code_table.py``). The path tracer
calls them by address, so it is neither larger nor slower to compile because of them.
"""

from __future__ import annotations

import numpy as np

from ....jit import call_part, kernel, table

# Indices of the addresses, which are 0 in a scene without media.
PLACES = BOUNDS, ENTER, SCATTER, SHADOW, LAMP, SEEN_LAMP, FADE = range(7)

# Events of a path, or of a light ray that leaves it, at surfaces that bound media.
BEGIN, ESCAPE, NOTE, CROSS, PASS, LOOK, LOOK_THROUGH = range(7)

TABLES = {"media_code": np.dtype(np.int64)}
_code = table("media_code", np.int64)


@kernel
def bounds(block, workspace, what):
    """See ``stack.bounds``."""
    return call_part(_code(block)[BOUNDS], block, workspace, (what,), 1)[0] > 0.0


@kernel
def enter(block, workspace, length):
    """See ``travel.enter``."""
    return call_part(_code(block)[ENTER], block, workspace, (length,), 1)[0] > 0.0


@kernel
def scatter(block, workspace):
    """See ``travel.scatter``."""
    return call_part(_code(block)[SCATTER], block, workspace, (0.0,), 1)[0] > 0.0


@kernel
def fade(block, workspace, distance):
    """See ``travel.fade``."""
    return call_part(_code(block)[FADE], block, workspace, (distance,), 3)


@kernel
def shadow(block, workspace, start, direction, t_max, blockers):
    """See ``light_rays.shadow``."""
    x, y, z = start
    dx, dy, dz = direction
    return call_part(_code(block)[SHADOW], block, workspace, (x, y, z, dx, dy, dz, t_max, blockers), 3)


@kernel
def lamp(block, workspace, index, x, direction, count, start, u):
    """See ``light_rays.lamp``."""
    return call_part(
        _code(block)[LAMP],
        block,
        workspace,
        (index, x[0], x[1], x[2], direction[0], direction[1], direction[2], count, start[0], start[1], start[2], u),
        3,
    )


@kernel
def seen_lamp(block, workspace, index, count, t_to, u):
    """See ``light_rays.seen_lamp``."""
    return call_part(_code(block)[SEEN_LAMP], block, workspace, (index, count, t_to, u), 3)
