# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every panel is in a picture that a document shows."""

import pathlib
import subprocess
import sys

import artist_screenshots
import pytest

DOCUMENTS = pathlib.Path(__file__).resolve().parents[2] / "docs"
# The sidebar has the same panels of a lamp as the tab Data.
LISTED = """
import sys
import bpy
import host
from bl_ui.utils import PresetPanel
from sdf_lights import blender

blender.register()
for kind in bpy.types.Panel.__subclasses__():
    if kind.__module__.startswith("sdf_lights.") and not issubclass(kind, PresetPanel):
        print("panel", kind.__name__.removeprefix("SDFLIGHTS_PT_").replace("view3d_", "light_"))
host.finish(0)
"""


def test_every_panel_is_in_a_picture():
    pytest.importorskip("bpy")
    environment = {"PYTHONPATH": str(DOCUMENTS.parent / "scripts")}
    done = subprocess.run([sys.executable, "-c", LISTED], env=environment, capture_output=True, text=True, timeout=300)
    panels = {line.split()[1] for line in done.stdout.splitlines() if line.startswith("panel ")}
    assert len(panels) > 30, done.stderr
    shown = " ".join(artist_screenshots.PANELS.values()).replace("view3d_", "light_").split()
    assert panels == set(shown)


@pytest.mark.parametrize("name", artist_screenshots.PANELS)
def test_a_document_shows_the_picture(name):
    assert (DOCUMENTS / "images" / name).is_file()
    assert any(f"](images/{name})" in path.read_text(encoding="utf-8") for path in DOCUMENTS.glob("*.md"))
