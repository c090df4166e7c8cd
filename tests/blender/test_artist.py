# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An artist's session in Blender's window: see artist_session.py."""

import pathlib

import pytest
from sessions import seen_by

SESSION = pathlib.Path(__file__).with_name("artist_session.py")


@pytest.fixture(scope="module")
def seen(blender_command, tmp_path_factory):
    return seen_by(blender_command, SESSION, tmp_path_factory.mktemp("artist"), size=(1200, 800))


@pytest.mark.gui
def test_a_lamp_is_added_by_keys_undone_and_redone(seen):
    assert seen["added"] == ["Box Frame Lamp"] and seen["shape"] == "BOX_FRAME"
    assert seen["undone"] == 0 and seen["redone"] == ["BOX_FRAME"]


@pytest.mark.gui
def test_a_mistake_in_a_text_is_found_and_mended_by_typing(seen):
    assert seen["line"] == [1, 12]
    assert "sphere(" in seen["mended"] and seen["sliders"] == ["sdf_size"] and seen["formula"] == "Difference"


@pytest.mark.gui
def test_nodes_are_shown_added_grouped_and_say_what_is_wrong(seen):
    assert seen["nodes"] == ["Box", "Difference", "Lamp Output", "Math", "Parameter", "Sphere"] and seen["shown"]
    assert seen["added node"] == ["Torus Knot"]
    assert seen["mistake"] == ["Radius gets a vector, but takes a number: connect another output."]
    assert seen["groups"] == ["SDFLIGHTS_NodeGroup", 2, True, True] and seen["after"] == []


@pytest.mark.gui
def test_nothing_is_left_behind(seen):
    assert seen["left"] == []
