# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The evaluation of an expression. Its result is a shape or, see ``emission``, a brightness.

Only a whitelist of the syntax tree is evaluated (``statement_evaluation``, ``value_evaluation``), and nothing as
Python. Every step counts, those of a loop as often as it runs, and their number is limited. So is the size of shapes.
An expression can therefore not demand more than a moment's work.
"""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator

import numpy as np

from . import builtin_colors, builtin_data, builtin_shapes  # noqa: F401 (their words are in FUNCTIONS then)
from ..graph.formula import Formula
from .expression_values import kind_of
from .functions import as_shape
from .resolver import PlaceholderResolver
from .shapes import Field, Shape
from .statement_evaluation import StatementEvaluator
from .syntax import ExpressionError

MOST_FIELDS = 16  # in a shape: finding the limits of each takes time


class Evaluation(StatementEvaluator):
    """One run through the statements of an expression."""

    def run(self, tree: ast.Module) -> Shape:
        """The shape of the last line."""
        last, result = self.last(
            tree, "write a shape, for instance sphere(0.5)", "what glows", "end with a line that is a shape"
        )
        if not isinstance(result, (Shape, Formula)):
            raise self.error(
                last,
                f"the last line is a {kind_of(result)}",
                "end with a line that is a shape, or a field that is negative inside",
            )
        with np.errstate(all="ignore"):
            return self.finished(last, self.attempt(last, lambda: as_shape(result, self.slots)))

    def last(self, tree: ast.Module, sample: str, wanted: str, cure: str) -> tuple[ast.Expr, object]:
        """Runs all statements. Returns the last one and its value. The texts are for messages if there is no such
        value."""
        if not tree.body:
            raise ExpressionError("the expression is empty", 1, 1, sample)
        with np.errstate(all="ignore"):  # values that are not finite are reported where they arise
            self.block(tree.body[:-1])
            last = tree.body[-1]
            if not isinstance(last, ast.Expr):
                self.block([last])
                raise self.error(last, f"the last line does not say {wanted}", cure)
            return last, self.value(last.value)

    def finished(self, node: ast.AST, shape: Shape) -> Shape:
        """Refuses shapes that cannot be rendered."""
        shape = self.checked(node, shape)
        if isinstance(self.slots.resolver, PlaceholderResolver) and self.slots.resolver.asked:
            return shape  # of boxes in place of data, whose limits tell nothing
        fields = list(itertools.islice(_fields(shape), MOST_FIELDS + 1))
        if len(fields) > MOST_FIELDS:
            raise self.error(
                node,
                "the shape has too many parts that are fields",
                f"use at most {MOST_FIELDS}: make one field of several with min and max",
            )
        if not shape.bounded:
            raise self.error(
                node,
                "the shape has no limits, or none that can be found",
                "intersect it with box(…), or give limits with field(…, bounds=…)",
            )
        if len(fields) == 1 and fields[0] is shape and not np.any(shape.bounds()):
            raise self.error(node, "the field is positive everywhere", "make it negative inside the shape")
        return shape


def _fields(shape: Shape) -> Iterator[Field]:
    """The parts of a shape that are fields."""
    if isinstance(shape, Field):
        yield shape
    for child in shape.children:
        yield from _fields(child)
