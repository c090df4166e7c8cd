# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of formulas and of their gradients in boxes, by an interpreter: eight boxes at a time, without compilation.

``graph.lipschitz`` does the same for arrays of boxes, with more care for norms and rounding, and is the reference. It
pays from some thousand boxes of one formula on, but a tree of a combination has as many lists of terms as boxes. Here
the graph of a formula is a *tape* of instructions on registers, which hold bounds of a value and of its gradient in
eight boxes: interval forward differentiation (Griewank and Walther, "Evaluating Derivatives"; Moore, Kearfott and
Cloud, "Introduction to Interval Analysis"). Roots of sums of squares are treated as lengths, whose gradients have no
pole.

Bounds are exact except for rounding, which the caller must add (``ROUNDING``). They hold where the formula is
continuous. Unknown bounds are infinite.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...graph.formula import (
    CALL,
    CONSTANT,
    ITERATE,
    PARAMETER,
    POINT,
    RESULT,
    STATE,
    Formula,
    apply,
    body,
    sqrt,
)
from ...graph.functions import TableFunction, compiled_part
from ...graph.operations import CONDITIONS, OPERATIONS
from ...jit import call_numbers, kernel

CALL_NUMBERS = 32  # operands or results of a function of tables
BOXES = 8  # bounded together
SIZE = 8  # rows of a register: bounds of the value, and of each component of the gradient
ROUNDING = 1e-9  # relative; covers some thousand operations

_NAMES = [
    *OPERATIONS,
    "constant",
    "parameter",
    "copy",
    "length",
    "scale",
    "begin",
    "end",
    "select_less",
    "select_less_equal",
    "call",
]
_CODES = {name: code for code, name in enumerate(_NAMES)}

INSTRUCTION = np.dtype(
    [
        ("op", np.int64),
        ("out", np.int64),  # register of the result
        ("a", np.int64),
        ("b", np.int64),
        ("c", np.int64),
        ("d", np.int64),  # registers of the operands; see ``_Writer``
        ("number", np.float64),  # value of a constant, or the slot of a parameter
    ],
    align=True,
)


class Tape(NamedTuple):
    """Instructions of a formula. The first three registers are the coordinates of the point, with their gradients."""

    instructions: np.ndarray  # INSTRUCTION
    registers: int
    result: int


class _Writer:
    """Writes the tape of a formula, operands before their users.

    A loop is ``begin``, the body, and ``end``. In ``begin``, a: register of the number of iterations; b: number of
    states; c: the first of their registers; d: the first register of their values before the loop; number: maximum of
    iterations; out: position of its end. In ``end``, a and b: registers that are compared; c: 0 for no comparison, 1
    for "less", 2 for "less equal"; d: the first register of the next states; out: position of the beginning. Registers
    of states are contiguous.
    """

    def __init__(self):
        self.rows: list[tuple] = []
        self.registers = 3

    def new(self, count: int = 1) -> int:
        self.registers += count
        return self.registers - count

    def emit(self, name: str, *operands: int, out: int | None = None, number: float = 0.0) -> int:
        out = self.new() if out is None else out
        self.rows.append((_CODES[name], out, *operands, *[0] * (4 - len(operands)), number))
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
        return self.emit(node.kind, *operands)

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
        code = compiled_part(function.bounds, 2 * count - function.tables)
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


def tape(formula: Formula) -> Tape:
    """The tape of a formula."""
    writer = _Writer()
    (result,) = writer.write([formula], dict(zip(POINT, range(3))))
    return Tape(np.array(writer.rows, INSTRUCTION), writer.registers, result)


