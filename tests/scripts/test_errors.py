# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures of error, and what is read off their curves, on pictures whose error is known."""

import numpy as np
import pytest
from benchmarks import errors

REFERENCE = np.full((40, 50, 3), 2.0)


def test_errors_of_a_picture_that_is_a_tenth_too_bright():
    picture = 1.1 * REFERENCE
    assert errors.rel_mse(picture, REFERENCE) == pytest.approx(0.01 / 1.01)
    assert errors.mape(picture, REFERENCE) == pytest.approx(0.1 / 1.01)
    assert errors.pixel_errors(picture, REFERENCE) == pytest.approx((0.1 / 1.01**0.5,) * 2)


def test_one_bright_pixel_is_the_worst_and_not_the_999th():
    picture = REFERENCE.copy()
    picture[3, 4] *= 11.0
    usual, worst = errors.pixel_errors(picture, REFERENCE)
    assert usual < 0.1 < worst == pytest.approx(10.0 / 1.01**0.5)


def test_variance_of_the_reference_is_what_it_adds_to_the_error():
    random = np.random.default_rng(1)
    noisy = REFERENCE + random.normal(0.0, 0.05, REFERENCE.shape)
    assert errors.rel_mse(REFERENCE, noisy) == pytest.approx(
        errors.rel_variance(np.full(REFERENCE.shape, 0.05**2), REFERENCE), rel=0.05
    )


def test_a_power_law_is_read_off_at_any_place():
    curve = [(seconds, 3.0 * seconds**-1.5) for seconds in (0.5, 2.0, 8.0)]
    for seconds in (0.1, 0.5, 1.0, 3.0, 8.0, 50.0):
        assert errors.interpolated(curve, seconds) == pytest.approx(3.0 * seconds**-1.5)
    assert errors.slope(curve) == pytest.approx(-1.5)
    assert errors.interpolated([(2.0, 0.1)], 8.0) == pytest.approx(0.025)


def test_points_next_to_each_other_do_not_decide_how_a_curve_goes_on():
    curve = [(0.204, 0.0108), (0.207, 0.0081), (0.463, 0.0017)]
    assert errors.interpolated(curve, 0.19) == pytest.approx(0.0128, rel=0.05)
