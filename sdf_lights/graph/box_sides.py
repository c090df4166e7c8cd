# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparisons that separate the sides of clamps, folds and cells; boxes are split by them. See
``slope_evaluation.py``."""

from __future__ import annotations

import numpy as np

from .continuity import declared
from .discontinuity import EQUAL, alike
from .formula import ITERATE, STATE, VARIABLE, Formula, order
from .interval_arithmetic import Interval

SIGN, STEP = "sign", "step"


def find_sides(formula: Formula) -> dict[Formula, list[tuple]]:
    """The comparisons that separate the sides of clamps, folds and cells, for each formula that depends on them.

    A comparison is a pair. Either it has two formulas, or a formula and a number, of which the lesser or greater is
    taken. Or it has a formula and ``SIGN``, if its absolute value is taken, or ``STEP``, if it is rounded down.
    """
    pairs: dict[tuple, set[str]] = {}
    fixed: dict[Formula, bool] = {}
    pending = [formula]
    while pending:
        for node in order(pending.pop()):
            fixed[node] = node.kind not in (VARIABLE, STATE, ITERATE) and all(fixed[o] for o in node.operands)
            if node.kind == ITERATE:
                pending += node.value.roots()
            elif node.kind in ("abs", "floor"):
                pairs[node.operands[0], SIGN if node.kind == "abs" else STEP] = set()
            elif node.kind in ("minimum", "maximum"):
                known = node.operands[::-1] if node.operands[::-1] in pairs else node.operands
                pairs.setdefault(known, set()).add(node.kind)
    found: dict[Formula, list] = {}
    for (a, b), kinds in pairs.items():
        if b in (SIGN, STEP):
            found.setdefault(a, []).append((a, b))
        elif len(kinds) == 2 or fixed[a] != fixed[b]:
            found.setdefault(a, []).append((a, b))
            found.setdefault(b, []).append((a, b))
    return found


def declared_inputs(formula: Formula) -> set[Formula]:
    """The formulas of which others are declared to be continuous functions."""
    found: set[Formula] = set()
    pending = [formula]
    while pending:
        for node in order(pending.pop()):
            about = declared(node)
            if about is not None:
                found.update(about.inputs)
            if node.kind == ITERATE:
                pending += node.value.roots()
    return found


def remainder_limits(period: Interval, line) -> tuple[float, float] | None:
    """Values of a remainder a − period · floor(line of a) below and above its steps, if they are the same at all
    steps."""
    if not (period.is_number or np.all(period.high - period.low <= EQUAL * period.magnitude)):
        return None
    size, scale, shift = (float(0.5 * (value.low + value.high)) for value in (period, line.scale, line.shift))
    if not np.isfinite([size, scale, shift]).all() or scale == 0.0 or not alike((size * scale, 1.0)):
        return None
    above = -shift / scale
    return above + size, above


def taken_rows(value, index: np.ndarray, rows: int, done: dict):
    """A value with the rows ``index`` (n,) of its arrays (rows, …). Shared objects stay shared.

    ``done`` holds the objects seen so far, by identity, and keeps them alive.
    """
    if id(value) in done:
        return done[id(value)][1]
    if isinstance(value, np.ndarray):
        found = value[..., index] if value.ndim and value.shape[-1] == rows else value
    elif isinstance(value, dict):
        found = {key: taken_rows(part, index, rows, done) for key, part in value.items()}
    elif isinstance(value, (list, tuple)):
        parts = [taken_rows(part, index, rows, done) for part in value]
        found = type(value)(*parts) if hasattr(value, "_fields") else type(value)(parts)
    else:
        found = value
    done[id(value)] = value, found
    return found
