# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Formulas of thousands of operations: in blocks that LLVM compiles in linear time, and trees that take bounded
work."""

import numpy as np

from sdf_lights.emitter.tree import interior
from sdf_lights.graph import codegen_native, native_emission, numpy_evaluation
from sdf_lights.graph.formula import POINT, length, minimum, order
from sdf_lights.sdf.shapes import Box, Intersection
from sdf_lights.sdf.shapes.field import Field

BALLS = 330


def _balls(count: int = BALLS):
    places = np.random.default_rng(3).uniform(-1.0, 1.0, (count, 3))
    x, y, z = POINT
    return minimum(*(length(x - float(a), y - float(b), z - float(c)) - 0.12 for a, b, c in places))


def test_no_block_is_long():
    formula = _balls()
    assert len(order(formula)) > native_emission.BLOCK
    text = str(native_emission.module((formula,)))
    function = text[text.index("define void") :]
    longest = max(block.count("\n") for block in function.split("\n.")[1:] + function.split("br i1"))
    assert longest < 2 * native_emission.BLOCK


def test_values_are_those_of_numpy():
    points = np.random.default_rng(4).uniform(-1.2, 1.2, (100, 3))
    formula = _balls()
    expected = numpy_evaluation.evaluate(formula, points)
    np.testing.assert_allclose(codegen_native.evaluate(formula, points), expected, rtol=1e-13, atol=1e-14)


def test_a_costly_field_has_a_coarser_tree_with_the_same_light():
    field = Field.of(_balls(), (), Box(1.2))
    assert field._operations * interior.MOST_NODES < interior.FIELD_WORK  # this one is not costly
    full = interior.tree(field)
    kept = interior.FIELD_WORK
    try:
        interior.FIELD_WORK = field._operations << 13
        interior.tree.cache_clear()
        coarse = interior.tree(field)
    finally:
        interior.FIELD_WORK = kept
        interior.tree.cache_clear()
    assert 2000 < len(coarse.nodes) <= 1 << 13 < len(full.nodes)
    assert coarse.certified and full.certified
    assert full.nodes["mass"][0] <= coarse.nodes["mass"][0] < 3.0 * full.nodes["mass"][0]
    assert interior.tree(Intersection(Box(0.3), Box(0.2))).field is None
