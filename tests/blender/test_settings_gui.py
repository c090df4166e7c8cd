# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of Cycles, presets and the scene's report in Blender's window: see settings_session.py."""

import pathlib

import pytest
from sessions import seen_by

SESSION = pathlib.Path(__file__).with_name("settings_session.py")


@pytest.fixture(scope="module")
def seen(blender_command, tmp_path_factory):
    return seen_by(blender_command, SESSION, tmp_path_factory.mktemp("settings"))


@pytest.mark.gui
def test_settings_come_along_once_and_again_when_asked(seen):
    assert seen["copied"] == ["CYCLES", 77, 12.0]
    assert seen["kept"] == 5 and seen["copied again"] == 88
    assert seen["fresh"] == ["OWN", 128]


@pytest.mark.gui
def test_the_report_is_filled(seen):
    assert seen["checked"] == ["FINISHED"]
    assert seen["report"] == {"Scene": [""], "Objects": ["Cube"]}


@pytest.mark.gui
def test_a_preset_is_taken(seen):
    assert seen["preset"] == [32, True]
