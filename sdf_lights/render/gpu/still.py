# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""In the place of what the CPU does with things that move, which on the GPU all stand still, and with what rays start on."""

from ...jit import kernel
from ...vec import vec
from ..kernels.departure import beside
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
def leave(workspace, surface, direction):
    """In the place of ``departure.leave``: a ray starts beside its triangle, which it could meet."""
    return beside(vec(surface.position), vec(surface.ng), direction)
