# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a first render need not wait for, seen by new processes."""

import os
import pathlib
import shutil
import subprocess
import sys

import pytest

from sdf_lights import kernel_cache, kernel_code, machine_code

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]


def run(code: str, cache: pathlib.Path, timeout: float = 120.0) -> str:
    cache.mkdir(exist_ok=True)
    environment = {**os.environ, "SDF_LIGHTS_CACHE": str(cache), "PYTHONPATH": str(REPOSITORY)}
    return subprocess.run(
        [sys.executable, "-c", code],
        env=environment,
        cwd=cache,
        capture_output=True,
        text=True,
        check=True,
        timeout=timeout,
    ).stdout.strip()


def test_what_is_known_of_sources_is_what_they_contain(tmp_path):
    """Where it was read by this process and where it was found on disk; also after a change of a file."""
    shutil.copytree(REPOSITORY / "sdf_lights", tmp_path / "sdf_lights", ignore=shutil.ignore_patterns("__pycache__"))
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from sdf_lights import kernel_code as known; "
        "paths = known._files(); found = {path: known._source(path) for path in paths}; "
        "assert found == {path: known._read(path) for path in paths}; "
        "print(known.ROOT, known.source_hash(known.ROOT / 'vec.py'), known.source_hash(known.ROOT / 'render' / 'ies.py'))"
    )
    first = run(code, tmp_path / "cache").split()
    assert first[0] == str(tmp_path / "sdf_lights") and run(code, tmp_path / "cache").split() == first
    changed = tmp_path / "sdf_lights" / "render" / "ies.py"
    changed.write_text(changed.read_text(encoding="utf-8").replace("angle", "anglE"), encoding="utf-8")
    second = run(code, tmp_path / "cache").split()
    assert second[:2] == first[:2] and second[2] != first[2]


def test_compiled_entry_loads_without_the_compiler(tmp_path):
    code = (
        "import sys, numpy as np; from sdf_lights import jit; from sdf_lights.emitter.hashing import seeded; "
        "value = seeded(0.25, 0.5, 0.75); "
        "print(int(value), 'numba' in sys.modules or 'llvmlite' in sys.modules, jit.compiled_kernels())"
    )
    value, compiler, _ = run(code, tmp_path).split()
    assert compiler == "True"
    assert run(code, tmp_path).split() == [value, "False", "0"]


def test_entry_that_links_other_kernels_loads_without_them(tmp_path):
    code = (
        "from sdf_lights import jit; from sdf_lights.emitter.primitives.box import box_span; "
        "print(*box_span((0.0, 0.0, -3.0), (0.0, 0.0, 1.0), 1.0, 1.0, 0.5), jit.compiled_kernels())"
    )
    *first, parts = run(code, tmp_path).split()
    assert first == ["2.5", "3.5"] and int(parts) > 0
    assert run(code, tmp_path).split() == [*first, "0"]


def test_lamps_of_one_primitive_need_no_kernels_to_be_built(tmp_path):
    code = (
        "import numpy as np; from sdf_lights.emitter import build_lamp; "
        "from sdf_lights.sdf.shapes import Box, Capsule, Cone, Cylinder, Sphere, Torus; "
        "shapes = Box(), Capsule(), Cone(), Cylinder(), Sphere(), Torus(); "
        "print(*(len(build_lamp('Lamp', shape, np.eye(4)).program) for shape in shapes))"
    )
    assert run(code, tmp_path).split() == ["1"] * 6
    assert not list(tmp_path.rglob("*.kernel"))


FORMULA = (
    "import sys, numpy as np; from sdf_lights import machine_code{set}; "
    "from sdf_lights.emitter.hashing import seeded; from sdf_lights.graph import codegen_native, formula as f; "
    "x, y, z = f.POINT; points = np.linspace(-1, 1, 12).reshape(4, 3); "
    "print(int(seeded(0.25, 0.5, 0.75)), codegen_native.evaluate(f.sin(x) + f.power(y * y, z), points).tobytes().hex(), "
    "'numba' in sys.modules or 'llvmlite' in sys.modules)"
)


