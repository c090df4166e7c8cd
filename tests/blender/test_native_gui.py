# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What people who know Blender expect of a lamp, in Blender's window: see native_session.py."""

import pathlib

import pytest
from sessions import seen_by

SESSION = pathlib.Path(__file__).with_name("native_session.py")

pytestmark = pytest.mark.gui


@pytest.fixture(scope="module")
def seen(blender_command, tmp_path_factory):
    return seen_by(blender_command, SESSION, tmp_path_factory.mktemp("native"))


def test_an_arrow_has_a_name_and_is_undone_by_itself(seen):
    assert seen["hover"] == ["Half Size X: 50 cm"]
    assert seen["grown"] == pytest.approx(1.5, abs=0.05) and seen["undone"] == [True]


def test_an_arrow_stops_where_the_shape_would_end(seen):
    assert seen["held"] and seen["valid"] == ""


def test_a_half_typed_expression_keeps_the_last_good_shape(seen):
    assert seen["kept"] == 1 and "Last good shape" in seen["said"]
    assert "last good shape in viewports. In its expression:" in seen["reason"]


def test_both_places_have_the_same_panels_in_the_same_order(seen):
    assert seen["sections"]["sidebar"] == seen["sections"]["properties"]
    assert [label for label, _ in seen["sections"]["sidebar"]] == [
        "Shape",
        "Emission",
        "Pattern",
        "Visibility",
        "Readout",
        "Details",
    ]
    assert ["Readout", True] in seen["sections"]["sidebar"]


def test_editors_are_opened_where_there_are_none(seen):
    assert seen["before"] == [0, 0] and seen["text"] and seen["nodes"]


def test_a_line_in_the_header_tells_of_warnings(seen):
    assert seen["warnings"] == "3 warnings" and seen["groups"] == ["Images"]
