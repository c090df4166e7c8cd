# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields in kernels: a shape's terms as compiled code, evaluated at ``LANES`` points at a time.

A field consists of terms in postfix order (``sdf.shapes.Term``). A *list* holds the indices of terms, also in postfix
order: of all terms, or of those that matter in one box of space (see ``interior``). If a join reduces to one operand
with its sign changed, ``NEGATED`` follows the operand in the list.
"""

from __future__ import annotations

import math

import numpy as np

from ...frozen import frozen
from ...graph.codegen_native import LANES, compiled
from ...graph.formula import CALL, CONSTANT, ITERATE, PARAMETER, Formula, body, order
from ...graph.functions import compiled_part
from ...graph.numpy_evaluation import rounds
from ...graph.tables import tables_of
from ...jit import call_field, call_numbers, kernel, stack_array, table
from ...replaced import replaced_on_gpu
from ...sdf.shapes.base import Term

TERM = np.dtype(
    [
        ("address", np.int64),  # of the compiled formula
        ("parameters", np.int64),  # index of the formula's first parameter
        ("arity", np.int64),
        ("family", np.int64),  # sdf.shapes.Family
        ("blend_width", np.float64),
        ("lipschitz", np.float64),
        ("zeros", np.int64),  # address of the compiled ``Term.zeros``; 0 without one
    ],
    align=True,
)

LIST = np.dtype(np.int32)
NEGATED = -1  # in a list: the value on top of the stack changes its sign

TABLES = {"lamp_terms": TERM, "lamp_parameters": np.dtype(np.float64), "lamp_lists": LIST}

SMALL_TABLE = 1 << 12  # numbers: a tree of so many, with all its ``boxes``, takes a second or two

LIBRARY = frozenset({"sin", "cos", "tan", "asin", "acos", "atan", "exp", "log", "power", "atan2"})  # one call per lane

ZEROS_GIVEN, ZEROS_TOLD = 11, 2  # numbers that ``Term.zeros`` takes and returns

DEEPEST = 62  # values that an evaluation may hold at a time
VALUES = 3 * LANES  # offset of the values in ``stack``, after all x, all y and all z
STACK = VALUES + DEEPEST * LANES  # number of float64 in ``stack``: jit.stack_array(STACK), imported by that name

lamp_terms = table("lamp_terms", TERM)
lamp_parameters = table("lamp_parameters", np.float64)
lamp_lists = table("lamp_lists", LIST)


@frozen
class CompiledField:
    """A field ready for the kernels. ``code`` owns the memory at the addresses in ``terms`` and ``parameters``."""

    source: tuple[Term, ...]
    terms: np.ndarray  # TERM
    parameters: np.ndarray  # float64
    near_fields: np.ndarray  # largest distance from zero of the value of each term at which more than its sign matters
    gains: np.ndarray  # factor of each term on the Lipschitz bounds of its operands; infinite for leaves
    operations: np.ndarray  # of each term, per point
    costs: np.ndarray  # rough time of each term for LANES points: the same on every machine
    depth: int  # greatest number of values that an evaluation of all terms holds at a time
    boxes: int  # how many times as many boxes a tree may have (``TableFunction.boxes``)
    code: tuple

    def all_terms(self) -> np.ndarray:
        """The list of all terms."""
        return np.arange(len(self.terms), dtype=LIST)


def _work(nodes: list[Formula], parameters: np.ndarray, library: float) -> float:
    """Operations of a graph at a point, including all iterations of its loops; each library call counts as
    ``library``."""
    total = 0.0
    for node in nodes:
        if node.kind == ITERATE:
            count = node.operands[0]
            known = (
                count.value
                if count.kind == CONSTANT
                else parameters[count.value]
                if count.kind == PARAMETER
                else (node.value.limit)
            )
            total += rounds(known, node.value.limit) * _work(body(node), parameters, library)
        elif node.kind == CALL:
            total += getattr(node.value, "operations", library)
        else:
            total += library if node.kind in LIBRARY else 1.0
    return total


def _gains(terms: list[Term]) -> tuple[np.ndarray, int]:
    """``CompiledField.gains``, and the greatest number of values that an evaluation holds at a time."""
    gains, stack, depth = np.full(len(terms), np.inf), [], 0
    for index, term in enumerate(terms):
        if term.arity > 0:
            steepest = max(stack[-term.arity :])
            del stack[-term.arity :]
            # Without a known bound, no operator is steeper than its steepest operand.
            gains[index] = term.lipschitz / steepest if math.isfinite(term.lipschitz) else 1.0
        stack.append(term.lipschitz)
        depth = max(depth, len(stack))
    return gains, depth


def _near_fields(terms: list[Term]) -> np.ndarray:
    """``CompiledField.near_fields``: zero for the field as a whole."""
    near_fields, waiting = np.zeros(len(terms)), [0.0]
    for index in range(len(terms) - 1, -1, -1):
        near_fields[index] = waiting.pop()
        # An operand farther from zero than the blend width does not bring its value closer to zero than its own. A map
        # may bring any value to zero.
        needed = near_fields[index] + terms[index].blend_width if terms[index].arity == 2 else math.inf
        waiting += [needed] * terms[index].arity
    return near_fields


def _boxes(nodes: list[Formula], parameters: np.ndarray) -> int:
    """``CompiledField.boxes`` of one term, a power of two: fewer for large tables, whose bounds take long."""
    boxes = max((getattr(node.value, "boxes", 1) for node in nodes if node.kind == CALL), default=1)
    if boxes > 1:
        size = sum(len(table.array) for table in tables_of(nodes[-1], parameters))
        boxes = max(boxes * SMALL_TABLE // max(size, SMALL_TABLE), 1)
    return 1 << boxes.bit_length() - 1


def compile_terms(terms: list[Term]) -> CompiledField:
    """Compile all formulas that are not compiled yet; terms of the same formula share their code."""
    rows = np.zeros(len(terms), TERM)
    code, parameters, used = [], [np.zeros(0)], 0
    for row, term in zip(rows, terms):
        found = compiled(term.formula)
        code += [found.owner, *tables_of(term.formula, term.parameters)]
        row["address"], row["parameters"] = found.address, used
        if term.zeros is not None:
            row["zeros"] = compiled_part(term.zeros, ZEROS_GIVEN).address
        for name in ("arity", "family", "blend_width", "lipschitz"):
            row[name] = getattr(term, name)
        parameters.append(term.parameters)
        used += len(term.parameters)
    gains, depth = _gains(terms)
    orders = {formula: order(formula) for formula in {term.formula for term in terms}}
    graphs = [(orders[term.formula], term.parameters) for term in terms]
    return CompiledField(
        source=tuple(terms),
        terms=rows,
        parameters=np.concatenate(parameters),
        near_fields=_near_fields(terms),
        gains=gains,
        operations=np.array([_work(nodes, numbers, 1.0) for nodes, numbers in graphs]),
        costs=np.array([10.0 + 0.7 * _work(nodes, numbers, 50.0) for nodes, numbers in graphs]),
        depth=depth,
        boxes=max((_boxes(nodes, numbers) for nodes, numbers in graphs), default=1),
        code=tuple(dict.fromkeys(code)),
    )


@kernel
def run_terms(terms, parameters, lists, first, count, points, stack):
    """Values of a list, the
    ``count`` entries of ``lists`` from ``first``, at the first ``points`` of the ``LANES`` points in ``stack``; other
    values mean nothing.

    ``stack`` has ``STACK`` elements: the ``LANES`` x, then y, then z are at its head and stay there; the values follow,
    from ``VALUES``. A term reads its operands in place and overwrites them with its own values.
    """
    positions = stack.ctypes.data
    numbers = parameters.ctypes.data
    top = VALUES
    for index in range(first, first + count):
        number = lists[index]
        if number == NEGATED:
            for lane in range(top - LANES, top):
                stack[lane] = -stack[lane]
            continue
        term = terms[number]
        top -= term.arity * LANES
        place = positions + 8 * top
        call_field(term.address, points, positions if term.arity == 0 else place, numbers + 8 * term.parameters, place)
        top += LANES


@kernel
def evaluate(block, row, first, count, points, stack):
    """As ``run_terms``, for the lamp ``row`` of a block: ``first`` counts from the beginning of the lamp's lists."""
    run_terms(
        lamp_terms(block)[row.first_term :],
        lamp_parameters(block),
        lamp_lists(block),
        row.first_list + first,
        count,
        points,
        stack,
    )


