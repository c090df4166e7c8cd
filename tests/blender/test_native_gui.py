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


def test_presets_are_bright_and_keep_their_colour(seen):
    for name, color in seen["presets"].items():
        # AgX shows colours of this brightness bright and still saturated.
        assert 0.8 < max(color) < 3.0 and max(color) > 1.5 * min(color), name
    assert seen["own preset"] == ["TORUS", pytest.approx(0.123)]


def test_lamps_of_other_files_can_be_changed_and_lamps_be_assets(seen):
    assert seen["overridden"] == pytest.approx([0.77])
    assert seen["asset"] == [True, 128, 128]


def test_other_engines_say_what_they_render_and_get_meshes(seen):
    is_said, *others = seen["other engine"]
    assert is_said and not any(others) and seen["converted"] == "MESH"
    assert seen["beside"] == [2, "SDF_LIGHTS", True]


def test_words_and_icons(seen):
    assert seen["labels"] == ["Exponent", "Iterations"] and all(seen["icons"])
    assert seen["cure"].endswith("did you mean box?")
    assert len(set(map(tuple, seen["node colours"]))) == 3


def test_thumbnails_of_lights_show_shape_and_colour(seen):
    assert seen["thumbnail"][0] > 0.3


def test_registering_prints_no_warnings(seen):
    assert "register_class" not in seen["printed"].partition("REGISTERED")[0]


# -- the walk of a new user: see scripts/walk_session.py ---------------------------------------------------------------


def test_a_new_user_has_a_neon_sign_in_less_than_twenty_clicks(blender_command, tmp_path):
    session = SESSION.parents[2] / "scripts" / "walk_session.py"
    seen = seen_by(blender_command, session, tmp_path, size=(1240, 800))
    assert seen["engine"] == "SDF_LIGHTS" and seen["lamps"] == ["Neon Heart"]
    assert seen["reddest"] > 0.2
    assert seen["actions"] < 20


# -- bounds: see bounds_session.py -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bounds(blender_command, tmp_path_factory):
    return seen_by(blender_command, SESSION.with_name("bounds_session.py"), tmp_path_factory.mktemp("bounds"))


def test_lamps_of_all_sizes_are_framed(bounds):
    for what in ("framed 5.0", "framed 0.05"):
        assert 0.5 < bounds[what] < 0.95, what
    assert bounds["framed all"] > 0.3


def test_the_circle_of_the_light_grows_with_the_lamp(bounds):
    assert bounds["circle 5.0"] == pytest.approx(100.0 * bounds["circle 0.05"], rel=0.02)


def test_boxes_and_circles_select_bodies(bounds):
    assert bounds["in the box"] == ["Ring"] and bounds["in a box in the hole"] == []
    assert bounds["after B"] == ["Ring"]
    assert bounds["taken off by the circle"] == [] and bounds["after C"] == ["Ring"]


def test_a_thin_lamp_is_seen_all_along_in_solid(bounds):
    assert min(bounds["thin"]) > 0.1


def test_scale_is_applied_to_sizes_or_refused_with_the_reason(bounds):
    assert bounds["applied"] == pytest.approx([1.0, 1.0, 1.0, 2.0, 0.2])
    assert "Lamp 'Ring' stays as it is. A Torus has one size" in bounds["refused"]


def test_the_origin_goes_to_the_geometry_which_stays(bounds):
    assert bounds["origin"] == pytest.approx([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], abs=0.01)


def test_other_engines_get_the_colour_of_the_pattern(bounds):
    red, green, blue = bounds["flame"]
    assert red == pytest.approx(1.0) and red > 1.5 * green > 2.0 * blue
    assert bounds["even"] == pytest.approx([1.0, 1.0, 1.0]) and bounds["tint"] == pytest.approx([1.0, 0.1, 0.1])
