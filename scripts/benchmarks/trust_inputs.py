# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Potentially harmful inputs, random by a seed: each must give a result or a sentence; anything else is a fault.

``TRIED``: their name, a function of their number and the seed, and the number in a whole run.
"""

from __future__ import annotations

import os
import pathlib
import re
import tempfile
import time

import numpy as np

FORMATS = ("png", "exr", "tif", "jpg", "bmp", "hdr", "tga")


def _damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """Some bytes changed, a part left out, or the end cut off."""
    content = bytearray(content)
    kind = rng.integers(3)
    if kind == 0:
        for place in rng.integers(len(content), size=rng.integers(1, 20)):
            content[place] = rng.integers(256)
    elif kind == 1:
        del content[int(rng.integers(len(content))) :]
    else:
        first = int(rng.integers(len(content)))
        del content[first : first + int(rng.integers(1, 64))]
    return bytes(content)


def _outcomes(inputs, attempt, expected: tuple[type[Exception], ...]) -> dict:
    """How many inputs gave a result, a sentence, and anything else; the processor time of all and of the worst."""
    results = sentences = faults = 0
    worst, started = 0.0, time.process_time()
    for content in inputs:
        begun = time.process_time()
        try:
            attempt(content)
            results += 1
        except expected:
            sentences += 1
        except Exception as error:
            faults += 1
            print(f"{type(error).__name__}: {error}", flush=True)
        worst = max(worst, time.process_time() - begun)
    spent = time.process_time() - started
    return dict(
        tried=len(inputs), results=results, sentences=sentences, faults=faults, worst_seconds=worst, seconds=spent
    )


def _reworded(text: str, rng: np.random.Generator) -> str:
    """A word or a sign left out, doubled, or replaced by another one of the text."""
    words = re.findall(r"\w+|\s+|[^\w\s]", text)
    place = int(rng.integers(len(words)))
    words[place : place + 1] = [[], ["("], [words[int(rng.integers(len(words)))]]][int(rng.integers(3))]
    return "".join(words)


def texts(count: int, seed: int) -> dict:
    """Random programs of the language: of four, one as it is, two with words changed, one with letters."""
    from sdf_lights.sdf.expression import ExpressionError, evaluate
    from support.shapes import random_programs

    rng = np.random.default_rng(seed)
    inputs = []
    for number in range(count):
        text = random_programs.program(seed * count + number)
        for _ in range(number % 4 if number % 4 < 3 else 0):
            text = _reworded(text, rng)
        inputs.append(_damaged(text.encode(), rng).decode("latin-1") if number % 4 == 3 else text)
    return _outcomes(inputs, evaluate, (ExpressionError,))


def examples(count: int, seed: int) -> dict:
    """The worked examples of shapes and the presets of emission, damaged."""
    from sdf_lights.sdf import emission_presets
    from sdf_lights.sdf import examples as shapes
    from sdf_lights.sdf.emission import EmissionExpression
    from sdf_lights.sdf.expression import Expression, ExpressionError

    rng = np.random.default_rng(seed)
    known = [(Expression, example.text) for example in shapes.examples().values()]
    known += [(EmissionExpression, example.text) for example in emission_presets.presets().values()]
    inputs = []
    for number in range(count):
        kind, text = known[int(rng.integers(len(known)))]
        inputs.append((kind, _reworded(text, rng) if number % 2 else _damaged(text.encode(), rng).decode("latin-1")))

    def read(pair) -> None:
        kind, text = pair
        made = kind(text)
        made.shape() if kind is Expression else made.emission()

    return _outcomes(inputs, read, (ExpressionError,))


def certified(count: int, seed: int) -> dict:
    """Random programs as lamps: rays through certified ones, compared with a dense march."""
    from support.lamps.marched import Verdict, verdict

    class Told(Exception):
        """It is no lamp, or not certified, and so its panel says."""

    def try_rays(number: int) -> None:
        found = verdict(number)
        if found is Verdict.WRONG:
            raise AssertionError(f"program {number} is called certified, and rays miss parts of it")
        if found is not Verdict.RIGHT:
            raise Told

    first = 1_000_000 + seed * count  # different from those of the tests
    return _outcomes(range(first, first + count), try_rays, (Told,))


def images(count: int, seed: int) -> dict:
    """Damaged files of every format, read as textures are."""
    import OpenImageIO

    from sdf_lights.blender.sync.pixels import File, Form

    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "picture"
        inputs = []
        for kind in FORMATS:
            whole = path.with_suffix(f".{kind}")
            output = OpenImageIO.ImageOutput.create(str(whole))
            output.open(str(whole), OpenImageIO.ImageSpec(48, 32, 3, "half" if kind in ("exr", "hdr") else "uint8"))
            output.write_image(rng.random((32, 48, 3)).astype(np.float32))
            output.close()
            inputs += [(whole, _damaged(whole.read_bytes(), rng)) for _ in range(-(-count // len(FORMATS)))]

        def read(pair) -> None:
            whole, content = pair
            whole.write_bytes(content)
            file = File(str(whole))
            if file.width * file.height > 1 << 26:
                raise OSError("sync refuses what does not fit into memory")
            file.read(Form())

        return _outcomes(inputs, read, (OSError, MemoryError))


def light_distributions(count: int, seed: int) -> dict:
    """Damaged IES files."""
    from sdf_lights.render import ies

    rng = np.random.default_rng(seed)
    angles = "0 30 60 90 120 150 180"
    values = "\n".join(" ".join(f"{value:.1f}" for value in row) for row in rng.uniform(1.0, 99.0, (4, 7)))
    whole = f"IESNA:LM-63-1995\nTILT=NONE\n1 -1 1.0 7 4 1 2 0.1 0.2 0.3\n1 1 30\n{angles}\n0 30 60 90\n{values}\n"
    inputs = [_damaged(whole.encode(), rng).decode("latin-1") for _ in range(count)]
    return _outcomes(inputs, ies.numbers_of, (ies.IESError,))


def cache(count: int, seed: int) -> dict:
    """Damaged files of the cache of kernels; a result is the saved data or nothing."""
    from sdf_lights.kernel_cache import Files

    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        files = Files(pathlib.Path(folder), "kernel")
        files.save("key", list(range(200)))
        path = files.path("key")
        whole = path.read_bytes()

        def load(content: bytes) -> None:
            path.write_bytes(content)
            os.chmod(path, 0o600)
            if files.load("key") not in (None, list(range(200))):
                raise AssertionError("a damaged file was taken for a good one")

        return _outcomes([_damaged(whole, rng) for _ in range(count)], load, ())


TRIED = {
    "texts of lamps": (texts, 6_000),
    "examples and presets, damaged": (examples, 4_000),
    "image files": (images, 3_500),
    "IES files": (light_distributions, 10_000),
    "files of the cache": (cache, 5_000),
    "random lamps, their rays against a dense march": (certified, 100),
}
