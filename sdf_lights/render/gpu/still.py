# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""In the place of what the CPU does with things that move, which on the GPU all stand still, and with what rays start on."""

from ...jit import kernel
from ...vec import vec
from ..kernels.departure import offset_ray_origin
from ..kernels.geometry import instance_table


@kernel
def instance_at(block, index):
    """Replaces ``geometry.instance_at``: nothing moves here."""
    return instance_table(block)[index]


@kernel
def form_of(block, instance):
    """Replaces ``geometry.form_of``: nothing moves here."""
    return 0, 0.0


@kernel
def spawn_ray(workspace, surface, direction):
    """Replaces ``departure.spawn_ray``: the origin is always offset, because a ray could hit its own triangle again."""
    return offset_ray_origin(vec(surface.position), vec(surface.ng), direction)
