# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The ball cover on fields along a line, whose zeros are known."""

import numpy as np
import pytest

from sdf_lights.emitter.intersection import cover as covering
from sdf_lights.emitter.intersection.cover import OPEN, PATIENCE, PENDING_SIZE, SIGN, UNKNOWN, add, cover, insert
from sdf_lights.emitter.intersection.fields import LANES, LIST, STACK, compile_terms
from sdf_lights.graph.formula import POINT, constant, maximum, minimum, sin, sqrt
from sdf_lights.jit import fill_table, kernel, stack_array
from sdf_lights.sdf.shapes.base import Family, Term
from support.lamps.rays import BLOCK, ROW

TOLERANCE, PRECISION = 1e-7, 1e-12
# Of a field that no evaluation settles: all lanes in each round that the cover has patience for, and some to give up.
MOST_EVALUATIONS = LANES * (PATIENCE + 1000)


@kernel
def _covered(blocks, rows, d, stretches, fall, rise, tolerance, precision, spans):
    pending, stack = stack_array(PENDING_SIZE), stack_array(STACK)
    used = add(pending, 0, stretches[0], SIGN, stretches[0], UNKNOWN, fall, rise, OPEN)
    for index in range(len(stretches) - 1):
        used = add(pending, used, stretches[index], UNKNOWN, stretches[index + 1], UNKNOWN, fall, rise, OPEN)
    return cover(
        blocks[0], rows[0], 0, 1, (0.0, 0.0, 0.0), d, pending, used, tolerance, precision, spans, len(spans), 0, stack
    )


def covered(formula, end, fall, rise=None, start=0.0, pieces=1, d=(1.0, 0.0, 0.0), rows=200, tolerance=TOLERANCE):
    """(zeros, value at the end, unresolved, evaluations) of a formula along a line from ``start`` to ``end``.

    The first zero is ``start`` itself where the formula is negative there.
    """
    field = compile_terms([Term(formula, np.zeros(0), 0, Family.LEAF, 0.0, 1.0)])
    tables = dict(lamp_terms=field.terms, lamp_parameters=np.zeros(1), lamp_lists=np.zeros(1, LIST))
    blocks, spans = np.zeros(1, BLOCK), np.full((rows, 2), np.nan)
    for name, table in tables.items():
        fill_table(blocks, name, table)
    found, last, unresolved, evaluations = _covered(
        blocks,
        np.zeros(1, ROW),
        d,
        np.linspace(start, end, pieces + 1),
        float(fall),
        float(fall if rise is None else rise),
        tolerance,
        PRECISION,
        spans,
    )
    return spans.ravel()[:found].copy(), last, unresolved, evaluations


def hats(roots):
    """A field along x with slopes of ±1 or ∓1 that is zero at an even number of sorted roots, negative between
    pairs."""
    distances = [maximum(a - POINT.x, POINT.x - b) for a, b in zip(roots[::2], roots[1::2])]
    return minimum(*distances)


def test_zeros_of_steep_fields():
    """A slope equal to the rate leaves no gap: one value on each side of every zero is enough."""
    zeros, last, unresolved, evaluations = covered(hats([0.3, 0.7]), 1.0, 1.0)
    assert np.allclose(zeros, [0.3, 0.7], rtol=0.0, atol=1e-12)
    assert last == pytest.approx(0.3)
    assert unresolved < 1e-15
    assert evaluations <= 12


@pytest.mark.parametrize("pieces", [1, 2, 7, 60])
@pytest.mark.parametrize("excess", [1.0, 1.5, 5.0])
def test_random_zeros(excess, pieces):
    """Many zeros, some very close; the bound exceeds the true slope by a factor."""
    rng = np.random.default_rng(int(10 * excess) + pieces)
    for _ in range(40):
        steps = 10.0 ** rng.uniform(-5.0, 0.0, 2 * rng.integers(1, 8))
        roots = 0.05 + 0.9 * np.cumsum(steps) / steps.sum()
        zeros, _, unresolved, evaluations = covered(hats(roots), 1.0, excess, pieces=pieces)
        assert len(zeros) == len(roots)
        assert np.abs(zeros - roots).max() < 1e-11
        assert unresolved < 5.0 * TOLERANCE * len(roots)
        assert evaluations < 60 * len(roots) * excess + pieces


@pytest.mark.parametrize("apart", [1e-3, 1e-5, 3e-7])
def test_close_pairs_are_found_down_to_the_tolerance(apart):
    for shift in np.linspace(0.2, 0.8, 23):
        for sign in (1.0, -1.0):  # a thin sheet, or a thin gap
            zeros, *_ = covered(hats([shift, shift + apart]) * sign, 1.0, 1.0)
            assert len(zeros) - (sign < 0.0) == 2
            assert np.allclose(zeros[sign < 0.0 :], [shift, shift + apart], rtol=0.0, atol=1e-11)


