# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of a block as 32-bit words of one buffer, and what the translator has to know of them.

A record lies in the buffer field by field, each number in a word: floats as float32, integers as int32. A shader finds
a table by where it starts and how many rows it has, which are in the uniform block ``scene``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

MOST_VALUES = 32  # different values of a field that are worth knowing


@dataclass(frozen=True)
class Array:
    """Elements one after the other; ``inner`` is the type of each: a scalar's name, a ``Record``, an ``Array``."""

    inner: object
    count: int = 0  # 0: not known
    packed: bool = False  # a GLSL array or vector of its own, not in the buffer

    @property
    def stride(self) -> int:
        return 1 if isinstance(self.inner, str) or (self.packed and isinstance(self.inner, Record)) else self.inner.size

    @property
    def size(self) -> int:
        return self.count * self.stride

    @property
    def vector(self) -> bool:
        """Whether it is a vec3 in a structure of GLSL."""
        return self.packed and self.count == 3 and self.inner == "float"

    @property
    def element(self) -> str:
        return self.inner


@dataclass(frozen=True)
class Record:
    """Layout of a NumPy record. ``packed``: as a structure of GLSL, not in the buffer."""

    name: str
    dtype: np.dtype
    packed: bool = False

    def __hash__(self):
        return hash((self.name, self.packed))

    @cached_property
    def fields(self) -> dict[str, tuple[int, object]]:
        """Offset in words and layout of each field."""
        found, offset = {}, 0
        for name in self.dtype.names:
            inner = layout_of(self.dtype[name], f"{self.name}.{name}", self.packed)
            found[name] = offset, inner
            offset += 1 if isinstance(inner, str) else inner.size
        return found

    @cached_property
    def size(self) -> int:
        return sum(1 if isinstance(inner, str) else inner.size for _, inner in self.fields.values())


def scalar_of(dtype: np.dtype) -> str:
    return "float" if dtype.kind == "f" else "uint" if dtype == np.uint32 else "int"


def layout_of(dtype: np.dtype, name: str, packed: bool = False):
    """Layout of a table's element, or of a field."""
    if dtype.subdtype is not None:
        base, shape = dtype.subdtype
        inner = layout_of(base, name, packed)
        for count in reversed(shape):
            inner = Array(inner, count, packed)
        return inner
    return Record(name, dtype, packed) if dtype.names else scalar_of(dtype)


def words_of(array: np.ndarray) -> np.ndarray:
    """(rows, words of a record) uint32 of a table."""
    rows = len(array)
    if array.dtype.names:
        parts = [words_of(np.ascontiguousarray(array[name])) for name in array.dtype.names]
        return np.concatenate(parts, axis=1) if parts else np.zeros((rows, 0), np.uint32)
    flat = array.reshape(rows, int(np.prod(array.shape[1:])))
    if array.dtype.kind == "f":
        with np.errstate(over="ignore"):
            return flat.astype(np.float32).view(np.uint32)
    if array.dtype == np.uint32:
        return flat
    # Addresses of the CPU's memory are integers, too; nothing reads them here.
    return flat.astype(np.int64).astype(np.int32).view(np.uint32)


