# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables that are written anew between the dispatches of one program, in a buffer of their own.

The buffer begins with the number of rows of each table. Each table begins at a constant place, so a program is the same
for all contents.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .layout import Array, layout_of, size_of, words_of
from .translate.values import Ref, Value

STREAMED, BINDING = "streamed_", 5  # prefix of the functions that read these tables; binding of the buffer


class StreamedTables:
    """``kinds``: of each table the dtype, and the most rows that it has; the last one may have any number."""

    def __init__(self, kinds: Mapping[str, tuple[np.dtype, int]]):
        self._kinds = kinds
        self._places: dict[str, int] = {}
        self._used = len(kinds)
        for name, (dtype, most) in kinds.items():
            self._places[name] = self._used
            self._used += size_of(np.zeros(most, dtype))

    def __contains__(self, name: str) -> bool:
        return name in self._kinds

    def table(self, name: str) -> Value:
        """A table, for the translator."""
        rows = list(self._kinds).index(name)
        layout = Array(layout_of(self._kinds[name][0], name))
        return Value(Ref(layout, reader=STREAMED), str(self._places[name]), count=f"{STREAMED}int_at({rows})")

    def words(self, tables: Mapping[str, np.ndarray]) -> np.ndarray:
        """(n,) uint32, the buffer with these ``tables``, each (rows,)."""
        found = np.zeros(self._used + size_of(tables[list(self._kinds)[-1]]), np.uint32)
        for index, (name, place) in enumerate(self._places.items()):
            words = words_of(tables[name]).ravel()
            found[index] = len(tables[name])
            found[place : place + len(words)] = words
        return found

    def source(self) -> str:
        """GLSL of the buffer, if there is one, and of functions that read it."""
        return reader_source(STREAMED, BINDING) if self._kinds else ""


def reader_source(prefix: str, binding: int) -> str:
    """GLSL of a buffer of words, and of functions with this ``prefix`` that read it."""
    vector = ", ".join(f"{prefix}float_at(place + {axis})" for axis in range(3))
    words = f"{prefix}words"
    return "\n".join(
        [
            f"layout(std430, binding = {binding}) readonly buffer {prefix.strip('_').title()} {{ uint {words}[]; }};",
            f"uint {prefix}uint_at(int place) {{ return {words}[place]; }}",
            f"int {prefix}int_at(int place) {{ return int({words}[place]); }}",
            f"float {prefix}float_at(int place) {{ return uintBitsToFloat({words}[place]); }}",
            f"vec3 {prefix}vector_at(int place) {{ return vec3({vector}); }}",
        ]
    )
