# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiled entries of kernels: found on disk, loaded, and called from Python or from C.

Where ``machine_code`` can load them, this needs neither Numba nor LLVM: to import these takes half a second and 60 MB.
A missing entry is compiled by ``kernel_compiler``.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import importlib
import pathlib
import sys
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from . import kernel_cache, machine_code
from .kernel_code import ROOT, Stored, compiler, origin, python_interface, source_hash, target

FOR_C = "C"  # in the place of the kinds of arguments


def missing() -> str:
    """Why Numba cannot be imported; "" if it can. Tries it once for each installation, because it takes long."""
    installation = repr((origin("numba"), origin("llvmlite"), *compiler(), np.__version__, sys.version))
    mark = kernel_cache.writable_folder() / f"numba-{hashlib.sha256(installation.encode()).hexdigest()[:16]}.usable"
    if origin("numba") and origin("llvmlite") and mark.is_file():
        return ""
    try:
        from . import kernel_compiler, kernel_intrinsics  # noqa: F401
    except Exception as error:  # an ImportError, or a binary that does not match this NumPy or Python
        return f"Numba could not be imported ({type(error).__name__}: {error})"
    with contextlib.suppress(OSError):
        mark.touch()
    return ""


def linked(code: tuple | bytes, known: Mapping[str, int] = MappingProxyType({})):
    """Loads a result of ``stored_code``. The returned object has ``address(symbol)``, and must live as long as the
    code. ``known``: addresses of functions that it calls, beside those of the process."""
    if not isinstance(code, bytes):
        return machine_code.load(machine_code.Image(*code), known)
    from .kernel_compiler import linked_by_llvm

    return linked_by_llvm(code, known)


def address(stored: Stored) -> tuple[int, object]:
    """The address of an entry for C, and what must live as long as it is called."""
    code = linked(stored.code)
    return code.address(stored.symbol), code


def function(stored: Stored, python) -> Callable:
    """An entry for Python; ``python`` is the function that it was compiled from."""
    code, dynfunc = linked(stored.code), machine_code.numba_library("numba._dynfunc")
    made = []
    for symbol, constants in stored.environments:
        environment = dynfunc.Environment(python.__globals__)
        environment.consts.extend(constants)
        ctypes.c_void_p.from_address(code.address(symbol)).value = id(environment)
        made.append(environment)
    module = importlib.import_module(python.__module__)
    start = code.address(stored.symbol)
    return dynfunc.make_function(module, python.__name__, python.__doc__ or "", start, made[0], (code, made))


class Entry:
    """A place on disk for a compiled entry: in the user's folder, or else in that which the extension ships."""

    def __init__(self, source: pathlib.Path, place: tuple, kinds: object):
        """``source``: file of the kernel; ``place``: parts of its name inside the source folder; ``kinds``: of its
        arguments, or ``FOR_C``. What C calls is the same for all versions of Python: most of the code of kernels, which
        several Blenders share."""
        source = source.resolve()
        inside = source.is_relative_to(ROOT)
        # Modules with the same sources have the same hash.
        module = source.relative_to(ROOT).with_suffix("").parts if inside else (source.stem,)
        folder = pathlib.Path(source_hash(source), ".".join(module))
        self._key = kinds, target(), None if kinds == FOR_C else python_interface()
        self._files = kernel_cache.Files(
            kernel_cache.writable_folder() / folder,
            "-".join(map(str, place)).replace("<", "").replace(">", ""),
            shipped=kernel_cache.SHIPPED / folder if inside else None,
        )

    def get(self, compiled: Callable[[], tuple[Stored, bool]], load: Callable):
        """``load`` of what is stored, or of what is compiled now: then also whether it may be stored."""
        stored = self._files.load(self._key)
        if stored is not None:
            try:
                return load(Stored(*stored))
            except Exception:  # a file written by another version
                self._files.forget(self._key)
        stored, lasting = compiled()
        if lasting:
            self._files.save(self._key, tuple(stored))
        return load(stored)
