# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps in every shading of every engine, in a Blender with a window: see shadings_session.py."""

import pathlib

import pytest
from sessions import seen_by

SESSION = pathlib.Path(__file__).with_name("shadings_session.py")
ENGINES = "BLENDER_EEVEE", "BLENDER_WORKBENCH", "CYCLES", "SDF_LIGHTS"
SHADINGS = "WIREFRAME", "SOLID", "MATERIAL", "RENDERED"

pytestmark = pytest.mark.gui


@pytest.fixture(scope="module")
def report(blender_command, tmp_path_factory) -> dict:
    return seen_by(blender_command, SESSION, tmp_path_factory.mktemp("shadings"), size=(800, 540))


@pytest.fixture(scope="module")
def seen(report) -> dict:
    assert report["failures"] == {}
    return {(row["engine"], row["shading"]): row for row in report["seen"]}


@pytest.mark.parametrize("shading", SHADINGS)
@pytest.mark.parametrize("engine", ENGINES)
def test_a_lamp_is_there_and_ends_at_a_wall(seen, engine, shading):
    if (engine, shading) == ("BLENDER_WORKBENCH", "MATERIAL"):
        pytest.skip("Workbench has no Material Preview")
    row = seen[engine, shading]
    without, with_overlays, alone = (
        row[name] for name in ("overlays, no lamps", "overlays, lamps", "no overlays, lamps")
    )
    path_traced = (engine, shading) == ("SDF_LIGHTS", "RENDERED")
    picture = shading in ("MATERIAL", "RENDERED")  # of which lamps are a part
    assert _glows(without[0]) == path_traced, "the switch among the overlays"
    assert _glows(with_overlays[0])
    assert _glows(alone[0]) == picture, "without overlays"
    if shading == "WIREFRAME":  # one sees through
        assert _glows(with_overlays[1][::-1])
        return
    for colors in (with_overlays, alone):
        assert colors[1] == pytest.approx(without[1], rel=0.1, abs=0.02), "a lamp behind the wall"


def test_meshes_are_gone_through_when_they_change(report):
    """Their depth is drawn for every view; which there are is asked when it may be others."""
    meshes = report["meshes"]
    assert meshes["a turn of the view"] == dict(drawn=True, listed=False, count=2)
    assert meshes["a move"] == dict(drawn=True, listed=True, count=2)
    assert meshes["hiding one"] == dict(drawn=True, listed=True, count=1)
    assert meshes["a filter of the viewport"] == dict(drawn=True, listed=True, count=0)


def _glows(color) -> bool:
    """Whether it is that of the red lamp, whose middle is brighter than 1 in every shading."""
    return color[0] > 1.0 and color[0] > 5.0 * color[2]
