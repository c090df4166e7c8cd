# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Translation of one kernel: its names, lines and conversions; the other parts derive from it."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field

from .values import (
    CONSTANT,
    INT,
    SCALARS,
    UINT,
    ULONG,
    Ref,
    Tuple,
    Untranslatable,
    Value,
    constant_text,
    is_number,
    is_value,
    join,
    known,
    safe_name,
    type_of,
)


@dataclass
class Names:
    """The translation of a kernel, ``python``, for ``arguments``, into the GLSL function ``name``."""

    translator: object  # the Translator
    python: object
    name: str
    arguments: list[Value]
    lines: list[str] = field(default_factory=list)
    depth: int = 1

    def _lookup(self, name: str) -> Value:
        if name in self.locals:
            return self.locals[name]
        module = self.python.__globals__
        replaced = self.translator.constants.get((self.python.__module__, name))
        if replaced is not None:
            return known(replaced)
        if name in module:
            return known(module[name])
        builtins = module["__builtins__"]
        builtins = builtins if isinstance(builtins, dict) else vars(builtins)
        if name in builtins:
            return known(builtins[name])
        raise self._error(f"{name} has no value")

    def _error(self, text: str, node: ast.AST | None = None) -> Untranslatable:
        line = self.python.__code__.co_firstlineno + (node.lineno - 1 if node is not None else 0)
        return Untranslatable(f"{self.python.__module__}.{self.python.__name__}, line {line}: {text}")

    def temporary(self, kind, text: str) -> str:
        """Name of a new variable with the value ``text``."""
        name = f"tmp{self._count}"
        self._count += 1
        self.used[name] = kind
        self._say(f"{name} = {text};")
        return name

    def _set(self, name: str, value: Value) -> None:
        """Assign to a local variable."""
        if value.type == CONSTANT and not is_value(value.constant):
            self.locals[name] = value
            return
        value = self._value(value)
        kind = value.type
        if isinstance(kind, Ref) and kind.lvalue and "{}" not in kind.lvalue:
            self.locals[name] = value
            return
        text = safe_name(name)
        if isinstance(kind, Ref):
            text += "_at"
        else:
            kind = self.types[name] = join(self.types[name], kind) if name in self.types else kind
        self.used[text] = kind
        self._say(f"{text} = {self.converted(value, kind).text};")
        count = ""
        if value.count:
            count = text + "_count"
            self.used[count] = INT
            self._say(f"{count} = {value.count};")
        # Known values of a variable are valid only if nothing else sets it.
        once = self.stores.get(name, 0) == 1 and kind == value.type
        self.locals[name] = Value(kind, text, count=count, possible=value.possible if once else None)

    def _say(self, line: str) -> None:
        self.lines.append("    " * self.depth + line)

    # Values

    def _value(self, value: Value) -> Value:
        """The value with a GLSL type."""
        if value.type != CONSTANT:
            return value
        constant = value.constant
        if is_number(constant):
            kind = type_of(constant)
            possible = frozenset([int(constant)]) if kind == INT else None
            return Value(kind, constant_text(constant, kind), possible=possible)
        if isinstance(constant, tuple):
            return self._tuple([known(item) for item in constant])
        raise self._error(f"{constant!r} has no value in GLSL")

    def converted(self, value: Value, kind) -> Value:
        """The value as one of type ``kind``. Raises Untranslatable if that is impossible."""
        if value.type == CONSTANT:
            if is_number(value.constant) and kind in SCALARS:
                return Value(kind, constant_text(value.constant, kind))
            value = self._value(value)
        if value.type == kind:
            return value
        if isinstance(kind, Tuple) and isinstance(value.type, Tuple):
            items = value.items or [self._item(value, index) for index in range(len(kind.items))]
            return self._tuple([self.converted(item, part) for item, part in zip(items, kind.items, strict=True)], kind)
        if kind in SCALARS and value.type in SCALARS:
            return Value(kind, _converted(value.text, value.type, kind))
        raise self._error(f"{value.type} is not {kind}")

    def _tuple(self, items: list[Value], kind: Tuple | None = None) -> Value:
        items = [
            item
            if item.type == CONSTANT and not is_number(item.constant) and not isinstance(item.constant, tuple)
            else self._value(item)
            for item in items
        ]
        if any(item.type == CONSTANT or isinstance(item.type, Ref) for item in items):
            return Value(None, items=tuple(items))  # only used by its parts
        kind = kind or Tuple(tuple(item.type for item in items))
        text = f"{self.translator.glsl_type(kind)}({', '.join(item.text for item in items)})"
        return Value(kind, text, items=tuple(items))

    def _item(self, value: Value, index: int) -> Value:
        if value.items:
            return value.items[index]
        kind = value.type
        index = index if index >= 0 else len(kind.items) + index
        text = value.text if value.text.isidentifier() or value.text.endswith(")") else f"({value.text})"
        return Value(kind.items[index], f"{text}.{'xyzw'[index]}" if kind.vector else f"{text}.v{index}")

    def _expression(self, node: ast.expr) -> Value:
        method = getattr(self, "_read_" + type(node).__name__, None)
        if method is None:
            raise self._error(f"{type(node).__name__} has no GLSL version", node)
        return method(node)


def _converted(text: str, own: str, kind: str) -> str:
    """GLSL for a scalar of type ``own`` as one of another ``kind``."""
    if kind == ULONG:
        return f"word_64({text})"
    if own == ULONG:
        low = f"({text}).x"
        return {UINT: low, INT: f"int{low}"}.get(kind, f"{kind}_of_64({text})")
    return f"{kind}({text})"
