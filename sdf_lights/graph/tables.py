# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays that formulas read: outlines, curves, grids, weights.

A formula refers to a table by a parameter that holds the address of its first number. So the graph, which is the key of
compiled code, does not depend on the content of a table: editing an outline compiles nothing. An address is below 2⁵³,
so float64 holds it.

Tables of the same content are one object, found by a hash. A shape refers to its tables, and an ``Address`` to its
table. So a cache key that contains one keeps the memory alive.
"""

from __future__ import annotations

import functools
import hashlib
import threading
import weakref
from collections.abc import Iterable

import numpy as np

from .formula import CALL, ITERATE, PARAMETER, Formula, Numbers, body, order

_LARGEST = 1e37  # in float32


class Table:
    """A read-only 1-D array in a separate piece of memory, compared by identity. Only ``table`` makes them."""

    __slots__ = ("array", "key", "__weakref__")

    array: np.ndarray
    key: bytes

    @property
    def address(self) -> "Address":
        """Address of the first number, for a slot of a formula."""
        return Address(self)

    @property
    def bytes(self) -> int:
        """Size in memory."""
        return self.array.nbytes

    def __reduce__(self):
        return table, (np.array(self.array),)

    def __repr__(self):
        return f"<Table {self.array.dtype} × {len(self.array)}>"


class Address(float):
    """The address of a table, as a number that keeps the table alive."""

    table: Table

    def __new__(cls, owner: Table):
        found = super().__new__(cls, owner.array.ctypes.data)
        found.table = owner
        return found

    def __reduce__(self):
        return Address, (self.table,)


_known: weakref.WeakValueDictionary[bytes, Table] = weakref.WeakValueDictionary()
_places: weakref.WeakValueDictionary[int, Table] = weakref.WeakValueDictionary()
_lock = threading.Lock()


def table(array: np.ndarray) -> Table:
    """The table with the content of an array (n,). The array is copied unless the table already exists. A table begins
    at a cache line. Raises ValueError for an empty array, or one of more dimensions."""
    array = np.ascontiguousarray(array)
    if array.ndim != 1 or not len(array):
        raise ValueError(f"a table is a non-empty array of one dimension, not one of shape {array.shape}")
    key = hashlib.sha256(array.dtype.str.encode() + array.view(np.uint8).data).digest()
    with _lock:
        found = _known.get(key)
        if found is None:
            memory = np.empty(array.nbytes + 64, np.uint8)
            start = -memory.ctypes.data % 64
            copy = memory[start : start + array.nbytes].view(array.dtype)
            copy[:] = array
            copy.flags.writeable = False
            found = Table.__new__(Table)
            found.array, found.key = copy, key
            _known[key] = found
            _places[copy.ctypes.data] = found
    return found


def tables_of(formula: Formula, parameters: Numbers) -> tuple[Table, ...]:
    """Tables that a formula with these parameters reads. Code that keeps only the numbers must keep these too."""
    found = [at_address(parameters[slot]) for slot in sorted(address_slots(formula))]
    return tuple(dict.fromkeys(known for known in found if known is not None))


def with_places(numbers: np.ndarray, slots: Iterable[int], first: int = 0) -> tuple[np.ndarray, list[Table]]:
    """Numbers (n,) for a graphics card, and their tables. Addresses of tables, in ``slots``, are replaced by the
    position of the first number of each table in the concatenated tables, counted from ``first`` on."""
    numbers, places, used = np.array(numbers, np.float64), dict[Table, int](), first
    for slot in sorted(slots):
        found = at_address(numbers[slot])
        if found is not None and found not in places:
            places[found] = used
            used += len(found.array)
        numbers[slot] = places.get(found, 0) if found is not None else 0
    return numbers, list(places)


def as_float32(found: Table) -> np.ndarray:
    """The numbers of a table, clamped to the finite range of float32."""
    return np.clip(found.array, -_LARGEST, _LARGEST).astype(np.float32)


@functools.lru_cache(maxsize=256)
def address_slots(*formulas: Formula) -> frozenset[int]:
    """Slots of the formulas that hold addresses."""
    found, seen, pending = set(), set(), list(order(*formulas))
    while pending:
        node = pending.pop()
        if node in seen:
            continue
        seen.add(node)
        if node.kind == ITERATE:
            pending += [*body(node), *node.operands]
        if node.kind == CALL:
            found |= {operand.value for operand in node.operands[: node.value.tables] if operand.kind == PARAMETER}
    return frozenset(found)


def kept(value: float) -> float:
    """A number as a float. The address of a table stays one, which keeps the table."""
    return value if isinstance(value, Address) else float(value)


def tables_among(values: Iterable[float]) -> tuple[Table, ...]:
    """Tables whose addresses are among numbers."""
    return tuple(dict.fromkeys(value.table for value in values if isinstance(value, Address)))


def at_address(number: float) -> Table | None:
    """The table at an address, if there is one."""
    return _places.get(int(number))


def memory() -> int:
    """Bytes of all tables in memory."""
    with _lock:
        return sum(known.bytes for known in _known.values())
