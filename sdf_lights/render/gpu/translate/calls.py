# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls: of other kernels, of natives, and of functions of Python, NumPy and ``vec``."""

from __future__ import annotations

import ast
import inspect
from dataclasses import replace

import numpy as np

from .expressions import Expressions
from .values import (
    BOOL,
    CONSTANT,
    FLOAT,
    INT,
    UINT,
    ULONG,
    VECTOR,
    Native,
    Ref,
    Untranslatable,
    Value,
    is_number,
    join,
    known,
)


class Calls(Expressions):
    """Translates calls: of kernels, of natives, of built-in functions."""

    def _read_Call(self, node):
        function = self._expression(node.func)
        if function.type != CONSTANT:
            raise self._error("the called function is unknown", node)
        arguments = [self._expression(argument) for argument in node.args]
        called = function.constant
        native = self.translator.natives.get(inspect.unwrap(called) if callable(called) else called)
        if isinstance(native, Native):
            return self._native(native, arguments)
        if native is not None:
            called = native
        name = getattr(called, "table_name", None)
        if name is not None:
            return self.translator.tables.table(name, called.table_dtype, arguments[0])
        if hasattr(called, "__wrapped__"):
            if inspect.unwrap(called).__module__.rpartition(".")[2] == "vec":
                vector = self._vector(inspect.unwrap(called).__name__, arguments)
                if vector is not None:
                    return vector
            name, result = self.translator.function(called, arguments)
            if result.type == CONSTANT:
                return result
            return replace(result, text=f"{name}({', '.join(self.passed(arguments))})")
        return self._builtin(called, arguments, node)

    def passed(self, arguments: list[Value]) -> list[str]:
        """GLSL of the arguments of a call; arguments known at translation time are left out."""
        texts = []
        for argument in arguments:
            if argument.type == CONSTANT:
                if not is_number(argument.constant):
                    continue
                argument = self._value(argument)
            if isinstance(argument.type, Ref) and argument.type.lvalue and "{}" not in argument.type.lvalue:
                continue
            texts.append(argument.text)
            if argument.count:
                texts.append(argument.count)
        return texts

    def _native(self, native: Native, arguments: list[Value]) -> Value:
        if callable(native.name):
            return native.name(self, arguments)
        texts = self.passed([replace(argument, count="") for argument in arguments])
        return Value(native.result, f"{native.name}({', '.join(texts)})")

    def _vector(self, name: str, arguments: list[Value]) -> Value | None:
        """GLSL operators for the functions of ``vec`` on vectors."""
        if name == "vec" and isinstance(arguments[0].type, Ref):
            return self._as_vector(arguments[0])
        if name not in _VECTOR_TEXTS:
            return None
        arguments = [self._value(argument) for argument in arguments]
        if not all(argument.type in (VECTOR, FLOAT, INT) for argument in arguments):
            return None
        template, kind = _VECTOR_TEXTS[name]
        texts = [
            argument.text if argument.type == VECTOR else self.converted(argument, FLOAT).text for argument in arguments
        ]
        return Value(kind, template.format(*texts))

    def _builtin(self, called, arguments: list[Value], node: ast.Call) -> Value:
        if called is len:
            return Value(INT, f"({arguments[0].count})")
        if called in (min, max):
            return self._extremum(called, arguments)
        if called is np.uint64:
            if arguments[0].type == CONSTANT:
                return known(np.uint64(arguments[0].constant))
            return self.converted(arguments[0], ULONG)
        if called in (int, np.int64, np.int32):
            if arguments[0].type == CONSTANT:
                return known(int(arguments[0].constant))
            return self.converted(arguments[0], INT)
        if called is np.uint32:
            return self.converted(arguments[0], UINT)
        if called in (float, np.float64, np.float32):
            return self.converted(arguments[0], FLOAT)
        if called is bool:
            return self._condition(node.args[0])
        if called is abs:
            value = self._value(arguments[0])
            return Value(value.type, f"abs({value.text})")
        name = getattr(called, "__name__", str(called))
        if name not in _FUNCTIONS:
            raise self._error(f"{name} has no GLSL version", node)
        if all(argument.type == CONSTANT for argument in arguments):
            return known(called(*(argument.constant for argument in arguments)))
        texts = [self.converted(argument, FLOAT).text for argument in arguments]
        template, kind = _FUNCTIONS[name]
        return Value(kind, template.format(*texts))

    def _extremum(self, called, arguments: list[Value]) -> Value:
        if all(argument.type == CONSTANT for argument in arguments):
            return known(called(*(argument.constant for argument in arguments)))
        arguments = [self._value(argument) for argument in arguments]
        kind = arguments[0].type
        for argument in arguments[1:]:
            kind = join(kind, argument.type)
        if kind == ULONG:
            raise Untranslatable(f"{called.__name__} of 64 bits has no GLSL version")
        texts = [self.converted(argument, kind).text for argument in arguments]
        text = texts[0]
        for other in texts[1:]:
            text = f"{called.__name__}({text}, {other})"
        return Value(kind, text)


_VECTOR_TEXTS = {
    "add": ("({} + {})", VECTOR),
    "sub": ("({} - {})", VECTOR),
    "mul": ("({} * {})", VECTOR),
    "scale": ("({} * {})", VECTOR),
    "madd": ("({} + {} * {})", VECTOR),
    "negate": ("(-{})", VECTOR),
    "dot": ("dot({}, {})", FLOAT),
    "cross": ("cross({}, {})", VECTOR),
    "length": ("length({})", FLOAT),
}

_FUNCTIONS = {
    "sqrt": ("sqrt({})", FLOAT),
    "sin": ("sin({})", FLOAT),
    "cos": ("cos({})", FLOAT),
    "tan": ("tan({})", FLOAT),
    "exp": ("exp({})", FLOAT),
    "log": ("log({})", FLOAT),
    "acos": ("angle_acos({})", FLOAT),
    "asin": ("angle_asin({})", FLOAT),
    "atan": ("angle_atan({})", FLOAT),
    "atan2": ("angle_atan2({}, {})", FLOAT),
    "hypot": ("length(vec2({}, {}))", FLOAT),
    "copysign": ("copy_sign({}, {})", FLOAT),
    "isnan": ("isnan({})", BOOL),
    "isfinite": ("is_finite({})", BOOL),
    "floor": ("floor({})", FLOAT),
    "ceil": ("ceil({})", FLOAT),
}
