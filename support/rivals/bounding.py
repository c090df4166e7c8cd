# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Projection sampling of a lamp's bounding box in the world, for comparison: rays may miss the lamp."""

from sdf_lights.emitter.lamps import lamps
from sdf_lights.emitter.primitives.box import box_span
from sdf_lights.jit import kernel
from sdf_lights.vec import add, normalize, sub, vec


@kernel
def sample(block, lamp, x, u1, u2, u3):
    """Unit direction from x to a uniform point of the box; its density is ``density``."""
    row = lamps(block)[lamp]
    h = vec(row.half)
    place = ((2.0 * u1 - 1.0) * h[0], (2.0 * u2 - 1.0) * h[1], (2.0 * u3 - 1.0) * h[2])
    return normalize(add(sub(vec(row.center), x), place))


@kernel
def density(block, lamp, x, d):
    """Density per solid angle of ``sample`` giving d."""
    row = lamps(block)[lamp]
    h = vec(row.half)
    start, end = box_span(sub(x, vec(row.center)), d, h[0], h[1], h[2])
    start, end = max(start, 0.0), max(end, 0.0)
    return max(end * end * end - start * start * start, 0.0) / (24.0 * h[0] * h[1] * h[2])