class Tables:
    """The tables of a scene, for the translator and for the GPU.

    ``tables`` are those of the block, ``scalars`` its numbers; ``settled`` names scalars that programs are made for.
    ``workspace`` maps names to (dtype, count) of what each thread has.
    """

    def __init__(self, tables: dict[str, np.ndarray], scalars: dict[str, float], settled: frozenset[str],
                 workspace: dict[str, tuple[np.dtype, int]]):
        self._tables, self._scalars, self._settled, self._workspace = tables, scalars, settled, workspace
        self.used_scalars: dict[str, str] = {}
        self._values: dict[tuple[str, str], frozenset | None] = {}

    # For the translator

    def scalar(self, name: str):
        from .translate import Value, known

        number = self._scalars[name]
        if name in self._settled:
            return known(number)
        kind = "float" if isinstance(number, (float, np.floating)) else "int"
        self.used_scalars[name] = kind
        return Value(kind, f"scene.{name}")

    def table(self, name: str, dtype, base):
        """The table of a block, of a workspace, or of a record that points at one."""
        from .translate import ASIDE, BLOCK, CONSTANT, Ref, Value, known

        dtype = np.dtype(dtype)
        if base.type != CONSTANT:  # the record holds the first word
            offset, _ = base.type.layout.fields[name + "_address"]
            self.used_scalars[name + "_start"] = "int"
            return Value(Ref(Array(layout_of(dtype, name))), f"scene.{name}_start + int_at({base.text} + {offset})")
        if base.constant is not BLOCK:
            if name == "aside":
                return known(ASIDE)
            if name not in self._workspace:
                return known(None)
            dtype, count = self._workspace[name]
            inner = layout_of(dtype, name, packed=True)
            name = base.constant.prefix + name
            if count == 1 and isinstance(inner, Record):
                return Value(Ref(Array(inner, 1, packed=True), name + "_row"))
            return Value(Ref(Array(inner, count, packed=True), name + "_rows[{}]"), "0", count=str(count))
        self.used_scalars[name + "_start"] = self.used_scalars[name + "_rows"] = "int"
        rows = f"scene.{name}_rows"
        if not len(self._tables[name]):
            rows = "0"
        return Value(Ref(Array(layout_of(dtype, name))), f"scene.{name}_start", count=rows)

    def values(self, layout: Record, name: str) -> frozenset | None:
        """Values that an integer field of a table has in this scene, if they are few."""
        if layout.packed or layout.name not in self._tables:
            return None
        key = layout.name, name
        if key not in self._values:
            column = self._tables[layout.name][name]
            found = None
            if column.dtype.kind in "iu" and column.ndim == 1 and len(column):
                different = np.unique(column)
                if len(different) <= MOST_VALUES:
                    found = frozenset(different.tolist())
            self._values[key] = found
        return self._values[key]

    # For the GPU

    def workspace_source(self, aside: bool) -> str:
        """Structures and global variables of the workspace, and a function that clears what is not an array."""
        from .translate import safe_name

        lines, cleared = [], []
        for name, (dtype, count) in self._workspace.items():
            inner = layout_of(dtype, name, packed=True)
            kind = inner
            if isinstance(inner, Record):
                kind = "Record_" + name
                lines.append(f"struct {kind} {{ {' '.join(_member(*item) for item in inner.fields.items())} }};")
            for prefix in ("", "aside_") if aside else ("",):
                single = count == 1 and isinstance(inner, Record)
                lines.append(f"{kind} {prefix}{name}{'_row' if single else f'_rows[{count}]'};")
                if single:
                    cleared += [f"    {prefix}{name}_row.{safe_name(field)} = {scalar}(0);"
                                for field, (_, scalar) in inner.fields.items() if isinstance(scalar, str)]
        lines += ["void clear_workspace()", "{", *cleared, "}"]
        return "\n".join(lines) + "\n"

    def pack(self) -> tuple[np.ndarray, dict[str, int]]:
        """All tables in one array of words, and where each starts and how many rows it has."""
        parts, numbers, used = [], {}, 0
        for name, array in self._tables.items():
            words = words_of(array)
            numbers[name + "_start"], numbers[name + "_rows"] = used, len(array)
            parts.append(words.ravel())
            used += words.size
        return np.concatenate(parts), numbers


def _member(name: str, field: tuple) -> str:
    from .translate import safe_name

    _, inner = field
    name = safe_name(name)
    if isinstance(inner, str):
        return f"{inner} {name};"
    if inner.vector:
        return f"vec3 {name};"
    kind = inner
    while not isinstance(kind, str):
        kind = kind.inner
    return f"{kind} {name}[{inner.size}];"
