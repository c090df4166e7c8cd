# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Numba as this project uses it: one decorator, one cache folder, arrays and functions reached by address.

The lowest layer, below all kernels. If Numba cannot be imported, ``AVAILABLE`` is False, ``REASON`` gives the reason in
one sentence, and ``kernel`` leaves a function as it is (plain, slow Python). So every module still imports, and the
NumPy reference can take over.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import inspect
import itertools
import pathlib

import numpy as np

from .replaced import replaced_on_gpu

try:
    from llvmlite import binding as llvm
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.core.ccallback import CFunc
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler
    from numba.core.compiler_machinery import PassManager
    from numba.core.registry import CPUDispatcher
    from numba.core.serialize import dumps
    from numba.core.typed_passes import (
        AnnotateTypes,
        IRLegalization,
        NativeLowering,
        NoPythonBackend,
        NopythonRewrites,
        NopythonTypeInference,
        PreLowerStripPhis,
    )
    from numba.core.untyped_passes import (
        DeadBranchPrune,
        FixupArgs,
        GenericRewrites,
        IRProcessing,
        ReconstructSSA,
        TranslateByteCode,
    )
    from numba.extending import intrinsic
    from numba.np.arrayobj import populate_array
    from numba.np.numpy_support import from_dtype

    from .kernel_code import Cache, codegen

    AVAILABLE, REASON = True, ""
except Exception as error:  # an ImportError, or a binary that does not match this NumPy or Python
    AVAILABLE, REASON = False, f"Numba could not be imported ({type(error).__name__}: {error})"

# Reassociation and contraction only: infinities and NaN keep their meaning, because kernels test for them.
FASTMATH = {"contract", "reassoc", "arcp", "nsz"}


_PARTS: list = []
_LOADED: set = set()  # kernels that C calls
_BEGUN: list = []  # kernels that Python calls
_numbers = itertools.count()


def compiled_kernels() -> int:
    """Kernels that were compiled in this process, for linking into others."""
    return sum(len(part.overloads) for part in _PARTS)


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


