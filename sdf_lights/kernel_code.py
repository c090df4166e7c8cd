# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The stored form of compiled kernels: its content, its processor and its name.

Kernels are compiled for one base processor if the machine supports it. Their stored form does not depend on the folder
or the package name of the installation. So an extension can ship kernels that were compiled when its zip was built, and
a seed gives the same picture on all such machines. Needs Numba.
"""

from __future__ import annotations

import copy
import functools
import hashlib
import importlib
import os
import pathlib
import platform
import re

import numba
import numpy as np
from llvmlite import binding as llvm
from numba.core import config
from numba.core.caching import _Cache as CacheInterface
from numba.core.codegen import JITCPUCodegen
from numba.core.compiler import CompileResult
from numba.core.environment import _rebuild_env
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys

from . import kernel_cache

# The third level of x86-64: all processors of Intel since 2013, and of AMD since 2015, except some of the cheapest.
BASE = "x86-64-v3"
BASE_FEATURES = {"avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2"}

_IMPORT = re.compile(r"^\s*from (\.+|sdf_lights\b)([\w.]*) import (\([^)]*\)|[^\n#]+)", re.MULTILINE)
_ROOT = pathlib.Path(__file__).resolve().parent
_PREFIX = __package__ + "."
_OWN = "<package>."  # stands for ``_PREFIX`` in stored code


@functools.cache
def base_processor() -> str:
    """LLVM's name of the processor that kernels are compiled for; "" for the one of this machine."""
    if config.CPU_NAME is not None or config.CPU_FEATURES is not None:  # NUMBA_CPU_NAME is an explicit choice
        return ""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return ""
    here = llvm.get_host_cpu_features()
    return BASE if all(here.get(name) for name in BASE_FEATURES) else ""


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
    for function in rtsys.library._final_module.functions:
        if not function.is_declaration:  # Numba's run time is code of its own generator
            llvm.add_symbol(function.name, rtsys.library.get_pointer_to_function(function.name))
    return _Codegen("sdf_lights")


@functools.cache
def _imports(path: pathlib.Path) -> frozenset[pathlib.Path]:
    """Source files of the package that the source file ``path`` imports directly."""
    found = set()
    for dots, module, names in _IMPORT.findall(path.read_text(encoding="utf-8")):
        # Only tests, which are outside the package, import it absolutely.
        root = path.parents[len(dots) - 1] if dots.startswith(".") else _ROOT
        base = root.joinpath(*filter(None, module.split(".")))
        candidates = [base.with_suffix(".py"), base / "__init__.py"]
        for name in re.findall(r"\w+", names):
            candidates += [base / f"{name}.py", base / name / "__init__.py"]
        found.update(candidate for candidate in candidates if candidate.is_file())
    if "import_module(" in path.read_text(encoding="utf-8"):  # siblings of the package
        found.update(path.parent.glob("*.py"))
    return frozenset(found)


@functools.cache
def source_hash(path: pathlib.Path) -> str:
    """Hash of a kernel source file, of all that it imports from the package, of Numba, and of NumPy's interface.

    Numba's own cache looks at the time stamp of the one file that defines a function, so it misses changes in the
    called functions. A folder named by this hash gives every such change a clean cache.
    """
    reached, pending = set(), {path}
    while pending:
        reached |= pending
        pending = set().union(*map(_imports, pending)) - reached
    sampler = os.environ.get("SDF_LIGHTS_SAMPLER", "")  # the sampler of the kernels: see ``render.kernels.samplers``
    digest = hashlib.sha256(f"{numba.__version__} {np.__version__.partition('.')[0]} {sampler}".encode())
    for source in sorted(reached):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _kept_name(module: str) -> str:
    """The stored name of a module."""
    return _OWN + module[len(_PREFIX) :] if module.startswith(_PREFIX) else module


def _name_here(module: str) -> str:
    """The name in this installation for a result of ``_kept_name``."""
    return _PREFIX + module[len(_OWN) :] if module.startswith(_OWN) else module


def _reduced(result: CompileResult) -> tuple:
    """The stored form of a compiled function."""
    code, described, own, signature, *_, reached = result._reduce()
    described = copy.copy(described)
    described.modname = _kept_name(described.modname)
    environments = [(_kept_name(each.globals["__name__"]), each.consts, each.env_name) for each in (own, *reached)]
    return code, described, signature, environments


def _rebuilt(target, kept: tuple) -> CompileResult:
    """The compiled function from the result of ``_reduced``, like Numba's own ``_rebuild``, for this copy of the
    package."""
    code, described, signature, environments = kept
    described.modname = _name_here(described.modname)
    importlib.import_module(described.modname)
    own, *reached = [_rebuild_env(_name_here(name), *rest) for name, *rest in environments]
    library = codegen().unserialize_library(code)
    result = CompileResult(
        target_context=target,
        typing_context=target.typing_context,
        library=library,
        environment=own,
        entry_point=target.get_executable(library, described, own),
        fndesc=described,
        type_annotation="",
        signature=signature,
        objectmode=False,
        lifted=(),
        typing_error=None,
        call_helper=None,
        metadata=None,
        reload_init=(),
        referenced_envs=reached,
    )
    for each in reached:
        library.codegen.set_env(each.env_name, each)
    return result


class Cache(CacheInterface):
    """Compiled entries on disk, for Numba: in the user's folder, or else those that the extension ships.

    Loads them without first registering all that Numba can compile, which takes a third of a second: outside itself, an
    entry calls only C's mathematics, Python's interface and Numba's run time. A file that cannot be loaded is compiled
    again. ``source``: file of the kernel; ``place``: parts of its name inside the source folder.
    """

    def __init__(self, source: pathlib.Path, *place):
        source = source.resolve()
        inside = source.is_relative_to(_ROOT)
        # Modules with the same sources have the same hash.
        module = source.relative_to(_ROOT).with_suffix("").parts if inside else (source.stem,)
        self._place = pathlib.Path(source_hash(source), ".".join(module))
        name = "-".join(map(str, place)).replace("<", "").replace(">", "")
        self._files = kernel_cache.Files(
            kernel_cache.writable_folder() / self._place,
            name,
            shipped=kernel_cache.SHIPPED / self._place if inside else None,
        )

    @property
    def cache_path(self):
        return str(kernel_cache.writable_folder() / self._place)

    def enable(self):
        pass

    disable = enable

    def flush(self):
        self._files.flush()

    def _key(self, signature) -> tuple:
        return signature, codegen().magic_tuple(), platform.python_version_tuple()[:2]

    def load_overload(self, sig, target_context):
        rtsys.initialize(target_context)
        kept = self._files.load(self._key(sig))
        if kept is None:
            return None
        try:
            return _rebuilt(target_context, kept)
        except Exception:  # any exception of Numba for a file written by another version
            self._files.forget(self._key(sig))
            return None

    def save_overload(self, sig, data):
        if not data.library.has_dynamic_globals:
            self._files.save(self._key(sig), _reduced(data))
