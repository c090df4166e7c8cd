# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The NumPy reading of a formula: vectorised float64, the reference for every other reading."""

from __future__ import annotations

import numpy as np

from .formula import CONSTANT, OPERATIONS, PARAMETER, POSITION, Formula, order


def evaluate(formula: Formula, points: np.ndarray, parameters: np.ndarray = ()) -> np.ndarray:
    """Values (…) of the formula at points (…, 3). Where it is undefined the value is NaN, without a warning."""
    points = np.asarray(points, np.float64)
    nodes = order(formula)
    uses = dict.fromkeys(nodes, 0)
    for node in nodes:
        for operand in node.operands:
            uses[operand] += 1
    values: dict[Formula, np.ndarray | np.float64] = {}
    with np.errstate(all="ignore"):
        for node in nodes:
            if node.kind == CONSTANT:
                values[node] = np.float64(node.value)
            elif node.kind == POSITION:
                values[node] = points[..., node.value]
            elif node.kind == PARAMETER:
                values[node] = np.float64(parameters[node.value])
            else:
                values[node] = OPERATIONS[node.kind].meaning(*(values[operand] for operand in node.operands))
                for operand in node.operands:  # a graph of hundreds of nodes must not hold hundreds of arrays
                    uses[operand] -= 1
                    if not uses[operand]:
                        values.pop(operand, None)
        return np.broadcast_to(values[formula], points.shape[:-1]).astype(np.float64)
