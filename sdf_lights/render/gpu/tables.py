# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of a block as 32-bit words of a buffer, and their description for the translator.

A record is stored in the buffer field by field, one number per word: floats as float32, integers as int32. The uniform
block ``scene`` has the start and the number of rows of each table. Small tables (the camera, lamps, materials) are in
the uniform block themselves; those with one record are at constant positions. Values that all threads read together are
fastest there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .layout import Array, Record, layout_of, size_of, words_of
from .streamed import StreamedTables, reader_source
from .thread_arrays import ThreadArrays
from .translate.values import BLOCK, CONSTANT, SECONDARY, Ref, Value, known, safe_name

MOST_VALUES = 32  # maximum number of distinct values of a field that are recorded
NEAR = "near_"  # prefix of the functions that read tables in the uniform block
SECOND = "second_"  # the same for tables that do not fit into the buffer
NEAR_WORDS = 3072  # of all of them: OpenGL guarantees 4096
SECOND_BINDING = 4
SMALL = 256  # maximum words of such a table
LARGE = frozenset({"lamp_boxes", "lamp_parts"})  # tables that all threads read from end to end: there if they fit
PLACED = "lamp_parameters"  # the same, with their position as a constant of the program
CLEARED = frozenset({"path", "sample"})  # tables with several rows of which only the first is cleared
BUFFERED = frozenset({"lamp_fields"})  # tables that hand-written shaders expect in the buffer
VARIABLES = frozenset({"registers"})  # tables of the workspace that other code names as variables