# Codes of the instructions, for the kernels.
(
    _NEGATE,
    _ABS,
    _SQRT,
    _SIN,
    _COS,
    _TAN,
    _ASIN,
    _ACOS,
    _ATAN,
    _EXP,
    _LOG,
    _FLOOR,
    _ADD,
    _SUBTRACT,
    _MULTIPLY,
    _DIVIDE,
    _POWER,
    _ATAN2,
    _MINIMUM,
    _MAXIMUM,
    _CONSTANT,
    _PARAMETER,
    _COPY,
    _LENGTH,
    _SCALE,
    _BEGIN,
    _END,
    _SELECT_LESS,
    _SELECT_LESS_EQUAL,
    _CALL,
) = (
    _CODES[name]
    for name in (
        "negate",
        "abs",
        "sqrt",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "exp",
        "log",
        "floor",
        "add",
        "subtract",
        "multiply",
        "divide",
        "power",
        "atan2",
        "minimum",
        "maximum",
        "constant",
        "parameter",
        "copy",
        "length",
        "scale",
        "begin",
        "end",
        "select_less",
        "select_less_equal",
        "call",
    )
)
DEEPEST_LOOP = 16
_HALF_TURN, _TURN = math.pi, 2.0 * math.pi


@kernel(forceinline=True)
def _times(a, b):
    """Product of bounds, where 0 · ∞ is 0: a multiple of something bounded by 0 is 0."""
    product = a * b
    return product if product == product else 0.0


@kernel(forceinline=True)
def product_bounds(a_low, a_high, b_low, b_high):
    """Bounds (low, high) of the product of two intervals, without rounding outwards."""
    p, q, r, s = _times(a_low, b_low), _times(a_low, b_high), _times(a_high, b_low), _times(a_high, b_high)
    return min(min(p, q), min(r, s)), max(max(p, q), max(r, s))


@kernel(forceinline=True)
def _quotient(a_low, a_high, b_low, b_high):
    if b_low <= 0.0 <= b_high:
        return -math.inf, math.inf
    return product_bounds(a_low, a_high, 1.0 / b_high, 1.0 / b_low)


@kernel(forceinline=True)
def _square(low, high):
    """Bounds of a square."""
    least = 0.0 if low <= 0.0 <= high else min(low * low, high * high)
    return least, max(low * low, high * high)


@kernel(forceinline=True)
def _unit(low, high, rest_low, rest_high):
    """Bounds of u/√(u² + r) for u and r ≥ 0 within bounds: it grows with u, and moves towards 0 as r grows."""
    a = low / math.sqrt(low * low + (rest_low if low < 0.0 else rest_high))
    b = high / math.sqrt(high * high + (rest_low if high > 0.0 else rest_high))
    # At the origin, any unit vector is possible: NaN fails both tests.
    return (a if a >= -1.0 else -1.0), (b if b <= 1.0 else 1.0)


@kernel(forceinline=True)
def _passes(low, high, first, period):
    """Whether one of the numbers first + i · period is between the bounds."""
    return math.ceil((low - first) / period - ROUNDING) <= math.floor((high - first) / period + ROUNDING)


@kernel
def _wave(low, high, crest):
    """Bounds of the function with period 2π that is 1 at ``crest`` and falls like a cosine on both sides."""
    if not high - low < _TURN:
        return -1.0, 1.0
    a, b = math.cos(low - crest), math.cos(high - crest)
    least = -1.0 if _passes(low, high, crest + _HALF_TURN, _TURN) else min(a, b)
    return least, (1.0 if _passes(low, high, crest, _TURN) else max(a, b))


@kernel
def _power(low, high, exponent):
    """Bounds of a power of a base without sign change, unless the exponent is whole and not negative."""
    whole = exponent == math.floor(exponent)
    if low < 0.0 and not whole or low <= 0.0 <= high and exponent < 0.0:
        return -math.inf, math.inf
    a, b = low**exponent, high**exponent
    if low < 0.0 < high and exponent % 2.0 == 0.0:
        return 0.0, max(a, b)
    return min(a, b), max(a, b)


