# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A formula read at another point, with other parameters: from graph to graph."""

from __future__ import annotations

from collections.abc import Sequence

from .formula import (
    CONSTANT, ITERATE, PARAMETER, POSITION, RESULT, STATE, Formula, Vector, apply, body, iterate, order)


def substitute(formula: Formula, point: Vector, parameters: Sequence[Formula]) -> Formula:
    """The formula with ``point`` for the position and ``parameters`` for its slots, loops included."""
    return _written((formula,), {}, point, parameters)[0]


def _written(roots: tuple[Formula, ...], known: dict, point: Vector, parameters: Sequence[Formula]) -> list[Formula]:
    written = dict(known)
    for node in order(*roots, known=set(known)):
        if node in written:
            continue
        operands = [written[operand] for operand in node.operands]
        if node.kind in (CONSTANT, STATE):
            written[node] = node
        elif node.kind == POSITION:
            written[node] = point[node.value]
        elif node.kind == PARAMETER:
            written[node] = parameters[node.value]
        elif node.kind == ITERATE:
            written[node] = _loop(node, operands, point, parameters)
        elif node.kind == RESULT:
            written[node] = operands[0][node.value]
        else:
            written[node] = apply(node.kind, *operands)
    return [written[root] for root in roots]


def _loop(node: Formula, operands: list[Formula], point: Vector, parameters: Sequence[Formula]) -> tuple[Formula, ...]:
    """Results of the loop, written anew: states of loops are numbered by how deep they stand."""
    loop, size = node.value, len(node.value.steps)
    captures = dict(zip(node.operands[1 + size:], operands[1 + size:]))
    own = [n for n in body(node) if n.kind == STATE and n.value[0] == loop.level]

    def run(*states: Formula):
        known = captures | {state: states[state.value[1]] for state in own}
        steps = _written(loop.roots(), known, point, parameters)
        return (steps[:-1], steps[-1]) if loop.going is not None else (steps, None)

    return iterate(operands[0], tuple(operands[1:1 + size]), run, loop.limit)
