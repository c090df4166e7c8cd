# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiled terms in kernels against the NumPy reading of the whole field."""

import math

import numpy as np
import pytest

from sdf_lights.emitter.intersection import fields
from sdf_lights.emitter.intersection.fields import LANES, NEGATED, STACK, VALUES
from sdf_lights.jit import kernel, stack_array
from sdf_lights.sdf.data.voxels import mesh_grid
from sdf_lights.sdf.shapes import Difference, Exclusive, Sphere, Torus, Transformed, Union
from support.grids import torus
from support.lamps.shapes_under_test import COMPOSITES, FIELDS, moved, turned


@kernel
def run(terms, parameters, lists, points, values):
    """Values (n,) of the list at points (3, n); n is a multiple of LANES."""
    stack = stack_array(STACK)
    for start in range(0, len(values), LANES):
        for lane in range(LANES):
            for k in range(3):
                stack[k * LANES + lane] = points[k, start + lane]
        fields.run_terms(terms, parameters, lists, 0, len(lists), fields.LANES, stack)
        for lane in range(LANES):
            values[start + lane] = stack[VALUES + lane]


def evaluate(field, lists, points):
    values = np.empty(len(points))
    run(field.terms, field.parameters, np.asarray(lists, fields.LIST), np.ascontiguousarray(points.T), values)
    return values


POINTS = np.random.default_rng(1).normal(scale=0.8, size=(80 * LANES, 3))


@pytest.mark.parametrize("name", [*COMPOSITES, *FIELDS])
def test_terms_are_the_field(name):
    """Also in another place, and at another scale: terms of a moved shape are its field, times the factor."""
    shape = {**COMPOSITES, **FIELDS}[name]
    for matrix, factor in ((np.eye(4), 1.0), (moved(0.1, -0.2, 0.3) @ turned(0.7, 1), 0.5)):
        field = fields.compile_terms(shape.terms(matrix, factor))
        here = np.linalg.inv(matrix)
        expected = factor * shape.distance(POINTS @ here[:3, :3].T + here[:3, 3])
        assert np.allclose(evaluate(field, field.all_terms(), POINTS), expected, rtol=1e-12, atol=1e-12)


def test_a_negated_operand():
    """Where the second operand of a difference is all that matters, its value is taken with its sign changed."""
    field = fields.compile_terms(Difference(Sphere(5.0), Torus(0.7, 0.3)).terms(np.eye(4), 1.0))
    assert len(field.terms) == 3
    ring = Torus(0.7, 0.3).distance(POINTS)
    assert np.allclose(evaluate(field, [1, NEGATED], POINTS), -ring, atol=1e-14)
    assert np.allclose(evaluate(field, [1, NEGATED, NEGATED], POINTS), ring, atol=1e-14)


def test_same_formulas_share_code():
    """A hundred placed spheres are one piece of code, and the joins another."""
    shape = Union(*(Transformed(Sphere(0.1 + 0.01 * k), moved(k)) for k in range(100)))
    field = fields.compile_terms(shape.terms(np.eye(4), 1.0))
    assert len(field.terms) == 199 and len(field.code) == 2
    assert field.depth <= 8  # joins are balanced
    assert len(set(field.terms["parameters"][field.terms["arity"] == 0])) == 100


def test_gains_and_costs():
    shape = Exclusive(Sphere(0.5), Transformed(Torus(0.5, 0.1), moved(0.2)))
    field = fields.compile_terms(shape.terms(np.eye(4), 1.0))
    assert np.array_equal(field.gains, [math.inf, math.inf, 1.0])
    assert (field.operations > 0).all() and (field.costs > 0.0).all()
    loops = fields.compile_terms(FIELDS["formula"].terms(np.eye(4), 1.0))
    assert loops.terms["lipschitz"][0] == math.inf


def test_functions_of_tables_are_called_for_the_wanted_points_alone():
    shape = mesh_grid(*torus(0.7, 0.25, 32, 16), 0.1)
    field = fields.compile_terms(shape.terms(np.eye(4), 1.0))
    stack = np.zeros(STACK)
    points = POINTS[:LANES]
    stack[: 3 * LANES] = points.T.ravel()
    run_some(field.terms, field.parameters, field.all_terms(), 3, stack)
    np.testing.assert_allclose(stack[VALUES : VALUES + 3], shape.distance(points[:3]), rtol=1e-12)
    assert not stack[VALUES + 3 : VALUES + LANES].any()


@kernel
def run_some(terms, parameters, lists, points, stack):
    fields.run_terms(terms, parameters, lists, 0, len(lists), points, stack)
