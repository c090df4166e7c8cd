# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Machine code in memory, without a linker: how compiled kernels and formulas start without LLVM.

LLVM emits object files. ``image`` lays out the sections of one as they lie in memory, when it is compiled. What is left
for ``load`` is to copy the bytes, and to add one address to each of some words. Only the object files of Linux on
x86-64 are read, with absolute addresses alone (System V ABI, AMD64 supplement 1.0, section 4.4). Unwind tables are left
out: kernels raise no C++ exceptions.
"""

from __future__ import annotations

import builtins
import ctypes
import functools
import importlib
import importlib.machinery
import importlib.util
import mmap
import pathlib
import platform
import struct
import sys
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

AVAILABLE = sys.platform.startswith("linux") and platform.machine() == "x86_64"

_PAGE = 4096
_SECTION, _SYMBOL, _RELOCATION = struct.Struct("<IIQQQQIIQQ"), struct.Struct("<IBBHQQ"), struct.Struct("<QQq")
_SYMBOLS, _RELOCATIONS, _EMPTY = 2, 4, 8  # SHT_SYMTAB, SHT_RELA, SHT_NOBITS
_ALLOCATED, _EXECUTABLE = 2, 4  # SHF_ALLOC, SHF_EXECINSTR
_UNDEFINED, _COMMON = 0, 0xFFF2  # SHN_UNDEF, SHN_COMMON
_ADDRESS = 1  # R_X86_64_64


class Unsupported(Exception):
    """An object file has something that this module does not know."""


class Image(NamedTuple):
    """Code as it lies in memory."""

    content: bytes
    executable: int  # bytes, whole pages at the start; all others can be written
    symbols: dict[str, int]  # places of what is called from outside
    words: dict[str, bytes]  # symbol -> places (int64) of words to which its address is added; "": that of the image


def image(code: bytes, wanted: tuple[str, ...]) -> Image:
    """The image of an object file, with the places of the ``wanted`` symbols. Raises ``Unsupported``."""
    if code[:6] != b"\x7fELF\x02\x01" or code[18:20] != b"\x3e\x00":
        raise Unsupported("not an object file of Linux on x86-64")
    (start,), (count, of_names) = struct.unpack_from("<Q", code, 40), struct.unpack_from("<HH", code, 60)
    sections = [_SECTION.unpack_from(code, start + _SECTION.size * index) for index in range(count)]
    names = _content(code, sections[of_names])
    content, places = bytearray(), {}
    for executable in (_EXECUTABLE, 0):
        for index, (name, kind, flags, _, _, size, _, _, alignment, _) in enumerate(sections):
            if flags & _ALLOCATED and flags & _EXECUTABLE == executable and _text(names, name) != ".eh_frame":
                _pad(content, alignment)
                places[index] = len(content)
                content += bytes(size) if kind == _EMPTY else _content(code, sections[index])
        if executable:
            _pad(content, _PAGE)
            pages = len(content)

    symbols, found = {}, []
    table = next(section for section in sections if section[1] == _SYMBOLS)
    names = _content(code, sections[table[6]])
    for name, _, _, section, value, size in _SYMBOL.iter_unpack(_content(code, table)):
        text, place = _text(names, name), None
        if section == _COMMON:  # its value is its alignment
            _pad(content, value)
            place = len(content)
            content += bytes(size)
        elif section in places:
            place = places[section] + value
        found.append((text, section, place))
        if text in wanted:
            symbols[text] = place
    _pad(content, _PAGE)

    words: dict[str, list[int]] = {}
    for section in sections:
        if section[1] != _RELOCATIONS or section[7] not in places:
            continue
        for offset, information, addend in _RELOCATION.iter_unpack(_content(code, section)):
            text, where, place = found[information >> 32]
            if information & 0xFFFFFFFF != _ADDRESS or place is None and where != _UNDEFINED:
                raise Unsupported(f"a relocation of kind {information & 0xFFFFFFFF} of {text!r}")
            at = places[section[7]] + offset
            words.setdefault("" if place is not None else text, []).append(at)
            struct.pack_into("<q", content, at, addend + (place or 0))
    return Image(bytes(content), pages, symbols, {name: np.array(at).tobytes() for name, at in words.items()})


def _pad(content: bytearray, alignment: int) -> None:
    content += bytes(-len(content) % max(alignment, 1))


def _content(code: bytes, section: tuple) -> bytes:
    return code[section[4] : section[4] + section[5]]


def _text(names: bytes, at: int) -> str:
    return names[at : names.index(b"\0", at)].decode()


class Loaded:
    """Code that can be called, as long as this object lives."""

    def __init__(self, memory: mmap.mmap, symbols: dict[str, int]):
        self._memory, self._symbols = memory, symbols
        self._first = _first_byte(memory)

    def address(self, symbol: str) -> int:
        """Where something of the image is. Raises KeyError."""
        return self._first + self._symbols[symbol]


def load(code: Image, known: Mapping[str, int] = MappingProxyType({})) -> Loaded:
    """Code in memory. ``known``: addresses of what it calls; all others are those of ``process_symbol``. Raises
    OSError if the system allows no new code, and KeyError for an unknown symbol."""
    memory = mmap.mmap(-1, len(code.content), flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    memory[:] = code.content
    loaded = Loaded(memory, code.symbols)
    content = np.frombuffer(memory, np.uint8)
    for name, at in code.words.items():
        address = _first_byte(memory) if name == "" else known[name] if name in known else process_symbol(name)
        places = np.frombuffer(at, np.int64)[:, None] + np.arange(8)
        content[places] = (content[places].view(np.int64) + np.int64(address)).view(np.uint8)
    del content
    first, size = ctypes.c_void_p(_first_byte(memory)), ctypes.c_size_t(code.executable)
    if _library().mprotect(first, size, mmap.PROT_READ | mmap.PROT_EXEC):
        raise OSError("the system allows no new code")
    return loaded


def _first_byte(memory: mmap.mmap) -> int:
    return ctypes.addressof(ctypes.c_char.from_buffer(memory))


@functools.cache
def _library() -> ctypes.CDLL:
    """All that is in this process."""
    return ctypes.CDLL(None)


@functools.cache
def process_symbol(name: str) -> int:
    """The address of a function of C, of Python or of Numba's run time. Raises KeyError."""
    if name.startswith("PyExc_"):  # in Numba's code, such a name is that of the class, not of a pointer to it
        return id(getattr(builtins, name.removeprefix("PyExc_")))
    helpers = numba_library("numba._helperlib").c_helpers
    if name in helpers:  # C's mathematics
        return helpers[name]
    for prefix, known in (("numba_", helpers), ("NRT_", numba_library("numba.core.runtime._nrt_python").c_helpers)):
        if name.startswith(prefix):
            return known[name.removeprefix(prefix)]
    try:
        return ctypes.addressof(ctypes.c_char.in_dll(_library(), name))
    except ValueError:
        raise KeyError(name) from None


@functools.cache
def numba_library(name: str):
    """A library of Numba, which is a Python module in C: without Numba's Python modules, which take half a second.
    Raises ImportError if there is none."""
    if not AVAILABLE or name in sys.modules:
        return importlib.import_module(name)
    found = importlib.util.find_spec("numba")
    if found is None or found.origin is None:
        raise ImportError("Numba is not installed", name=name)
    path = pathlib.Path(found.origin).parent.joinpath(*name.split(".")[1:])
    for suffix in importlib.machinery.EXTENSION_SUFFIXES:
        library = path.with_name(path.name + suffix)
        if library.is_file():
            spec = importlib.util.spec_from_file_location(name, library)
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            return module
    raise ImportError(f"Numba has no library {name}", name=name)
