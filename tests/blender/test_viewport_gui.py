# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps and renders in the viewport of a Blender with a window."""

import pathlib

import numpy as np
import pytest
from sessions import seen_by

SESSION = pathlib.Path(__file__).with_name("viewport_session.py")

pytestmark = pytest.mark.gui


@pytest.fixture(scope="module")
def seen(blender_command, tmp_path_factory) -> dict:
    """The report of ``viewport_session.py``."""
    return seen_by(blender_command, SESSION, tmp_path_factory.mktemp("viewport"), size=(900, 600))


@pytest.mark.parametrize("shading", ["SOLID", "WIREFRAME", "RENDERED"])
def test_lamps_glow_in_every_shading(seen, shading):
    glow = np.array(seen[f"{shading} with"]) - seen[f"{shading} without"]
    assert glow[0] > 0.1 and glow[0] > 2.0 * abs(glow[2])


def test_overlay_says_what_is_wrong(seen):
    assert seen["error"] == ""
    assert "Red" in seen["error in expression"] and "expression" in seen["error in expression"]
    assert seen["failures"] == {}


def test_path_tracer_draws(seen):
    red, _, blue = seen["RENDERED path traced"]
    assert red > 0.5 and red > 1.5 * blue
    assert seen["picture after a zoom"]


def test_threads_end_when_nobody_looks(seen):
    assert len(seen["threads"]) == 1
    assert seen["most threads while undoing"] == 1 and seen["renders after undo"]
    for event in ("a change of engine", "a change of shading", "the area has changed", "loading a file"):
        assert seen[f"threads after {event}"] == [], event


def test_blender_ends_in_the_middle_of_a_render(seen):
    assert seen["code"] == 0