if AVAILABLE:

    class _WithoutEnvironment:
        """A code generator that does not look up the environment of code that is never emitted."""

        def __init__(self, codegen):
            self._codegen = codegen

        def __getattr__(self, name):
            return getattr(self._codegen, name)

        def set_env(self, name, environment):
            pass

    class _Library(JITCodeLibrary):
        """Code of kernels: each function is optimised for size by itself before it is linked."""

        def _optimize_functions(self, ll_module):
            """As in Numba, but with one pass manager for each function, also for functions that are only declared."""
            ll_module.data_layout = self._codegen._data_layout
            manager, builder = self._codegen._function_pass_manager()
            for function in ll_module.functions:
                if not function.is_declaration:
                    manager.run(function, builder)

    class _Part(_Library):
        """Code of a kernel that other kernels call: intermediate code, which is linked into an entry.

        Numba would link each function with all its callees, optimise it and emit it, at every level of the call tree.
        For a path tracer that is most of the compile time. Here it happens once, in the entry.
        """

        # Not the class itself, because kernels of another copy of this module may be linked in.
        only_linked = True

        @property
        def codegen(self):
            return _WithoutEnvironment(self._codegen)

        def finalize(self):
            self._raise_if_finalized()
            self._finalize_dynamic_globals()
            self._finalized = True

        def _get_module_for_linking(self):
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == llvm.Linkage.external:
                    function.linkage = "linkonce_odr"  # several entries may have it
            return self._final_module

        def get_pointer_to_function(self, name):
            self._ensure_finalized()
            return 0

    class _Entry(_Library):
        """Code of a kernel that is called from outside, with all kernels that it calls."""

        def finalize(self):
            reached, pending = dict.fromkeys(self._linking_libraries), list(self._linking_libraries)
            while pending:
                library = pending.pop()
                if getattr(library, "only_linked", False):
                    found = [other for other in library._linking_libraries if other not in reached]
                    reached |= dict.fromkeys(found)
                    pending += found
            self._linking_libraries = list(reached)
            super().finalize()

    class _Compiler(Compiler):
        """Numba without the passes for closures, comprehensions and ``with``, which kernels do not use."""

        def define_pipelines(self):
            passes = PassManager("kernel")
            for one in (
                TranslateByteCode,
                FixupArgs,
                IRProcessing,
                DeadBranchPrune,
                GenericRewrites,
                ReconstructSSA,
                NopythonTypeInference,
                PreLowerStripPhis,
                NopythonRewrites,
                IRLegalization,
                AnnotateTypes,
                NativeLowering,
                NoPythonBackend,
            ):
                passes.add_pass(one, one.__name__)
            passes.finalize()
            return [passes]

    class _PartCompiler(_Compiler):
        def __init__(self, typing_context, target_context, library, *arguments):
            library = library or _Part(codegen(), f"kernel{next(_numbers)}")
            super().__init__(typing_context, target_context, library, *arguments)

    class _EntryCompiler(_Compiler):
        def __init__(self, typing_context, target_context, library, *arguments):
            if library is None:
                library = _Entry(codegen(), f"entry{next(_numbers)}")
                library.enable_object_caching()
            super().__init__(typing_context, target_context, library, *arguments)

    class _PartDispatcher(CPUDispatcher):
        """A call with a constant argument uses the same kernel as a call with a variable."""

        def get_call_template(self, args, kws):
            return super().get_call_template(tuple(map(types.unliteral, args)), kws)

    class _Kernel:
        """The result of ``kernel``. Kernels link it in. A call from Python compiles it once more as an entry, which is
        optimised, emitted, wrapped for Python, and cached on disk."""

        def __init__(self, function, settings: dict):
            functools.update_wrapper(self, function)
            self._settings = settings

        def __call__(self, *arguments):
            return self._entry(*arguments)

        def loaded(self) -> bool:
            """Whether it is ready, including all that it calls."""
            return self in _LOADED or "_entry" in self.__dict__ and bool(self._entry.overloads)

        def compiled(self) -> bool:
            """Whether it is ready for linking into others."""
            return "_numba_type_" in self.__dict__ and bool(self._numba_type_.dispatcher.overloads)

        @functools.cached_property
        def _entry(self):
            _BEGUN.append(self)
            return _entry(self.__wrapped__, self._settings)

        @functools.cached_property
        def _numba_type_(self):
            """Numba asks for this if another kernel calls this one: never, if all entries come from the cache."""
            settings = {name: value for name, value in self._settings.items() if name != "cache"}
            part = _PartDispatcher(
                self.__wrapped__, targetoptions={**settings, "no_cpython_wrapper": True}, pipeline_class=_PartCompiler
            )
            _PARTS.append(part)
            return types.Dispatcher(part)

    def _entry(function, options: dict):
        options = dict(options)
        cached = options.pop("cache")
        dispatcher = CPUDispatcher(py_func=function, targetoptions=options, pipeline_class=_EntryCompiler)
        if cached:
            code = function.__code__
            # Tests make kernels in functions, which differ in their closures.
            closed = dumps(tuple(cell.cell_contents for cell in function.__closure__ or ()))
            own = hashlib.sha256(code.co_code + closed).hexdigest()[:16]
            place = function.__qualname__, code.co_firstlineno, own
            dispatcher._cache = Cache(pathlib.Path(code.co_filename), *place)
        return dispatcher

    def kernel(function=None, **options):
        """Compile ``function`` with Numba on first use: no GIL, cached on disk, division by zero gives infinity.

        Functions and their arguments are scalars, tuples of floats (vectors, RGB), NumPy arrays and records.
        """
        if function is None:
            return lambda function: kernel(function, **options)
        settings = dict(
            nopython=True,
            boundscheck=None,
            nogil=True,
            cache=True,
            error_model="numpy",
            fastmath=FASTMATH,
            no_cfunc_wrapper=True,
        )
        settings.update(options)
        return _Kernel(function, settings)

    def _caller(kinds):
        """Intrinsic that calls a C function without a result at an address; ``kinds`` are the types of its
        arguments."""
        signature = types.void(*[types.int64] * (1 + len(kinds)))

        def codegen(context, builder, signature, arguments):
            function = builder.inttoptr(arguments[0], ir.FunctionType(ir.VoidType(), kinds).as_pointer())
            builder.call(
                function,
                [
                    builder.inttoptr(value, kind) if isinstance(kind, ir.PointerType) else value
                    for kind, value in zip(kinds, arguments[1:])
                ],
            )
            return context.get_dummy_value()

        return lambda typingctx, *arguments: (signature, codegen)

    @intrinsic
    def call_address3(typingctx, address, a, b, c):
        """Call the C function ``void f(void*, void*, void*)`` at an address; all arguments are integers."""
        return _caller([cgutils.voidptr_t] * 3)(typingctx)

    @intrinsic
    def call_field(typingctx, address, count, points, parameters, values):
        """Call a compiled formula (see ``graph.codegen_native.Compiled``) at an address; all arguments are integers."""
        return _caller([ir.IntType(64)] + [cgutils.voidptr_t] * 3)(typingctx)

    @intrinsic
    def call_surface_code(typingctx, address, block, workspace, surface, parameters, values):
        """Call code of ``graph.codegen_native.compiled_at_surface`` at an address; all arguments are integers."""
        return _caller([ir.IntType(64)] * 3 + [cgutils.voidptr_t] * 2)(typingctx)

    @replaced_on_gpu
    @intrinsic(prefer_literal=True)
    def call_part(typingctx, address, block, workspace, given, count):
        """Call a ``CallablePart`` at an address, for a block and a workspace, with a tuple of numbers. Returns a tuple
        of a literal ``count`` of results."""
        kind = types.UniTuple(types.float64, count.literal_value)

        def codegen(context, builder, signature, arguments):
            word, double = ir.IntType(64), ir.DoubleType()
            numbers = cgutils.alloca_once(builder, double, size=ir.Constant(word, max(len(given), 1)))
            results = cgutils.alloca_once(builder, double, size=ir.Constant(word, count.literal_value))
            for index, number in enumerate(given):
                value = context.cast(builder, builder.extract_value(arguments[3], index), number, types.float64)
                builder.store(value, builder.gep(numbers, [ir.Constant(word, index)]))
            function = builder.inttoptr(arguments[0], ir.FunctionType(ir.VoidType(), [word] * 4).as_pointer())
            builder.call(function, [builder.ptrtoint(pointer, word) for pointer in (*arguments[1:3], numbers, results)])
            return context.make_tuple(
                builder,
                kind,
                [
                    builder.load(builder.gep(results, [ir.Constant(word, index)]))
                    for index in range(count.literal_value)
                ],
            )

        return kind(address, block, workspace, given, count), codegen

    @intrinsic
    def address_of_record(typingctx, record):
        """Address of a record, as an integer."""

        def codegen(context, builder, signature, arguments):
            return builder.ptrtoint(arguments[0], context.get_value_type(types.int64))

        return types.int64(record), codegen

    def _record_at(dtype):
        """Intrinsic that returns the record of ``dtype`` at an address."""
        record = from_dtype(np.dtype(dtype))

        @intrinsic
        def view(typingctx, address):
            def codegen(context, builder, signature, arguments):
                return builder.inttoptr(arguments[0], context.get_value_type(record))

            return record(address), codegen

        return view

    def array_at(dtype, count: int):
        """Intrinsic that returns the 1-D array of ``count`` numbers of ``dtype`` at an address, which may be a
        float."""
        array_type = types.Array(from_dtype(np.dtype(dtype)), 1, "C")
        itemsize = np.dtype(dtype).itemsize

        @intrinsic
        def view(typingctx, address):
            """The numbers at an address."""

            def codegen(context, builder, signature, arguments):
                array = context.make_array(array_type)(context, builder)
                place = context.cast(builder, arguments[0], signature.args[0], types.int64)
                data = builder.inttoptr(place, context.get_data_type(array_type.dtype).as_pointer())
                size = context.get_constant(types.intp, itemsize)
                shape = [context.get_constant(types.intp, count)]
                populate_array(array, data=data, shape=shape, strides=[size], itemsize=size, meminfo=None)
                return array._getvalue()

            return array_type(address), codegen

        return view

    _ANY = 1 << 40  # the real number of elements is in the head of a table
    doubles_at, floats_at, ints_at = (array_at(dtype, _ANY) for dtype in (np.float64, np.float32, np.int32))

    @intrinsic(prefer_literal=True)
    def _load_numbers(typingctx, address, count):
        """A tuple of a literal ``count`` of doubles at an address."""
        kind = types.UniTuple(types.float64, count.literal_value)

        def codegen(context, builder, signature, arguments):
            start = builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())
            return context.make_tuple(
                builder,
                kind,
                [
                    builder.load(builder.gep(start, [ir.Constant(ir.IntType(64), index)]))
                    for index in range(count.literal_value)
                ],
            )

        return kind(types.int64, count), codegen

    @intrinsic
    def _store_numbers(typingctx, address, numbers):
        """Write a number, or each of a tuple, as doubles at an address."""
        kinds = list(numbers) if isinstance(numbers, types.BaseTuple) else [numbers]

        def codegen(context, builder, signature, arguments):
            start = builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())
            for index, kind in enumerate(kinds):
                number = arguments[1]
                if isinstance(numbers, types.BaseTuple):
                    number = builder.extract_value(number, index)
                number = context.cast(builder, number, kind, types.float64)
                builder.store(number, builder.gep(start, [ir.Constant(ir.IntType(64), index)]))
            return context.get_dummy_value()

        return types.void(address, numbers), codegen

    def _c_function(function, arguments: int, kernel, key: list) -> CFunc:
        """``function`` calls ``kernel`` from C, with so many integers and no result; it is loaded from a file or
        compiled. ``key`` separates its file from those of other kernels with the same sources."""
        settings = dict(nopython=True, boundscheck=None, nogil=True, error_model="numpy", fastmath=FASTMATH)
        # The machine code has this name. Kernels written by several processes may meet in the process that reads them.
        function.__name__ = function.__qualname__ = "_".join(map(str, key))
        compiled = CFunc(
            function, ((types.int64,) * arguments, types.void), {}, settings, pipeline_class=_EntryCompiler
        )
        compiled._cache = Cache(pathlib.Path(kernel.__wrapped__.__code__.co_filename), *key)
        compiled.compile()
        _LOADED.add(kernel)
        return compiled

    class Callback:
        """A kernel of one record as a C function ``void f(record *)``, for libraries to call: ``address``."""

        def __init__(self, kernel, record: np.dtype):
            record_at = _record_at(record)

            def function(address):
                kernel(record_at(address))

            key = [kernel.__wrapped__.__name__]
            self._compiled = _c_function(function, 1, kernel, key)
            self.address = self._compiled.address

    class CallablePart:
        """A kernel as a C function ``void f(int64 block, int64 workspace, int64 operands, int64 results)``. Compiled
        formulas call it, and other kernels do (``call_part``). It is compiled on first use, and cached on disk."""

        def __init__(self, kernel, static: tuple[int, ...], operands: int, records: tuple | None):
            """``records``: types of the block and the workspace, if the kernel uses them."""
            function = _called(kernel, static, operands, records)
            key = [kernel.__wrapped__.__name__, *static, operands]
            if records is not None:  # their fields may change without a change of the kernel's sources
                layouts = "".join(str(from_dtype(np.dtype(record))) for record in records)
                key.append(hashlib.sha256(layouts.encode()).hexdigest()[:16])
            self._compiled = _c_function(function, 4, kernel, key)
            self.address = self._compiled.address

        def fill(self, operands: np.ndarray, results: np.ndarray) -> None:
            """Results (n, count) for operands (n, count), both float64 and contiguous, of a kernel without records."""
            strides = operands.strides[0], results.strides[0]
            _call_each(self.address, len(results), operands.ctypes.data, strides[0], results.ctypes.data, strides[1])

    @intrinsic
    def call_numbers(typingctx, address, operands, results):
        """Call a ``CallablePart`` that needs no records; all arguments are integers."""
        signature, codegen = _caller([ir.IntType(64)] * 4)(typingctx)

        def without_records(context, builder, _, arguments):
            nothing = ir.Constant(ir.IntType(64), 0)
            return codegen(context, builder, signature, (arguments[0], nothing, nothing, *arguments[1:]))

        return types.void(*[types.int64] * 3), without_records

    @kernel
    def _call_each(address, count, operands, operand_stride, results, result_stride):
        for index in range(count):
            call_numbers(address, operands + index * operand_stride, results + index * result_stride)

    def _called(kernel, static: tuple[int, ...], operands: int, records: tuple | None):
        if records is None:
            if operands == 0:

                def function(block, workspace, given, results):
                    _store_numbers(results, kernel(*static))
            elif static:

                def function(block, workspace, given, results):
                    _store_numbers(results, kernel(*(static + _load_numbers(given, operands))))
            else:

                def function(block, workspace, given, results):
                    _store_numbers(results, kernel(*_load_numbers(given, operands)))

            return function
        block_at, workspace_at = (_record_at(record) for record in records)
        if operands == 0:

            def function(block, workspace, given, results):
                _store_numbers(results, kernel(block_at(block), workspace_at(workspace), *static))
        elif static:

            def function(block, workspace, given, results):
                _store_numbers(
                    results,
                    kernel(block_at(block), workspace_at(workspace), *(static + _load_numbers(given, operands))),
                )
        else:

            def function(block, workspace, given, results):
                _store_numbers(
                    results, kernel(block_at(block), workspace_at(workspace), *_load_numbers(given, operands))
                )

        return function

    @intrinsic
    def float_of_bits(typingctx, bits):
        """The double with the bits of an integer."""

        def codegen(context, builder, signature, arguments):
            return builder.bitcast(arguments[0], ir.DoubleType())

        return types.float64(types.int64), codegen

    @replaced_on_gpu
    @intrinsic
    def float_bits(typingctx, number):
        """The bits of a number in single precision, as uint32."""

        def codegen(context, builder, signature, arguments):
            return builder.bitcast(builder.fptrunc(arguments[0], ir.FloatType()), ir.IntType(32))

        return types.uint32(types.float64), codegen

    @replaced_on_gpu
    @intrinsic(prefer_literal=True)
    def stack_array(typingctx, count):
        """Uninitialised float64 array of a literal ``count`` elements on the stack, valid until the function
        returns."""
        array_type = types.Array(types.float64, 1, "C")
        size = count.literal_value

        def codegen(context, builder, signature, arguments):
            array = context.make_array(array_type)(context, builder)
            element = context.get_data_type(types.float64)
            data = cgutils.alloca_once(builder, element, size=ir.Constant(ir.IntType(64), size))
            data.align = 64
            itemsize = context.get_constant(types.intp, 8)
            populate_array(
                array,
                data=data,
                shape=[context.get_constant(types.intp, size)],
                strides=[itemsize],
                itemsize=itemsize,
                meminfo=None,
            )
            return array._getvalue()

        return array_type(count), codegen

