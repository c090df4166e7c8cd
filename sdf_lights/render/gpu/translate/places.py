# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields and elements of records, tables and vectors: reading, and targets of assignments."""

from __future__ import annotations

import ast
from dataclasses import replace

from ..layout import Array, Record
from .names import Names
from .values import INT, VECTOR, Ref, Value, safe_name


class Places(Names):
    """Translates reads and writes of a kernel: names, fields, elements."""

    def _place(self, node: ast.expr) -> Value:
        """The target of a field or an element: a ``Ref``, or a scalar or vector whose text can be assigned to."""
        if isinstance(node, ast.Attribute):
            base = self._expression(node.value)
            return self._field(base, node.attr, node)
        base = self._expression(node.value)
        return self._element(base, node.slice, node)

    def _field(self, base: Value, name: str, node: ast.AST) -> Value:
        layout = base.type.layout
        if name not in layout.fields:
            raise self._error(f"there is no field {name}", node)
        offset, inner = layout.fields[name]
        if base.type.lvalue:
            lvalue = f"{base.type.lvalue}.{safe_name(name)}"
            if not isinstance(inner, Array):
                return Value(inner, lvalue.replace("{}", base.text))
            if inner.vector:
                return Value(Ref(inner, lvalue), base.text)
            if "{}" not in lvalue:
                return self.translator.tables.field(lvalue, inner)
            # For a table of several rows, the row is part of the address, which cannot be passed to other functions.
            return Value(Ref(inner, lvalue.replace("{}", base.text) + "[{}]"), "0")
        address = _sum(base.text, offset)
        if isinstance(inner, Array):
            return Value(Ref(inner, reader=base.type.reader), address)
        return Value(inner, _read(base.type, inner, address), possible=self.translator.tables.values(layout, name))

    def _element(self, base: Value, index: ast.expr, node: ast.AST) -> Value:
        layout = base.type.layout
        if isinstance(index, ast.Slice):
            start = self.converted(self._value(self._expression(index.lower)), INT).text if index.lower else "0"
            count = ""
            if index.upper is not None:
                count = f"({self.converted(self._value(self._expression(index.upper)), INT).text}) - ({start})"
            elif base.count:
                count = f"{base.count} - ({start})"
            return Value(base.type, f"{base.text} + {_times(start, layout.stride)}", count=count)
        parts = index.elts if isinstance(index, ast.Tuple) else [index]
        inner = layout
        indices = []
        for part in parts:
            indices.append(self.converted(self._value(self._expression(part)), INT).text)
        if layout.vector and base.type.lvalue:
            return Value(inner.element, f"{base.type.lvalue.replace('{}', base.text)}[{indices[0]}]")
        if base.type.lvalue and "{}" not in base.type.lvalue:
            return Value(Ref(inner.inner, base.type.lvalue))  # the only row
        address = base.text or "0"
        for text in indices:
            if not isinstance(inner, Array):
                raise self._error("too many indices", node)
            if inner.count != 1:
                address = _sum(address, _times(text, inner.stride))
            inner = inner.inner
        if isinstance(inner, (Array, Record)):
            return Value(replace(base.type, layout=inner), address)
        if base.type.lvalue:
            return Value(inner, base.type.lvalue.replace("{}", address))
        return Value(inner, _read(base.type, inner, address))

    def _as_vector(self, place: Value) -> Value:
        if place.type.lvalue:
            text = place.type.lvalue.replace("{}", place.text)
            if place.type.layout.vector:
                return Value(VECTOR, text)
            items = [place.type.lvalue.replace("{}", _sum(place.text, axis)) for axis in range(3)]
            return Value(VECTOR, f"vec3({', '.join(items)})")
        return Value(VECTOR, _read(place.type, "vector", place.text))


def _sum(a: str, b) -> str:
    if b in (0, "0"):
        return a
    return f"{a} + {b}" if a not in ("", "0") else str(b)


def _times(text: str, factor: int) -> str:
    if factor == 1:
        return text
    return str(int(text) * factor) if text.isdigit() else f"({text}) * {factor}"


def _read(place: Ref, kind: str, address: str) -> str:
    return f"{place.reader}{kind}_at({address})"
