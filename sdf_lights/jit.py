# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Numba as this project uses it: one decorator, one cache folder, arrays and functions reached by address.

The lowest layer, below all kernels. ``kernel_entries`` stores and loads what ``kernel_compiler`` compiles: Numba is
imported only if a kernel is not stored yet. If it cannot be imported, ``AVAILABLE`` is False, ``REASON`` gives the
reason in one sentence, and ``kernel`` leaves a function as it is (plain, slow Python). So every module still imports,
and the NumPy reference can take over.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import inspect
import pathlib
import sys
import threading
from collections.abc import Set

import numpy as np

from . import kernel_entries
from .replaced import replaced_on_gpu

REASON = kernel_entries.missing()
AVAILABLE = not REASON

_LOADED: set = set()  # kernels that C calls
_BEGUN: list = []  # kernels that Python calls
_lock = threading.RLock()  # while an entry is loaded or compiled


def compiled_kernels() -> int:
    """Kernels that were compiled in this process, for linking into others."""
    compiler = sys.modules.get(f"{__package__}.kernel_compiler")
    # Another thread may still be importing it.
    count = getattr(compiler, "compiled_kernels", None)
    return count() if count else 0


def _callees(python) -> list:
    """Kernels that a function names: in its module, in modules that it imports, and in its closure."""
    names = python.__code__.co_names
    found = [python.__globals__.get(name) for name in names]
    found += [getattr(each, name, None) for each in found if inspect.ismodule(each) for name in names]
    found += [cell.cell_contents for cell in python.__closure__ or ()]
    return [each for each in found if isinstance(each, _Kernel)]


@functools.cache
def reachable(kernel) -> frozenset:
    """A kernel and all that it may call."""
    reached, pending = set(), [kernel]
    while pending:
        found = pending.pop()
        if found not in reached:
            reached.add(found)
            pending += _callees(found.__wrapped__)
    return frozenset(reached)


def begun() -> list:
    """Kernels that Python has called in this process."""
    return list(_BEGUN)


def progress(kernels) -> tuple[int, int]:
    """Progress of the compilation of entries: (number of ready kernels, number of all that they call)."""
    ready, wanted = set(), set()
    for kernel in kernels:
        reached = reachable(kernel)
        wanted |= reached
        ready |= reached if kernel.loaded() else {each for each in reached if each.compiled()}
    return len(ready), len(wanted)


class _Kernel:
    """The result of ``kernel``. Kernels link it in. A call from Python compiles it once more as an entry, which is
    optimised, emitted, wrapped for Python, and cached on disk: one for each kind of arguments."""

    def __init__(self, function, settings: dict):
        functools.update_wrapper(self, function)
        self._settings, self._entries = settings, {}

    def __call__(self, *arguments):
        kinds = tuple(map(_kind, arguments))
        entry = self._entries.get(kinds)
        return (entry or self._entry(kinds, arguments))(*arguments)

    def loaded(self) -> bool:
        """Whether it is ready, including all that it calls."""
        return self in _LOADED or bool(self._entries)

    def compiled(self) -> bool:
        """Whether it is ready for linking into others."""
        if "_numba_type_" not in self.__dict__:
            return False
        from .kernel_compiler import is_part_compiled

        return is_part_compiled(self._numba_type_)

    def _entry(self, kinds: tuple, arguments: tuple):
        python, code = self.__wrapped__, self.__wrapped__.__code__
        with _lock:
            if kinds in self._entries:
                return self._entries[kinds]
            if self not in _BEGUN:
                _BEGUN.append(self)
            own = hashlib.sha256(code.co_code)
            if python.__closure__:  # tests make kernels in functions, which differ in their closures
                from numba.core.serialize import dumps

                own.update(dumps(tuple(cell.cell_contents for cell in python.__closure__)))
            place = python.__qualname__, code.co_firstlineno, own.hexdigest()[:16]

            def compiled():
                from . import kernel_compiler

                return kernel_compiler.compiled(python, self._settings, arguments)

            found = kernel_entries.Entry(pathlib.Path(code.co_filename), place, kinds)
            self._entries[kinds] = entry = found.get(compiled, lambda stored: kernel_entries.function(stored, python))
            return entry

    @functools.cached_property
    def _numba_type_(self):
        """Numba asks for this if another kernel calls this one: never, if all entries come from the cache."""
        from . import kernel_compiler

        return kernel_compiler.part(self.__wrapped__, self._settings)


_NUMBERS = frozenset((float, int, bool, type(None)))


def _kind(value):
    """All that the code of an entry depends on in one of its arguments; two of the same ``repr`` are the same."""
    kind = type(value)
    if kind in _NUMBERS:
        return kind if kind is not int or -(1 << 63) <= value < 1 << 63 else np.uint64
    if kind is np.ndarray:
        flags = value.flags
        layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
        return value.dtype, value.ndim, layout, flags.writeable
    if kind is tuple:
        return tuple, *map(_kind, value)
    return getattr(value, "dtype", kind)  # a number or a record of NumPy


