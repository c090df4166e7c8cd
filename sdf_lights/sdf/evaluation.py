# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The walk over the syntax tree of an expression. Its result is a shape or, see ``emission``, a brightness.

Only a whitelist of the tree is walked: nothing is evaluated as Python. Every step of the walk counts, those of a loop
as often as it runs, and their number is limited; so is the size of shapes. So an expression cannot demand more than a
moment's work.
"""

from __future__ import annotations

import ast
import difflib
import itertools
import math
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np

from . import (  # noqa: F401 (the words of these modules are in FUNCTIONS then)
    builtin_colors,
    builtin_data,
    builtin_shapes,
    declarations,
    expression_values,
)
from ..graph import formula
from ..graph.formula import LONGEST_LOOP, POINT, Formula
from .functions import CONSTANTS, FUNCTIONS, as_shape
from .resolver import Resolver, Standing
from .shapes import Difference, Field, Intersection, Shape, ShapeError, Union
from .shapes.base import Parametric
from .syntax import DEEPEST, ExpressionError
from .expression_values import (
    Condition,
    Live,
    Misuse,
    NeedsNumber,
    Work,
    choose,
    compute,
    has_field,
    kind_of,
    lifted,
    live,
    spread,
)
from .builtin_numbers import modulo

MOST_PRIMITIVES = 2_000
DEEPEST_SHAPE = 100
MOST_FIELDS = 16  # in a shape: finding the limits of each takes time

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


class Evaluation:
    """One run through the statements, with the names known so far."""

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
        if isinstance(self.slots.resolver, Standing) and self.slots.resolver.asked:
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

    def step(self, node: ast.AST, count: int = 1) -> None:
        """Count work on the expression. Raises ExpressionError if it is too much."""
        try:
            self.slots.step(count)
        except Misuse as misuse:
            raise self.error(node, str(misuse), misuse.cure) from None

    def operate(self, node: ast.AST, count: int) -> None:
        """Count operations of a field. Raises ExpressionError if they are too many."""
        self.attempt(node, lambda: self.slots.operate(count))

    # -- statements ---------------------------------------------------------------------------------------------------

    def inner(self, statements: list[ast.stmt]) -> None:
        """Runs the statements of a block."""
        self.nesting += 1
        self.block(statements)
        self.nesting -= 1

    def block(self, statements: list[ast.stmt]) -> None:
        """Run statements, one after the other."""
        for statement in statements:
            self.step(statement)
            run = _STATEMENTS.get(type(statement))
            if run is None:
                raise self.error(
                    statement,
                    "this statement is not part of the language",
                    "write name = value, for name in range(count):, or a shape last",
                )
            run(self, statement)

    def no_effect(self, statement: ast.Expr) -> None:
        """Refuse a line that is a value and not the last one."""
        raise self.error(
            statement, "this line has no effect", "give its value a name, or combine it into the last line"
        )

    def misplaced_break(self, statement: ast.Break) -> None:
        """Refuse a break that does not belong to a loop."""
        raise self.error(
            statement,
            ("break is not allowed here"),
            "write if condition: break among the lines of the loop itself",
        )

    def new_name(self, target: ast.expr, statement: ast.stmt) -> str:
        """The name that a statement assigns to. Raises ExpressionError if it is no name, or already taken."""
        if not isinstance(target, ast.Name):
            raise self.error(statement, "only a name can be given a value", "write name = value")
        if target.id in declarations.USAGE or target.id == "range":
            raise self.error(statement, f"{target.id} already means something", "choose another name")
        return target.id

    def assign(self, statement: ast.Assign) -> None:
        """``name = value``, or the declaration of a parameter."""
        if len(statement.targets) != 1:
            raise self.error(statement, "a line gives one name a value", "write name = value")
        name = self.new_name(statement.targets[0], statement)
        call = statement.value
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id in declarations.USAGE:
            self.names[name] = self.declared(name, call.func.id, call)
        else:
            self.names[name] = self.value(call)

    def assign_in_place(self, statement: ast.AugAssign) -> None:
        """``a += b`` as ``a = a + b``."""
        name = self.new_name(statement.target, statement)
        old = ast.copy_location(ast.Name(name, ast.Load()), statement.target)
        self.names[name] = self.value(ast.copy_location(ast.BinOp(old, statement.op, statement.value), statement))

    def declared(self, name: str, kind: str, call: ast.Call):
        """The value of a parameter that is declared here."""
        if name in self.declarations:
            raise self.error(call, f"there already is a parameter {name}", "choose another name")
        if self.nesting:
            raise self.error(call, "a parameter cannot be declared in a block", "move the line to the top")
        # otherwise the limits, and with them the user interface, would change as sliders move
        for part in ast.walk(call):
            if isinstance(part, ast.Name) and self.names.get(part.id) is not CONSTANTS.get(part.id):
                raise self.error(
                    part,
                    f"the numbers of a parameter cannot depend on {part.id:.40}",
                    f"write {declarations.USAGE[kind]}",
                )
        if call.keywords:
            raise self.error(call, f"{kind} takes no named arguments", f"write {declarations.USAGE[kind]}")
        given = [self.value(argument) for argument in call.args]
        declared = self.attempt(
            call, lambda: declarations.declare(name, kind, given, self.remarks.get(call.lineno, ""))
        )
        self.declarations[name] = declared
        try:
            return declared.live(declared.held(self.given.get(name, declared.default)))
        except (TypeError, ValueError, OverflowError):
            raise self.error(
                call,
                f"the value given for {name} is not a {'vector' if kind == 'vector' else 'number'}",
                "set it to a number",
            ) from None

    def branch(self, statement: ast.If) -> None:
        """Both sides are computed. The condition chooses between their results, point by point if necessary."""
        condition = self.condition(statement.test)
        if type(condition.truth) is float:  # a constant condition
            self.inner(statement.body if condition.truth > 0.5 else statement.orelse)
            return
        before = dict(self.names)
        self.inner(statement.body)
        then, self.names = self.names, dict(before)
        self.inner(statement.orelse)
        otherwise, self.names = self.names, before
        for name in then:
            if name not in otherwise:
                continue  # it would have no value on one side
            self.names[name] = self.chosen(statement, condition, then[name], otherwise[name])

    def loop(self, statement: ast.For) -> None:
        """``for name in range(count)``: one node of the formula if the states allow it, else iteration by iteration."""
        index = self.new_name(statement.target, statement)
        if statement.orelse:
            raise self.error(statement.orelse[0], "a loop has no else", "leave it out")
        count = self.count(statement.iter)
        inside = [node for part in statement.body for node in ast.walk(part) if isinstance(node, ast.Name)]
        written = {node.id for node in inside if isinstance(node.ctx, ast.Store)}
        read = {node.id for node in inside if isinstance(node.ctx, ast.Load)} | {
            part.target.id
            for body in statement.body
            for part in ast.walk(body)
            if isinstance(part, ast.AugAssign) and isinstance(part.target, ast.Name)
        }
        carried = [name for name in self.names if name in written and name != index]
        outside = {name: self.names[name] for name in self.names if name in read | written}
        shapes = any(isinstance(outside[name], Parametric) for name in carried)
        state = dict(self.names), self.nesting, self.loops, self.slots.rounds
        if not shapes and any(map(has_field, outside.values())):
            try:
                self.iterated(statement, index if index in read else "", count, carried)
                return
            except NeedsNumber:  # it makes shapes from the states: then the loop is unrolled
                self.names, self.nesting, self.loops, self.slots.rounds = state
        self.unrolled(statement, index, count, carried)

    def count(self, node: ast.expr) -> float:
        """The number of iterations of a loop: at most a thousand for all values of parameters."""
        if not (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id == "range"
            and len(node.args) == 1
            and not node.keywords
        ):
            raise self.error(node, "a loop runs over a range", "write for name in range(count):")
        argument = node.args[0]
        count = self.value(argument)
        if not isinstance(count, float):
            raise self.error(argument, f"the number of rounds is a {kind_of(count)}", "give a whole number")
        greatest = count.greatest if isinstance(count, Live) else count
        if greatest == math.inf:
            raise self.error(
                argument,
                "the number of rounds has no greatest value",
                "give a whole number, or a parameter: count = integer(5, 1, 10)",
            )
        if not isinstance(count, Live) and count != math.floor(count):
            raise self.error(argument, f"{count:g} is not a whole number of rounds", "give a whole number")
        if greatest > LONGEST_LOOP:
            raise self.error(argument, f"a loop of {greatest:g} rounds is too long", f"use at most {LONGEST_LOOP}")
        return count

    def round(self, statements: list[ast.stmt], carried: list[str]) -> Condition:
        """Runs the statements of a loop once. Returns the condition under which one of its lines ``if …: break`` has
        ended it."""
        exits = []
        self.nesting += 1
        for part in statements:
            if isinstance(part, ast.If) and isinstance(part.body[-1], ast.Break) and not part.orelse:
                self.step(part)
                condition, names = self.condition(part.test), self.names
                self.names = dict(names)
                self.block(part.body[:-1])
                exits.append((part, condition, self.names))
                self.names = names
            else:
                self.block([part])
        self.nesting -= 1
        ended = Condition(0.0)
        for part, condition, names in reversed(exits):
            for name in carried:
                self.names[name] = self.chosen(part, condition, names[name], self.names[name])
            ended = self.chosen(part, condition, Condition(1.0), ended)
        return ended

    def unrolled(self, statement: ast.For, index: str, count: float, carried: list[str]) -> None:
        """Iterates one after another: for loops of numbers, and of shapes."""
        before = self.names
        carry = {name: before[name] for name in carried}
        follows = isinstance(count, Live)  # whether the results change with parameters through the number of iterations
        ended = Condition(0.0)
        for i in range(int(max(count, 0.0))):
            self.step(statement)
            self.names = before | carry | {index: float(i)}
            now = self.round(statement.body, carried)
            carry = {name: self.chosen(statement, ended, carry[name], self.names[name]) for name in carried}
            ended = self.chosen(statement, ended, Condition(1.0), now)
            follows = follows or isinstance(ended.truth, Live)
            if isinstance(ended.truth, float) and ended.truth > 0.5:
                break
        self.names = before | {name: live(value) if follows else value for name, value in carry.items()}

    def iterated(self, statement: ast.For, index: str, count: float, carried: list[str]) -> None:
        """The loop as a loop of the formula: for loops of fields."""
        limit = int(count.greatest if isinstance(count, Live) else count)
        if limit < 1:
            return
        before = self.names
        for name in carried:
            if kind_of(before[name]) not in ("number", "field", "vector"):
                raise self.error(
                    statement,
                    f"{name} is a {kind_of(before[name])}, which a loop cannot carry on",
                    "carry on numbers, fields, vectors or shapes",
                )
        sizes = [len(before[name]) if isinstance(before[name], tuple) else 0 for name in carried]
        breaks = any(isinstance(node, ast.Break) for part in statement.body for node in ast.walk(part))

        def flat(names: Mapping[str, object]) -> list:
            return [
                scalar for name in carried for scalar in expression_values.components(lifted(names[name], self.slots))
            ]

        def body(*states: Formula):
            self.names = dict(before)
            remaining = iter(states)
            for name, size in zip(carried, sizes):
                self.names[name] = tuple(itertools.islice(remaining, size)) if size else next(remaining)
            if index:
                self.names[index] = next(remaining)
            ended = self.round(statement.body, carried)
            for name, size in zip(carried, sizes):
                now = self.names[name]
                if isinstance(now, Parametric) or (len(now) if isinstance(now, tuple) else 0) != size:
                    raise self.error(
                        statement,
                        f"{name} is a {kind_of(before[name])} before the loop, and a {kind_of(now)} after a round",
                        "keep it of one kind, or choose another name",
                    )
            steps = flat(self.names)
            if index:
                steps.append(states[len(steps)] + 1.0)
            if not breaks:
                return tuple(steps), None
            steps.append(lifted(choose(self.slots, ended, 1.0, 0.0), self.slots))
            return tuple(steps), states[-1] < 0.5

        rounds = self.slots.rounds
        self.slots.rounds, self.loops = rounds * limit, self.loops + 1
        first = (*flat(before), *[0.0] * (bool(index) + breaks))
        results = iter(formula.iterate(lifted(count, self.slots), first, body, limit))
        self.names, self.slots.rounds, self.loops = before, rounds, self.loops - 1
        for name, size in zip(carried, sizes):
            self.names[name] = tuple(itertools.islice(results, size)) if size else next(results)

    # -- values -------------------------------------------------------------------------------------------------------

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


def _fields(shape: Shape) -> Iterator[Field]:
    """The parts of a shape that are fields."""
    if isinstance(shape, Field):
        yield shape
    for child in shape.children:
        yield from _fields(child)


_STATEMENTS = {
    ast.Assign: Evaluation.assign,
    ast.AugAssign: Evaluation.assign_in_place,
    ast.For: Evaluation.loop,
    ast.If: Evaluation.branch,
    ast.Expr: Evaluation.no_effect,
    ast.Break: Evaluation.misplaced_break,
}
_VISITS = {
    ast.Constant: Evaluation.constant,
    ast.Name: Evaluation.name,
    ast.Call: Evaluation.call,
    ast.BinOp: Evaluation.binary,
    ast.UnaryOp: Evaluation.unary,
    ast.Tuple: Evaluation.vector,
    ast.Attribute: Evaluation.component,
    ast.Compare: Evaluation.comparison,
    ast.BoolOp: Evaluation.logic,
    ast.IfExp: Evaluation.selection,
}
