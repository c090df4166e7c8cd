# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Means of formulas over space, where one value must do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...graph.folding import Folding
from ...graph.formula import VARIABLE, Formula, order
from ...graph.functions import Function
from ...graph.numpy_evaluation import Inputs, evaluate_inputs
from ..material import OBJECT_DENSITY, Attribute, Table

_POINTS = 2048


def mean_inside(formulas: Sequence[Formula], parameters: Sequence["float | Attribute | Table"]) -> list[float]:
    """Mean of each formula over a cube of one metre at the origin, or over all coordinates of images and objects."""
    folding = Folding([value if isinstance(value, float) else float(place) for place, value in enumerate(parameters)])
    values = evaluate_inputs(tuple(map(folding.fold, formulas)), _Cube(parameters))
    return [float(np.mean(np.where(np.isfinite(value), value, 0.0))) for value in values]


def varies(formulas: Sequence[Formula]) -> bool:
    """Whether formulas may vary in space or from ray to ray: they use more than curves and ramps."""
    return any(
        node.kind == VARIABLE or isinstance(node.value, Function) and node.value.scene and node.value.name != "table"
        for node in order(*formulas)
    )


class _Cube(Inputs):
    """Points inside a mesh, where its attributes are zero."""

    def __init__(self, parameters: Sequence["float | Attribute | Table"]):
        self._parameters = parameters
        self._points = np.random.default_rng(0).random((3, _POINTS))

    def variable(self, name: str, component: int) -> np.ndarray:
        return self._points[component] if name == "position" else np.zeros(_POINTS)

    def call(self, function: Function, operands: list) -> tuple[np.ndarray, ...]:
        if not function.scene:
            return super().call(function, operands)
        if function.name == "attribute":
            found = self._place(operands[0])
            if found in (Attribute("texture_space", "scale"), OBJECT_DENSITY):
                return (np.ones(_POINTS),) * function.results
            generated = getattr(found, "kind", "") == "generated"
            return (*self._points, np.ones(_POINTS)) if generated else (np.zeros(_POINTS),) * function.results
        if function.name == "table":
            return self._table(function, operands)
        if function.name == "occlusion":
            return (np.ones(_POINTS),)
        if function.name.startswith(("to_", "from_")):
            return tuple(operands[-3:])
        return tuple(self._points[index % 3] for index in range(function.results))

    def _place(self, operand) -> "float | Attribute | Table | None":
        place = int(np.ravel(operand)[0])
        return self._parameters[place] if 0 <= place < len(self._parameters) else None

    def _table(self, function: Function, operands: list) -> tuple[np.ndarray, ...]:
        rows = np.asarray(self._place(operands[0]).values, np.float64).reshape(-1, function.static[0])
        at = np.linspace(0.0, 1.0, len(rows))
        columns = [np.interp(operands[2], at, column) for column in rows.T]
        columns = columns * 3 if len(columns) == 1 else columns
        return tuple([*columns, np.ones(_POINTS)][:4])
