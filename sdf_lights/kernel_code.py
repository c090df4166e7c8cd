# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What compiled kernels are for: the content, the processor and the sources that name their files.

Kernels are compiled for one base processor if the machine supports it. Their stored form does not depend on the folder
or the package name of the installation. So an extension can ship kernels that were compiled when its zip was built, and
a seed gives the same picture on all such machines.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import os
import pathlib
import platform
import re
import sys
from typing import NamedTuple

import numpy as np

from . import kernel_cache, machine_code

# The third level of x86-64: all processors of Intel since 2013, and of AMD since 2015, except some of the cheapest.
BASE = "x86-64-v3"
BASE_FEATURES = {"avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2"}

# Reassociation and contraction only: infinities and NaN keep their meaning, because kernels test for them.
FASTMATH = {"contract", "reassoc", "arcp", "nsz"}

_IMPORT = re.compile(r"^\s*from (\.+|sdf_lights\b)([\w.]*) import (\([^)]*\)|[^\n#]+)", re.MULTILINE)
ROOT = pathlib.Path(__file__).resolve().parent
_ROOT = f"{ROOT}{os.sep}"
_MOST_BYTES = 1 << 20  # of what is known about sources

_FLAGS = dict(bmi1="bmi", abm="lzcnt", sse4_2="sse4.2")  # names in Linux that are not those in LLVM


def _processor_features() -> set[str]:
    """What this processor has, in LLVM's names."""
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
            flags = next((line for line in file if line.startswith("flags")), "")
        return {_FLAGS.get(name, name) for name in flags.partition(":")[2].split()}
    except OSError:
        from llvmlite import binding as llvm

        return {name for name, has in llvm.get_host_cpu_features().items() if has}


@functools.cache
def base_processor() -> str:
    """LLVM's name of the processor that kernels are compiled for; "" for the one of this machine."""
    if os.environ.get("NUMBA_CPU_NAME") or os.environ.get("NUMBA_CPU_FEATURES"):  # an explicit choice
        return ""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return ""
    return BASE if BASE_FEATURES <= _processor_features() else ""


@functools.cache
def compiler() -> tuple:
    """Numba and LLVM, as far as code depends on them."""
    return tuple(map(version, ("numba", "llvmlite")))


def origin(package: str) -> str:
    """The file that an import of a package would read first; "" if there is none."""
    try:
        found = importlib.util.find_spec(package)
    except ImportError:  # of a finder that refuses the package
        return ""
    return found.origin or "" if found is not None else ""


def version(package: str) -> str:
    """The version of an installed package; "" if there is none.

    ``importlib.metadata`` takes as long as NumPy to import.
    """
    if not origin(package):
        return ""
    root = pathlib.Path(origin(package)).parents[1]
    return next((path.name.split("-")[1] for path in root.glob(f"{package}-*.dist-info")), "")


@functools.cache
def target() -> tuple:
    """Everything that code depends on, beside its sources: the compiler, the system and the processor."""
    system = *compiler(), sys.platform, platform.machine()
    if base_processor():
        return *system, base_processor()
    from llvmlite import binding as llvm

    chosen = tuple(os.environ.get(f"NUMBA_{name}") for name in ("CPU_NAME", "CPU_FEATURES", "ENABLE_AVX"))
    return *system, *chosen, llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


@functools.cache
def _files() -> dict[str, tuple[int, int, int]]:
    """All source files of the package, by their paths: size, and times of changes in nanoseconds."""
    found, pending = {}, [str(ROOT)]
    while pending:
        for entry in os.scandir(pending.pop()):
            if entry.is_dir():
                pending.append(entry.path)
            elif entry.name.endswith(".py"):
                status = entry.stat()
                found[entry.path] = status.st_size, status.st_mtime_ns, status.st_ctime_ns
    return found


def _is_file(path: str) -> bool:
    return path in _files() if path.startswith(_ROOT) else os.path.isfile(path)


def _read(path: str) -> tuple[bytes, tuple[str, ...]]:
    """Hash of a source file, and the source files of the package that it imports directly."""
    found: set[str] = set()
    content = pathlib.Path(path).read_bytes()
    text = content.decode()
    for dots, module, names in _IMPORT.findall(text):
        # Only tests, which are outside the package, import it absolutely.
        root = path.rsplit(os.sep, len(dots))[0] if dots.startswith(".") else str(ROOT)
        base = os.path.join(root, *filter(None, module.split(".")))
        candidates = [base + ".py", os.path.join(base, "__init__.py")]
        for name in re.findall(r"\w+", names):
            inside = os.path.join(base, name)
            candidates += [inside + ".py", os.path.join(inside, "__init__.py")]
        found.update(filter(_is_file, candidates))
    if "import_module(" in text:  # siblings of the package
        found.update(map(str, pathlib.Path(path).parent.glob("*.py")))
    return hashlib.sha256(content).digest(), tuple(sorted(found))


@functools.cache
def _sources() -> dict[str, tuple[bytes, tuple[str, ...]]]:
    """What ``_read`` finds in each source file of the package. It is kept on disk until a file changes."""
    files = kernel_cache.Files(kernel_cache.writable_folder() / "sources", "sources", most=_MOST_BYTES)
    key = hashlib.sha256(repr(sorted(_files().items())).encode()).hexdigest()
    found = files.load(key)
    if found is None:
        found = {path: _read(path) for path in _files()}
        files.save(key, found)
    return found


@functools.cache
def _source(path: str) -> tuple[bytes, tuple[str, ...]]:
    return _sources()[path] if path in _files() else _read(path)


def _common() -> str:
    """What all kernels depend on beside their sources: Numba, and the sampler (see ``render.kernels.samplers``)."""
    return f"{compiler()[0]} {os.environ.get('SDF_LIGHTS_SAMPLER', '')}"


def python_interface() -> tuple:
    """What an entry for Python depends on, and one for C does not: versions of Python and of NumPy's interface."""
    return sys.version_info[:2], np.__version__.partition(".")[0]


def host_hash() -> str:
    """Hash of all that kernels depend on beside their sources: Python, NumPy's interface, Numba, system, processor."""
    return hashlib.sha256(repr((python_interface(), _common(), target())).encode()).hexdigest()[:16]


@functools.cache
def source_hash(path: pathlib.Path) -> str:
    """Hash of a kernel source file, of all that it imports from the package, and of Numba.

    Numba's own cache looks at the time stamp of the one file that defines a function, so it misses changes in the
    called functions. A folder named by this hash gives every such change a clean cache.
    """
    reached: set[str] = set()
    pending = {str(path)}
    while pending:
        reached |= pending
        pending = set().union(*(_source(each)[1] for each in pending)) - reached
    digest = hashlib.sha256(_common().encode())
    for source in sorted(reached, key=lambda source: source.split(os.sep)):
        digest.update(_source(source)[0])
    return digest.hexdigest()[:16]


class Stored(NamedTuple):
    """A compiled entry on disk."""

    code: tuple | bytes  # a ``machine_code.Image``, or an object file where that module cannot load one
    symbol: str  # of the function that is called
    # What the code needs of Python: (symbol, constants), of the entry first.
    environments: list[tuple[str, tuple]]


def stored_code(code: bytes, symbols: tuple[str, ...]) -> tuple | bytes:
    """``Stored.code`` of an object file."""
    return tuple(machine_code.image(code, symbols)) if machine_code.AVAILABLE else code
