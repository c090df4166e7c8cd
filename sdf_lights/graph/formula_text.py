# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a formula for people: infix text, with a separate line for every shared part."""

from __future__ import annotations

from collections import Counter

from .formula import CALL, CONSTANT, ITERATE, PARAMETER, POSITION, RESULT, STATE, VARIABLE, Formula, body, order
from .operations import OPERATIONS

_NEGATE, _ATOM = 4, 5

_Written = tuple[str, int]  # text, and the precedence of its outermost operation


def text(formula: Formula) -> str:
    """The formula as text: one definition per line, its value last. ``k0, k1, …`` are parameters, ``a0, a1, …`` shared
    parts.

        a0 = sqrt(x * x + y * y) - k0
        sqrt(a0 * a0 + z * z) - k1

    ``s0, s1, …`` are the states of loops.

        s0, s1 = x, 0
        repeat k0 times, at most 20:
            stop unless s1 < 9
            s0, s1 = s0 * s0 + y, s1 + 1
        sqrt(s0)
    """
    writer = _Writer()
    writer.write(order(formula), (formula,))
    return "\n".join([*writer.lines, writer.text[formula][0]])


class _Writer:
    """Writes nodes into ``lines``. ``text`` holds the name or expression of each node."""

    def __init__(self):
        self.lines: list[str] = []
        self.text: dict[Formula, _Written] = {}
        self._states: dict[Formula, list[str]] = {}  # of each loop
        self._named: Counter[str] = Counter()  # number of names so far, by letter

    def _name(self, letter: str) -> str:
        self._named[letter] += 1
        return f"{letter}{self._named[letter] - 1}"

    def write(self, nodes: list[Formula], roots: tuple[Formula, ...], indent: str = "") -> None:
        """Write ``nodes``, operands first. ``roots`` are the requested results."""
        uses = Counter(roots) + Counter(operand for node in nodes for operand in node.operands)
        for node in nodes:
            if node.kind == ITERATE:
                self._write_loop(node, indent)
            elif node.kind == RESULT:
                origin = node.operands[0]
                if origin.kind == CALL:
                    self.text[node] = f"{self.text[origin][0]}[{node.value}]", _ATOM
                else:
                    self.text[node] = self._states[origin][node.value], _ATOM
            elif node not in self.text:
                line, strength = _line(node, [self.text[operand] for operand in node.operands])
                if node.operands and uses[node] > 1:
                    name = self._name("a")
                    self.lines.append(f"{indent}{name} = {line}")
                    line, strength = name, _ATOM
                self.text[node] = line, strength

    def _write_loop(self, node: Formula, indent: str) -> None:
        loop, nodes = node.value, body(node)
        states = self._states[node] = [self._name("s") for _ in loop.steps]
        count, *operands = (self.text[operand][0] for operand in node.operands)
        self.lines.append(f"{indent}{', '.join(states)} = {', '.join(operands[: len(states)])}")
        self.lines.append(f"{indent}repeat {count} times, at most {loop.limit}:")
        outside = self.text
        self.text = {n: outside[n] for n in node.operands[1 + len(states) :]}
        self.text |= {n: (states[n.value[1]], _ATOM) for n in nodes if n.kind == STATE and n.value[0] == loop.level}
        self.write(nodes, loop.roots(), indent + "    ")
        if loop.going is not None:
            self.lines.append(f"{indent}    stop unless {self.text[loop.going][0]}")
        following = ", ".join(self.text[step][0] for step in loop.steps)
        self.lines.append(f"{indent}    {', '.join(states)} = {following}")
        self.text = outside  # loops side by side have the same states, so equal nodes with different meanings


def _line(node: Formula, operands: list[_Written]) -> _Written:
    if node.kind == CONSTANT:
        return f"{node.value:.17g}", _NEGATE if node.value < 0.0 else _ATOM
    if node.kind == VARIABLE:
        name, component = node.value
        return "xyz"[component] if name == POSITION else f"{name}.{component}", _ATOM
    if node.kind == PARAMETER:
        return f"k{node.value}", _ATOM
    if node.kind == "negate":
        return f"-{_inside(operands[0], _ATOM)}", _NEGATE
    infix = OPERATIONS[node.kind].infix if node.kind in OPERATIONS else None
    if infix is not None:
        symbol, strength = infix
        left, right = operands
        return f"{_inside(left, strength)} {symbol} {_inside(right, strength + 1)}", strength
    name = node.value.name if node.kind == CALL else node.kind
    return f"{name}({', '.join(operand for operand, _ in operands)})", _ATOM


def _inside(operand: _Written, least: int) -> str:
    line, strength = operand
    return line if strength >= least else f"({line})"
