# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Numba as this project uses it: one decorator, one cache folder, arrays and functions reached by address.

The lowest layer: it imports nothing of the package. Where Numba cannot be imported, ``AVAILABLE`` is False,
``REASON`` says why in one sentence, and ``kernel`` leaves a function as it is (plain, slow Python), so that every
module still imports and the NumPy reference can take over.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import os
import pathlib
import re
import tempfile

import numpy as np

try:
    import numba
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.core.caching import FunctionCache
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler
    from numba.core.registry import CPUDispatcher
    from numba.core.runtime import rtsys
    from numba.extending import intrinsic
    from numba.np.arrayobj import populate_array
    from numba.np.numpy_support import from_dtype

    AVAILABLE, REASON = True, ""
except Exception as error:  # an ImportError, or a binary that does not match this NumPy or Python
    AVAILABLE, REASON = False, f"Numba could not be imported ({type(error).__name__}: {error})"

# Reassociation and contraction only: infinities and NaN keep their meaning, because kernels test for them.
FASTMATH = {"contract", "reassoc", "arcp", "nsz"}


_IMPORT = re.compile(r"^\s*from (\.+|sdf_lights\b)([\w.]*) import (\([^)]*\)|[^\n#]+)", re.MULTILINE)


@functools.lru_cache(maxsize=None)
def _imports(path: pathlib.Path) -> frozenset[pathlib.Path]:
    """Source files of the package that the source file ``path`` imports directly."""
    found = set()
    for dots, module, names in _IMPORT.findall(path.read_text(encoding="utf-8")):
        # Absolute imports of the package occur outside it, in tests.
        root = path.parents[len(dots) - 1] if dots.startswith(".") else pathlib.Path(__file__).parent
        base = root.joinpath(*filter(None, module.split(".")))
        candidates = [base.with_suffix(".py"), base / "__init__.py"]
        for name in re.findall(r"\w+", names):
            candidates += [base / f"{name}.py", base / name / "__init__.py"]
        found.update(candidate for candidate in candidates if candidate.is_file())
    return frozenset(found)


@functools.lru_cache(maxsize=None)
def source_hash(path: pathlib.Path) -> str:
    """Hash of a kernel source file and all it imports from the package, of the package's name, Numba and NumPy.

    Numba's own cache looks at the time stamp of the one file that defines a function and misses changes in the
    functions it calls; a folder named by this hash makes any such change start from a clean cache. A cached kernel
    also holds the full name of its module, which differs between an extension and a checkout.
    """
    reached, pending = set(), {path}
    while pending:
        reached |= pending
        pending = set().union(*map(_imports, pending)) - reached
    digest = hashlib.sha256(f"{numba.__version__} {np.__version__} {__package__}".encode())
    for source in sorted(reached):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> pathlib.Path:
    """Folder for compiled kernels: ``SDF_LIGHTS_CACHE`` (set by the extension to its own user folder), or the
    user's cache folder."""
    root = os.environ.get("SDF_LIGHTS_CACHE")
    if root:
        return pathlib.Path(root)
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or pathlib.Path.home() / ".cache"
    return pathlib.Path(base) / "sdf_lights"


@functools.lru_cache(maxsize=None)
def _writable_cache() -> pathlib.Path:
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return pathlib.Path(tempfile.mkdtemp(prefix="sdf_lights-"))


_PARTS: list = []
_numbers = itertools.count()


def compiled_kernels() -> int:
    """Kernels that were compiled in this process to be linked into others: how far a first compilation has come."""
    return sum(len(part.overloads) for part in _PARTS)