@kernel
def _function(op, low, high):
    """Bounds (low, high) of a function of one operand, and of its derivative (low, high)."""
    if op == _SIN:
        value, slope = _wave(low, high, 0.5 * _HALF_TURN), _wave(low, high, 0.0)
    elif op == _COS:
        value, slope = _wave(low, high, 0.0), _wave(low, high, -0.5 * _HALF_TURN)
    elif op == _TAN:
        if not high - low < _HALF_TURN or _passes(low, high, 0.5 * _HALF_TURN, _HALF_TURN):
            return -math.inf, math.inf, 1.0, math.inf
        value = math.tan(low), math.tan(high)
        square = _square(value[0], value[1])
        slope = 1.0 + square[0], 1.0 + square[1]
    elif op == _ASIN or op == _ACOS:
        a, b = min(max(low, -1.0), 1.0), min(max(high, -1.0), 1.0)
        square = _square(a, b)
        slope = 1.0 / math.sqrt(1.0 - square[0]), 1.0 / math.sqrt(1.0 - square[1])
        value = math.asin(a), math.asin(b)
        if op == _ACOS:
            value, slope = (math.acos(b), math.acos(a)), (-slope[1], -slope[0])
    elif op == _ATAN:
        square = _square(low, high)
        value, slope = (math.atan(low), math.atan(high)), (1.0 / (1.0 + square[1]), 1.0 / (1.0 + square[0]))
    elif op == _EXP:
        value = math.exp(low), math.exp(high)
        slope = value
    elif op == _LOG:
        a, b = max(low, 0.0), max(high, 0.0)
        value, slope = (math.log(a), math.log(b)), (1.0 / b, 1.0 / a)
    elif op == _SQRT:
        value = math.sqrt(max(low, 0.0)), math.sqrt(max(high, 0.0))
        slope = 0.5 / value[1], 0.5 / value[0]
    else:  # floor
        value, slope = (math.floor(low), math.floor(high)), (0.0, 0.0)
    return value[0], value[1], slope[0], slope[1]


# Functions that take the registers for every box are inlined: passing an array costs an atomic reference count.


@kernel(forceinline=True)
def _chain(registers, out, box, a, low, high, factor_low, factor_high):
    """A result with the gradient of an operand times a factor."""
    registers[out, 0, box], registers[out, 1, box] = low, high
    for row in range(2, SIZE, 2):
        registers[out, row, box], registers[out, row + 1, box] = product_bounds(
            registers[a, row, box], registers[a, row + 1, box], factor_low, factor_high
        )


@kernel(forceinline=True)
def _choose(registers, out, box, a, b, first, second):
    """A result that may be a if ``first``, and b if ``second``; its value is left unchanged."""
    for row in range(2, SIZE, 2):
        low, high = math.inf, -math.inf
        if first:
            low, high = registers[a, row, box], registers[a, row + 1, box]
        if second:
            low, high = min(low, registers[b, row, box]), max(high, registers[b, row + 1, box])
        registers[out, row, box], registers[out, row + 1, box] = low, high


@kernel(forceinline=True)
def _length(registers, out, box, a, b, c, count):
    """Root of the sum of the squares of two or three operands."""
    parts = (a, b, c)
    low, high = 0.0, 0.0
    for index in range(count):
        square = _square(registers[parts[index], 0, box], registers[parts[index], 1, box])
        low += square[0]
        high += square[1]
    for row in range(2, SIZE):
        registers[out, row, box] = 0.0
    for index in range(count):
        part = parts[index]
        square = _square(registers[part, 0, box], registers[part, 1, box])
        unit = _unit(
            registers[part, 0, box], registers[part, 1, box], max(low - square[0], 0.0), max(high - square[1], 0.0)
        )
        for row in range(2, SIZE, 2):
            product = product_bounds(registers[part, row, box], registers[part, row + 1, box], unit[0], unit[1])
            registers[out, row, box] += product[0]
            registers[out, row + 1, box] += product[1]
    registers[out, 0, box], registers[out, 1, box] = math.sqrt(low), math.sqrt(high)