class Tables:
    """The tables of a scene, for the translator and for the GPU.

    ``tables`` are those of the block, ``scalars`` its numbers; ``settled`` names scalars that are constants of
    programs. ``workspace`` maps names to (dtype, count) of each thread's tables. ``room``: words of a buffer; tables
    that do not fit into the first are in a second one. ``code`` has the kernels by index in tables that hold addresses
    on the CPU. ``changing``: scalars that change along a path. ``written``: tables that kernels write into, as arrays
    of floats in GLSL, with ``{}`` for the index. ``unknown``: tables of whose values a program may know nothing.
    ``arrays``: where the arrays of a thread are. ``streamed``: tables that are written anew between dispatches.
    """

    def __init__(
        self,
        tables: dict[str, np.ndarray],
        scalars: dict[str, float],
        settled: frozenset[str],
        workspace: dict[str, tuple[np.dtype, int]],
        room: float = np.inf,
        code: dict[str, dict[int, Callable]] | None = None,
        changing: dict[str, Value] | None = None,
        written: dict[str, str] | None = None,
        unknown: frozenset[str] = frozenset(),
        arrays: ThreadArrays | None = None,
        streamed: StreamedTables | None = None,
    ):
        self._tables, self._scalars, self._settled, self._workspace = tables, scalars, settled, workspace
        self._code, self._changing, self._written = code or {}, changing or {}, written or {}
        self._unknown = unknown
        self.arrays = arrays or ThreadArrays(buffered=False)
        self.streamed = streamed or StreamedTables({})
        self.used_scalars: dict[str, str] = {}
        self._near: dict[str, int] = {}  # first word of each table that is in the uniform block
        used = 0
        sizes = {name: size_of(array) for name, array in tables.items() if name not in BUFFERED}
        self._single = {name for name in sizes if len(tables[name]) == 1 and tables[name].dtype.names}
        # Tables at constant positions come first, large ones last.
        for name in sorted(sizes, key=lambda name: (name not in self._single, name != PLACED, name in LARGE)):
            wanted = (
                name in self._single or 0 < sizes[name] and (sizes[name] <= SMALL or name in LARGE or name == PLACED)
            )
            if wanted and used + sizes[name] <= NEAR_WORDS:
                self._near[name] = used
                used += sizes[name]
        self._single &= set(self._near)
        self._second: set[str] = set()
        used = sum(size_of(tables[name]) for name in BUFFERED & set(tables))
        for name in sizes:
            if name not in self._near:
                if used + sizes[name] > room:
                    self._second.add(name)
                else:
                    used += sizes[name]
        self._values: dict[tuple[str, str], frozenset | None] = {}
        self._rows: dict[str, np.ndarray] = {}  # rows with additional known facts

    # For the translator

    def scalar(self, name: str):
        """The value of a scalar of the block: a number if the program is made for it, else a uniform."""
        number = self._scalars[name]
        if name in self._changing:
            self.used_scalars[name] = "int"
            return self._changing[name]
        if name in self._settled:
            return known(number)
        kind = "float" if isinstance(number, (float, np.floating)) else "int"
        self.used_scalars[name] = kind
        return Value(kind, f"scene.{name}")

    def table(self, name: str, dtype, base):
        """The table of a block, of a workspace, or of a record that refers to one."""
        if base.type != CONSTANT:  # the record holds the first word
            offset, _ = base.type.layout.fields[name + "_address"]
            self.used_scalars[name + "_start"] = "int"
            start = f"scene.{name}_start + {base.type.reader}int_at({base.text} + {offset})"
            return Value(Ref(Array(layout_of(np.dtype(dtype), name)), reader=self.reader(name)), start)
        if name in self._code:
            return known(self._code[name])
        if name in self._written:
            return Value(Ref(Array("float", packed=True), self._written[name]), "0")
        if base.constant is not BLOCK and (name in self._workspace or name not in self._tables):
            if name == "secondary":
                return known(SECONDARY)
            if name not in self._workspace:
                return known(None)
            dtype, count = self._workspace[name]
            inner = layout_of(dtype, name, packed=True)
            buffered = self._in_buffer(name, inner, count)
            name = base.constant.prefix + name
            if count == 1 and isinstance(inner, Record):
                return Value(Ref(Array(inner, 1, packed=True), name + "_row"))
            if buffered:
                lvalue, first = self.arrays.place(name, inner, count)
                return Value(Ref(Array(inner, count, packed=True), lvalue), first, count=str(count))
            return Value(Ref(Array(inner, count, packed=True), name + "_rows[{}]"), "0", count=str(count))
        if name in self.streamed:
            return self.streamed.table(name)
        dtype = self._tables[name].dtype if name in self._tables else np.dtype(dtype)
        if name in self._single:
            return Value(Ref(Array(layout_of(dtype, name), 1), reader=NEAR), str(self._near[name]), count="1")
        self.used_scalars[name + "_start"] = self.used_scalars[name + "_rows"] = "int"
        rows = f"scene.{name}_rows"
        if not len(self._tables[name]):
            rows = "0"
        return Value(Ref(Array(layout_of(dtype, name)), reader=self.reader(name)), f"scene.{name}_start", count=rows)

    def _in_buffer(self, name: str, inner, count: int) -> bool:
        """Whether a table of the workspace, of ``inner``, is in the buffer of ``arrays``."""
        return isinstance(inner, str) and name not in VARIABLES and self.arrays.in_buffer(inner, count)

    def field(self, lvalue: str, inner: Array) -> Value:
        """An array in the only row of a table of the workspace: its GLSL in the row, and its layout."""
        if self.arrays.in_buffer(inner.number, inner.size):
            text, first = self.arrays.place(lvalue, inner.number, inner.size)
            return Value(Ref(inner, text), first)
        return Value(Ref(inner, lvalue + "[{}]"), "0")

    def constant(self, array: np.ndarray) -> Value | None:
        """The table that is this array (n,), in a module of kernels; None if there is none."""
        for name, own in self._tables.items():
            if own is array:
                return self.table(name, array.dtype, known(BLOCK))
        return None

    def row(self, name: str, index: int, text: str) -> Value:
        """A row of a table that is known to have this index, with additional known facts."""
        array = self._tables[name][index : index + 1]
        own = f"{name}_{index}"
        self._rows[own] = array
        return Value(Ref(layout_of(array.dtype, own), reader=self.reader(name)), text)

    def values(self, layout: Record, name: str) -> frozenset | None:
        """Values of an integer field of a table in this scene, if they are few."""
        table = self._rows.get(layout.name, self._tables.get(layout.name))
        if layout.packed or table is None or layout.name in self._unknown:
            return None
        key = layout.name, name
        if key not in self._values:
            column = table[name]
            found = None
            if column.dtype.kind in "iu" and column.ndim == 1 and len(column):
                different = np.unique(column)
                if len(different) <= MOST_VALUES:
                    found = frozenset(different.tolist())
            self._values[key] = found
        return self._values[key]

    def shares_program_with(self, other: Tables) -> bool:
        """Whether the program that was translated with these tables is also that of another scene with tables like
        these: places and constants are the same, and fields have no other values than the program expects."""
        if (self._near, self._second, self._single) != (other._near, other._second, other._single):
            return False
        if self._workspace != other._workspace or self._rows:
            return False
        if any(self._scalars.get(name) != other._scalars.get(name) for name in self._settled | other._settled):
            return False
        if any(bool(len(table)) != bool(len(other._tables[name])) for name, table in self._tables.items()):
            return False
        for (name, field), expected in self._values.items():
            found = other.values(Record(name, self._tables[name].dtype), field)
            if expected is not None and (found is None or not found <= expected):
                return False
        return True

    def use_program_of(self, other: Tables) -> None:
        """Use the program of other tables, which ``shares_program_with``."""
        self.used_scalars, self.arrays = other.used_scalars, other.arrays

    # For the GPU

    def workspace_source(self, secondary: bool) -> str:
        """Structures and global variables of the workspace, and a function that clears everything except arrays."""

        lines, cleared = [], []
        for name, (dtype, count) in self._workspace.items():
            inner = layout_of(dtype, name, packed=True)
            if self._in_buffer(name, inner, count):
                continue
            kind = inner
            single = count == 1 and isinstance(inner, Record)
            if isinstance(inner, Record):
                kind = "Record_" + name
                members = [_member(*item) for item in inner.fields.items() if not (single and self._apart(item[1][1]))]
                lines.append(f"struct {kind} {{ {' '.join(members)} }};")
            for prefix in ("", "secondary_") if secondary else ("",):
                lines.append(f"{kind} {prefix}{name}{'_row' if single else f'_rows[{count}]'};")
                if single or name in CLEARED:
                    cleared += [
                        f"    {prefix}{name}_{'row' if single else 'rows[0]'}.{safe_name(field)} = {scalar}(0);"
                        for field, (_, scalar) in inner.fields.items()
                        if isinstance(scalar, str)
                    ]
        lines += ["void clear_workspace()", "{", *cleared, "}"]
        return "\n".join(lines) + "\n"

    def _apart(self, inner) -> bool:
        """Whether a field of a table's only row is in the buffer of ``arrays``."""
        return isinstance(inner, Array) and not inner.vector and self.arrays.in_buffer(inner.number, inner.size)

    def reader(self, name: str) -> str:
        """The prefix of the functions that read this table."""
        return NEAR if name in self._near else SECOND if name in self._second else ""

    def near_place(self, name: str) -> int | None:
        """First word of a table in the uniform block; None if it is not there."""
        return self._near.get(name)

    def uniform_source(self) -> str:
        """The uniform block ``scene``, and functions that read tables there."""
        members = "".join(f" {kind} {name};" for name, kind in sorted(self.used_scalars.items()))
        return "\n".join(
            [
                f"layout(std140, binding = 0) uniform Scene {{{members} uvec4 near[{NEAR_WORDS // 4}]; }} scene;",
                f"uint {NEAR}uint_at(int place) {{ return scene.near[place >> 2][place & 3]; }}",
                f"int {NEAR}int_at(int place) {{ return int({NEAR}uint_at(place)); }}",
                f"float {NEAR}float_at(int place) {{ return uintBitsToFloat({NEAR}uint_at(place)); }}",
                f"vec3 {NEAR}vector_at(int place)",
                "{",
                f"    return vec3({', '.join(f'{NEAR}float_at(place + {axis})' for axis in range(3))});",
                "}",
            ]
        )

    def buffer_source(self) -> str:
        """The second buffer and that of streamed tables, if they are there, and functions that read tables there."""
        second = [reader_source(SECOND, SECOND_BINDING)] if self._second else []
        return "\n".join([*second, *filter(None, [self.streamed.source()])])

    def pack(self, more: dict[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All tables in two arrays of words, and the words of the uniform block; ``more`` are scalars other than
        positions of tables."""
        parts, second, numbers, used, used_second = [np.zeros(0, np.uint32)], [np.zeros(1, np.uint32)], dict(more), 0, 1
        near = np.zeros(NEAR_WORDS, np.uint32)
        for name, array in self._tables.items():
            words = words_of(array).ravel()
            numbers[name + "_start"], numbers[name + "_rows"] = self._near.get(name, used), len(array)
            if name in self._near:
                near[self._near[name] : self._near[name] + words.size] = words
                continue
            if name in self._second:
                numbers[name + "_start"] = used_second
                second.append(words)
                used_second += words.size
                continue
            parts.append(words)
            used += words.size
        scalars = [
            np.array(numbers[name], np.float32 if kind == "float" else np.int32).view(np.uint32)
            for name, kind in sorted(self.used_scalars.items())
        ]
        scalars += [np.uint32(0)] * (-len(scalars) % 4)
        return np.concatenate(parts), np.concatenate(second), np.concatenate([np.array(scalars, np.uint32), near])


def _member(name: str, field: tuple) -> str:

    _, inner = field
    name = safe_name(name)
    if isinstance(inner, str):
        return f"{inner} {name};"
    if inner.vector:
        return f"vec3 {name};"
    return f"{inner.number} {name}[{inner.size}];"
