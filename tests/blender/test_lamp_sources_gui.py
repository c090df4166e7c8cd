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
    assert seen["object button"] and seen["network button"]
    for name, place in dict(text="letter", curve="ring", mesh="ring").items():  # dark in the middle
        assert min(seen[name][place]) > 0.1 > 3.0 * max(seen[name]["middle"]), name
    for name in ("text changed", "image", "image changed"):
        assert min(seen[name]["middle"]) > 0.1, name
    for before, after in (("text again", "text changed"), ("image", "image changed")):
        assert min(seen[before]["letter"]) > 0.1 > 3.0 * max(seen[after]["letter"]), after
    assert seen["mesh"]["bounds"] != seen["mesh changed"]["bounds"] and seen["neon"]["bounds"] != seen["text"]["bounds"]
    assert seen["network"]["bounds"] != seen["image changed"]["bounds"]
    if "volume" in seen:
        assert min(seen["volume"]["middle"]) > 0.1
