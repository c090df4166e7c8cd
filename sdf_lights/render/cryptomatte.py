# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cryptomatte: names as numbers, and the metadata of a file (Friedman and Jones 2015, "Fully automatic ID mattes with
support for motion blur and transparency")."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable

_MASK = 0xFFFFFFFF


def _rotated(x: int, bits: int) -> int:
    return (x << bits | x >> (32 - bits)) & _MASK


def murmur_hash(name: str) -> int:
    """32-bit MurmurHash3 of the name in UTF-8."""
    data = name.encode()
    whole = len(data) // 4 * 4
    value = 0
    for (word,) in struct.iter_unpack("<I", data[:whole]):
        value ^= _rotated(word * 0xCC9E2D51 & _MASK, 15) * 0x1B873593 & _MASK
        value = (_rotated(value, 13) * 5 + 0xE6546B64) & _MASK
    rest = int.from_bytes(data[whole:], "little")
    value ^= _rotated(rest * 0xCC9E2D51 & _MASK, 15) * 0x1B873593 & _MASK
    value ^= len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35)):
        value = (value ^ value >> shift) * factor & _MASK
    return value ^ value >> 16


def number_of(name: str) -> float:
    """The hash of a name as a float32 that is finite and not denormal."""
    value = murmur_hash(name)
    exponent = min(max(value >> 23 & 0xFF, 1), 254)
    return struct.unpack("<f", struct.pack("<I", value & 0x807FFFFF | exponent << 23))[0]


def metadata(layer: str, names: Iterable[str]) -> dict[str, str]:
    """The metadata of one kind of Cryptomatte in a file: ``layer`` is the name of the view layer and of the passes."""
    prefix = f"cryptomatte/{murmur_hash(layer):08x}"[: len("cryptomatte/") + 7]
    manifest = {name: f"{murmur_hash(name):08x}" for name in sorted(set(names))}
    return {
        f"{prefix}/name": layer,
        f"{prefix}/hash": "MurmurHash3_32",
        f"{prefix}/conversion": "uint32_to_float32",
        f"{prefix}/manifest": json.dumps(manifest, ensure_ascii=False, separators=(",", ":")),
    }