@replaced_on_gpu
@kernel
def value(block, row, first, count, p):
    """Value of a list at a single point."""
    stack = stack_array(STACK)
    for k in range(3):
        for lane in range(LANES):
            stack[k * LANES + lane] = p[k]
    evaluate(block, row, first, count, 1, stack)
    return stack[VALUES]


@kernel
def zeros(block, term, o, d, start, end, spans, limit):
    """All zeros of the field of a lamp with this single ``term`` along a ray, start ≤ s ≤ end, by its own function:
    ``Term.zeros``.

    They are written to ``spans`` one after the other, at most 2 ``limit``, after the start if it is inside. Returns
    (number of all, number of the steps that this took). The function takes the addresses of the term's parameters, o,
    d, start and end, the address of ``spans`` and how many numbers have room there.
    """
    given, told = stack_array(ZEROS_GIVEN), stack_array(ZEROS_TOLD)
    given[0] = lamp_parameters(block).ctypes.data + 8 * term.parameters
    for k in range(3):
        given[1 + k], given[4 + k] = o[k], d[k]
    given[7], given[8], given[9], given[10] = start, end, spans.ctypes.data, 2 * limit
    call_numbers(term.zeros, given.ctypes.data, told.ctypes.data)
    return int(told[0]), int(told[1])
