# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the formulas of materials to code that fills registers.

First, parameters become numbers, and constant parts are folded: a mapping without effect costs nothing. The remaining
numbers become parameters again, except 0 and 1. Each use of a number has its own slot, because numbers that are equal
by chance do not stay equal. So materials that differ only in numbers share their code, and a slider compiles nothing.
There are exceptions: the number, or a result of numbers alone, reaches or leaves 0 or 1, or the order of two numbers
changes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ....graph import codegen_native
from ....graph.formula import VARIABLE, Formula, order, parameter
from ....graph.functions import Function
from ....graph.numpy_evaluation import Inputs, evaluate_inputs
from ....graph.substitution import rewritten
from ....jit import CallablePart, layout
from .records import (
    DEPENDS_ON_VIEW,
    NEEDS_DERIVATIVES,
    NEEDS_OBJECT_NORMAL,
    NEEDS_RAY,
    NEEDS_SHADOW_POINT,
    TRACES_RAYS,
    VARIABLES,
)

_LITERAL = (0.0, 1.0)
_TYPICAL_POINTS = 16


def typical(formulas: Sequence[Formula], image_mean: Callable) -> np.ndarray:
    """(formulas,) means over artificial points of a surface, which estimate its brightness. The formulas have no
    parameters."""
    return np.array(
        [
            np.mean(np.maximum(np.nan_to_num(value), 0.0))
            for value in evaluate_inputs(tuple(formulas), _Typical(image_mean))
        ]
    )


class _Typical(Inputs):
    """Random points of surfaces, and the mean of a texture for every look-up."""

    def __init__(self, image_mean: Callable):
        self._image_mean, self._values = image_mean, {}

    def variable(self, name: str, component: int) -> np.ndarray:
        if (name, component) not in self._values:
            self._values[name, component] = np.random.default_rng(len(self._values)).random(_TYPICAL_POINTS)
        return self._values[name, component]

    def call(self, function: Function, operands: list) -> tuple:
        if function.name == "image":
            return (*self._image_mean(int(np.max(operands[0]))), 1.0)
        if function.scene:
            return tuple(self.variable(function.name, index) for index in range(function.results))
        return super().call(function, operands)


def needs(roots: Sequence[Formula], shadow: bool) -> int:
    """Flags of the fields of a surface that the formulas read."""
    names = {node.value[0] for node in order(*roots) if node.kind == VARIABLE}
    flags = NEEDS_DERIVATIVES if names & {"dpdu", "dpdv", "bump_step"} else 0
    flags |= TRACES_RAYS if any(isinstance(node.value, Function) and node.value.traces for node in order(*roots)) else 0
    flags |= NEEDS_OBJECT_NORMAL if "object_normal" in names else 0
    flags |= DEPENDS_ON_VIEW if names & {"incoming", "bump_step"} else 0
    flags |= NEEDS_RAY if names & {"ray_length", "ray_singular", "depth"} else 0
    if shadow and names - {"barycentric", "incoming", "backfacing", "ray_kind"}:
        flags |= NEEDS_SHADOW_POINT
    return flags


class Graphs:
    """The distinct graphs of a scene's materials: formulas whose parameters are ``slots``."""

    def __init__(self):
        self.structures: list[tuple[Formula, ...]] = []
        self._index: dict[tuple[Formula, ...], int] = {}
        self._compiled: list[codegen_native.Compiled] = []

    def add(self, roots: Sequence[Formula]) -> tuple[int, list[float]]:
        """Index of a graph, −1 for none, and the values of its slots. ``roots`` have no parameters any more."""
        if not roots:
            return -1, []
        numbers: list[float] = []

        def slot(node: Formula) -> Formula:
            if node.value in _LITERAL:
                return node
            numbers.append(node.value)
            return parameter(len(numbers) - 1)

        structure = tuple(rewritten(tuple(roots), {}, lambda node: node, number=slot))
        if structure not in self._index:
            self._index[structure] = len(self.structures)
            self.structures.append(structure)
        return self._index[structure], numbers

    def addresses(self, records: tuple) -> np.ndarray:
        """Addresses of the graphs' code, for blocks and workspaces of these ``records``. The code lives as long as this
        object."""

        def address_of(function: Function, operands: int) -> int:
            return _part(function, operands, records if function.scene else None).address

        for structure in self.structures[len(self._compiled) :]:
            self._compiled.append(codegen_native.compiled_at_surface(structure, VARIABLES, address_of, layout(records)))
        return np.array([code.address for code in self._compiled] or [0], np.int64)


def compile_calls(calls: Sequence[tuple[Function, int]], records: tuple) -> None:
    """Compile functions with so many operands in advance, as graphs call them."""
    for function, operands in calls:
        _part(function, operands, records if function.scene else None)


_parts: dict[tuple, CallablePart] = {}


def _part(function: Function, operands: int, records: tuple | None) -> CallablePart:
    key = function, operands, records and layout(records)
    if key not in _parts:
        _parts[key] = CallablePart(function.kernel, function.static, operands, records)
    return _parts[key]