@kernel(forceinline=True)
def _angle(registers, out, box, y, x):
    """atan2(y, x)."""
    y_low, y_high, x_low, x_high = (
        registers[y, 0, box],
        registers[y, 1, box],
        registers[x, 0, box],
        registers[x, 1, box],
    )
    if y_low <= 0.0 <= y_high and x_low <= 0.0:  # the cut, or the centre
        registers[out, 0, box], registers[out, 1, box] = -_HALF_TURN, _HALF_TURN
    else:
        p, q, r, s = (
            math.atan2(y_low, x_low),
            math.atan2(y_low, x_high),
            math.atan2(y_high, x_low),
            math.atan2(y_high, x_high),
        )
        registers[out, 0, box], registers[out, 1, box] = min(min(p, q), min(r, s)), max(max(p, q), max(r, s))
    xx, yy = _square(x_low, x_high), _square(y_low, y_high)
    across, along = _unit(x_low, x_high, yy[0], yy[1]), _unit(y_low, y_high, xx[0], xx[1])
    near, far = 1.0 / math.sqrt(xx[0] + yy[0]), 1.0 / math.sqrt(xx[1] + yy[1])
    across, along = product_bounds(across[0], across[1], far, near), product_bounds(-along[1], -along[0], far, near)
    for row in range(2, SIZE, 2):
        p = product_bounds(registers[y, row, box], registers[y, row + 1, box], across[0], across[1])
        q = product_bounds(registers[x, row, box], registers[x, row + 1, box], along[0], along[1])
        registers[out, row, box], registers[out, row + 1, box] = p[0] + q[0], p[1] + q[1]


@kernel(forceinline=True)
def _is_number(registers, a, box):
    """Whether an operand is the same number in all of a box, and around it."""
    same = registers[a, 0, box] == registers[a, 1, box]
    for row in range(2, SIZE):
        same = same and registers[a, row, box] == 0.0
    return same


@kernel(forceinline=True)
def _join(registers, op, out, box, a, b):
    """Operations on two operands."""
    a_low, a_high, b_low, b_high = (
        registers[a, 0, box],
        registers[a, 1, box],
        registers[b, 0, box],
        registers[b, 1, box],
    )
    if op == _MINIMUM or op == _MAXIMUM:
        if op == _MINIMUM:
            low, high, first, second = min(a_low, b_low), min(a_high, b_high), a_low <= b_high, b_low <= a_high
        else:
            low, high, first, second = max(a_low, b_low), max(a_high, b_high), a_high >= b_low, b_high >= a_low
        _choose(registers, out, box, a, b, first or not second, second or not first)
    elif op == _MULTIPLY and a == b:
        low, high = _square(a_low, a_high)
        _chain(registers, out, box, a, low, high, 2.0 * a_low, 2.0 * a_high)
    elif op == _MULTIPLY:
        low, high = product_bounds(a_low, a_high, b_low, b_high)
        for row in range(2, SIZE, 2):
            p = product_bounds(registers[a, row, box], registers[a, row + 1, box], b_low, b_high)
            q = product_bounds(registers[b, row, box], registers[b, row + 1, box], a_low, a_high)
            registers[out, row, box], registers[out, row + 1, box] = p[0] + q[0], p[1] + q[1]
    elif op == _DIVIDE:
        low, high = _quotient(a_low, a_high, b_low, b_high)
        for row in range(2, SIZE, 2):
            p = product_bounds(registers[b, row, box], registers[b, row + 1, box], low, high)
            registers[out, row, box], registers[out, row + 1, box] = _quotient(
                registers[a, row, box] - p[1], registers[a, row + 1, box] - p[0], b_low, b_high
            )
    elif _is_number(registers, b, box):  # a power with a known exponent
        low, high = _power(a_low, a_high, b_low)
        slope = _power(a_low, a_high, b_low - 1.0)
        slope = product_bounds(slope[0], slope[1], b_low, b_low)
        _chain(registers, out, box, a, low, high, slope[0], slope[1])
    else:
        # a^b = exp(b · log a), with the gradient a^b (b/a ∇a + log a ∇b).
        low, high, slope_low, slope_high = -math.inf, math.inf, -math.inf, math.inf
        log_low, log_high = -math.inf, math.inf
        if a_low > 0.0:
            log_low, log_high = math.log(a_low), math.log(a_high)
            low, high = product_bounds(log_low, log_high, b_low, b_high)
            low, high = math.exp(low), math.exp(high)
            slope_low, slope_high = _quotient(b_low, b_high, a_low, a_high)
        for row in range(2, SIZE, 2):
            p = product_bounds(registers[a, row, box], registers[a, row + 1, box], slope_low, slope_high)
            q = product_bounds(registers[b, row, box], registers[b, row + 1, box], log_low, log_high)
            registers[out, row, box], registers[out, row + 1, box] = product_bounds(p[0] + q[0], p[1] + q[1], low, high)
    registers[out, 0, box], registers[out, 1, box] = low, high


