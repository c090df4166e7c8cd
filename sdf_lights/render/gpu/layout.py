# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Records and arrays as 32-bit words: floats as float32, integers as int32, field by field."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...frozen import frozen


@frozen
class Array:
    """Elements in sequence; ``inner`` is the type of each: a scalar's name, a ``Record``, an ``Array``."""

    inner: object
    count: int = 0  # 0: unknown
    packed: bool = False  # a separate GLSL array or vector, not in the buffer

    @property
    def stride(self) -> int:
        """Words from one element to the next."""
        return 1 if isinstance(self.inner, str) or (self.packed and isinstance(self.inner, Record)) else self.inner.size

    @property
    def size(self) -> int:
        """Words of all elements."""
        return self.count * self.stride

    @property
    def vector(self) -> bool:
        """Whether it is a vec3 in a structure of GLSL."""
        return self.packed and self.count == 3 and self.inner == "float"

    @property
    def number(self) -> str:
        """Type of its numbers, if it has arrays in it, too."""
        return self.inner if isinstance(self.inner, str) else self.inner.number

    @property
    def element(self) -> str:
        """Type of an element."""
        return self.inner


@frozen
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
        """Words of the record."""
        return sum(1 if isinstance(inner, str) else inner.size for _, inner in self.fields.values())


def scalar_of(dtype: np.dtype) -> str:
    """GLSL type of a NumPy number."""
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


def size_of(array: np.ndarray) -> int:
    """Number of 32-bit words of a table (rows,)."""
    layout = layout_of(array.dtype, "")
    return array.size * (1 if isinstance(layout, str) else layout.size)


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
    # Addresses in the CPU's memory are integers, too; nothing reads them here.
    return flat.astype(np.int64).astype(np.int32).view(np.uint32)
