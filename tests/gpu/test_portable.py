# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs keep to the letter of GLSL: drivers are strict in different places."""

import re
import shutil
import subprocess

import pytest

from sdf_lights import jit
from sdf_lights.render.film import Film
from sdf_lights.render.gpu import thread_arrays
from sdf_lights.render.gpu.packed_scene import GpuScene
from support import scenes
from support.scenes.lamps import cove
from support.scenes.media import MEDIA_SCENES, VARYING_SCENES
from tests.gpu.support import with_light_paths

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SCENES = scenes.SCENES | MEDIA_SCENES | VARYING_SCENES


def program(name: str, **settings) -> str:
    """That of a graphics card."""
    scene = SCENES[name](8, 6)
    for setting, value in settings.items():
        setattr(scene.settings, setting, value)
    return GpuScene(scene, Film(scene, ())).source()


def complaints(source: str, path) -> tuple[int, list[str]]:
    """What the reference compiler tells of a program."""
    compiler = shutil.which("glslangValidator")
    if compiler is None:
        pytest.skip("needs the reference compiler for GLSL: apt-get install glslang-tools")
    path.write_text(source, encoding="utf-8")
    told = subprocess.run([compiler, str(path)], capture_output=True, text=True, timeout=120)
    return told.returncode, [line for line in told.stdout.splitlines() if line.startswith(("ERROR", "WARNING"))]


@pytest.mark.parametrize("name", ["transparent", "field_lamps", "shadow_catcher", "environment", "thinning_fog"])
def test_no_name_is_reserved(name):
    # NVIDIA's compiler takes two underscores in succession for an error, Mesa's does not.
    assert re.findall(r"\b\w*__\w*", program(name)) == []


def test_connections_to_light_paths_are_no_exception(tmp_path):
    scene, film, tracer = with_light_paths(cove(8, 6))
    source = GpuScene(scene, film, tracer=tracer).source()
    assert re.findall(r"\b\w*__\w*", source) == []
    assert "own_floats[OWN(" in source  # what a point expects of each top node is a long array
    assert complaints(source, tmp_path / "program.comp") == (0, [])


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_the_reference_compiler_has_no_complaint(name, tmp_path):
    assert complaints(program(name), tmp_path / "program.comp") == (0, [])


@pytest.mark.parametrize("name", ["torus_room", "field_lamps", "thinning_fog"])
def test_long_arrays_are_in_a_buffer(name, tmp_path):
    """With direct light alone there are the arrays of cuts, too."""
    source = program(name, max_bounces=0)
    lengths = [int(count) for count in re.findall(r"^float (?!\w*registers)\w+\[(\d+)\];", source, re.MULTILINE)]
    assert lengths and max(lengths) <= thread_arrays.SHORT
    assert "own_floats[OWN(" in source and "own_ints[OWN(" in source
    assert complaints(source, tmp_path / "program.comp") == (0, [])
