# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of the expression language: the evaluator of one node of the syntax tree, with what it refers to.

The names of a tree are those of constants, of the point ``p`` and of values assigned so far. Each step is counted.
"""

from __future__ import annotations

import ast
import difflib
import itertools
import math
import operator
from collections.abc import Callable, Iterable, Mapping

from ..graph.formula import POINT
from . import declarations, expression_values
from .builtin_numbers import modulo
from .expression_values import (
    Condition,
    Misuse,
    NeedsNumber,
    Work,
    choose,
    compute,
    has_field,
    kind_of,
    spread,
)
from .functions import CONSTANTS, FUNCTIONS, as_shape
from .resolver import Resolver
from .shapes import Difference, Intersection, Shape, ShapeError, Union
from .shapes.base import Parametric
from .syntax import DEEPEST, ExpressionError

MOST_PRIMITIVES = 2_000
DEEPEST_SHAPE = 100

_SHAPE_STEPS = 6  # cost of making a shape

_ARITHMETIC: dict[type, Callable] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Mod: modulo,
    ast.Pow: expression_values.power,
}
_COMBINATIONS = {ast.BitOr: Union, ast.BitAnd: Intersection, ast.Sub: Difference}
_SYMBOLS = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Mod: "%",
    ast.Pow: "**",
    ast.BitOr: "|",
    ast.BitAnd: "&",
}
_COMPARISONS: dict[type, Callable] = {
    ast.Lt: expression_values.less,
    ast.LtE: expression_values.less_equal,
    ast.Gt: lambda a, b: expression_values.less(b, a),
    ast.GtE: lambda a, b: expression_values.less_equal(b, a),
}


class ValueEvaluator:
    """The values of expressions, with the names known so far. Errors are ``ExpressionError`` at the node."""

    def __init__(self, given: Mapping[str, object], remarks: Mapping[int, str], resolver: Resolver | None = None):
        self.given = given
        self.remarks = remarks
        self.names: dict[str, object] = CONSTANTS | {"p": tuple(POINT)}
        self.declarations: dict[str, declarations.Declaration] = {}
        self.slots = Work(resolver)
        self.depth = 0  # of values inside one another
        self.nesting = 0  # of blocks
        self.loops = 0  # of the formula, that are being made

    def error(self, node: ast.AST, message: str, cure: str) -> ExpressionError:
        """The error at the position of a node: the mistake and the cure."""
        return ExpressionError(message, getattr(node, "lineno", 1), getattr(node, "col_offset", 0) + 1, cure)

    def step(self, node: ast.AST, count: int = 1) -> None:
        """Count work on the expression. Raises ExpressionError if it is too much."""
        try:
            self.slots.step(count)
        except Misuse as misuse:
            raise self.error(node, str(misuse), misuse.cure) from None

    def operate(self, node: ast.AST, count: int) -> None:
        """Count operations of a field. Raises ExpressionError if they are too many."""
        self.attempt(node, lambda: self.slots.operate(count))

    def value(self, node: ast.expr):
        """The value of an expression: a scalar, a vector, a condition, a shape or a profile."""
        self.depth += 1
        try:
            if self.depth > 2 * DEEPEST:
                raise self.error(node, "the expression is nested too deeply", "name parts of it on lines of their own")
            self.step(node)
            visit = _VISITS.get(type(node))
            if visit is None:
                raise self.error(
                    node,
                    "this is not part of the language",
                    "use numbers, names, calls, vectors, comparisons and the operators + - * / % ** | &",
                )
            return self.checked(node, visit(self, node))
        finally:
            self.depth -= 1

    def checked(self, node: ast.expr, value):
        """The value. Raises ExpressionError if it is not finite, or is a shape that cannot be built."""
        if isinstance(value, Parametric):
            if isinstance(value, Shape) and (value.size > MOST_PRIMITIVES or value.depth > DEEPEST_SHAPE):
                raise self.error(
                    node,
                    "the shape has too many parts",
                    f"use at most {MOST_PRIMITIVES} shapes, and {DEEPEST_SHAPE} combinations inside one another",
                )
            problem = value.check()
            if problem:
                message, _, cure = problem.rstrip(".").rpartition(": ")
                message, cure = (message, cure) if ": " in message else (problem.rstrip("."), "change the value")
                raise self.error(node, message, cure)
        else:
            for scalar in expression_values.components(value):
                if isinstance(scalar, float) and not math.isfinite(scalar):
                    raise self.error(node, "the value is undefined or too large", "use other numbers")
        return value

    def constant(self, node: ast.Constant) -> float | str | Condition:
        """A number, a text, or True or False as a condition."""
        if type(node.value) is str:
            return node.value
        if type(node.value) is bool:
            return Condition(float(node.value))
        if type(node.value) not in (int, float):
            raise self.error(node, f"{node.value!r:.40} is not a number of the language", "write a number such as 0.5")
        return self.attempt(node, lambda: float(node.value))

    def name(self, node: ast.Name):
        """The value of a name."""
        if node.id in self.names:
            return self.names[node.id]
        if node.id in FUNCTIONS:
            raise self.error(node, f"{node.id} needs brackets", f"write {FUNCTIONS[node.id].signature()}")
        raise self.unknown(node, FUNCTIONS | self.names)

    def unknown(self, node: ast.Name, known) -> ExpressionError:
        """The error for a name without a value, with the most similar known name."""
        # Searching for similar names takes time for each name, so it is limited.
        close = difflib.get_close_matches(node.id[:40], itertools.islice(reversed(known), 200), 1)
        cure = f"did you mean {close[0]}?" if close else "give it a value on a line above, or choose a known name"
        return self.error(node, f"{node.id:.40} is not a known name", cure)

    def call(self, node: ast.Call):
        """The result of a function of the language, or of a shape called with a point: its field there."""
        # A name with a value still means the function where it is called, unless the value can be called.
        name = node.func.id if isinstance(node.func, ast.Name) else None
        if name not in FUNCTIONS and name not in declarations.USAGE or isinstance(self.names.get(name), Parametric):
            shape = self.called(node)
            function = FUNCTIONS["distance"]
            if len(node.args) != 1 or node.keywords:
                raise self.error(node, "the field of a shape takes one point", "write shape(p)")
            positional, named = [shape, self.value(node.args[0])], {}
        elif name in declarations.USAGE:
            raise self.error(node, f"{name} has to stand alone", f"write {declarations.USAGE[name]}")
        else:
            function, positional, named = FUNCTIONS[name], [], {}
            for argument in node.args:
                positional.append(self.value(argument))
            for keyword in node.keywords:
                if keyword.arg is None:
                    raise self.error(node, "** is not part of a call", "name the arguments")
                named[keyword.arg] = self.value(keyword.value)
        given = [*positional, *named.values()]
        self.limit(node, given)
        if any(map(has_field, given)):
            self.operate(node, function.cost * sum(len(expression_values.components(value)) for value in given))
        else:
            self.step(node, _SHAPE_STEPS if function.makes_shape else 1)
        return self.attempt(node, lambda: function(self.slots, positional, named))

    def called(self, node: ast.Call) -> Parametric:
        """The shape or profile before the brackets of a call."""
        if isinstance(node.func, ast.Name) and node.func.id not in self.names:
            raise self.unknown(node.func, FUNCTIONS)
        value = self.value(node.func)
        if not isinstance(value, Parametric):
            what = node.func.id if isinstance(node.func, ast.Name) else "this"
            raise self.error(
                node, f"{what:.40} is a {kind_of(value)}, not a function", "leave out the brackets after it"
            )
        return value

    def limit(self, node: ast.expr, given: Iterable) -> None:
        """Refuses to combine shapes that are too large together, before that takes time."""
        size = sum(value.size for value in given if isinstance(value, Shape))
        if size > MOST_PRIMITIVES:
            raise self.error(node, "the shape has too many parts", f"use at most {MOST_PRIMITIVES} shapes")
        self.step(node, size // 16)

    def attempt(self, node: ast.AST, work: Callable):
        """The result of ``work``. Its errors become ExpressionErrors at the node."""
        try:
            return work()
        except NeedsNumber as misuse:
            if self.loops:
                raise
            raise self.error(node, str(misuse), misuse.cure) from None
        except Misuse as misuse:
            raise self.error(node, str(misuse), misuse.cure) from None
        except ShapeError as error:
            raise self.error(node, str(error).rstrip("."), "give it numbers") from None
        except ZeroDivisionError:
            raise self.error(node, "division by zero", "divide by another number") from None
        except (ValueError, OverflowError):
            raise self.error(node, "the value is undefined or too large", "use other numbers") from None

    def binary(self, node: ast.BinOp):
        """The value of operators between operands: of a whole chain at once."""
        # The tree of a long chain a + b + c + … leans to the left. Walking down its spine needs no recursion.
        spine = [node]
        while isinstance(spine[-1].left, ast.BinOp):
            spine.append(spine[-1].left)
        result = self.value(spine[-1].left)
        parts = spine[::-1]
        while parts:
            part, kind = parts[0], type(parts[0].op)
            operands = [result, self.value(part.right)]
            count = 1
            if self.combines(kind, *operands):
                # A chain of one operator is built at once: link by link, each would copy the shapes before it.
                count = next((i for i, later in enumerate(parts) if type(later.op) is not kind), len(parts))
                for later in parts[1:count]:
                    operands.append(self.value(later.right))
                    if kind_of(operands[-1]) not in ("shape", "field"):
                        raise self.mismatch(later, "shape", kind_of(operands[-1]))
                result = self.combination(parts[count - 1], operands)
            else:
                result = self.arithmetic(part, *operands)
            result = self.checked(parts[count - 1], result)
            parts = parts[count:]
        return result

    def combines(self, kind: type, left, right) -> bool:
        """Whether an operator makes a shape: from shapes, or from fields if no other meaning is possible."""
        kinds = {kind_of(left), kind_of(right)}
        return kind in _COMBINATIONS and kinds <= {"shape", "field"} and ("shape" in kinds or kind is not ast.Sub)

    def combination(self, node: ast.BinOp, operands: list) -> Shape:
        """The shape that ``|``, ``&`` or ``-`` makes of two or more shapes or fields."""
        self.limit(node, operands)
        return self.attempt(node, lambda: _COMBINATIONS[type(node.op)](*(as_shape(o, self.slots) for o in operands)))

    def mismatch(self, node: ast.BinOp, left: str, right: str) -> ExpressionError:
        """The error for an operator between kinds that it does not accept."""
        symbol = _SYMBOLS.get(type(node.op), "this operator")
        cure = "use | & - between shapes, and + - * / % ** between numbers, fields and vectors"
        if {left, right} == {"shape", "field"}:
            cure = "write shape(p) for the field of a shape"
        return self.error(node, f"{symbol} does not work between a {left} and a {right}", cure)

    def arithmetic(self, node: ast.BinOp, left, right):
        """The value of ``+ - * / % **`` between numbers, fields and vectors, component by component."""
        kinds = kind_of(left), kind_of(right)
        function = _ARITHMETIC.get(type(node.op))
        if function is None or not set(kinds) <= {"number", "field", "vector"}:
            raise self.mismatch(node, *kinds)
        if has_field(left) or has_field(right):
            self.operate(node, 3 if "vector" in kinds else 1)
        return self.attempt(node, lambda: spread(lambda *scalars: compute(self.slots, function, *scalars), left, right))

    def unary(self, node: ast.UnaryOp):
        """The value of ``-``, ``+`` or ``not`` before an operand."""
        if isinstance(node.op, ast.Not):
            return self.chosen(node, self.condition(node.operand), Condition(0.0), Condition(1.0))
        value = self.value(node.operand)
        if kind_of(value) not in ("number", "field", "vector") or not isinstance(node.op, (ast.USub, ast.UAdd)):
            raise self.error(node, f"this sign does not work before a {kind_of(value)}", "use - and + before numbers")
        if isinstance(node.op, ast.UAdd):
            return value
        return spread(lambda scalar: compute(self.slots, operator.neg, scalar), value)

    def condition(self, node: ast.expr) -> Condition:
        """The value of an expression. Raises ExpressionError if it is no condition."""
        value = self.value(node)
        if not isinstance(value, Condition):
            raise self.error(node, f"a {kind_of(value)} is not a condition", "compare it, as in a < b")
        return value

    def comparison(self, node: ast.Compare) -> Condition:
        """The condition of ``<``, ``<=``, ``>`` or ``>=`` between two numbers or fields."""
        function = _COMPARISONS.get(type(node.ops[0]))
        if function is None or len(node.ops) > 1:
            raise self.error(
                node,
                "this comparison is not part of the language",
                "compare two values with < <= > >=, and join comparisons with and",
            )
        left, right = self.value(node.left), self.value(node.comparators[0])
        for value in (left, right):
            if kind_of(value) not in ("number", "field"):
                raise self.error(node, f"a {kind_of(value)} cannot be compared", "compare numbers or fields")
        if has_field(left) or has_field(right):
            self.operate(node, 1)
        return compute(self.slots, function, left, right)

    def logic(self, node: ast.BoolOp) -> Condition:
        """The condition of ``and`` or ``or`` between conditions."""
        result = self.condition(node.values[0])
        for operand in node.values[1:]:
            other = self.condition(operand)
            sides = (other, Condition(0.0)) if isinstance(node.op, ast.And) else (Condition(1.0), other)
            result = self.chosen(node, result, *sides)
        return result

    def selection(self, node: ast.IfExp):
        """The value of ``then if condition else otherwise``."""
        condition = self.condition(node.test)
        then, otherwise = self.value(node.body), self.value(node.orelse)
        return self.chosen(node, condition, then, otherwise)

    def chosen(self, node: ast.AST, condition: Condition, then, otherwise):
        """``then`` where the condition holds, else ``otherwise``, point by point if it is a field."""
        if then is otherwise:
            return then
        if has_field(condition) or has_field(then) or has_field(otherwise):
            # Conditions also count as values here: they become numbers for the choice.
            self.operate(
                node,
                4
                if isinstance(then, Condition)
                else max(len(expression_values.components(value)) for value in (then, otherwise)),
            )
        return self.attempt(node, lambda: choose(self.slots, condition, then, otherwise))

    def vector(self, node: ast.Tuple):
        """A vector of two or three numbers or fields."""
        parts = tuple(self.value(element) for element in node.elts)
        if len(parts) not in (2, 3) or not all(kind_of(part) in ("number", "field") for part in parts):
            raise self.error(node, "a vector has two or three numbers or fields", "write vec3(x, y, z)")
        return parts

    def component(self, node: ast.Attribute):
        """One or more components of a vector, as ``.x`` or ``.xy``."""
        value = self.value(node.value)
        if kind_of(value) != "vector" or len(node.attr) > 3 or not set(node.attr) <= set("xyz"[: len(value)]):
            raise self.error(
                node,
                f".{node.attr:.40} is not part of a {kind_of(value)}",
                "only vectors have parts: .x, .y, .z, .xy and so on; functions are written function(shape, …)",
            )
        chosen = tuple(value["xyz".index(letter)] for letter in node.attr)
        return chosen if len(chosen) > 1 else chosen[0]


_VISITS = {
    ast.Constant: ValueEvaluator.constant,
    ast.Name: ValueEvaluator.name,
    ast.Call: ValueEvaluator.call,
    ast.BinOp: ValueEvaluator.binary,
    ast.UnaryOp: ValueEvaluator.unary,
    ast.Tuple: ValueEvaluator.vector,
    ast.Attribute: ValueEvaluator.component,
    ast.Compare: ValueEvaluator.comparison,
    ast.BoolOp: ValueEvaluator.logic,
    ast.IfExp: ValueEvaluator.selection,
}
