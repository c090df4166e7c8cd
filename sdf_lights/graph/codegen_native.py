# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Machine code for formulas, compiled once for each formula or group of formulas.

``compiled`` makes code over n points, for the fields of lamps; ``compiled_at_surface`` for one point of a surface, for
materials.

The graph is translated node by node into LLVM vector instructions (Numba's LLVM), for ``LANES`` points side by side. No
source text is made, and LLVM's optimiser is not run: hash-consing has already done its work on a graph without
branches. The optimiser takes 5 s for the 2,800 nodes of 200 transformed spheres, while instruction selection alone
takes 0.4 s and the code is as fast. Values that depend only on parameters stay scalar.

Compiled code is also cached on disk, under a description of the formulas: a second process loads it in a tenth of the
time.

``AVAILABLE`` is False if Numba cannot be imported. Then ``numpy_evaluation`` does the same, more slowly.
"""

from __future__ import annotations

import ctypes
import functools
import pathlib
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from .. import kernel_cache
from ..jit import AVAILABLE, REASON
from ..kernel_code import source_hash, stored_code, target
from ..kernel_entries import linked
from ..machine_code import process_symbol
from .formula import CALL, ITERATE, Formula, Numbers, body, order, slots
from .functions import Function, compiled_part
from .native_names import LANES, SYMBOL, Place, library_symbol, part_symbol, symbol
from .operations import OPERATIONS, Native

KEPT = 256  # number of cached formulas, the most recently used ones; each takes some kilobytes of code

MOST_BYTES = 64 << 20  # of code on disk

_SIGNATURE = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class Compiled(NamedTuple):
    """Machine code of one or more formulas: the C function

        void f(int64_t n, const double *points, const double *parameters, double *values)

    ``points`` (3, m) has all x, then all y, then all z, where m is n rounded up to a multiple of
    ``LANES``. ``parameters`` has the formulas' slots. ``values`` (formulas, m) gets all values of the first formula
    first. Only the first n of m values count: functions that a formula calls are called for no other point. Any number
    of threads may call it.
    """

    address: int  # valid as long as ``owner`` lives
    owner: object


_compiled: OrderedDict[tuple, Compiled] = OrderedDict()
_lock = threading.RLock()


def compiled(*formulas: Formula) -> Compiled:
    """Code of the formulas, compiled on first use. Parameter values are not part of it."""
    known = {part_symbol(each, operands): compiled_part(each, operands).address for each, operands in _calls(formulas)}
    return _kept(formulas, formulas, tuple(known), known, lambda emission: emission.module(formulas))


def _calls(formulas: tuple[Formula, ...]) -> list[tuple[Function, int]]:
    """Functions that formulas call, and with how many operands."""
    return [(node.value, len(node.operands)) for node in _all_nodes(formulas) if node.kind == CALL]


def compiled_at_surface(
    formulas: tuple[Formula, ...],
    places: Mapping[str, Place],
    address_of: Callable[[Function, int], int],
    scene: object = None,
) -> Compiled:
    """Code of the formulas for one point of a surface: the C function

        void f(int64_t block, int64_t workspace, int64_t surface, const double *parameters, double *values)

    ``places`` gives the positions of the variables in the record at ``surface``. ``address_of`` returns the address of
    ``void f(int64_t block, int64_t workspace, int64_t operands, int64_t results)`` for a function called with some
    number of operands; ``scene`` stands for everything that these addresses depend on.
    """

    def symbol_of(function: Function, operands: int) -> str:
        """Identifies a function in code that calls it: the same in each process, unlike its address."""
        return symbol(function, operands, scene)

    known = {symbol_of(each, operands): address_of(each, operands) for each, operands in _calls(formulas)}
    context = "surface", sorted(places.items()), tuple(known)
    key = formulas, "surface", scene
    return _kept(key, formulas, context, known, lambda emission: emission.surface_module(formulas, places, symbol_of))


def _kept(key: tuple, formulas: tuple[Formula, ...], context: tuple, known: dict[str, int], module: Callable):
    """The code of ``key``, from the cache, or compiled from ``module(native_emission)``. It depends only on
    ``formulas`` and ``context``; ``known`` has the addresses of what it calls."""
    with _lock:
        found = _compiled.get(key)
        if found is None:
            found = _compiled[key] = _from_disk(formulas, context, known, module)
            if len(_compiled) > KEPT:
                _compiled.popitem(last=False)
        else:
            _compiled.move_to_end(key)
        return found


def _from_disk(formulas: tuple[Formula, ...], context: tuple, known: dict[str, int], module: Callable) -> Compiled:
    if not AVAILABLE:
        raise RuntimeError(REASON)
    key = *target(), context, _description(formulas)
    files = kernel_cache.Files(_folder(), "formulas", MOST_BYTES)
    code = files.load(key)
    if code is None:
        from . import native_emission

        operations = len(order(*formulas))
        code = stored_code(native_emission.object_code(module(native_emission), operations), (SYMBOL,))
        files.save(key, code)
    for node in _all_nodes(formulas):
        if node.kind in OPERATIONS and OPERATIONS[node.kind].native[0] is Native.LIBRARY:
            name = OPERATIONS[node.kind].native[1]
            known[library_symbol(name)] = process_symbol(name)
    loaded = linked(code, known)
    return Compiled(loaded.address(SYMBOL), loaded)


@functools.cache
def _folder() -> pathlib.Path:
    source = pathlib.Path(__file__).resolve()
    return kernel_cache.writable_folder() / source_hash(source) / "formulas"


def _all_nodes(formulas: tuple[Formula, ...]) -> list[Formula]:
    """Nodes of the formulas, including those in loops."""
    found: dict[Formula, None] = {}
    pending = list(order(*formulas))
    while pending:
        node = pending.pop()
        if node not in found:
            found[node] = None
            if node.kind == ITERATE:
                pending += body(node)
    return list(found)


def _description(formulas: tuple[Formula, ...]) -> str:
    """Text that identifies the code of formulas, the same in each process."""
    lines: list[str] = []
    numbers: dict[Formula, int] = {}

    def write(nodes: list[Formula]) -> None:
        for node in nodes:
            if node in numbers:
                continue
            value = node.value
            if node.kind == ITERATE:
                write(body(node))
                value = value.level, value.limit, [numbers[root] for root in value.roots()], value.going is not None
            elif node.kind == CALL:
                value = value.name, value.results
            numbers[node] = len(numbers)
            lines.append(f"{node.kind} {value!r} {[numbers[operand] for operand in node.operands]}")

    write(order(*formulas))
    return "\n".join([*lines, repr([numbers[formula] for formula in formulas])])


def evaluate(formula: Formula, points: np.ndarray, parameters: Numbers = ()) -> np.ndarray:
    """Values (…) of the formula at points (…, 3), like ``numpy_evaluation.evaluate``. Raises ValueError.

    The two agree to rounding. If an operand of minimum, maximum or a comparison is NaN, either operand may result.
    """
    points = np.asarray(points, np.float64)
    rows = points.reshape(-1, 3)
    n = len(rows)
    columns = np.zeros((3, -(-n // LANES) * LANES))
    columns[:, :n] = rows.T
    parameters = np.ascontiguousarray(parameters, np.float64)
    if len(parameters) < slots(formula):
        raise ValueError(f"the formula has {slots(formula)} parameters, not {len(parameters)}")
    values = np.empty(columns.shape[1])
    code = compiled(formula)
    _SIGNATURE(code.address)(n, columns.ctypes.data, parameters.ctypes.data, values.ctypes.data)
    return values[:n].reshape(points.shape[:-1])
