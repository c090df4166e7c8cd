# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates a formula in NumPy: vectorised float64, the reference for all other evaluators."""

from __future__ import annotations

import numpy as np

from . import functions
from .formula import (
    CALL,
    CONSTANT,
    ITERATE,
    PARAMETER,
    POSITION,
    RESULT,
    STATE,
    VARIABLE,
    Formula,
    Numbers,
    body,
    order,
)
from .operations import OPERATIONS


def evaluate(formula: Formula, points: np.ndarray, parameters: Numbers = ()) -> np.ndarray:
    """Values (…) of the formula at points (…, 3). Undefined values are NaN, without a warning."""
    return evaluate_all((formula,), points, parameters)[0]


def evaluate_all(formulas: tuple[Formula, ...], points: np.ndarray, parameters: Numbers = ()) -> list[np.ndarray]:
    """As ``evaluate``, for each formula; shared parts are computed once."""
    points = np.asarray(points, np.float64)
    with np.errstate(all="ignore"):
        values = _run(order(*formulas), formulas, {}, _OfPosition(points), parameters)
        return [np.broadcast_to(values[formula], points.shape[:-1]).astype(np.float64) for formula in formulas]


class Inputs:
    """External inputs of a formula: values of variables, and functions that read a scene."""

    def variable(self, name: str, component: int) -> np.ndarray:
        """Values of component ``component`` of the variable: an array or a number. Raises ValueError if it has none."""
        raise ValueError(f"the variable {name!r} has no value here")

    def call(self, function: functions.Function, operands: list) -> tuple[np.ndarray, ...]:
        """Results of a function, each an array (…) or a number. Override this for functions with ``function.scene``.
        Raises ValueError for a function that needs a scene."""
        if function.scene:
            raise ValueError(f"{function.name!r} needs a scene")
        return functions.evaluate(function, operands)


class _OfPosition(Inputs):
    def __init__(self, points: np.ndarray):
        self._points = points

    def variable(self, name: str, component: int) -> np.ndarray:
        if name != POSITION:
            return super().variable(name, component)
        return self._points[..., component]


def evaluate_inputs(formulas: tuple[Formula, ...], inputs: Inputs, parameters: Numbers = ()) -> list:
    """As ``evaluate_all``, with the values of variables from ``inputs``: arrays that broadcast with one another."""
    with np.errstate(all="ignore"):
        values = _run(order(*formulas), tuple(formulas), {}, inputs, parameters)
        return [values[formula] for formula in formulas]


def _run(nodes: list[Formula], wanted: tuple[Formula, ...], known: dict, inputs: Inputs, parameters) -> dict:
    """Values of ``nodes``, given in order; those that are not ``wanted`` are dropped after their last use."""
    uses = dict.fromkeys(nodes, 0)
    for node in (*wanted, *(operand for node in nodes for operand in node.operands)):
        if node in uses:
            uses[node] += 1
    values = dict(known)
    for node in nodes:
        operands = [values[operand] for operand in node.operands]
        if node.kind == CONSTANT:
            values[node] = np.float64(node.value)
        elif node.kind == VARIABLE:
            values[node] = inputs.variable(*node.value)
        elif node.kind == PARAMETER:
            values[node] = np.float64(parameters[node.value])
        elif node.kind == ITERATE:
            values[node] = _loop(node, operands, inputs, parameters)
        elif node.kind == CALL:
            values[node] = inputs.call(node.value, operands)
        elif node.kind == RESULT:
            values[node] = operands[0][node.value]
        else:
            values[node] = OPERATIONS[node.kind].meaning(*operands)
        for operand in node.operands:  # a graph of hundreds of nodes must not hold hundreds of arrays
            if operand in uses:
                uses[operand] -= 1
                if not uses[operand]:
                    values.pop(operand, None)
    return values


def _loop(node: Formula, operands: list, inputs: Inputs, parameters) -> list:
    """States after the loop of an ``ITERATE`` node."""
    loop, size = node.value, len(node.value.steps)
    states = operands[1 : 1 + size]
    captures = dict(zip(node.operands[1 + size :], operands[1 + size :]))
    nodes = body(node)
    own = [n for n in nodes if n.kind == STATE and n.value[0] == loop.level]
    computed = [n for n in nodes if n not in own]
    going = True
    for _ in range(rounds(operands[0], loop.limit)):
        known = captures | {state: states[state.value[1]] for state in own}
        values = _run(computed, loop.roots(), known, inputs, parameters)
        if loop.going is not None:
            going = going & values[loop.going]
            if not np.any(going):
                break
        states = [np.where(going, values[step], state) for step, state in zip(loop.steps, states)]
    return states


def rounds(count: float, limit: int) -> int:
    """Number of iterations of a loop from the value of its count."""
    return int(min(max(np.floor(count), 0.0), limit)) if count == count else 0