@pytest.mark.skipif(not machine_code.AVAILABLE, reason="LLVM loads all code on this platform")
def test_code_that_llvm_loads_gives_the_same(tmp_path):
    """As on Windows and macOS."""
    ours, llvm = FORMULA.format(set=""), FORMULA.format(set="; machine_code.AVAILABLE = False")
    *first, compiler = run(ours, tmp_path / "ours").split()
    assert compiler == "True" and run(ours, tmp_path / "ours").split() == [*first, "False"]
    for _ in range(2):
        assert run(llvm, tmp_path / "llvm").split() == [*first, "True"]


def test_the_processor_is_known_where_no_file_describes_it(monkeypatch):
    """As on Windows and macOS, where LLVM tells."""
    found = kernel_code._processor_features() & kernel_code.BASE_FEATURES

    def refuse(path, *arguments, **options):
        raise FileNotFoundError(path)

    monkeypatch.setattr("builtins.open", refuse)
    assert kernel_code._processor_features() & kernel_code.BASE_FEATURES == found


RENDER = """
import sys
from sdf_lights import jit, machine_code
machine_code.AVAILABLE = {available}
import dataclasses
import numpy as np
from support.scenes import cove
from sdf_lights.render import session
from sdf_lights.render.settings import LampPaths, PathReuse
from sdf_lights.sdf.shapes import Box, Difference, Sphere
scene = cove(16, 12)
scene.lamps[0] = dataclasses.replace(scene.lamps[0], shape=Difference(Box((0.3, 0.3, 0.3)), Sphere(0.36)))
scene.settings = dataclasses.replace(
    scene.settings, samples=2, threads=2, lamp_paths=LampPaths.ALWAYS, path_reuse=PathReuse.NEVER
)
film = session.render(scene, ("Depth",))
print(film.read("Combined").tobytes().hex(), scene.warnings, "numba" in sys.modules, jit.compiled_kernels())
"""


@pytest.mark.slow  # compiles the path tracer for each way to load it
@pytest.mark.skipif(not machine_code.AVAILABLE, reason="LLVM loads all code on this platform")
def test_a_render_with_code_that_llvm_loads_is_the_same(tmp_path):
    """As on Windows and macOS: kernels, formulas and lamps with trees, compiled and from disk. The files hold object
    files."""
    shared = kernel_cache.cache_folder()  # which spares compiling them the usual way, too
    run(RENDER.format(available=True), shared, 1800.0)
    *picture, numba, count = run(RENDER.format(available=True), shared).split()
    assert (numba, count) == ("False", "0")
    *first, numba, count = run(RENDER.format(available=False), tmp_path, 1800.0).split()
    assert first == picture and numba == "True" and int(count) > 100
    assert run(RENDER.format(available=False), tmp_path).split() == [*picture, "True", "0"]
    assert picture[1:] == ["[]"]
    objects, others = (
        [path for path in folder.rglob("*.kernel") if b"\x7fELF" in path.read_bytes()] for folder in (tmp_path, shared)
    )
    assert objects and not others


@pytest.mark.slow
@pytest.mark.skipif(not machine_code.AVAILABLE, reason="LLVM loads all code on this platform")
def test_lamps_with_trees_are_built_without_the_compiler(tmp_path):
    code = (
        "import sys, numpy as np; from sdf_lights.emitter import build_lamp; "
        "from sdf_lights.sdf.shapes import Box, Difference, Sphere; "
        "lamp = build_lamp('Lamp', Difference((Box(), Sphere(0.6))), np.eye(4)); "
        "print(len(lamp.program), 'numba' in sys.modules or 'llvmlite' in sys.modules)"
    )
    count, compiler = run(code, tmp_path).split()
    assert compiler == "True" and run(code, tmp_path).split() == [count, "False"]
