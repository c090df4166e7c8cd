# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reading of a formula for people: infix text, with a line of its own for whatever is used more than once."""

from __future__ import annotations

from .formula import CONSTANT, PARAMETER, POSITION, Formula, order

# Symbol and how strongly it binds; everything else is written as a function.
_INFIX = {"less": ("<", 1), "less_equal": ("<=", 1), "add": ("+", 2), "subtract": ("-", 2),
          "multiply": ("*", 3), "divide": ("/", 3)}
_NEGATE, _ATOM = 4, 5


def text(formula: Formula) -> str:
    """The formula, a definition a line and its value last; ``k0, k1, …`` are parameters, ``a0, a1, …`` shared parts.

        a0 = sqrt(x * x + y * y) - k0
        sqrt(a0 * a0 + z * z) - k1
    """
    nodes = order(formula)
    uses = dict.fromkeys(nodes, 0)
    for node in nodes:
        for operand in node.operands:
            uses[operand] += 1
    lines = []
    written: dict[Formula, tuple[str, int]] = {}
    for node in nodes:
        line, strength = _written(node, [written[operand] for operand in node.operands])
        if node.operands and uses[node] > 1:
            name = f"a{len(lines)}"
            lines.append(f"{name} = {line}")
            line, strength = name, _ATOM
        written[node] = line, strength
    return "\n".join([*lines, written[formula][0]])


def _written(node: Formula, operands: list[tuple[str, int]]) -> tuple[str, int]:
    """Text of one node, and how strongly its outermost operation binds."""
    if node.kind == CONSTANT:
        return f"{node.value:.17g}", _NEGATE if node.value < 0.0 else _ATOM
    if node.kind == POSITION:
        return "xyz"[node.value], _ATOM
    if node.kind == PARAMETER:
        return f"k{node.value}", _ATOM
    if node.kind == "negate":
        return f"-{_inside(operands[0], _ATOM)}", _NEGATE
    if node.kind in _INFIX:
        symbol, strength = _INFIX[node.kind]
        left, right = operands
        return f"{_inside(left, strength)} {symbol} {_inside(right, strength + 1)}", strength
    return f"{node.kind}({', '.join(operand for operand, _ in operands)})", _ATOM


def _inside(operand: tuple[str, int], least: int) -> str:
    line, strength = operand
    return line if strength >= least else f"({line})"
