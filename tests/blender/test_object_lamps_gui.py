# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A sign in Blender's window: see object_lamps_session.py."""

import pathlib

import pytest
from sessions import seen_by

SESSION = pathlib.Path(__file__).with_name("object_lamps_session.py")


@pytest.mark.gui
def test_a_sign_is_written_drawn_rendered_and_undone(blender_command, tmp_path):
    seen = seen_by(blender_command, SESSION, tmp_path, size=(1200, 800))
    assert seen["added"] == ["OBJECT"]
    assert min(seen["in"]) > 3.0 * max(seen["beside"])
    assert seen["mode"] == "EDIT_TEXT" and seen["body"].lower() == "high"
    assert seen["wider while writing"] == pytest.approx(seen["wider"]) and seen["wider"] > 1.5 * seen["width"]
    assert min(seen["rendered"]) > 0.0
    assert seen["left"] == [] and seen["redone"] == ["Text"]