if AVAILABLE:

    class _WithoutEnvironment:
        """A code generator that does not look for the environment of code that is never emitted."""

        def __init__(self, codegen):
            self._codegen = codegen

        def __getattr__(self, name):
            return getattr(self._codegen, name)

        def set_env(self, name, environment):
            pass

    class _Part(JITCodeLibrary):
        """Code of a kernel that other kernels call: intermediate code, to be linked into an entry.

        Numba would optimise each function together with all it calls, and emit it, at every level of the call tree:
        for a path tracer that is most of the time spent on compiling. Here that happens once, in the entry.
        """

        @property
        def codegen(self):
            return _WithoutEnvironment(self._codegen)

        def _optimize_final_module(self):
            pass

        def _finalize_final_module(self):
            self._finalize_dynamic_globals()
            self._finalized = True

        def get_pointer_to_function(self, name):
            self._ensure_finalized()
            return 0

    class _PartCompiler(Compiler):
        def __init__(self, typing_context, target_context, library, *arguments):
            library = library or _Part(target_context.codegen(), f"kernel{next(_numbers)}")
            super().__init__(typing_context, target_context, library, *arguments)

    class _Kernel:
        """What ``kernel`` returns. Kernels link it in; a call from Python compiles it once more as an entry, which is
        optimised, emitted, given the wrapper that Python needs, and cached on disk."""

        def __init__(self, function, settings: dict):
            functools.update_wrapper(self, function)
            self._settings = settings

        def __call__(self, *arguments):
            return self._entry(*arguments)

        @functools.cached_property
        def _entry(self):
            return _entry(self.__wrapped__, self._settings)

        @functools.cached_property
        def _numba_type_(self):
            """Numba asks for this where another kernel calls this one: never, where all entries come from the cache."""
            settings = {name: value for name, value in self._settings.items() if name != "cache"}
            part = CPUDispatcher(
                self.__wrapped__, targetoptions={**settings, "no_cpython_wrapper": True}, pipeline_class=_PartCompiler)
            _PARTS.append(part)
            return types.Dispatcher(part)

    class _Cache(FunctionCache):
        """Loads compiled entries without first registering all that Numba can compile, which takes a third of a second.

        What an entry calls outside itself is C's mathematics, Python's interface and Numba's run time.
        """

        def load_overload(self, signature, target):
            rtsys.initialize(target)
            with self._guard_against_spurious_io_errors():
                return self._load_overload(signature, target)

    def _entry(function, options: dict):
        options = dict(options)
        cached = options.pop("cache")
        dispatcher = CPUDispatcher(py_func=function, targetoptions=options)
        if cached:
            # Numba reads this process-wide setting when caching is enabled; other add-ons keep theirs.
            previous = numba.config.CACHE_DIR
            source = pathlib.Path(function.__code__.co_filename).resolve()
            numba.config.CACHE_DIR = str(_writable_cache() / source_hash(source))
            try:
                dispatcher._cache = _Cache(function)
            finally:
                numba.config.CACHE_DIR = previous
        return dispatcher

    def kernel(function=None, **options):
        """Compile ``function`` with Numba on first use: no GIL, cached on disk, division by zero gives infinity.

        Functions and their arguments are scalars, tuples of floats (vectors, RGB), NumPy arrays and records.
        """
        if function is None:
            return lambda function: kernel(function, **options)
        settings = dict(
            nopython=True, boundscheck=None, nogil=True, cache=True, error_model="numpy", fastmath=FASTMATH,
            no_cfunc_wrapper=True)
        settings.update(options)
        return _Kernel(function, settings)

    def _caller(kinds):
        """Intrinsic that calls a C function without result at an address; ``kinds`` are the types of its arguments."""
        signature = types.void(*[types.int64] * (1 + len(kinds)))

        def codegen(context, builder, signature, arguments):
            function = builder.inttoptr(arguments[0], ir.FunctionType(ir.VoidType(), kinds).as_pointer())
            builder.call(function, [
                builder.inttoptr(value, kind) if isinstance(kind, ir.PointerType) else value
                for kind, value in zip(kinds, arguments[1:])])
            return context.get_dummy_value()

        return lambda typingctx, *arguments: (signature, codegen)

    @intrinsic
    def call_address3(typingctx, address, a, b, c):
        """Call the C function ``void f(void*, void*, void*)`` at an address; all arguments are integers."""
        return _caller([cgutils.voidptr_t] * 3)(typingctx)

    @intrinsic
    def call_field(typingctx, address, count, points, parameters, values):
        """Call a compiled formula (see ``sdf.read_native.Compiled``) at an address; all arguments are integers."""
        return _caller([ir.IntType(64)] + [cgutils.voidptr_t] * 3)(typingctx)

    @intrinsic(prefer_literal=True)
    def stack_array(typingctx, count):
        """Uninitialised float64 array of a literal ``count`` elements on the stack, gone when the function returns."""
        array_type = types.Array(types.float64, 1, "C")
        size = count.literal_value

        def codegen(context, builder, signature, arguments):
            array = context.make_array(array_type)(context, builder)
            element = context.get_data_type(types.float64)
            data = cgutils.alloca_once(builder, element, size=ir.Constant(ir.IntType(64), size))
            data.align = 64
            itemsize = context.get_constant(types.intp, 8)
            populate_array(array, data=data, shape=[context.get_constant(types.intp, size)], strides=[itemsize],
                           itemsize=itemsize, meminfo=None)
            return array._getvalue()

        return array_type(count), codegen

else:

    def kernel(function=None, **options):
        return function if function is not None else (lambda function: function)


def table(name: str, dtype):
    """``view(block)``, for kernels: the 1-D array of ``dtype`` that ``block[name + "_address"]`` points at.

    A block is one NumPy record that holds the address and length of every array of a scene, so kernels pass one
    word where they would pass seven for each array, and never touch a reference count that two threads share.
    """
    if not AVAILABLE:
        return None

    def read(context, builder, signature, arguments, field):
        block_type = signature.args[0]
        getter = context.get_getattr(block_type, field)
        return getter(context, builder, block_type, arguments[0], field)

    @intrinsic
    def view(typingctx, block):
        # Written as an intrinsic because a compiled function for each table would cost a tenth of all compile time.
        array_type = types.Array(from_dtype(np.dtype(dtype)), 1, "C")

        def codegen(context, builder, signature, arguments):
            address = read(context, builder, signature, arguments, name + "_address")
            count = read(context, builder, signature, arguments, name + "_count")
            array = context.make_array(array_type)(context, builder)
            element = context.get_data_type(array_type.dtype)
            data = builder.inttoptr(address, element.as_pointer())
            size = context.get_constant(types.intp, context.get_abi_sizeof(element))
            populate_array(array, data=data, shape=[count], strides=[size], itemsize=size, meminfo=None)
            return array._getvalue()

        return array_type(block), codegen

    view.table_name, view.table_dtype = name, np.dtype(dtype) if dtype is not None else None
    return view


def block_dtype(tables: dict[str, np.dtype], scalars: list[tuple] = ()) -> np.dtype:
    """Record type with ``<name>_address`` and ``<name>_count`` for every table, followed by ``scalars``."""
    fields = []
    for name in tables:
        fields += [(name + "_address", np.int64), (name + "_count", np.int64)]
    return np.dtype(fields + list(scalars), align=True)


def fill_table(block: np.ndarray, name: str, array: np.ndarray) -> None:
    """Point table ``name`` of the one-element ``block`` at ``array``, which the caller keeps alive."""
    assert array.flags.c_contiguous and array.ndim == 1
    block[name + "_address"] = array.ctypes.data
    block[name + "_count"] = len(array)
