# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions except calls. Values known at translation time are computed then, and so are comparisons with one
possible outcome."""

from __future__ import annotations

import ast
import types

from .places import Places
from .values import BLOCK, BOOL, CONSTANT, FLOAT, INT, UINT, ULONG, Ref, Scope, Value, is_number, join, known


class Expressions(Places):
    """Translates expressions."""

    def _read_Constant(self, node):
        return known(node.value)

    def _read_Name(self, node):
        return self._lookup(node.id)

    def _read_Tuple(self, node):
        return self._tuple([self._expression(item) for item in node.elts])

    def _read_Attribute(self, node):
        base = self._expression(node.value)
        if base.type != CONSTANT:
            return self._field(base, node.attr, node)
        if base.constant is BLOCK:
            return self.translator.tables.scalar(node.attr)
        if isinstance(base.constant, types.ModuleType):
            replaced = self.translator.constants.get((base.constant.__name__, node.attr))
            if replaced is not None:
                return known(replaced)
        return known(getattr(base.constant, node.attr))

    def _read_Subscript(self, node):
        base = self._expression(node.value)
        if base.type == CONSTANT:
            index = self._expression(node.slice)
            if isinstance(base.constant, Scope):
                return base
            if index.type == CONSTANT:
                return known(base.constant[index.constant])
            table = self.translator.tables.constant(base.constant)
            if table is not None:
                return self._element(table, node.slice, node)
            return Value(FLOAT, f"({self._value(base).text})[{index.text}]")
        if isinstance(base.type, Ref):
            return self._element(base, node.slice, node)
        index = self._expression(node.slice)
        if index.type == CONSTANT:
            return self._item(base, index.constant)
        return Value(FLOAT, f"{base.text}[{self.converted(index, INT).text}]")

    def _read_UnaryOp(self, node):
        if isinstance(node.op, ast.Not):
            value = self._condition(node.operand)
            return known(not value.constant) if value.type == CONSTANT else Value(BOOL, f"!{value.text}")
        value = self._expression(node.operand)
        if value.type == CONSTANT:
            number = value.constant
            changed = (
                -number if isinstance(node.op, ast.USub) else ~number if isinstance(node.op, ast.Invert) else number
            )
            return known(changed)
        if value.type == BOOL:
            value = self.converted(value, INT)
        return Value(value.type, f"({'-' if isinstance(node.op, ast.USub) else '~'}{value.text})")

    def _read_BinOp(self, node):
        return self._operation(type(node.op).__name__, self._expression(node.left), self._expression(node.right))

    def _operation(self, name: str, a: Value, b: Value) -> Value:
        if a.type == CONSTANT and b.type == CONSTANT:
            return known(PYTHON[name](a.constant, b.constant))
        a, b = self._value(a), self._value(b)
        kind = join(a.type, b.type)
        if name == "Pow":
            return self._power(a, b)
        if name == "Div":
            kind = FLOAT
        if kind == BOOL:
            kind = INT
        if name in ("LShift", "RShift"):
            kind = a.type if a.type != BOOL else INT
            if kind == ULONG:
                return Value(ULONG, f"{OF_64_BITS[name]}({a.text}, {self.converted(b, INT).text})")
            return Value(kind, f"({self.converted(a, kind).text} {SYMBOLS[name]} {b.text})")
        if name == "BitAnd" and kind == INT:
            for value, mask in ((a, b), (b, a)):
                if value.possible is not None and mask.possible is not None and len(mask.possible) == 1:
                    found = frozenset(number & next(iter(mask.possible)) for number in value.possible)
                    if len(found) == 1:
                        return known(next(iter(found)))
        left, right = self.converted(a, kind).text, self.converted(b, kind).text
        if kind == ULONG and not name.startswith("Bit"):
            if name not in OF_64_BITS:
                raise self._error(f"{name} of 64 bits has no GLSL version")
            return Value(ULONG, f"{OF_64_BITS[name]}({left}, {right})")
        if name == "Mod":
            if kind == FLOAT:
                return Value(FLOAT, f"mod({left}, {right})")
            return Value(kind, f"modulo({left}, {right})")
        return Value(kind, f"({left} {SYMBOLS[name]} {right})")

    def _power(self, a: Value, b: Value) -> Value:
        base = self.converted(a, FLOAT).text
        if b.text in ("2", "2.0"):
            return Value(FLOAT, f"square({base})")
        if b.text in ("3", "3.0"):
            return Value(FLOAT, f"cube({base})")
        return Value(FLOAT, f"pow({base}, {self.converted(b, FLOAT).text})")

    def _condition(self, node: ast.expr) -> Value:
        """An expression as a boolean."""
        value = self._expression(node)
        if value.type == CONSTANT:
            return known(bool(value.constant))
        if value.type == BOOL:
            return value
        if value.possible is not None and (0 not in value.possible or value.possible == {0}):
            return known(0 not in value.possible)
        zero = {INT: "0", UINT: "0u", ULONG: "uvec2(0u)", FLOAT: "0.0"}[value.type]
        return Value(BOOL, f"({value.text} != {zero})")

    def _read_BoolOp(self, node):
        every = isinstance(node.op, ast.And)
        parts = []
        for operand in node.values:
            value = self._condition(operand)
            if value.type == CONSTANT:
                if value.constant != every:
                    if not parts:
                        return known(not every)
                    parts.append("false" if every else "true")
                    break
                continue
            parts.append(value.text)
        if not parts:
            return known(every)
        return Value(BOOL, parts[0] if len(parts) == 1 else f"({(' && ' if every else ' || ').join(parts)})")

    def _read_Compare(self, node):
        values = [self._expression(operand) for operand in (node.left, *node.comparators)]
        parts = []
        for operator, a, b in zip(node.ops, values, values[1:]):
            name = type(operator).__name__
            if name in ("Is", "IsNot"):
                both = a.type == CONSTANT and b.type == CONSTANT and a.constant is b.constant
                parts.append(known(both == (name == "Is")))
            else:
                parts.append(self._compare(name, a, b))
        if all(part.type == CONSTANT for part in parts):
            return known(all(part.constant for part in parts))
        if any(part.type == CONSTANT and not part.constant for part in parts):
            return known(False)
        texts = [part.text for part in parts if part.type != CONSTANT]
        return Value(BOOL, texts[0] if len(texts) == 1 else f"({' && '.join(texts)})")

    def _compare(self, name: str, a: Value, b: Value) -> Value:
        if a.type == CONSTANT and b.type == CONSTANT:
            return known(PYTHON[name](a.constant, b.constant))
        if (
            CONSTANT in (a.type, b.type)
            and (a.constant is None) != (b.constant is None)
            and not (is_number(a.constant) or is_number(b.constant) or isinstance(a.constant or b.constant, tuple))
        ):
            return known(name == "NotEq")
        a, b = self._value(a), self._value(b)
        if a.possible is not None and b.possible is not None:
            outcomes = {bool(PYTHON[name](x, y)) for x in a.possible for y in b.possible}
            if len(outcomes) == 1:
                return known(outcomes.pop())
        kind = join(a.type, b.type)
        if kind == ULONG and name not in ("Eq", "NotEq"):
            raise self._error(f"{name} of 64 bits has no GLSL version")
        return Value(BOOL, f"({self.converted(a, kind).text} {SYMBOLS[name]} {self.converted(b, kind).text})")

    def _read_IfExp(self, node):
        test = self._condition(node.test)
        if test.type == CONSTANT:
            return self._expression(node.body if test.constant else node.orelse)
        a, b = self._expression(node.body), self._expression(node.orelse)
        if a.type == CONSTANT and b.type == CONSTANT and is_number(a.constant) and is_number(b.constant):
            possible = (
                frozenset([a.constant, b.constant])
                if isinstance(a.constant, int) and isinstance(b.constant, int)
                else None
            )
        else:
            possible = None
        a, b = self._value(a), self._value(b)
        kind = join(a.type, b.type)
        if isinstance(kind, Ref):
            return Value(kind, f"({test.text} ? {a.text} : {b.text})")
        return Value(
            kind, f"({test.text} ? {self.converted(a, kind).text} : {self.converted(b, kind).text})", possible=possible
        )


OF_64_BITS = {"Add": "add_64", "Mult": "multiply_64", "LShift": "shift_left_64", "RShift": "shift_right_64"}

SYMBOLS = {
    "Add": "+",
    "Sub": "-",
    "Mult": "*",
    "Div": "/",
    "FloorDiv": "/",
    "BitAnd": "&",
    "BitOr": "|",
    "BitXor": "^",
    "LShift": "<<",
    "RShift": ">>",
    "Lt": "<",
    "LtE": "<=",
    "Gt": ">",
    "GtE": ">=",
    "Eq": "==",
    "NotEq": "!=",
}

PYTHON = {
    "Add": lambda a, b: a + b,
    "Sub": lambda a, b: a - b,
    "Mult": lambda a, b: a * b,
    "Div": lambda a, b: a / b,
    "FloorDiv": lambda a, b: a // b,
    "Mod": lambda a, b: a % b,
    "Pow": lambda a, b: a**b,
    "BitAnd": lambda a, b: a & b,
    "BitOr": lambda a, b: a | b,
    "BitXor": lambda a, b: a ^ b,
    "LShift": lambda a, b: a << b,
    "RShift": lambda a, b: a >> b,
    "Lt": lambda a, b: a < b,
    "LtE": lambda a, b: a <= b,
    "Gt": lambda a, b: a > b,
    "GtE": lambda a, b: a >= b,
    "Eq": lambda a, b: a == b,
    "NotEq": lambda a, b: a != b,
}
