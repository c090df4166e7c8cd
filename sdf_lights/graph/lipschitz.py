# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lipschitz bounds of formulas over boxes: values and gradients in interval arithmetic, side by side.

Interval forward differentiation (Griewank and Walther, "Evaluating Derivatives"), with two additions that distance
fields need. First, every node has a bound on the norm of its gradient; a norm from bounds of the components would be
inflated by rotations and nested lengths. Second, the square root of a sum of squares is treated as a norm: its gradient
is bounded, while that of the root alone has a pole. At a crease the gradients of both sides are bounded (Clarke's
generalised gradient).

Every value also records in which boxes it may be *discontinuous*: at a step of ``floor``, at a ``select`` whose sides
may differ, at the cut of an angle, at the end of a loop that points leave early, at a pole, at the border of its
domain. There the bound is infinite, unless later operations join both sides again, as the absolute value of a remainder
from −1 to 1 does. ``continuity`` has further cases.
"""

from __future__ import annotations

import numpy as np

from .formula import ITERATE, Formula, Numbers, order
from .interval_evaluation import run
from .slope import NO_GRADIENT, length_bound
from .slope_evaluation import SlopeBoxes


def lipschitz(
    formula: Formula,
    low: np.ndarray,
    high: np.ndarray,
    parameters: Numbers = (),
    parts: int = 16,
    jumps: bool = True,
) -> np.ndarray:
    """Least bounds (n,) found for |φ(x) − φ(y)| / |x − y| over boxes with the corners ``low`` and ``high`` (n, 3).

    Infinite if no bound is found. The bound covers every box separately: between points of two boxes, the greatest
    bound of the boxes that the segment passes through holds. ``parts`` is the maximum number of cases for a box, by the
    sides of clamps and folds that its points are on. Without ``jumps`` the bounds are those of both sides of a jump.
    """
    return _slope(formula, low, high, parameters, parts, jumps)[2]


def discontinuous(
    formula: Formula, low: np.ndarray, high: np.ndarray, parameters: Numbers = (), parts: int = 16
) -> np.ndarray:
    """The boxes in which the formula may jump, or may be undefined somewhere: (n,)."""
    return ~np.isfinite(_slope(formula, low, high, parameters, parts)[2])


def may_be_discontinuous(formula: Formula) -> bool:
    """Whether any part of a formula can jump or be undefined."""
    return any(
        node.kind in _DISCONTINUOUS
        or node.kind == ITERATE
        and any(map(may_be_discontinuous, node.value.roots()))
        or _leaves(node)
        for node in order(formula)
    )


def _leaves(node: Formula) -> bool:
    return node.kind == ITERATE and node.value.going is not None


_DISCONTINUOUS = frozenset({"floor", "select", "atan2", "tan", "divide", "sqrt", "log", "asin", "acos", "power"})


def global_lipschitz(
    formula: Formula, low: np.ndarray, high: np.ndarray, parameters: Numbers = (), jumps: bool = True
) -> float:
    """As ``lipschitz``, for one box with the corners ``low`` and ``high`` (3,), which is split while the bound is
    loose.

    Ends when no slope much below the bound is known to occur any more, or after ``_ROUNDS`` splits. Infinite if no
    bound is found.
    """
    low, high = np.array(low, np.float64, ndmin=2), np.array(high, np.float64, ndmin=2)
    if not np.isfinite(high - low).all():
        return float(lipschitz(formula, low, high, parameters, jumps=jumps)[0])
    low, high = _octants(*_octants(low, high))
    settled = steepest = 0.0
    round_ = 0
    while True:
        round_ += 1
        # Slopes that do occur: those at one point of each box, away from the planes of symmetry of shapes.
        points = low + (high - low) * _INSIDE
        bounds = lipschitz(formula, np.concatenate([low, points]), np.concatenate([high, points]), parameters, 1, jumps)
        bounds, slopes = bounds[: len(low)], bounds[len(low) :]
        steepest = max(steepest, slopes[np.isfinite(slopes)].max(initial=0.0))
        enough = (1.0 + _LOOSE) * steepest
        loose = np.flatnonzero(bounds > enough)
        bounds[loose] = lipschitz(formula, low[loose], high[loose], parameters, _PARTS, jumps)
        worst = np.argsort(bounds)[: -_DIVIDED - 1 : -1]
        divided = np.zeros(len(low), bool)
        divided[worst] = bounds[worst] > enough
        if not divided.any() or round_ == _ROUNDS:
            return float(max(settled, bounds.max()))
        settled = max(settled, bounds[~divided].max(initial=0.0))
        low, high = _octants(low[divided], high[divided])


_ROUNDS, _DIVIDED, _PARTS, _LOOSE = 4, 32, 8, 0.01
_INSIDE = np.array([0.37, 0.61, 0.53])


def _octants(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (n, 3), each split in 8."""
    corner = np.stack(np.meshgrid(*[(0.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(8, 1, 3)
    middle = 0.5 * (low + high)
    return np.where(corner, middle, low).reshape(-1, 3), np.where(corner, high, middle).reshape(-1, 3)


def gradient_bounds(
    formula: Formula, low: np.ndarray, high: np.ndarray, parameters: Numbers = (), parts: int = 16
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds (n, 3), (n, 3) of the components of the gradient over boxes, both sides of every crease included."""
    least, most, _ = _slope(formula, low, high, parameters, parts, False)
    return least.T, most.T


def _slope(formula: Formula, low, high, parameters, parts: int, jumps: bool = True):
    """Bounds over boxes of the gradient, (3, n) and (3, n), and of its length (n,), infinite where it is
    discontinuous."""
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    with np.errstate(all="ignore"):
        boxes = SlopeBoxes(formula, low, high, parameters, parts)
        found = run((formula,), boxes)[0]
        n = len(boxes.rows)
        gradient = NO_GRADIENT if found.gradient is None else found.gradient
        norm = np.broadcast_to(np.minimum(found.norm, length_bound(gradient)), n)
        if jumps and found.discontinuity.boxes is not None:
            norm = np.where(found.discontinuity.boxes, np.inf, norm)
        least, most = (np.broadcast_to(bound, (3, n)) for bound in gradient[:2])
        return boxes.whole(np.minimum, least), boxes.whole(np.maximum, most), boxes.whole(np.maximum, norm)
