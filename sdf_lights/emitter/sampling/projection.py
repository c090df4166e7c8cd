# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Projection sampling: a uniform point of a lamp's interior gives a direction.

Huang, Zheng, Xu, Kitamura and Wang 2026, "Efficient Monte Carlo rendering of implicit-shaped volumetric emitters",
equations 2, 4 and 6; as a solid angle technique already in Simon et al. 2017. The density of a direction is the
integral of r² along its ray,

    p(ω|x) = 1/(3V) Σ (r₊³ − r₋³) = 1/(3V) Σ 2h (3c² + h²)

over the intervals [c − h, c + h] of the ray inside.
"""

from ...jit import kernel
from ...vec import add, normalize, sub, transform_point, vec
from .. import primitives
from ..hashing import following, seeded, uniform
from ..intersection import fields
from ..intersection.membership import contains
from ..lamps import CLOSED, PRIMITIVE, instructions, lamps, lists, nodes
from ..tree.nodes import INSIDE
from ..tree.points import tree_point

ATTEMPTS = 4096  # draws before giving up; with the least acceptance of a lamp, its probability is 1e-9


@kernel
def _found_inside(block, row, q, leaf):
    """Whether the point q, in a leaf on the boundary, is inside, by the list of that leaf."""
    node = nodes(block)[row.first_node + leaf]
    if row.kind == CLOSED:
        program = instructions(block)[row.first_instruction : row.first_instruction + row.instruction_count]
        first = row.first_list + node.row_first
        return contains(program, q, lists(block)[first : first + node.row_count])
    return fields.value(block, row, node.row_first, node.row_count, q) <= 0.0


@kernel
def interior_point(block, lamp, u1, u2, u3):
    """Uniform point in a lamp, relative to its centre.

    If a point in the tree's boxes is outside the shape, it is drawn again with numbers hashed from u1, u2 and u3.
    """
    row = lamps(block)[lamp]
    if row.kind == PRIMITIVE:
        return transform_point(row.matrix, primitives.point(row.primitive, row.parameters, u1, u2, u3))
    tree = nodes(block)[row.first_node : row.first_node + row.node_count]
    state = seeded(u1, u2, u3)
    q = (0.0, 0.0, 0.0)
    for _ in range(ATTEMPTS):
        q, leaf = tree_point(tree, row.low, row.high, u1, u2, u3)
        if tree[leaf].state == INSIDE or _found_inside(block, row, q, leaf):
            break
        state = following(state)
        u1 = uniform(state)
        state = following(state)
        u2 = uniform(state)
        state = following(state)
        u3 = uniform(state)
    return transform_point(row.matrix, q)


@kernel
def interior_offset(block, lamp, x, u1, u2, u3):
    """Offset from x to a uniform point of the lamp."""
    return add(sub(vec(lamps(block)[lamp].center), x), interior_point(block, lamp, u1, u2, u3))


@kernel
def sample_direction(block, lamp, x, n, u1, u2, u3):
    """Unit direction from x to a uniform point of the lamp; its density is ``direction_pdf``."""
    return normalize(interior_offset(block, lamp, x, u1, u2, u3))


@kernel
def direction_pdf(block, lamp, x, n, d, spans, count):
    """Density per solid angle of ``sample_direction`` giving d, from the intervals that ``trace`` found from x."""
    total = 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        total += 2.0 * h * (3.0 * c * c + h * h)
    return total / (3.0 * lamps(block)[lamp].volume)
