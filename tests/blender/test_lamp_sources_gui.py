# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of all sources in Blender's window: see lamp_sources_session.py. An exception in a panel fails it."""

import pathlib

import pytest
from sessions import seen_by

SESSION = pathlib.Path(__file__).with_name("lamp_sources_session.py")


@pytest.mark.gui
def test_the_panel_and_the_body_follow_each_source(blender_command, tmp_path):
    seen = seen_by(blender_command, SESSION, tmp_path, size=(1200, 800))
    assert seen["object button"] and seen["image button"] and seen["network button"]
    for name in ("text", "curve", "mesh", "text again"):  # rings: dark in the middle
        assert min(seen[name]["right"]) > 3.0 * max(seen[name]["middle"]), name
    for name in ("text changed", "image"):
        assert min(seen[name]["middle"]) > 0.3, name
    assert max(seen["text changed"]["right"]) < 0.3 * min(seen["text again"]["right"])
    assert max(seen["image changed"]["right"]) < 0.3 * min(seen["image"]["right"])
    assert seen["mesh"]["bounds"] != seen["mesh changed"]["bounds"] and seen["neon"]["bounds"] != seen["text"]["bounds"]
    if "volume" in seen:
        assert min(seen["volume"]["middle"]) > 0.3