def kernel(function=None, **options):
    """Compile ``function`` with Numba on first use: no GIL, cached on disk, division by zero gives infinity.

    Functions and their arguments are scalars, tuples of floats (vectors, RGB), NumPy arrays and records.
    """
    if not AVAILABLE:
        return function if function is not None else (lambda function: function)
    if function is None:
        return lambda function: kernel(function, **options)
    return _Kernel(function, options)


class _Intrinsic:
    """Code of ``kernel_intrinsics`` that kernels call, made when a kernel that calls it is compiled; without Numba, a
    ``plain`` function."""

    def __init__(self, name: str, *parameters, plain=None):
        self._name, self._parameters, self._plain = name, parameters, plain

    def __call__(self, *arguments):
        return self._plain(*arguments)

    @functools.cached_property
    def _numba_type_(self):
        """Numba asks for this if a kernel names it."""
        from . import kernel_intrinsics

        made = getattr(kernel_intrinsics, self._name)
        return kernel_intrinsics.type_of(made(*self._parameters) if self._parameters else made)


def _reader(kind):
    class Memory:
        """Numbers at an address."""

        def __init__(self, address):
            self.first = int(address)

        def __getitem__(self, index):
            return kind.from_address(self.first + ctypes.sizeof(kind) * int(index)).value

    return Memory


# Kernels that call machine code import the first ones. Without Numba, such kernels cannot be called.
call_address3, call_address4, call_field, call_surface_code, call_numbers, address_of_record = (
    _Intrinsic(name)
    for name in "call_address3 call_address4 call_field call_surface_code call_numbers address_of_record".split()
)
call_part = replaced_on_gpu(_Intrinsic("call_part"))
float_of_bits = _Intrinsic("float_of_bits", plain=lambda bits: float(np.int64(bits).view(np.float64)))
float_bits = replaced_on_gpu(_Intrinsic("float_bits", plain=lambda number: int(np.float32(number).view(np.uint32))))
stack_array = replaced_on_gpu(_Intrinsic("stack_array", plain=np.empty))
load_numbers, store_numbers = _Intrinsic("load_numbers"), _Intrinsic("store_numbers")


def array_at(dtype, count: int, plain=None):
    """The 1-D array of ``count`` numbers of ``dtype`` at an address, which may be a float: for kernels."""
    return _Intrinsic("array_at", dtype, count, plain=plain)


def record_at(dtype):
    """The record of ``dtype`` at an address: for kernels."""
    return _Intrinsic("record_at", dtype)


_ANY = 1 << 40  # the real number of elements is in the head of a table
doubles_at, floats_at, ints_at = (
    array_at(dtype, _ANY, plain=_reader(number))
    for dtype, number in ((np.float64, ctypes.c_double), (np.float32, ctypes.c_float), (np.int32, ctypes.c_int32))
)


class _ForC:
    """A function that calls a kernel, as a C function of integers without a result: ``address``."""

    def __init__(self, function, arguments: int, kernel, key: list):
        """``key`` separates its file from those of other kernels with the same sources."""
        # The machine code has this name. Kernels written by several processes may meet in the process that reads them.
        function.__name__ = function.__qualname__ = "_".join(map(str, key))

        def compiled():
            from . import kernel_compiler

            return kernel_compiler.compiled_for_c(function, arguments)

        with _lock:
            found = kernel_entries.Entry(
                pathlib.Path(kernel.__wrapped__.__code__.co_filename), tuple(key), kernel_entries.FOR_C
            )
            self.address, self._code = found.get(compiled, kernel_entries.address)
            _LOADED.add(kernel)


class Callback(_ForC):
    """A kernel of one record as a C function ``void f(record *)``, for libraries to call: ``address``."""

    def __init__(self, kernel, record: np.dtype):
        at = record_at(record)

        def function(address):
            kernel(at(address))

        super().__init__(function, 1, kernel, [kernel.__wrapped__.__name__])


@functools.cache
def layout(records: tuple) -> str:
    """Identifies the fields of records of these types, which may change without a change of a kernel's sources."""
    return hashlib.sha256(repr([np.dtype(record) for record in records]).encode()).hexdigest()[:16]


class CallablePart(_ForC):
    """A kernel as a C function ``void f(int64 block, int64 workspace, int64 operands, int64 results)``. Compiled
    formulas call it, and other kernels do (``call_part``). It is compiled on first use, and cached on disk."""

    def __init__(self, kernel, static: tuple[int, ...], operands: int, records: tuple | None):
        """``records``: types of the block and the workspace, if the kernel uses them."""
        key = [kernel.__wrapped__.__name__, *static, operands]
        if records is not None:
            key.append(layout(records))
        super().__init__(_called(kernel, static, operands, records), 4, kernel, key)

    def fill(self, operands: np.ndarray, results: np.ndarray) -> None:
        """Results (n, count) for operands (n, count), both float64 and contiguous, of a kernel without records."""
        strides = operands.strides[0], results.strides[0]
        _call_each(self.address, len(results), operands.ctypes.data, strides[0], results.ctypes.data, strides[1])


