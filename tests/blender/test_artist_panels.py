# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An artist in the sidebar of Blender's window: see panels_session.py."""

import pathlib

import pytest
from sessions import seen_by

SESSION = pathlib.Path(__file__).with_name("panels_session.py")


@pytest.fixture(scope="module")
def seen(blender_command, tmp_path_factory):
    return seen_by(blender_command, SESSION, tmp_path_factory.mktemp("panels"))


@pytest.mark.gui
def test_a_number_is_changed_for_one_lamp_and_for_all_that_are_selected(seen):
    assert seen["sidebar by N"] and seen["button"]
    assert seen["before"] == [0.05] * 3 and seen["one"] == [0.05, 0.05, 0.06]
    assert seen["all"] == [0.07, 0.07, 0.08]  # all by as much as the active one
    assert seen["animated"]


@pytest.mark.gui
def test_duplicates_deletion_and_undo_by_keys(seen):
    assert seen["linked"] == [4, 2] and seen["deleted"] == 3 and seen["back"] == 4


@pytest.mark.gui
def test_a_lamp_is_added_by_keys_alone_and_can_be_redone(seen):
    assert seen["added"] == "TORUS_KNOT" and seen["redo"] == "SDF_LIGHTS_OT_lamp_add"


@pytest.mark.gui
def test_an_arrow_is_dragged(seen):
    assert seen["dragged"] == pytest.approx(2.0, abs=0.05)


@pytest.mark.gui
def test_the_sidebar_works_at_twice_the_size(seen):
    assert seen["at twice the size"] > 0.0


@pytest.mark.gui
def test_nothing_is_left_behind(seen):
    assert seen["traces"] > 100 and seen["left"] == []