def test_what_is_too_fine_is_counted():
    """A sheet far thinner than the tolerance may go unseen, but not unnoticed."""
    unseen = 0
    for shift in np.linspace(0.2, 0.8, 50):
        zeros, _, unresolved, _ = covered(hats([shift, shift + 1e-11]), 1.0, 1.0, tolerance=1e-4)
        unseen += len(zeros) == 0
        assert len(zeros) == 2 or 0.0 < unresolved < 1e-3
    assert unseen > 25


def test_smooth_fields_and_rates_of_each_direction():
    """sin along x: rates that say where it is monotonic save what a Lipschitz bound costs."""
    wave, roots = sin(POINT.x * np.pi), np.arange(0, 10)
    zeros, _, _, plain = covered(wave, 9.5, np.pi, start=-0.3)
    assert np.allclose(zeros[1:], roots, rtol=0.0, atol=1e-11) and zeros[0] == -0.3
    zeros, _, unresolved, evaluations = covered(wave, 0.5, -1.0, np.pi, start=-0.45)
    assert np.allclose(zeros, [-0.45, 0.0], rtol=0.0, atol=1e-12)
    assert unresolved == 0.0 and evaluations <= 7
    assert plain > 4 * evaluations


def test_directions_of_any_length():
    for factor in (1e-3, 7.0):
        zeros, *_ = covered(hats([0.3, 0.7]), 1.0 / factor, factor, d=(factor, 0.0, 0.0), tolerance=TOLERANCE / factor)
        assert np.allclose(zeros * factor, [0.3, 0.7], rtol=0.0, atol=1e-9)


def test_what_is_not_a_number_is_outside():
    """√(0.36 − x²) − 0.5 has no value beyond 0.6; on this side it is inside from √0.11 on."""
    zeros, *_ = covered(sqrt(0.36 - POINT.x * POINT.x) - 0.5, 1.0, 20.0)
    assert np.allclose(zeros, [np.sqrt(0.11), 0.6], rtol=0.0, atol=1e-11)


def test_infinite_values_and_rates():
    zeros, _, unresolved, evaluations = covered(1.0 / (POINT.x - 0.3), 1.0, np.inf)
    assert len(zeros) == 2 and zeros[0] == 0.0 and abs(zeros[1] - 0.3) < 1e-6
    assert evaluations < MOST_EVALUATIONS
    zeros, *_ = covered(constant(np.inf) + 0.0 * POINT.x, 1.0, 1.0)
    assert len(zeros) == 0


def test_work_is_bounded_and_the_rest_is_counted():
    """A field of zeros, as far as values tell, and one that crosses zero everywhere."""
    for formula in (0.0 * POINT.x + 1e-200, sin(POINT.x * 1e9) * 1e-6):
        zeros, _, unresolved, evaluations = covered(formula, 1.0, 1.0)
        assert evaluations < MOST_EVALUATIONS
        assert unresolved > 0.5
        assert np.all(np.diff(zeros) >= 0.0)


def test_zeros_beyond_the_rows_are_dropped_from_the_far_end():
    spans = np.empty((3, 2))
    count = 0
    values = np.random.default_rng(0).permutation(20) + 0.5
    for value in values:
        count = insert(spans, 3, count, value)
    assert count == 20
    assert np.array_equal(spans.ravel(), np.arange(6) + 0.5)


def test_brackets_locate_in_few_steps():
    """Simple zeros of curved functions, a cubic one, and a jump."""
    for formula, zero, most in (
        (POINT.x * POINT.x - 0.5, np.sqrt(0.5), 8),
        (sin(POINT.x * 3.0) - 0.5, np.pi / 18, 8),
        ((POINT.x - 0.4) * (POINT.x - 0.4) * (POINT.x - 0.4), 0.4, 60),
    ):
        zeros, _, _, evaluations = covered(formula, 1.0 if zero > 0.3 else 0.4, -1e-9, 20.0)
        assert zeros[0] == 0.0 and len(zeros) == 2
        assert abs(zeros[1] - zero) < (1e-12 if most < 10 else 1e-4)
        assert evaluations <= most + 2


def test_kept_values_are_never_zero():
    for value, kept in ((0.0, -SIGN), (-0.0, -SIGN), (np.nan, SIGN), (np.inf, covering.LARGEST), (-2.0, -2.0)):
        assert covering.signed(value) == kept