@kernel
def _call_each(address, count, operands, operand_stride, results, result_stride):
    for index in range(count):
        call_numbers(address, operands + index * operand_stride, results + index * result_stride)


def _called(kernel, static: tuple[int, ...], operands: int, records: tuple | None):
    if records is None:
        if operands == 0:

            def function(block, workspace, given, results):
                store_numbers(results, kernel(*static))
        elif static:

            def function(block, workspace, given, results):
                store_numbers(results, kernel(*(static + load_numbers(given, operands))))
        else:

            def function(block, workspace, given, results):
                store_numbers(results, kernel(*load_numbers(given, operands)))

        return function
    block_at, workspace_at = (record_at(record) for record in records)
    if operands == 0:

        def function(block, workspace, given, results):
            store_numbers(results, kernel(block_at(block), workspace_at(workspace), *static))
    elif static:

        def function(block, workspace, given, results):
            store_numbers(
                results,
                kernel(block_at(block), workspace_at(workspace), *(static + load_numbers(given, operands))),
            )
    else:

        def function(block, workspace, given, results):
            store_numbers(results, kernel(block_at(block), workspace_at(workspace), *load_numbers(given, operands)))

    return function


def specialised(function, name: str, **names):
    """A copy of a kernel under another ``name``, with other values for some global ``names`` of its module.

    The values are kernels, or integers known at compile time: branches that they exclude cost nothing. A kernel as an
    argument would do the same, but such code cannot be cached.
    """
    python = inspect.unwrap(function)
    copy = type(python)(python.__code__, {**python.__globals__, **names}, name, python.__defaults__)
    copy.__module__, copy.__qualname__, copy.__doc__ = python.__module__, name, python.__doc__
    return kernel(copy, **function._settings) if AVAILABLE else copy


def dispatched(link, cases: list[dict], last):
    """A kernel that selects one of several kernels by a number.

    ``link(number, …)`` is a kernel that tests one number: if it is ``NUMBER``, it calls the function of the case, else
    ``REST(number, …)``. ``cases`` has the values of these names in its module for each of the numbers. ``last(number,
    …)`` handles all others.
    """
    for names in reversed(cases):
        last = specialised(link, f"{link.__name__}_{names['NUMBER']}", REST=last, **names)
    return last


def table(name: str, dtype, columns: int = 0):
    """``view(block)``, for kernels: the array of ``dtype`` that ``block[name + "_address"]`` points at; 1-D, or rows of
    so many ``columns``.

    A block is one NumPy record with the address and length of every array of a scene. So kernels pass one word instead
    of seven for each array, and never touch a reference count shared by threads.
    """
    view = _Intrinsic("table", name, dtype, columns)
    view.table_name, view.table_dtype = name, np.dtype(dtype) if dtype is not None else None
    return view


def block_dtype(tables: dict[str, np.dtype], scalars: list[tuple] = ()) -> np.dtype:
    """Record type with ``<name>_address`` and ``<name>_count`` for every table, followed by ``scalars``."""
    fields = []
    for name in tables:
        fields += [(name + "_address", np.int64), (name + "_count", np.int64)]
    return np.dtype(fields + list(scalars), align=True)


def fill_table(block: np.ndarray, name: str, array: np.ndarray) -> None:
    """Point table ``name`` of the ``block`` (1,) at ``array`` (n,), which the caller keeps alive."""
    assert array.flags.c_contiguous and array.ndim == 1
    block[name + "_address"] = array.ctypes.data
    block[name + "_count"] = len(array)


_LINE = 128  # bytes: a cache line and its neighbour, which processors fetch together


def new_tables(
    dtypes: dict[str, np.dtype], counts: dict[str, int], uncleared: Set[str] = frozenset()
) -> dict[str, np.ndarray]:
    """Tables of so many elements, all zero but for the ``uncleared`` ones, in a separate piece of memory. Raises
    MemoryError if there is not enough.

    They share no cache line with other tables, which may belong to another thread: two threads that write to one line
    slow each other down. Each table begins at a cache line, as Embree requires for rays.
    """
    sizes = {name: -(-count * dtypes[name].itemsize // _LINE) * _LINE for name, count in counts.items()}
    memory = np.empty(sum(sizes.values()) + _LINE, np.uint8)
    tables, at = {}, -memory.ctypes.data % _LINE
    for name, count in counts.items():
        part = memory[at : at + count * dtypes[name].itemsize]
        if name not in uncleared:
            part[:] = 0
        tables[name] = part.view(dtypes[name])
        at += sizes[name]
    return tables
