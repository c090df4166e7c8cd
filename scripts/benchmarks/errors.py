# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors of a picture relative to a reference. Pictures are (height, width, RGB), scene-linear."""

from __future__ import annotations

import math
import os

import numpy as np

FLOOR = 0.01  # fraction of the mean of the reference that errors are relative to where it is darker


def _squares(reference: np.ndarray) -> np.ndarray:
    return reference**2 + FLOOR * reference.mean() ** 2


def rel_mse(picture: np.ndarray, reference: np.ndarray) -> float:
    """Mean of (x − r)² / (r² + 0.01 r̄²)."""
    return float(np.mean((picture - reference) ** 2 / _squares(reference)))


def rel_variance(variance: np.ndarray, reference: np.ndarray) -> float:
    """The contribution of a ``variance`` of each value to ``rel_mse``."""
    return float(np.mean(variance / _squares(reference)))


def mape(picture: np.ndarray, reference: np.ndarray) -> float:
    """Mean of |x − r| / (r + 0.01 r̄)."""
    return float(np.mean(np.abs(picture - reference) / (reference + FLOOR * reference.mean())))


def pixel_errors(picture: np.ndarray, reference: np.ndarray) -> tuple[float, float]:
    """The 99.9th percentile and the largest relative error of a pixel: of the root mean square over its channels."""
    errors = np.sqrt(np.mean((picture - reference) ** 2 / _squares(reference), axis=2))
    return float(np.quantile(errors, 0.999)), float(errors.max())


def flip(picture: np.ndarray, reference: np.ndarray) -> float | None:
    """LDR-FLIP of both as sRGB, clipped to [0, 1]; None where the package flip-evaluator is not installed."""
    return flip_of_shown(
        *(
            np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)
            for x in (np.clip(picture, 0.0, 1.0), np.clip(reference, 0.0, 1.0))
        )
    )


def flip_of_shown(picture: np.ndarray, reference: np.ndarray) -> float | None:
    """LDR-FLIP of two pictures as a screen shows them, in [0, 1]; None where the package flip-evaluator is not
    installed."""
    # Threads of OpenMP that wait must not spin: the next render is timed.
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    try:
        import flip_evaluator
    except ImportError:
        return None
    shown = [np.ascontiguousarray(values, np.float32) for values in (reference, picture)]
    return float(flip_evaluator.evaluate(*shown, "LDR", inputsRGB=True, applyMagma=False)[1])


def interpolated(curve: list[tuple[float, float]], at: float) -> float:
    """Value at a position, from (position, value) points that scatter about a power law: extrapolated from the nearest
    point."""
    x, y = min(curve, key=lambda point: abs(math.log(point[0] / at)))
    # A single point: the error of independent samples, against their number.
    return y * (at / x) ** (slope(curve) if len(curve) > 1 else -1.0)


def slope(curve: list[tuple[float, float]]) -> float:
    """Exponent of a power law through (samples, error) points, by least squares of logarithms."""
    x, y = np.log(np.array(curve, float)).T
    return float(np.polyfit(x, y, 1)[0])
