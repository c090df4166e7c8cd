# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names as numbers of Cryptomatte."""

import numpy as np
import pytest

from sdf_lights.render.cryptomatte import metadata, murmur_hash, number_of

# Of MurmurHash3_x86_32 with the seed 0.
KNOWN = {
    "": 0x00000000,
    "hello": 0x248BFA47,
    "hello, world": 0x149BBB7F,
    "The quick brown fox jumps over the lazy dog": 0x2E4FF723,
}


@pytest.mark.parametrize("name", KNOWN)
def test_hash_is_murmur_hash_3(name):
    assert murmur_hash(name) == KNOWN[name]


def test_numbers_are_finite_and_normal():
    numbers = np.array([number_of(f"Object.{index}") for index in range(2000)])
    assert np.isfinite(numbers).all() and (np.abs(numbers) >= np.finfo(np.float32).tiny).all()
    assert (numbers == numbers.astype(np.float32)).all() and len(set(numbers)) == 2000


def test_a_file_names_every_thing_once():
    told = metadata("ViewLayer.CryptoObject", ["b", "a", "b", 'quoted "name"'])
    assert {name.rsplit("/", 1)[1] for name in told} == {"name", "hash", "conversion", "manifest"}
    manifest = next(value for name, value in told.items() if name.endswith("manifest"))
    assert manifest.startswith(f'{{"a":"{murmur_hash("a"):08x}","b":') and 'quoted \\"name\\"' in manifest
