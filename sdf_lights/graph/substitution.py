# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Formulas at another point, with other parameters: from graph to graph."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .continuity import declare, declared
from .formula import (
    CALL,
    CONSTANT,
    ITERATE,
    PARAMETER,
    RESULT,
    STATE,
    VARIABLE,
    Formula,
    Vector,
    apply,
    axis_of,
    body,
    call,
    constant,
    order,
)
from .functions import Function
from .loops import iterate


def substitute(formula: Formula, point: Vector, parameters: Sequence[Formula]) -> Formula:
    """The formula with ``point`` for the position and ``parameters`` for its slots, including loops."""

    def replace(node: Formula) -> Formula:
        return point[axis_of(node)] if node.kind == VARIABLE else parameters[node.value]

    return rewritten((formula,), {}, replace)[0]


def without_objects(roots: Sequence[Formula]) -> list[Formula]:
    """The formulas without an object: functions of an object return 0, and object space is world space."""

    def called(function: Function, *operands: Formula) -> tuple[Formula, ...]:
        if not function.of_object:
            return call(function, *operands)
        # A transform returns as many numbers as it takes.
        return operands if len(operands) == function.results else (constant(0.0),) * function.results

    return rewritten(roots, {}, lambda node: node, called)


def rewritten(
    roots: Sequence[Formula],
    known: dict,
    replace: Callable[[Formula], Formula],
    called: Callable[..., tuple[Formula, ...]] = call,
    number: Callable[[Formula], Formula] | None = None,
) -> list[Formula]:
    """The formulas with ``known`` nodes replaced. Every variable and parameter is replaced by ``replace``. Outside of
    loops, every call of a function is replaced by ``called`` of the function and its operands, and every use of a
    constant by ``number``.

    New nodes are added to ``known``. Declarations of continuity are kept.
    """
    written = known

    def used(node: Formula):
        return number(node) if number is not None and node.kind == CONSTANT else written[node]

    for node in order(*roots, known=known.keys()):
        if node in written:
            continue
        operands = [used(operand) for operand in node.operands]
        if node.kind in (CONSTANT, STATE):
            written[node] = node
        elif node.kind in (VARIABLE, PARAMETER):
            written[node] = replace(node)
        elif node.kind == ITERATE:
            written[node] = _loop(node, operands, replace)
        elif node.kind == CALL:
            written[node] = called(node.value, *operands)
        elif node.kind == RESULT:
            written[node] = operands[0][node.value]
        else:
            written[node] = apply(node.kind, *operands)
        about = declared(node) if called is call and number is None and node.kind != STATE else None
        if about is not None:
            # A formula depends only on variables that it contains; this is exact enough.
            inputs = [part for part in about.inputs if part in written or part.kind != VARIABLE]
            if all(part in written or part.kind == CONSTANT for part in (*inputs, *about.whole)):
                inputs, whole = ([written.get(part, part) for part in group] for group in (inputs, about.whole))
                declare(written[node], inputs, about.even, whole)
    return [used(root) for root in roots]


def _loop(node: Formula, operands: list[Formula], replace: Callable[[Formula], Formula]) -> tuple[Formula, ...]:
    """Results of the rewritten loop: its states are numbered by their nesting depth."""
    loop, size = node.value, len(node.value.steps)
    captures = dict(zip(node.operands[1 + size :], operands[1 + size :]))
    own = [n for n in body(node) if n.kind == STATE and n.value[0] == loop.level]

    def run(*states: Formula):
        known = captures | {state: states[state.value[1]] for state in own}
        steps = rewritten(loop.roots(), known, replace)
        return (steps[:-1], steps[-1]) if loop.going is not None else (steps, None)

    return iterate(operands[0], tuple(operands[1 : 1 + size]), run, loop.limit)
