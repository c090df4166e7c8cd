# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of formulas and of their gradients in boxes, by an interpreter: eight boxes at a time, without compilation.

``lipschitz`` does the same with NumPy, and more: norms, jumps, boxes split at folds, rounding of each operation. It is
the reference. It costs some microseconds for each operation of each formula, and a tree of a combination has a list of
terms of its own in almost every box. Both take the bounds of single operations from ``elementary_bounds``, and the
derivatives of functions from ``OPERATIONS``.

The graph of a formula is a *tape* of instructions (``interval_tape``) on registers, which hold bounds of a value and
of its gradient in eight boxes: interval forward differentiation (Griewank and Walther, "Evaluating Derivatives"; Moore,
Kearfott and Cloud, "Introduction to Interval Analysis"). Roots of sums of squares are treated as lengths, whose
gradients have no pole.

Bounds are exact except for rounding, which the caller must add (``interval_kernels.margin_of_rounding``). They hold
where the formula is continuous. Unknown bounds are infinite.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import call_numbers, kernel
from .elementary_bounds import TURN
from .interval_kernels import (
    ROUNDING,
    abs_bounds,
    angle_bounds,
    passes,
    power_bounds,
    product_bounds,
    quotient_bounds,
    square_bounds,
    times,
    unit_bounds,
    wave_bounds,
)
from .interval_tape import ALL, CALL_NUMBERS, CODE

BOXES = 8  # bounded together
SIZE = ALL
DEEPEST_LOOP = 16


@kernel
def _function(op, low, high):
    """Bounds (low, high) of a function of one operand."""
    if (op == CODE.sin or op == CODE.cos) and not high - low < TURN:  # common, and saves two cosines
        return -1.0, 1.0
    if op == CODE.sin:
        return wave_bounds(math.sin(low), math.sin(high), low, high, 0.25, ROUNDING)
    if op == CODE.cos:
        return wave_bounds(math.cos(low), math.cos(high), low, high, 0.0, ROUNDING)
    if op == CODE.tan:
        if passes(low, high, 0.25, 0.5, ROUNDING):
            return -math.inf, math.inf
        return math.tan(low), math.tan(high)
    if op == CODE.asin or op == CODE.acos:
        a, b = min(max(low, -1.0), 1.0), min(max(high, -1.0), 1.0)
        if op == CODE.asin:
            return math.asin(a), math.asin(b)
        return math.acos(b), math.acos(a)
    if op == CODE.atan:
        return math.atan(low), math.atan(high)
    if op == CODE.exp:
        return math.exp(low), math.exp(high)
    if op == CODE.log:
        return math.log(max(low, 0.0)), math.log(max(high, 0.0))
    if op == CODE.square:
        return square_bounds(low, high)
    if op == CODE.sqrt:
        return math.sqrt(max(low, 0.0)), math.sqrt(max(high, 0.0))
    return math.floor(low), math.floor(high)


@kernel(forceinline=True)
def _quotient(a_low, a_high, b_low, b_high):
    """Bounds of a quotient; infinite if the divisor may be 0."""
    if b_low <= 0.0 <= b_high:
        return -math.inf, math.inf
    return quotient_bounds(a_low, a_high, b_low, b_high)