else:

    def kernel(function=None, **options):
        return function if function is not None else (lambda function: function)

    def float_bits(number):
        return int(np.float32(number).view(np.uint32))

    def float_of_bits(bits):
        return float(np.int64(bits).view(np.float64))

    def _reader(kind):
        class Memory:
            """Numbers at an address."""

            def __init__(self, address):
                self.first = int(address)

            def __getitem__(self, index):
                return kind.from_address(self.first + ctypes.sizeof(kind) * int(index)).value

        return Memory

    def stack_array(count):
        return np.empty(count)

    doubles_at, floats_at, ints_at = _reader(ctypes.c_double), _reader(ctypes.c_float), _reader(ctypes.c_int32)

    # Kernels that call machine code import these. Without Numba, such kernels cannot be called.
    call_address3 = call_field = call_surface_code = call_part = call_numbers = address_of_record = CallablePart = (
        Callback
    ) = None


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


def table(name: str, dtype):
    """``view(block)``, for kernels: the 1-D array of ``dtype`` that ``block[name + "_address"]`` points at.

    A block is one NumPy record with the address and length of every array of a scene. So kernels pass one word instead
    of seven for each array, and never touch a reference count shared by threads.
    """
    if not AVAILABLE:
        return None

    def read(context, builder, signature, arguments, field):
        block_type = signature.args[0]
        getter = context.get_getattr(block_type, field)
        return getter(context, builder, block_type, arguments[0], field)

    @intrinsic
    def view(typingctx, block):
        # An intrinsic, because a compiled function for each table would cost a tenth of all compile time.
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


_LINE = 128  # bytes: a cache line and its neighbour, which processors fetch together


def new_tables(dtypes: dict[str, np.dtype], counts: dict[str, int]) -> dict[str, np.ndarray]:
    """Tables of so many elements, all zero, in a separate piece of memory. Raises MemoryError if there is not enough.

    They share no cache line with other tables, which may belong to another thread: two threads that write to one line
    slow each other down. Each table begins at a cache line, as Embree requires for rays.
    """
    sizes = {name: -(-count * dtypes[name].itemsize // _LINE) * _LINE for name, count in counts.items()}
    memory = np.zeros(sum(sizes.values()) + _LINE, np.uint8)
    tables, at = {}, -memory.ctypes.data % _LINE
    for name, count in counts.items():
        tables[name] = memory[at : at + count * dtypes[name].itemsize].view(dtypes[name])
        at += sizes[name]
    return tables
