# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How the GPU traces closed lamps of several parts, by the same kernels on the CPU: against the whole program."""

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.emitter.intersection.intervals import _combine, regularize, rows_needed, solve
from sdf_lights.emitter.lamps import LAMP
from sdf_lights.jit import block_dtype, fill_table, kernel
from sdf_lights.render.gpu import closed_lamp_parts
from sdf_lights.sdf.expression import Expression
from sdf_lights.sdf.program import INSTRUCTION, Op
from tests.gpu.test_session import balls

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

BLOCK = block_dtype(
    {"lamp_instructions": INSTRUCTION, "lamp_fields": closed_lamp_parts.FIELD, "lamp_parts": closed_lamp_parts.PART}
)
SHAPES = {
    "balls": f"union({balls(12)})",
    "kinds": "union(translate(box(0.2, 0.1, 0.3), -1, 0, 0), rotate_x(torus(0.3, 0.1), 40),"
    " translate(capsule(0.1, 0.5), 1, 0, 0),"
    " translate(cylinder(0.2, 0.5), 0, 1, 0), translate(rotate_y(cone(0.3, 0.6), 70), 0, -1, 0))",
    "nested": "union(translate(box(0.3) - sphere(0.36), -1, 0, 0), sphere(0.3), translate(sphere(0.3) & box(0.25), 1, 0, 0),"
    " union(translate(sphere(0.2), 0, 0, 0.4), translate(menger_sponge(0.3, 2), 0, 1, 0)))",
}


@kernel
def _both(blocks, row, program, origins, directions, spans):
    """Rays whose intervals differ, and all of them."""
    first, second = np.empty((200, 2)), np.empty((200, 2))
    different = crossed = 0
    for i in range(len(origins)):
        o = (origins[i, 0], origins[i, 1], origins[i, 2])
        d = (directions[i, 0], directions[i, 1], directions[i, 2])
        count = regularize(spans, solve(program, o, d, spans), 1e-10)
        first[:count] = spans[:count]
        more = regularize(spans, closed_lamp_parts.solve_all(blocks[0], row[0], o, d, spans), 1e-10)
        second[:more] = spans[:more]
        crossed += count > 0
        same = count == more
        for k in range(count if same else 0):
            same = same and abs(first[k, 0] - second[k, 0]) < 1e-12 and abs(first[k, 1] - second[k, 1]) < 1e-12
        different += not same
    return different, crossed


@pytest.mark.parametrize("name", SHAPES)
def test_parts_give_what_the_whole_does(name):
    program = Expression(SHAPES[name]).shape().program()
    found = closed_lamp_parts.parts_of(program)
    assert len(found) >= closed_lamp_parts.MANY and found["count"].sum() + len(found) - 1 == len(program)
    block, row, field = np.zeros(1, BLOCK), np.zeros(1, LAMP), np.zeros(1, closed_lamp_parts.FIELD)
    field["part_count"], row["instruction_count"], row["rows"] = len(found), len(program), rows_needed(program)[0]
    for table, array in (("lamp_instructions", program), ("lamp_fields", field), ("lamp_parts", found)):
        fill_table(block, table, array)
    rng = np.random.default_rng(3)
    origins, directions = rng.uniform(-1.2, 1.2, (20_000, 3)), rng.normal(size=(20_000, 3))
    different, crossed = _both(block, row, program, origins, directions, np.zeros((row["rows"][0] + len(found), 2)))
    assert different == 0 and crossed > 300


def test_few_parts_have_no_boxes():
    assert len(closed_lamp_parts.parts_of(Expression("sphere(0.5) | box(0.3)").shape().program())) == 0


@kernel
def _combined(a, b, op, looped, direct):
    counts = np.empty((len(a), 2), np.int64)
    for i in range(len(a)):
        for rows in (looped, direct):
            rows[2], rows[3] = a[i], b[i]
        first, second = int(a[i, 0] < a[i, 1]), int(b[i, 0] < b[i, 1])
        counts[i, 0] = _combine(looped, 2, first, 3, second, op, 0)
        counts[i, 1] = closed_lamp_parts.combine_two(direct, 2, first, 3, second, op, 0)
        for k in range(counts[i, 0]):
            if abs(looped[k, 0] - direct[k, 0]) > 0.0 or abs(looped[k, 1] - direct[k, 1]) > 0.0:
                counts[i, 1] = -1
    return counts


@pytest.mark.parametrize("op", [Op.UNION, Op.INTERSECTION, Op.DIFFERENCE])
def test_two_intervals(op):
    rng = np.random.default_rng(5)
    a, b = rng.uniform(-1.0, 1.0, (2, 4000, 2))  # half of them empty
    counts = _combined(a, b, int(op), np.zeros((4, 2)), np.zeros((4, 2)))
    assert np.array_equal(counts[:, 0], counts[:, 1]) and counts.max() == (1 if op == Op.INTERSECTION else 2)
