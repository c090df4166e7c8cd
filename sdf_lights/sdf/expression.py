# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The artists' language: a few lines of text that say a shape.

    size = slider(1, 0.1, 3)          # a parameter: becomes a slider in Blender
    hole = sphere(1.35 * size)
    difference(box(size), hole) | torus(size * 1.6, 0.1)

Python's parser reads the text, and only a whitelist of its syntax tree is walked: nothing is evaluated as Python.
Before that, the text is held to few characters, a length and a nesting depth, so that the parser itself cannot be made
to labour; afterwards every value is a finite float, a vector of three or a ``Shape``, and shapes have a greatest size.
"""

from __future__ import annotations

import ast
import difflib
import itertools
import keyword
import math
import operator
import re
from collections.abc import Mapping
from typing import NamedTuple

from .functions import CONSTANTS, FUNCTIONS, Misuse, apply, kind_of
from .shapes import Difference, Intersection, Shape, ShapeError, Union

LONGEST = 10_000  # characters
DEEPEST = 50  # brackets inside one another
MOST_OPERATORS = 1_000  # in one statement; a chain of n is a tree n deep, and frees itself by recursion in CPython 3.13
MOST_POWERS = 100  # each is nested in the one before, and so takes of the parser's stack
MOST_PRIMITIVES = 2_000
DEEPEST_SHAPE = 100


class ExpressionError(Exception):
    """What is wrong in an expression, where, and how to put it right; ``str()`` says it in one sentence.

    ``line`` and ``column`` count from 1.
    """

    def __init__(self, message: str, line: int, column: int, cure: str):
        super().__init__(f"Line {line}, column {column}: {message}: {cure}.")
        self.message, self.line, self.column, self.cure = message, line, column, cure


class Slider(NamedTuple):
    """A parameter that an expression declares with ``name = slider(default, minimum, maximum)``."""

    name: str
    default: float
    minimum: float
    maximum: float


class Expression:
    """A checked expression: its ``sliders``, and its shape for any of their values."""

    def __init__(self, text: str):
        """Raises ``ExpressionError`` if the text does not say a shape."""
        self._tree = _parsed(text)
        evaluation = _Evaluation({})
        evaluation.run(self._tree)
        self.sliders: tuple[Slider, ...] = tuple(evaluation.sliders.values())

    def shape(self, values: Mapping[str, float] | None = None) -> Shape:
        """The shape with ``values`` of sliders by name in place of their defaults, held to the sliders' limits.

        Values of other names are ignored. Raises ``ExpressionError`` where these values do not make a shape.
        """
        return _Evaluation(values or {}).run(self._tree)


def evaluate(text: str, values: Mapping[str, float] | None = None) -> Shape:
    """The shape that the text says. Raises ``ExpressionError``."""
    return Expression(text).shape(values)


# -- before Python's parser -------------------------------------------------------------------------------------------

_OTHER_CHARACTER = re.compile(r"[^A-Za-z0-9_.,()+\-*/%=|& \t]")
_LONGEST_NUMBER = re.compile(r"\d{41}")
_SIGNS_IN_A_ROW = re.compile(r"([-+][ \t]*){10}")
_OPERATOR = re.compile(r"[-+*/%|&]|\.\s*[A-Za-z_]|\)\s*\(")
_WORD = re.compile(r"[A-Za-z_]\w*")
_CURES = {
    "[": "use ( ) instead", "]": "use ( ) instead", "{": "use ( ) instead", "}": "use ( ) instead",
    "'": "there is no text in expressions", '"': "there is no text in expressions",
    "^": "write ** for a power", ";": "write each statement on a line of its own",
    ":": "there are no blocks in expressions", "<": "there are no comparisons in expressions",
    ">": "there are no comparisons in expressions", "\\": "a line goes on by itself inside ( )"}


def _guard(lines: list[str]) -> None:
    """Refuses text that is not worth showing to the parser."""
    brackets = powers = 0
    statement = ""  # may go on over several lines, inside brackets
    for number, line in enumerate(lines, 1):
        for pattern, problem, cure in (
                (_OTHER_CHARACTER, "{!r} means nothing here", "use letters, digits, ( ) , . and + - * / % ** | & ="),
                (_LONGEST_NUMBER, "the number has too many digits", "write 1e9 for 10 to the 9th"),
                (_SIGNS_IN_A_ROW, "there are too many signs in a row", "use one")):
            found = pattern.search(line)
            if found:
                raise ExpressionError(
                    problem.format(found[0]), number, found.start() + 1, _CURES.get(found[0], cure))
        for word in _WORD.finditer(line):
            if keyword.iskeyword(word[0]):
                raise ExpressionError(f"{word[0]} is not part of the language", number, word.start() + 1,
                                      "write lines such as name = value, and a shape last")
        for column, character in enumerate(line, 1):
            brackets += (character == "(") - (character == ")")
            powers += line.startswith("**", column - 1)
            if brackets > DEEPEST:
                raise ExpressionError("the brackets are nested too deeply", number, column,
                                      f"use at most {DEEPEST} inside one another, and name parts on lines of their own")
            if powers > MOST_POWERS:
                raise ExpressionError("there are too many powers", number, column, f"use at most {MOST_POWERS}")
        statement += line + "\n"
        if brackets <= 0 or number == len(lines):
            if len(_OPERATOR.findall(statement)) > MOST_OPERATORS:
                raise ExpressionError("there are too many operators in one statement", number, 1,
                                      f"use at most {MOST_OPERATORS}, or union(a, b, …) with commas")
            statement = ""


def _parsed(text: str) -> ast.Module:
    if len(text) > LONGEST:
        raise ExpressionError(f"the expression has {len(text)} characters", 1, 1, f"use at most {LONGEST}")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    lines = [line.split("#", 1)[0] for line in text.split("\n")]
    _guard(lines)
    # There are no blocks, so how far a line is indented means nothing; but mistakes are reported where they stand.
    indents = [len(line) - len(line.lstrip()) for line in lines]
    try:
        tree = ast.parse("\n".join(map(str.lstrip, lines)))
    except SyntaxError as error:
        problem = re.sub(r"\W*(Perhaps|Maybe|Did) .*|\.$", "", error.msg or "invalid syntax")
        line = min(max(error.lineno or 1, 1), len(lines))
        raise ExpressionError(problem, line, max(error.offset or 1, 1) + indents[line - 1],
                              "look for a missing bracket, comma or operator just before") from None
    except (ValueError, RecursionError, MemoryError, OverflowError):
        raise ExpressionError("the expression is nested too deeply", 1, 1,
                              "name parts of it on lines of their own") from None
    if any(indents):
        for node in ast.walk(tree):
            if hasattr(node, "lineno"):
                node.col_offset += indents[node.lineno - 1]
    return tree


# -- the walk over the tree -------------------------------------------------------------------------------------------

_ARITHMETIC = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Mod: FUNCTIONS["mod"].call, ast.Pow: math.pow}
_COMBINATIONS = {ast.BitOr: Union, ast.BitAnd: Intersection, ast.Sub: Difference}
_SYMBOLS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Mod: "%", ast.Pow: "**", ast.BitOr: "|",
            ast.BitAnd: "&"}


class _Evaluation:
    """One run through the statements, with the names known so far."""

    def __init__(self, values: Mapping[str, float]):
        self.values = values
        self.names: dict[str, object] = dict(CONSTANTS)
        self.sliders: dict[str, Slider] = {}
        self.depth = 0

    def error(self, node: ast.AST, message: str, cure: str) -> ExpressionError:
        return ExpressionError(message, getattr(node, "lineno", 1), getattr(node, "col_offset", 0) + 1, cure)

    def run(self, tree: ast.Module) -> Shape:
        if not tree.body:
            raise ExpressionError("the expression is empty", 1, 1, "write a shape, for instance sphere(0.5)")
        for statement in tree.body[:-1]:
            self.assign(statement)
        last = tree.body[-1]
        if not isinstance(last, ast.Expr):
            self.assign(last)
            raise self.error(last, "the last line does not say what glows", "end with a line that is a shape")
        result = self.value(last.value)
        if not isinstance(result, Shape):
            raise self.error(last, f"the last line is a {kind_of(result)}", "end with a line that is a shape")
        return result

    def assign(self, statement: ast.stmt) -> None:
        if isinstance(statement, ast.Expr):
            raise self.error(statement, "this line has no effect",
                             "give its value a name, or combine it into the last line")
        if not (isinstance(statement, ast.Assign) and len(statement.targets) == 1
                and isinstance(statement.targets[0], ast.Name)):
            raise self.error(statement, "this statement is not part of the language", "write name = value, or a shape")
        name = statement.targets[0].id
        if name in FUNCTIONS or name in CONSTANTS or name == "slider":
            raise self.error(statement, f"{name} already means something", "choose another name")
        call = statement.value
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "slider":
            self.names[name] = self.slider(name, call)
        else:
            self.names[name] = self.value(call)

    def slider(self, name: str, call: ast.Call) -> float:
        cure = "write name = slider(default, minimum, maximum) with three numbers"
        if name in self.sliders:
            raise self.error(call, f"there already is a slider {name}", "choose another name")
        if call.keywords or len(call.args) != 3:
            raise self.error(call, "slider takes three numbers", cure)
        for part in ast.walk(call):  # or the limits, and with them the user interface, would change as sliders move
            if isinstance(part, ast.Name) and part.id in self.names and part.id not in CONSTANTS:
                raise self.error(part, f"the numbers of a slider cannot depend on {part.id:.40}", cure)
        numbers = [self.value(argument) for argument in call.args]
        if not all(isinstance(number, float) for number in numbers):
            raise self.error(call, "slider takes three numbers", cure)
        default, minimum, maximum = numbers
        if not minimum <= default <= maximum or minimum == maximum:
            raise self.error(call, f"the default {default:g} is not between {minimum:g} and {maximum:g}", cure)
        self.sliders[name] = Slider(name, *numbers)
        try:
            value = float(self.values.get(name, default))
        except (TypeError, ValueError, OverflowError):
            value = math.nan
        if math.isnan(value):
            raise self.error(call, f"the value given for {name} is not a number", "set it to a number")
        return min(max(value, minimum), maximum)

    def value(self, node: ast.expr):
        self.depth += 1
        try:
            if self.depth > 2 * DEEPEST:
                raise self.error(node, "the expression is nested too deeply", "name parts of it on lines of their own")
            visit = _VISITS.get(type(node))
            if visit is None:
                raise self.error(node, "this is not part of the language",
                                 "use numbers, names, calls, vectors and the operators + - * / % ** | &")
            return self.checked(node, visit(self, node))
        finally:
            self.depth -= 1

    def checked(self, node: ast.expr, value):
        if isinstance(value, Shape):
            if value.size > MOST_PRIMITIVES or value.depth > DEEPEST_SHAPE:
                raise self.error(node, "the shape has too many parts", f"use at most {MOST_PRIMITIVES} shapes, "
                                 f"and {DEEPEST_SHAPE} combinations inside one another")
            problem = value.check()
            if problem:
                message, _, cure = problem.rstrip(".").rpartition(": ")
                message, cure = (message, cure) if ": " in message else (problem.rstrip("."), "change the value")
                raise self.error(node, message, cure)
        elif not all(map(math.isfinite, value if isinstance(value, tuple) else (value,))):
            raise self.error(node, "the number is too large", "use smaller numbers")
        return value

    def constant(self, node: ast.Constant) -> float:
        if type(node.value) not in (int, float):
            raise self.error(node, f"{node.value!r:.40} is not a number of the language", "write a number such as 0.5")
        return self.attempt(node, lambda: float(node.value))

    def name(self, node: ast.Name):
        if node.id in self.names:
            return self.names[node.id]
        if node.id in FUNCTIONS:
            raise self.error(node, f"{node.id} needs brackets", f"write {FUNCTIONS[node.id].signature()}")
        raise self.unknown(node, FUNCTIONS | self.names)

    def unknown(self, node: ast.Name, known) -> ExpressionError:
        # Looking for what is alike takes time for each name, so not among thousands.
        close = difflib.get_close_matches(node.id[:40], itertools.islice(reversed(known), 200), 1)
        cure = f"did you mean {close[0]}" if close else "give it a value on a line above, or choose a known name"
        return self.error(node, f"{node.id:.40} is not a known name", cure)

    def call(self, node: ast.Call):
        if not isinstance(node.func, ast.Name):
            raise self.error(node, "only functions can be called", "write function(value, …)")
        if node.func.id == "slider":
            raise self.error(node, "slider has to stand alone", "write name = slider(default, minimum, maximum)")
        function = FUNCTIONS.get(node.func.id)
        if function is None:
            if node.func.id in self.names:
                raise self.error(node, f"{node.func.id} is a value, not a function", "leave out the brackets after it")
            raise self.unknown(node.func, FUNCTIONS)
        positional = [self.value(argument) for argument in node.args]
        named = {}
        for keyword in node.keywords:
            if keyword.arg is None:
                raise self.error(node, "** is not part of a call", "name the arguments")
            named[keyword.arg] = self.value(keyword.value)
        self.limit(node, [*positional, *named.values()])
        return self.attempt(node, lambda: function(positional, named))

    def limit(self, node: ast.expr, values: list) -> None:
        """Refuses to combine shapes that are too large together, before that takes time."""
        if sum(value.size for value in values if isinstance(value, Shape)) > MOST_PRIMITIVES:
            raise self.error(node, "the shape has too many parts", f"use at most {MOST_PRIMITIVES} shapes")

    def attempt(self, node: ast.expr, compute):
        try:
            return compute()
        except Misuse as misuse:
            raise self.error(node, str(misuse), misuse.cure) from None
        except ShapeError as error:
            raise self.error(node, str(error).rstrip("."), "give it numbers") from None
        except ZeroDivisionError:
            raise self.error(node, "division by zero", "divide by another number") from None
        except (ValueError, OverflowError):
            raise self.error(node, "the value is undefined or too large", "use other numbers") from None

    def binary(self, node: ast.BinOp):
        # The tree of a long chain a + b + c + … leans to the left: walked down its spine, it needs no recursion.
        spine = [node]
        while isinstance(spine[-1].left, ast.BinOp):
            spine.append(spine[-1].left)
        result = self.value(spine[-1].left)
        for part in reversed(spine):
            result = self.checked(part, self.operation(part, result, self.value(part.right)))
        return result

    def operation(self, node: ast.BinOp, left, right):
        kind = type(node.op)
        if isinstance(left, Shape) and isinstance(right, Shape) and kind in _COMBINATIONS:
            self.limit(node, [left, right])
            return _COMBINATIONS[kind](left, right)
        if isinstance(left, Shape) or isinstance(right, Shape) or kind not in _ARITHMETIC:
            symbol = _SYMBOLS.get(kind, "this operator")
            raise self.error(node, f"{symbol} does not work between a {kind_of(left)} and a {kind_of(right)}",
                             "use | & - between shapes, and + - * / % ** between numbers and vectors")
        return self.attempt(node, lambda: apply(_ARITHMETIC[kind], left, right))

    def unary(self, node: ast.UnaryOp):
        value = self.value(node.operand)
        if isinstance(value, Shape) or not isinstance(node.op, (ast.USub, ast.UAdd)):
            raise self.error(node, f"this sign does not work before a {kind_of(value)}", "use - and + before numbers")
        return apply(operator.neg, value) if isinstance(node.op, ast.USub) else value

    def vector(self, node: ast.Tuple):
        components = [self.value(element) for element in node.elts]
        if len(components) != 3 or not all(isinstance(component, float) for component in components):
            raise self.error(node, "a vector has three numbers", "write vec3(x, y, z)")
        return tuple(components)

    def component(self, node: ast.Attribute) -> float:
        value = self.value(node.value)
        if not isinstance(value, tuple) or node.attr not in ("x", "y", "z"):
            raise self.error(node, f".{node.attr:.40} is not part of a {kind_of(value)}",
                             "only vectors have parts: .x, .y and .z; functions are written function(shape, …)")
        return value["xyz".index(node.attr)]


_VISITS = {
    ast.Constant: _Evaluation.constant, ast.Name: _Evaluation.name, ast.Call: _Evaluation.call,
    ast.BinOp: _Evaluation.binary, ast.UnaryOp: _Evaluation.unary, ast.Tuple: _Evaluation.vector,
    ast.Attribute: _Evaluation.component}
