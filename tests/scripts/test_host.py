# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The checkout as an add-on, beside another copy of the program in the same process."""

import pathlib
import subprocess
import sys

import pytest

pytest.importorskip("bpy")

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = """
import sys
sys.path[:0] = ["scripts", "."]
import host
from sdf_lights import blender
blender.register()
host.register_extension()
print(host.program().__name__)
blender.unregister()
host.register_extension()
print(host.program("emitter.sampling.external").__name__)
"""


def test_the_copy_that_is_registered_is_found():
    done = subprocess.run([sys.executable, "-c", PROGRAM], cwd=REPOSITORY, capture_output=True, text=True, timeout=300)
    assert done.stdout.split()[-2:] == ["sdf_lights", "sdf_lights_checkout.sdf_lights.emitter.sampling.external"], (
        done.stdout + done.stderr
    )
