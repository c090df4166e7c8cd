# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ray Portal: the ray continues at another position, in another direction.

Fields of the closure: f0 is the new position and the tangent the new direction. Light rays do not pass it
(``material_compiler.py``).
"""

from .....jit import kernel
from .....vec import dot, negate, normalize, put, put_sum, scale, vec
from ..closures import begin, finish, lobe_table, positive
from ..material_records import NONE
from ..operands import vector
from ..records import PORTAL, SINGULAR, THROUGH_PORTAL, TRANSPARENT, closure_table, surface_table
from ..special_lobes import lobe_kind


@kernel
def add_lobe(block, workspace, lobe, weight):
    """Add the closure of lobe number ``lobe``, with this weight."""
    args, surface = lobe_table(block)[int(lobe)].args, surface_table(workspace)[0]
    color = scale(positive(vector(block, workspace, args[0])), weight)
    index = begin(workspace, color, vec(surface.n))
    if index < 0:
        return 0.0
    closure = closure_table(workspace)[index]
    closure.kind, closure.singular = PORTAL, 1
    position = vec(surface.position)
    if args[1] != NONE:
        position = vector(block, workspace, args[1])
    direction = negate(vec(surface.wo))
    if args[2] != NONE:
        given = normalize(vector(block, workspace, args[2]))
        if dot(given, given) > 0.5:
            direction = given
    put(closure.f0, position)
    put(closure.tangent, direction)
    surface.portal = 1
    put_sum(surface.transparency, color)
    finish(workspace, index, color)
    return 0.0


@kernel
def evaluate(block, workspace, index, x, y, z):
    """Zero: it is singular."""
    return 0.0, 0.0, 0.0, 0.0


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, f · |cos|, pdf and kind."""
    closure = closure_table(workspace)[int(index)]
    wi = vec(closure.tangent)
    put(surface_table(workspace)[0].exit, vec(closure.f0))
    return wi[0], wi[1], wi[2], 1.0, 1.0, 1.0, 1.0, THROUGH_PORTAL | TRANSPARENT | SINGULAR


LOBES = {lobe_kind("portal"): (add_lobe, (PORTAL,))}
CLOSURES = (PORTAL,)
