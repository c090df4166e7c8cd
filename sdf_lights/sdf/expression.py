# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The artists' language: a few lines of text that define a shape.

    size = slider(1, 0.1, 3)          # a parameter: becomes a slider in Blender
    hole = sphere(1.35 * size)
    difference(box(size), hole) | torus(size * 1.6, 0.1)

or, with the field itself, as a formula of the point p:

    for i in range(5):
        p = fold(abs(p), (1, -1, 0))
    box(0.5)(p) + 0.02 * sin(40 * p.x)

Python's parser reads the text (``syntax``), and ``evaluation`` walks the tree; nothing is ever run as Python.
"""

from __future__ import annotations

from collections.abc import Mapping

from .declarations import Declaration
from .evaluation import Evaluation
from .shapes import Shape
from .syntax import ExpressionError, parse

__all__ = ["Declaration", "Expression", "ExpressionError", "evaluate"]


class Expression:
    """A checked expression: its ``parameters``, and its shape for any of their values."""

    def __init__(self, text: str):
        """Raises ``ExpressionError`` if the text does not define a shape."""
        self._tree, self._remarks = parse(text)
        evaluation = Evaluation({}, self._remarks)
        evaluation.run(self._tree)
        self.parameters: tuple[Declaration, ...] = tuple(evaluation.declarations.values())

    def shape(self, values: Mapping[str, object] | None = None) -> Shape:
        """The shape with ``values`` of parameters by name, clamped to their limits; others have their defaults.

        Values of unknown names are ignored. Raises ``ExpressionError`` if these values define no shape.
        """
        return Evaluation(values or {}, self._remarks).run(self._tree)


def evaluate(text: str, values: Mapping[str, object] | None = None) -> Shape:
    """The shape that the text defines. Raises ``ExpressionError``."""
    return Expression(text).shape(values)
