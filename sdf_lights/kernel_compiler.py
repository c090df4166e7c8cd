# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles kernels: Numba with other passes, and with one link for all that an entry calls.

This module imports Numba, which takes half a second and 60 MB, so it is imported only to compile.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import pathlib
from collections.abc import Iterator
from typing import NamedTuple

from llvmlite import binding as llvm
from llvmlite import ir
from numba import types
from numba.core.callconv import CPUCallConv
from numba.core.ccallback import CFunc
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.runtime import rtsys
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
from numba.np import arrayobj

from .garbage import rarely_all_searched
from .kernel_code import FASTMATH, Stored, base_processor, stored_code

SETTINGS = dict(nopython=True, boundscheck=None, nogil=True, error_model="numpy", fastmath=FASTMATH)
_KERNEL = dict(SETTINGS, no_cfunc_wrapper=True)

_parts: list = []
_numbers = itertools.count()


def compiled_kernels() -> int:
    """Kernels that were compiled in this process, for linking into others."""
    return sum(len(part.overloads) for part in _parts)


class _Codegen(JITCPUCodegen):
    """Numba's target, for the base processor. A separate object, so that other add-ons keep theirs."""

    def _get_host_cpu_name(self):
        return base_processor() or super()._get_host_cpu_name()

    def _get_host_cpu_features(self):
        return "" if base_processor() else super()._get_host_cpu_features()


@functools.cache
def codegen() -> _Codegen:
    """The code generator of all kernels of this copy of the package."""
    rtsys.initialize(cpu_target.target_context)
    return _Codegen("sdf_lights")


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
        # Reference counts, so that the code needs no other code of Numba's generator. They come last: LLVM links of
        # such functions only those that the code names already.
        reached.pop(rtsys.library, None)
        self._linking_libraries = [*reached, rtsys.library]
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


def _index(context, builder, kind, index, size):
    """Numba's ``fix_integer_index`` without the test for negative numbers, which count from the end of an array: only
    written ones do in kernels. Samples a second: +4 to 5 %."""
    if not kind.signed or isinstance(index, ir.Constant):
        return _fix_integer_index(context, builder, kind, index, size)
    return context.cast(builder, index, kind, types.intp)


def _describe(self, exception, arguments, place, function):
    """Numba's ``build_excinfo_struct`` with a file's name without folders: the same code anywhere, and nothing about
    the machine in what a zip ships."""
    kind, given, found = _build_excinfo_struct(self, exception, arguments, place, function)
    return kind, given, found and (found[0], pathlib.PurePath(found[1]).name, found[2])


_fix_integer_index, _build_excinfo_struct = arrayobj.fix_integer_index, CPUCallConv.build_excinfo_struct


@contextlib.contextmanager
def _code_of_kernels() -> Iterator[None]:
    """Numba generates code for kernels, instead of for others."""
    with global_compiler_lock:  # others compile their code as before
        arrayobj.fix_integer_index, CPUCallConv.build_excinfo_struct = _index, _describe
        try:
            yield
        finally:
            arrayobj.fix_integer_index = _fix_integer_index
            CPUCallConv.build_excinfo_struct = _build_excinfo_struct


def part(python, settings: dict) -> types.Dispatcher:
    """Numba's type of a kernel that other kernels link in."""
    made = _PartDispatcher(
        python, targetoptions={**_KERNEL, **settings, "no_cpython_wrapper": True}, pipeline_class=_PartCompiler
    )
    _parts.append(made)
    return types.Dispatcher(made)


def is_part_compiled(kind: types.Dispatcher) -> bool:
    """Whether a result of ``part`` is ready for linking."""
    return bool(kind.dispatcher.overloads)


def compiled(python, settings: dict, arguments: tuple) -> tuple[Stored, bool]:
    """A kernel as an entry that Python calls with such arguments, and whether other processes may use it."""
    dispatcher = CPUDispatcher(py_func=python, targetoptions={**_KERNEL, **settings}, pipeline_class=_EntryCompiler)
    with rarely_all_searched(), _code_of_kernels():
        dispatcher.compile(tuple(map(dispatcher.typeof_pyval, arguments)))
    (result,) = dispatcher.overloads.values()
    return _stored(result, result.fndesc.llvm_cpython_wrapper_name), not result.library.has_dynamic_globals


def compiled_for_c(function, arguments: int) -> tuple[Stored, bool]:
    """A function as an entry that C calls with so many integers, and whether other processes may use it."""
    signature = (types.int64,) * arguments, types.void
    made = _CFunction(function, signature, {}, SETTINGS, pipeline_class=_EntryCompiler)
    with rarely_all_searched(), _code_of_kernels():
        made.compile()
    result = made.result
    return _stored(result, result.fndesc.llvm_cfunc_wrapper_name), not result.library.has_dynamic_globals


class _CFunction(CFunc):
    """Keeps what the compiler returned."""

    def _compile_uncached(self):
        self.result = super()._compile_uncached()
        return self.result


def _stored(result, symbol: str) -> Stored:
    others = [each for each in result._find_referenced_environments() if each is not result.environment and each.consts]
    environments = [(each.env_name, tuple(each.consts)) for each in (result.environment, *others)]
    code = stored_code(result.library._get_compiled_object(), (symbol, *(name for name, _ in environments)))
    return Stored(code, symbol, environments)


def linked_by_llvm(code: bytes, known):
    """``kernel_entries.linked`` for an object file."""
    codegen()  # Numba's run time
    for name, address in known.items():
        llvm.add_symbol(name, address)
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(codemodel="jitdefault", jit=True)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return _Linked(engine)


class _Linked(NamedTuple):
    """Code that LLVM loaded."""

    engine: llvm.ExecutionEngine

    def address(self, symbol: str) -> int:
        return self.engine.get_function_address(symbol) or self.engine.get_global_value_address(symbol)
