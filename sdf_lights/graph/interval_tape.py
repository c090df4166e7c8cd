# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tape of a formula: its graph as a list of instructions on registers, for ``interval_interpreter.enclose``."""

from __future__ import annotations

import collections
import functools
from typing import Any, NamedTuple

import numpy as np

from .formula import CALL, CONSTANT, ITERATE, PARAMETER, POINT, RESULT, STATE, Formula, apply, body, sqrt
from .functions import TableFunction, compiled_part
from .operations import CONDITIONS, OPERATIONS

CALL_NUMBERS = 32  # operands or results of a function of tables

NAMES = [
    *OPERATIONS,
    "constant",
    "parameter",
    "copy",
    "length",
    "scale",
    "chain",  # the value of b, with the gradient of a times c
    # Of values alone:
    "square",
    "divide_by_positive",
    "begin",
    "end",
    "select_less",
    "select_less_equal",
    "call",
]
CODE: Any = collections.namedtuple("Code", NAMES)(*range(len(NAMES)))
"""The number of each instruction, by its name."""

VALUE, ALL = 2, 8  # rows of a register: bounds of the value; those of each component of the gradient, too

INSTRUCTION = np.dtype(
    [
        ("op", np.int64),
        ("out", np.int64),  # register of the result
        ("a", np.int64),
        ("b", np.int64),
        ("c", np.int64),
        ("d", np.int64),  # registers of the operands; see ``_Writer``
        ("number", np.float64),  # value of a constant, or the slot of a parameter
        ("rows", np.int64),  # ``VALUE`` if nobody needs the gradient, else ``ALL``
    ],
    align=True,
)


class Tape(NamedTuple):
    """Instructions of a formula. The first three registers are the coordinates of the point, with their gradients."""

    instructions: np.ndarray  # INSTRUCTION
    registers: int
    result: int


class _Values:
    """The algebra of ``operations.Operation.derivative`` that writes instructions. Operands and results are registers,
    without gradients. Derivatives divide only by what is positive where they are defined."""

    def __init__(self, writer: _Writer):
        self.writer = writer

    def __getattr__(self, kind: str):
        return functools.partial(self.writer.emit, kind, rows=VALUE)

    def number(self, value: float) -> int:
        return self.writer.emit("constant", number=value, rows=VALUE)

    def square(self, a: int) -> int:
        return self.writer.emit("square", a, rows=VALUE)

    def divide(self, a: int, b: int) -> int:
        return self.writer.emit("divide_by_positive", a, b, rows=VALUE)


class _Writer:
    """Writes the tape of a formula, operands before their users.

    A loop is ``begin``, the body, and ``end``. In ``begin``, a: register of the number of iterations; b: number of
    states; c: the first of their registers; d: the first register of their values before the loop; number: maximum of
    iterations; out: position of its end. In ``end``, a and b: registers that are compared; c: 0 for no comparison, 1
    for "less", 2 for "less equal"; d: the first register of the next states; out: position of the beginning. Registers
    of states are contiguous.
    """

    def __init__(self, at_zeros: Formula | None = None):
        self.at_zeros = at_zeros
        self.rows: list[tuple] = []
        self.registers = 3

    def new(self, count: int = 1) -> int:
        self.registers += count
        return self.registers - count

    def emit(self, name: str, *operands: int, out: int | None = None, number: float = 0.0, rows: int = ALL) -> int:
        out = self.new() if out is None else out
        self.rows.append((getattr(CODE, name), out, *operands, *[0] * (4 - len(operands)), number, rows))
        return out

    def write(self, roots, known: dict[Formula, int]) -> list[int]:
        """Registers of the roots. ``known`` maps formulas to registers, and gets the new ones."""
        pending = [(root, False) for root in reversed(roots)]
        while pending:
            node, ready = pending.pop()
            if node in known:
                continue
            inputs = _inputs(node)
            if not ready:
                pending.append((node, True))
                pending += [(operand, False) for operand in reversed(inputs) if operand not in known]
            else:
                known[node] = self._written(node, [known[operand] for operand in inputs], known)
        return [known[root] for root in roots]

    def _written(self, node: Formula, operands: list[int], known: dict[Formula, int]) -> int:
        if node.kind == CONSTANT:
            return self.emit("constant", number=node.value)
        if node.kind == PARAMETER:
            return self.emit("parameter", number=float(node.value))
        if node.kind == RESULT:
            return operands[0] + node.value
        if node.kind == CALL:
            return self._call(node, operands)
        if node.kind == ITERATE:
            return self._loop(node, operands, known)
        if node.kind == "select":
            return self.emit(f"select_{node.operands[0].kind}", *operands)
        if _parts(node):
            return self.emit("length", *operands, *[operands[0]] * (3 - len(operands)), len(operands))
        if _rewritten(node) is not None:
            return operands[0]
        if node.kind == "multiply" and any(operand.kind in (CONSTANT, PARAMETER) for operand in node.operands):
            first = node.operands[0].kind in (CONSTANT, PARAMETER)
            return self.emit("scale", *(operands[::-1] if first else operands))
        derivative = OPERATIONS[node.kind].derivative
        if derivative is None:
            return self.emit(node.kind, *operands)
        value = self.emit(node.kind, *operands, rows=VALUE)
        return self.emit("chain", *operands, value, derivative(_Values(self), value, *operands))

    def _call(self, node: Formula, operands: list[int]) -> int:
        """a: the first of the contiguous operands; b: their number; c: how many of them are addresses; number: the
        code."""
        function = node.value
        if not isinstance(function, TableFunction) or function.bounds is None:
            raise ValueError(f"the function {function.name!r} has no known bounds")
        count = len(operands)
        if 2 * count + 2 > CALL_NUMBERS:
            raise ValueError(f"{function.name!r} has too many operands")
        first = self.new(count)
        for index, register in enumerate(operands):
            self.emit("copy", register, out=first + index)
        bounds = function.zero_bounds if node is self.at_zeros else function.bounds
        code = compiled_part(bounds, 2 * count - function.tables)
        return self.emit("call", first, count, function.tables, number=float(code.address))

    def _loop(self, node: Formula, operands: list[int], known: dict[Formula, int]) -> int:
        loop, size = node.value, len(node.value.steps)
        before, states, after = self.new(size), self.new(size), self.new(size)
        for index in range(size):
            self.emit("copy", operands[1 + index], out=before + index)
        begin = len(self.rows)
        self.emit("begin", operands[0], size, states, before, out=0, number=float(loop.limit))
        inside = dict(known)
        for inner in body(node):
            if inner.kind == STATE and inner.value[0] == loop.level:
                inside[inner] = states + inner.value[1]
        registers = self.write(loop.steps, inside)
        for index, register in enumerate(registers):
            self.emit("copy", register, out=after + index)
        compared = (0, 0, 0)
        if loop.going is not None:
            compared = (*self.write(loop.going.operands, inside), 1 if loop.going.kind == "less" else 2)
        self.rows[begin] = (*self.rows[begin][:1], len(self.rows), *self.rows[begin][2:])
        self.emit("end", *compared, after, out=begin)
        return states


