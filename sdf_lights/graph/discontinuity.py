# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where values may jump: at steps, at choices whose sides differ, at cuts, poles and borders. See ``lipschitz.py``."""

from __future__ import annotations

import numpy as np

from .formula import Formula
from .interval_arithmetic import Condition
from .operations import OPERATIONS
from .slope import ARITHMETIC, Discontinuity, Slope

EQUAL = 1e-9  # relative: values on both sides of a jump that differ only by rounding


def either(a: np.ndarray | None, b: np.ndarray | None) -> np.ndarray | None:
    """The boxes (n,) in which one of two masks holds; None for none."""
    return b if a is None else a if b is None else a | b


def any_of(mask) -> np.ndarray | None:
    """The mask (n,), or None if it holds nowhere."""
    return mask if np.any(mask) else None


def alike(limits: tuple[float, float]) -> bool:
    """Whether two numbers differ only by rounding."""
    u, v = limits
    return abs(u - v) <= EQUAL * (1.0 + abs(u) + abs(v))


def discontinuous_choice(condition: Condition, a: Slope, b: Slope, jumps: bool) -> np.ndarray | None:
    """Where a choice is discontinuous: where the chosen value is discontinuous, and, if it ``jumps``, where the
    condition may change."""
    certain, possible = condition
    found = any_of(possible & ~np.asarray(certain)) if jumps else None
    if a.discontinuity.boxes is not None:
        found = either(found, any_of(possible & a.discontinuity.boxes))
    if b.discontinuity.boxes is not None:
        found = either(found, any_of(~np.asarray(certain) & b.discontinuity.boxes))
    return found


def common_source(operands: list[Slope]) -> Formula | None:
    """The one node that makes the operands discontinuous, if there is only one."""
    sources = {operand.discontinuity.source for operand in operands if operand.discontinuity.boxes is not None}
    return sources.pop() if len(sources) == 1 else None


def at_limits(node: Formula, operands: list[Slope]) -> tuple[float, float] | None:
    """Values of an operation on both sides of the jumps of its one discontinuous operand, if these are known."""
    jumping = [operand for operand in operands if operand.discontinuity.boxes is not None]
    if len(jumping) != 1 or jumping[0].discontinuity.limits is None:
        return None
    if not all(operand.is_number for operand in operands if operand is not jumping[0]):
        return None
    meaning, limits = OPERATIONS[node.kind].meaning, jumping[0].discontinuity.limits
    found = [
        float(meaning(*(end if operand is jumping[0] else operand.value.low for operand in operands))) for end in limits
    ]
    return (found[0], found[1]) if np.isfinite(found).all() else None


def with_limits(discontinuity: Discontinuity) -> Discontinuity:
    """The facts about a discontinuity that follow from its limits."""
    if discontinuity.limits is None or discontinuity.boxes is None:
        return discontinuity
    u, v = discontinuity.limits
    if alike((u, v)):
        return Discontinuity(zero=discontinuity.source if alike((u, 0.0)) else discontinuity.zero)
    return discontinuity._replace(even=discontinuity.even or alike((abs(u), abs(v))))


def combined(node: Formula, operands: list[Slope]) -> Discontinuity:
    """The discontinuity of a continuous operation on operands."""
    kind, jumps = node.kind, [operand.discontinuity for operand in operands]
    zeros = [discontinuity.zero for discontinuity in jumps]
    common = zeros[0] if len(set(zeros)) == 1 else None
    if kind == "multiply":
        # A factor that is 0 where the other factor jumps makes the product continuous there.
        discontinuous = None
        for discontinuity, zero in zip(jumps, zeros[::-1]):
            if discontinuity.boxes is not None and (zero is None or discontinuity.source is not zero):
                discontinuous = either(discontinuous, discontinuity.boxes)
        zero = next((zero for zero in zeros if zero is not None), None)
    else:
        discontinuous = None
        for discontinuity in jumps:
            discontinuous = either(discontinuous, discontinuity.boxes)
        zero = zeros[0] if kind in ("negate", "abs", "divide") else common if kind in ("add", "subtract") else None
    if discontinuous is None:
        return Discontinuity(zero=zero)
    source = common_source(operands)
    signs = all(discontinuity.boxes is None or discontinuity.even for discontinuity in jumps)
    limits = at_limits(node, operands)
    if limits is None and signs and (kind in ("abs", "cos") or (kind == "multiply" and operands[0] is operands[1])):
        return Discontinuity(zero=zero)
    even = signs and kind in ("negate", "multiply", "divide")
    if signs and kind in ("add", "subtract") and source is not None:
        even = all(discontinuity.boxes is not None or discontinuity.zero is source for discontinuity in jumps)
    return with_limits(Discontinuity(discontinuous, source, limits, even, zero))


def outside_domain(node: Formula, operands: list[Slope]) -> np.ndarray | None:
    """The boxes in which an operation may have a pole or be undefined."""
    a = operands[0].value
    if node.kind == "sqrt":
        return any_of(a.low < 0.0)
    if node.kind == "log":
        return any_of(a.low <= 0.0)
    if node.kind in ("asin", "acos"):
        return any_of((a.low < -1.0 - EQUAL) | (a.high > 1.0 + EQUAL))
    if node.kind == "tan":
        value = ARITHMETIC.tan(a)
        return any_of((value.low == -np.inf) | (value.high == np.inf))
    if node.kind in ("divide", "power"):
        b = operands[1].value
        if node.kind == "divide":
            return any_of((b.low <= 0.0) & (b.high >= 0.0))
        if operands[1].is_number:
            exponent = float(b.low)
            if exponent >= 0.0:
                return None if exponent.is_integer() else any_of(a.low < 0.0)
            return any_of((a.low <= 0.0) & ((a.high >= 0.0) | (not exponent.is_integer())))
        return any_of(a.low <= 0.0)
    return None
