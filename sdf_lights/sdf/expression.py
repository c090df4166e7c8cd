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
from functools import cached_property

from .builtin_data import names_in
from .declarations import Declaration
from .evaluation import Evaluation
from .resolver import PlaceholderResolver, Resolver
from .shapes import Shape
from .syntax import ExpressionError, parse

__all__ = ["Declaration", "Expression", "ExpressionError", "evaluate"]


class Expression:
    """A checked expression: its ``parameters``, and its shape for any of their values.

    What its names of data mean is looked up when the shape is asked for.
    """

    def __init__(self, text: str):
        """Raises ``ExpressionError`` if the text does not define a shape."""
        self._tree, self._remarks = parse(text)
        evaluation = Evaluation({}, self._remarks, PlaceholderResolver())
        evaluation.run(self._tree)
        self.parameters: tuple[Declaration, ...] = tuple(evaluation.declarations.values())

    def shape(self, values: Mapping[str, object] | None = None, resolver: Resolver | None = None) -> Shape:
        """The shape with ``values`` of parameters by name in place of their defaults, held to their limits.

        Values of other names are ignored. ``resolver`` gives the shapes that data make. Raises ``ExpressionError``
        where these values do not make a shape.
        """
        return Evaluation(values or {}, self._remarks, resolver).run(self._tree)

    @cached_property
    def data(self) -> frozenset[tuple[str, str]]:
        """Kinds and names of data that the shape may be made of: see ``names_in``."""
        return names_in(self._tree)


def evaluate(text: str, values: Mapping[str, object] | None = None, resolver: Resolver | None = None) -> Shape:
    """The shape that the text says. Raises ``ExpressionError``."""
    return Expression(text).shape(values, resolver)