@kernel
def _power(low, high, exponent):
    """Bounds of a power with a known exponent; infinite if it may be undefined."""
    if low < 0.0 and exponent != math.floor(exponent):
        return -math.inf, math.inf
    return power_bounds(low, high, exponent)


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
        square = square_bounds(registers[parts[index], 0, box], registers[parts[index], 1, box])
        low += square[0]
        high += square[1]
    for row in range(2, SIZE):
        registers[out, row, box] = 0.0
    for index in range(count):
        part = parts[index]
        square = square_bounds(registers[part, 0, box], registers[part, 1, box])
        unit = unit_bounds(
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
    cut = (x_low <= 0.0) & (y_low <= 0.0) & (y_high >= 0.0)  # or the centre
    if cut:  # saves four arctangents
        registers[out, 0, box], registers[out, 1, box] = -math.pi, math.pi
    else:
        registers[out, 0, box], registers[out, 1, box] = angle_bounds(y_low, y_high, x_low, x_high, cut)
    xx, yy = square_bounds(x_low, x_high), square_bounds(y_low, y_high)
    across, along = unit_bounds(x_low, x_high, yy[0], yy[1]), unit_bounds(y_low, y_high, xx[0], xx[1])
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
    if op == CODE.minimum or op == CODE.maximum:
        if op == CODE.minimum:
            low, high, first, second = min(a_low, b_low), min(a_high, b_high), a_low <= b_high, b_low <= a_high
        else:
            low, high, first, second = max(a_low, b_low), max(a_high, b_high), a_high >= b_low, b_high >= a_low
        _choose(registers, out, box, a, b, first or not second, second or not first)
    elif op == CODE.multiply and a == b:
        low, high = square_bounds(a_low, a_high)
        _chain(registers, out, box, a, low, high, 2.0 * a_low, 2.0 * a_high)
    elif op == CODE.multiply:
        low, high = product_bounds(a_low, a_high, b_low, b_high)
        for row in range(2, SIZE, 2):
            p = product_bounds(registers[a, row, box], registers[a, row + 1, box], b_low, b_high)
            q = product_bounds(registers[b, row, box], registers[b, row + 1, box], a_low, a_high)
            registers[out, row, box], registers[out, row + 1, box] = p[0] + q[0], p[1] + q[1]
    elif op == CODE.divide:
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
        if op == CODE.constant or op == CODE.parameter:
            value = row.number if op == CODE.constant else parameters[slot + int(row.number)]
            for box in range(BOXES):
                registers[out, 0, box], registers[out, 1, box] = value, value
            registers[out, 2 : row.rows] = 0.0
        elif op == CODE.copy:
            registers[out] = registers[a]
        elif op == CODE.add:
            for line in range(row.rows):
                for box in range(BOXES):
                    registers[out, line, box] = registers[a, line, box] + registers[b, line, box]
        elif op == CODE.subtract:
            for line in range(row.rows):
                for box in range(BOXES):
                    registers[out, line, box] = registers[a, line, box] - registers[b, line ^ 1, box]
        elif op == CODE.negate:
            for line in range(row.rows):
                for box in range(BOXES):
                    registers[out, line, box] = -registers[a, line ^ 1, box]
        elif op == CODE.scale:
            number = registers[b, 0, 0]
            swap = 1 if number < 0.0 else 0
            for line in range(SIZE):
                for box in range(BOXES):
                    registers[out, line, box] = times(registers[a, line ^ swap, box], number)
        elif op == CODE.abs:
            for box in range(BOXES):
                low, high = registers[a, 0, box], registers[a, 1, box]
                least, most = abs_bounds(low, high)
                _chain(registers, out, box, a, least, most, -1.0 if low < 0.0 else 1.0, 1.0 if high > 0.0 else -1.0)
        elif op == CODE.length:
            for box in range(BOXES):
                _length(registers, out, box, a, b, c, row.d)
        elif op == CODE.atan2:
            for box in range(BOXES):
                _angle(registers, out, box, a, b)
        elif op == CODE.select_less or op == CODE.select_less_equal:
            for box in range(BOXES):
                certain, possible = _less(registers, a, b, box, op == CODE.select_less_equal)
                low, high = math.inf, -math.inf
                if possible:
                    low, high = registers[c, 0, box], registers[c, 1, box]
                if not certain:
                    low, high = min(low, registers[row.d, 0, box]), max(high, registers[row.d, 1, box])
                _choose(registers, out, box, c, row.d, possible, not certain)
                registers[out, 0, box], registers[out, 1, box] = low, high
        elif op == CODE.begin:
            # ``rounds`` has the remaining iterations, and the position to jump back to.
            count_of_rounds = registers[a, 0, 0]
            left = int(min(max(count_of_rounds, 0.0), row.number)) if count_of_rounds == count_of_rounds else 0
            registers[c : c + b] = registers[row.d : row.d + b]
            if left == 0:
                at = first + out + 1
            else:
                rounds[depth, 0], rounds[depth, 1] = left, b
                depth += 1
        elif op == CODE.end:
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
        elif op == CODE.call:
            _call(registers, row, numbers)
        elif op == CODE.multiply or op == CODE.divide or op == CODE.minimum or op == CODE.maximum or op == CODE.power:
            for box in range(BOXES):
                _join(registers, op, out, box, a, b)
        elif op == CODE.chain:
            for box in range(BOXES):
                low, high = registers[b, 0, box], registers[b, 1, box]
                _chain(registers, out, box, a, low, high, registers[c, 0, box], registers[c, 1, box])
        elif op == CODE.divide_by_positive:
            for box in range(BOXES):
                registers[out, 0, box], registers[out, 1, box] = quotient_bounds(
                    registers[a, 0, box], registers[a, 1, box], max(registers[b, 0, box], 0.0), registers[b, 1, box]
                )
        else:
            registers[out, 2 : row.rows] = 0.0  # of ``floor``; functions have ``chain`` for their gradients
            for box in range(BOXES):
                registers[out, 0, box], registers[out, 1, box] = _function(
                    op, registers[a, 0, box], registers[a, 1, box]
                )
        if op != CODE.begin and op != CODE.end:
            for line in range(0, row.rows, 2):
                for box in range(BOXES):  # NaN is unknown
                    low, high = registers[out, line, box], registers[out, line + 1, box]
                    if not low <= high:
                        registers[out, line, box], registers[out, line + 1, box] = -math.inf, math.inf