@kernel(forceinline=True)
def _less(registers, a, b, box, equal):
    """Whether a < b, or a ≤ b, holds (everywhere, anywhere) in a box; with unknown bounds it may."""
    a_low, a_high, b_low, b_high = (
        registers[a, 0, box],
        registers[a, 1, box],
        registers[b, 0, box],
        registers[b, 1, box],
    )
    if equal:
        return a_high <= b_low, a_low <= b_high
    return a_high < b_low, a_low < b_high


@kernel
def _call(registers, row, numbers):
    """A function of tables, by its bounds in each box. ``numbers`` (2, CALL_NUMBERS) is scratch."""
    place = numbers.ctypes.data
    for box in range(BOXES):
        at = 0
        for operand in range(row.b):
            numbers[0, at] = registers[row.a + operand, 0, box]
            at += 1
            if operand >= row.c:
                numbers[0, at] = registers[row.a + operand, 1, box]
                at += 1
        call_numbers(int(row.number), place, place + 8 * CALL_NUMBERS)
        for line in range(2, SIZE):
            registers[row.out, line, box] = 0.0
        for operand in range(row.c, row.b):
            at = 2 + 2 * (operand - row.c)
            for line in range(2, SIZE, 2):
                product = product_bounds(
                    registers[row.a + operand, line, box],
                    registers[row.a + operand, line + 1, box],
                    numbers[1, at],
                    numbers[1, at + 1],
                )
                registers[row.out, line, box] += product[0]
                registers[row.out, line + 1, box] += product[1]
        registers[row.out, 0, box], registers[row.out, 1, box] = numbers[1, 0], numbers[1, 1]


