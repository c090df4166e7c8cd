# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Statements: control flow, and assignments to names, tuples and places."""

from __future__ import annotations

import ast
from dataclasses import replace

from ..layout import Record
from .calls import Calls
from .values import CONSTANT, INT, Ref, Untranslatable, Value, is_number, join, known


class Statements(Calls):
    """Translates statements."""

    def _block(self, statements: list[ast.stmt]) -> bool:
        """Translate statements. Returns True if the following ones are unreachable."""
        for statement in statements:
            method = getattr(self, "_do_" + type(statement).__name__, None)
            if method is None:
                raise self._error(f"{type(statement).__name__} has no GLSL version", statement)
            try:
                if method(statement):
                    return True
            except Untranslatable:
                raise
            except Exception as error:
                text = f"{type(error).__name__}: {error} in {ast.unparse(statement)[:120]!r}"
                raise self._error(text, statement) from error
        return False

    def _do_Expr(self, node: ast.Expr):
        if isinstance(node.value, ast.Constant):
            return
        value = self._expression(node.value)
        if value.text:
            self._say(value.text + ";")

    def _do_Pass(self, node):
        pass

    def _do_Return(self, node: ast.Return):
        if node.value is None:
            self.returned.add(None)
            self._say("return;")
            return True
        value = self._expression(node.value)
        self.returned.add(value.constant if value.type == CONSTANT and is_number(value.constant) else None)
        value = self._value(value)
        self.result = value.type if self.result is None else join(self.result, value.type)
        self._say(f"return {self.converted(value, self.result).text};")
        return True

    def _do_Break(self, node):
        self._say("break;")
        return True

    def _do_Continue(self, node):
        self._say("continue;")
        return True

    def _do_If(self, node: ast.If):
        test = self._condition(node.test)
        if test.type == CONSTANT:
            return self._block(node.body if test.constant else node.orelse)
        self._say(f"if ({test.text}) {{")
        before = dict(self.locals)
        first = self._nested(node.body)
        after_first, self.locals = self.locals, before if not node.orelse else dict(before)
        second = False
        if node.orelse:
            self._say("} else {")
            second = self._nested(node.orelse)
        self._say("}")
        if second:
            self.locals = after_first
        elif not first:
            for name, value in after_first.items():
                other = self.locals.setdefault(name, value)
                if other is not value and isinstance(value.type, Ref) and other.type != value.type:
                    self.locals[name] = known(f"{name}, which is a place of two kinds")
        return first and second

    def _nested(self, statements) -> bool:
        self.depth += 1
        over = self._block(statements)
        self.depth -= 1
        return over

    def _do_While(self, node: ast.While):
        test = self._condition(node.test)
        if test.type == CONSTANT and not test.constant:
            return
        self._say("while (true) {")
        self.depth += 1
        if test.type != CONSTANT:
            self._say(f"if (!({test.text})) {{ break; }}")
        self._block(node.body)
        self.depth -= 1
        self._say("}")

    def _do_For(self, node: ast.For):
        call = node.iter
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range"):
            raise self._error("for works only over a range", node)
        bounds = [self.converted(self._expression(argument), INT) for argument in call.args]
        start, end, step = "0", bounds[0].text, "1"
        if len(bounds) > 1:
            start, end = bounds[0].text, bounds[1].text
        if len(bounds) > 2:
            step = bounds[2].text
        if not end.lstrip("-").isdigit():
            end = self.temporary(INT, end)
        counter = f"loop{self._count}"
        self._count += 1
        down = step.startswith(("-", "(-"))
        self._say(f"for (int {counter} = {start}; {counter} {'>' if down else '<'} {end}; {counter} += {step}) {{")
        self.depth += 1
        if node.target.id != "_":
            self._set(node.target.id, Value(INT, counter))
        self._block(node.body)
        self.depth -= 1
        self._say("}")

    def _do_Assign(self, node: ast.Assign):
        value = self._expression(node.value)
        if len(node.targets) > 1:
            value = self._value(value)
            value = Value(value.type, self.temporary(value.type, value.text))
        for target in node.targets:
            self._assign(target, value)

    def _do_AugAssign(self, node: ast.AugAssign):
        target = ast.copy_location(ast.parse(ast.unparse(node.target), mode="eval").body, node.target)
        self._assign(
            node.target, self._operation(type(node.op).__name__, self._expression(target), self._expression(node.value))
        )

    def _assign(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            if target.id != "_":
                self._set(target.id, value)
            return
        if isinstance(target, ast.Tuple):
            self._unpack(target.elts, value)
            return
        place = self._place(target)
        if isinstance(place, Value) and not isinstance(place.type, Ref):
            self._say(f"{place.text} = {self.converted(self._value(value), place.type).text};")
            return
        if isinstance(value.type, Ref) and value.type == place.type and isinstance(place.type.layout, Record):
            row = place.type.lvalue
            if row:
                self._say(f"{row.replace('{}', place.text)} = {row.replace('{}', value.text)};")
                return
        raise self._error("this cannot be assigned to", target)

    def _unpack(self, targets: list[ast.expr], value: Value) -> None:
        if value.type == CONSTANT:
            parts = [known(part) for part in value.constant]
        elif value.items:
            # All values are computed before any name changes.
            parts = []
            for item in value.items:
                if item.type == CONSTANT or not item.text or (isinstance(item.type, Ref) and not item.text):
                    parts.append(item)
                else:
                    parts.append(replace(item, text=self.temporary(item.type, item.text)))
        else:
            text = self.temporary(value.type, value.text)
            parts = [self._item(Value(value.type, text), index) for index in range(len(targets))]
        for target, part in zip(targets, parts, strict=True):
            self._assign(target, part)