def _inputs(node: Formula) -> tuple[Formula, ...]:
    """The nodes needed before a node: its operands, those of a condition, or the parts of a length."""
    if node.kind == "select":
        return (*node.operands[0].operands, *node.operands[1:])
    if node.kind == ITERATE:
        return tuple(operand for operand in node.operands if operand.kind not in CONDITIONS)
    rewritten = _rewritten(node)
    return _parts(node) or (node.operands if rewritten is None else (rewritten,))


def _parts(node: Formula) -> tuple[Formula, ...]:
    """Two or three formulas whose sum of squares the node is the root of; none if it has another form."""
    if node.kind != "sqrt":
        return ()
    pending, parts = [node.operands[0]], []
    while pending and len(parts) < 4:
        term = pending.pop()
        if term.kind == "add":
            pending += term.operands
        elif term.kind == "multiply" and term.operands[0] is term.operands[1]:
            parts.append(term.operands[0])
        else:
            return ()
    return tuple(parts) if 2 <= len(parts) <= 3 else ()


def _rewritten(node: Formula) -> Formula | None:
    """The root of a square, or of the least or greatest of several, without the pole that roots have at 0."""
    if node.kind != "sqrt":
        return None
    square = node.operands[0]
    if square.kind == "multiply" and square.operands[0] is square.operands[1]:
        return abs(square.operands[0])
    if square.kind in ("minimum", "maximum"):
        return apply(square.kind, *(sqrt(operand) for operand in square.operands))
    return None


def with_zero_bounds(formula: Formula) -> Formula | None:
    """The call of a function of tables with ``zero_bounds`` whose value, times a number, is the formula; None
    otherwise."""
    while formula.kind == "multiply" and any(operand.kind in (CONSTANT, PARAMETER) for operand in formula.operands):
        first, second = formula.operands
        formula = second if first.kind in (CONSTANT, PARAMETER) else first
    if formula.kind != RESULT or formula.value != 0:
        return None
    function = formula.operands[0].value
    known = isinstance(function, TableFunction) and function.zero_bounds is not None
    return formula.operands[0] if known else None


def tape(formula: Formula, at_zeros: bool = False) -> Tape:
    """The tape of a formula; with ``at_zeros``, one ``with_zero_bounds``, whose gradient is bounded only there."""
    writer = _Writer(with_zero_bounds(formula) if at_zeros else None)
    (result,) = writer.write([formula], dict(zip(POINT, range(3))))
    return Tape(np.array(writer.rows, INSTRUCTION), writer.registers, result)