@kernel
def enclose(instructions, first, count, parameters, slot, registers, rounds):
    """Run the tape of ``count`` instructions from ``first``, of a formula whose parameters begin at ``slot``.

    ``registers`` (registers, SIZE, BOXES) holds the coordinates and their gradients in the first three and gets all
    results. ``rounds`` (DEEPEST_LOOP, 2) is scratch.
    """
    at, depth = first, 0
    numbers = np.empty((2, CALL_NUMBERS))
    while at < first + count:
        row = instructions[at]
        at += 1
        op, out, a, b, c = row.op, row.out, row.a, row.b, row.c
        if op == _CONSTANT or op == _PARAMETER:
            value = row.number if op == _CONSTANT else parameters[slot + int(row.number)]
            for box in range(BOXES):
                registers[out, 0, box], registers[out, 1, box] = value, value
            registers[out, 2:] = 0.0
        elif op == _COPY:
            registers[out] = registers[a]
        elif op == _ADD:
            for line in range(SIZE):
                for box in range(BOXES):
                    registers[out, line, box] = registers[a, line, box] + registers[b, line, box]
        elif op == _SUBTRACT:
            for line in range(SIZE):
                for box in range(BOXES):
                    registers[out, line, box] = registers[a, line, box] - registers[b, line ^ 1, box]
        elif op == _NEGATE:
            for line in range(SIZE):
                for box in range(BOXES):
                    registers[out, line, box] = -registers[a, line ^ 1, box]
        elif op == _SCALE:
            number = registers[b, 0, 0]
            swap = 1 if number < 0.0 else 0
            for line in range(SIZE):
                for box in range(BOXES):
                    registers[out, line, box] = _times(registers[a, line ^ swap, box], number)
        elif op == _ABS:
            for box in range(BOXES):
                low, high = registers[a, 0, box], registers[a, 1, box]
                least = 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
                _chain(
                    registers,
                    out,
                    box,
                    a,
                    least,
                    max(abs(low), abs(high)),
                    -1.0 if low < 0.0 else 1.0,
                    1.0 if high > 0.0 else -1.0,
                )
        elif op == _LENGTH:
            for box in range(BOXES):
                _length(registers, out, box, a, b, c, row.d)
        elif op == _ATAN2:
            for box in range(BOXES):
                _angle(registers, out, box, a, b)
        elif op == _SELECT_LESS or op == _SELECT_LESS_EQUAL:
            for box in range(BOXES):
                certain, possible = _less(registers, a, b, box, op == _SELECT_LESS_EQUAL)
                low, high = math.inf, -math.inf
                if possible:
                    low, high = registers[c, 0, box], registers[c, 1, box]
                if not certain:
                    low, high = min(low, registers[row.d, 0, box]), max(high, registers[row.d, 1, box])
                _choose(registers, out, box, c, row.d, possible, not certain)
                registers[out, 0, box], registers[out, 1, box] = low, high
        elif op == _BEGIN:
            # ``rounds`` has the remaining iterations, and the position to jump back to.
            count_of_rounds = registers[a, 0, 0]
            left = int(min(max(count_of_rounds, 0.0), row.number)) if count_of_rounds == count_of_rounds else 0
            registers[c : c + b] = registers[row.d : row.d + b]
            if left == 0:
                at = first + out + 1
            else:
                rounds[depth, 0], rounds[depth, 1] = left, b
                depth += 1
        elif op == _END:
            begin = instructions[first + out]
            going = False
            for box in range(BOXES):
                certain, possible = True, True
                if c > 0:
                    certain, possible = _less(registers, a, b, box, c == 2)
                going = going or possible
                if not possible:
                    continue
                for state in range(begin.b):
                    for line in range(SIZE):
                        new, old = registers[row.d + state, line, box], registers[begin.c + state, line, box]
                        if not certain:
                            new = min(new, old) if line % 2 == 0 else max(new, old)
                        registers[begin.c + state, line, box] = new
            rounds[depth - 1, 0] -= 1
            if going and rounds[depth - 1, 0] > 0:
                at = first + out + 1
            else:
                depth -= 1
        elif op == _CALL:
            _call(registers, row, numbers)
        elif op == _MULTIPLY or op == _DIVIDE or op == _MINIMUM or op == _MAXIMUM or op == _POWER:
            for box in range(BOXES):
                _join(registers, op, out, box, a, b)
        else:
            for box in range(BOXES):
                low, high, slope_low, slope_high = _function(op, registers[a, 0, box], registers[a, 1, box])
                _chain(registers, out, box, a, low, high, slope_low, slope_high)
        if op != _BEGIN and op != _END:
            for line in range(0, SIZE, 2):
                for box in range(BOXES):  # NaN is unknown
                    low, high = registers[out, line, box], registers[out, line + 1, box]
                    if not low <= high:
                        registers[out, line, box], registers[out, line + 1, box] = -math.inf, math.inf
