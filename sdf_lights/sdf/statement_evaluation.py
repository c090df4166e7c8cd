# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Statements of the expression language: assignments, parameters, conditions and loops."""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Mapping

from ..graph.formula import Formula
from ..graph.loops import LONGEST_LOOP, iterate
from . import declarations, expression_values
from .expression_values import Condition, Live, NeedsNumber, choose, has_field, kind_of, lifted, live
from .functions import CONSTANTS
from .shapes.base import Parametric
from .value_evaluation import ValueEvaluator


class StatementEvaluator(ValueEvaluator):
    """Runs statements, one after the other."""

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
        results = iter(iterate(lifted(count, self.slots), first, body, limit))
        self.names, self.slots.rounds, self.loops = before, rounds, self.loops - 1
        for name, size in zip(carried, sizes):
            self.names[name] = tuple(itertools.islice(results, size)) if size else next(results)


_STATEMENTS = {
    ast.Assign: StatementEvaluator.assign,
    ast.AugAssign: StatementEvaluator.assign_in_place,
    ast.For: StatementEvaluator.loop,
    ast.If: StatementEvaluator.branch,
    ast.Expr: StatementEvaluator.no_effect,
    ast.Break: StatementEvaluator.misplaced_break,
}
