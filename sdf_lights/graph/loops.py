# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounded loops in formulas: one node with a body of its own."""

from __future__ import annotations

import contextvars
from collections.abc import Callable

from .formula import CONSTANT, ITERATE, RESULT, STATE, VARIABLE, Formula, Loop, formula_of, intern, order
from .operations import CONDITIONS

LONGEST_LOOP = 1000  # rounds


_level = contextvars.ContextVar("level", default=0)


def iterate(
    count: Formula | float,
    initial: tuple[Formula | float, ...],
    body: Callable[..., tuple[tuple[Formula | float, ...], Formula | None]],
    limit: int,
) -> tuple[Formula, ...]:
    """States after ``count`` iterations of a loop: ``steps, going = body(*states)``.

    ``count`` must not depend on the position. It is rounded down, and clamped to 0 and ``limit`` (NaN counts as 0).
    ``going`` is a comparison of the states before the iteration, or None: a point at which it fails keeps its states
    from then on. ``body`` is called once, with formulas for the states. It may contain loops itself.
    Raises ValueError for a wrong ``limit``, TypeError for a wrong ``count`` or ``body``.
    """
    if not 0 < limit <= LONGEST_LOOP:
        raise ValueError(f"a loop can have 1 to {LONGEST_LOOP} rounds, not {limit}")
    rounds, *first = map(formula_of, (count, *initial))
    if any(node.kind in (VARIABLE, STATE) for node in order(rounds)):
        raise TypeError("the number of rounds of a loop cannot depend on a variable or on the states of a loop")
    if rounds.kind == CONSTANT and rounds.value < 1.0:
        return tuple(first)
    level = _level.get()
    states = tuple(intern(STATE, value=(level, index)) for index in range(len(first)))
    token = _level.set(level + 1)
    try:
        results, going = body(*states)
    finally:
        _level.reset(token)
    steps = tuple(map(formula_of, results))
    if len(steps) != len(states) or (going is not None and going.kind not in CONDITIONS):
        raise TypeError("the body of a loop gives one value for each state, and a comparison or None")
    loop = Loop(level, limit, steps, going)
    node = intern(ITERATE, (rounds, *first, *_captures(loop)), loop)
    return tuple(intern(RESULT, (node,), index) for index in range(len(states)))


def _captures(loop: Loop) -> list[Formula]:
    """Nodes used in the body of a loop that stay the same in all its iterations, without constants."""
    nodes = order(*loop.roots())
    inside: dict[Formula, bool] = {}
    for node in nodes:
        inside[node] = (node.kind == STATE and node.value[0] == loop.level) or any(inside[o] for o in node.operands)
    used = [o for node in nodes if inside[node] for o in node.operands]
    used += loop.roots()
    return [node for node in dict.fromkeys(used) if not inside[node] and node.kind != CONSTANT]
