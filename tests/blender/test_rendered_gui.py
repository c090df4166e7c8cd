# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The path tracer in a viewport of a Blender with a window, while artists go on working."""

import pathlib
import subprocess

import numpy as np
import pytest
from sessions import seen_by

SESSION, ESCAPE = (pathlib.Path(__file__).with_name(f"{name}_session.py") for name in ("rendered", "escape"))

pytestmark = pytest.mark.gui


SIZE = 800, 540


@pytest.fixture(scope="module")
def seen(blender_command, tmp_path_factory) -> dict:
    folder = tmp_path_factory.mktemp("rendered")
    return seen_by(blender_command, SESSION, folder, str(folder / "saved.blend"), size=SIZE)


def test_the_lamp_is_seen_and_lights_the_floor(seen):
    for place in ("lamp", "floor"):
        red, green, blue = seen[place]
        assert red > 0.05 and red > 2.0 * green and red > 2.0 * blue, place
    assert seen["lamp"][0] > 2.0 * seen["floor"][0]


def test_a_click_on_the_body_of_a_lamp_selects_it(seen):
    floor, lamp, both = seen["clicked"]
    assert floor == ["Floor", ["Floor"]], "Blender selects what is no lamp"
    assert lamp == ["Red", ["Red"]]
    assert both[1] == ["Floor", "Red"]


def test_orbiting_shows_pictures_on_the_way(seen):
    assert seen["orbit turned by"] > 5.0
    assert seen["pictures while orbiting"] >= 3
    assert seen["picture after the orbit is of the view"]
    # A ball's middle looks the same from everywhere.
    assert seen["lamp after the orbit"] == pytest.approx(seen["lamp"], rel=0.1)


def test_two_hundred_undos_and_redos_while_rendering(seen):
    assert seen["undos"] == 200
    assert seen["undos while rendering"] > 180
    assert len(seen["places of undo"]) > 10, "the keys did not reach Blender"
    assert seen["most threads while undoing"] == 1
    assert seen["lamp after undo"] == pytest.approx(seen["lamp"], rel=0.1)
    assert seen["floor after undo"] == pytest.approx(seen["floor"], rel=0.15, abs=0.01)


def test_local_view_has_what_is_in_it(seen):
    assert max(seen["lamp in local view"]) < 0.1 * max(seen["lamp"])


def test_render_regions(seen):
    x0, y0, x1, y1, width, height = seen["window of the region"]
    assert (x0, y0, y1) == (0, 0, height) and x1 == pytest.approx(width / 2, abs=2)
    assert max(seen["floor outside of the region"]) < 0.1 * max(seen["floor"])
    x0, y0, x1, y1, width, height = seen["window of the camera's region"]
    assert 0 < x0 < x1 < width and 0 < y0 < y1 < height
    # Half of the frame in both directions, whose sides are 16 to 9, around the middle of the viewport.
    assert (x1 - x0) / (y1 - y0) == pytest.approx(640 / 360, rel=0.02)
    assert x0 + x1 == pytest.approx(width, abs=2) and y0 + y1 == pytest.approx(height, abs=2)


def test_the_view_of_the_camera(seen):
    assert seen["lamp in camera view"] == pytest.approx(seen["lamp"], rel=0.1)


def test_threads_end_with_what_they_render_for(seen):
    assert seen["threads of two viewports"] == 2
    assert seen["threads after one was closed"] == 1
    for what in ("engine", "editor", "shading"):
        assert seen[f"threads after another {what}"] == 0, what
    assert seen["threads after loading"] <= 1


def test_escape_cancels_the_final_render_and_keeps_its_picture(blender_command, tmp_path):
    has_xdotool = "import shutil; print('xdotool:', shutil.which('xdotool'))"
    said = subprocess.run(
        [*blender_command, "--background", "--python-expr", has_xdotool], capture_output=True, text=True
    )
    if "xdotool: /" not in said.stdout:
        pytest.skip("there is no xdotool to press Esc with")
    found = seen_by(blender_command, ESCAPE, tmp_path, size=SIZE, real_keys=True)
    assert found["renders"]
    assert found["seconds"] < 10.0
    height, width, brightest = found["picture"]
    assert (height, width) == (90, 160) and brightest > 0.1


def test_a_saved_file_renders_as_before(seen):
    assert seen["shape after loading"][0] == "SPHERE" and seen["shape after loading"][1] == pytest.approx(0.7)
    np.testing.assert_allclose(seen["lamp after loading"], seen["lamp before saving"], rtol=0.1, atol=0.02)


def test_nothing_went_wrong(seen):
    assert seen["failures"] == {} and seen["errors"] == []


def test_blender_ends_in_the_middle_of_a_render(seen):
    assert seen["code"] == 0
