# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs keep to the letter of GLSL: drivers are strict in different places."""

import re
import shutil
import subprocess

import pytest

from sdf_lights import jit
from sdf_lights.render.film import Film
from sdf_lights.render.gpu.packed_scene import GpuScene
from support import scenes
from support.scenes.media import MEDIA_SCENES

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

SCENES = scenes.SCENES | MEDIA_SCENES


def program(name: str) -> str:
    scene = SCENES[name](8, 6)
    return GpuScene(scene, Film(scene, ())).source()


@pytest.mark.parametrize("name", ["transparent", "field_lamps", "shadow_catcher", "environment"])
def test_no_name_is_reserved(name):
    # NVIDIA's compiler takes two underscores in succession for an error, Mesa's does not.
    assert re.findall(r"\b\w*__\w*", program(name)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_the_reference_compiler_has_no_complaint(name, tmp_path):
    compiler = shutil.which("glslangValidator")
    if compiler is None:
        pytest.skip("needs the reference compiler for GLSL: apt-get install glslang-tools")
    path = tmp_path / "program.comp"
    path.write_text(program(name), encoding="utf-8")
    told = subprocess.run([compiler, str(path)], capture_output=True, text=True, timeout=120)
    complaints = [line for line in told.stdout.splitlines() if line.startswith(("ERROR", "WARNING"))]
    assert (told.returncode, complaints) == (0, [])
