# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Places that faces share: all are found, and those of faces side by side are none."""

import numpy as np
import pytest

from sdf_lights.render.kernels import shared_places
from sdf_lights.render.kernels.shared_places import EVERYWHERE


def quad(low, high, height=0.0, axis=2):
    """Two level triangles."""
    (a, b), (c, d) = low, high
    corners = [[a, b], [c, b], [c, d]], [[a, b], [c, d], [a, d]]
    return np.insert(np.array(corners, np.float32), axis, height, axis=2)


def places(*quads, others=()):
    """What ``shared_places`` finds if each of the quads is an instance: a list of boxes for each."""
    corners = np.concatenate([np.zeros((0, 3, 3), np.float32), *quads])
    boxes = np.array([[each.min((0, 1)), each.max((0, 1))] for each in quads] + list(others), np.float64)
    compared = np.arange(len(boxes)) < len(quads)
    owners = np.repeat(np.arange(len(quads)), 2)
    found, counts = shared_places.shared_places(corners, owners, boxes.reshape(-1, 2, 3), compared, ~compared)
    return np.split(found, np.cumsum(counts)[:-1])


@pytest.mark.parametrize("axis", range(3))
def test_what_level_faces_share(axis):
    floor, foot = quad((0, 0), (4, 4), 1.0, axis), quad((3, 1), (5, 2), 1.0, axis)
    far, above = quad((7, 0), (8, 1), 1.0, axis), quad((0, 0), (4, 4), 1.5, axis)
    for (here,) in places(floor, foot, far, above)[:2]:
        assert np.array_equal(np.delete(here, axis, 1), [[3, 1], [4, 2]]) and np.all(here[:, axis] == 1.0)
    assert [len(each) for each in places(floor, foot, far, above)] == [1, 1, 0, 0]


def test_faces_side_by_side_share_nothing():
    assert not any(map(len, places(quad((0, 0), (1, 1)), quad((1, 0), (2, 1)), quad((0, 1), (1, 2)))))


def test_faces_of_one_mesh():
    twice = np.concatenate([quad((0, 0), (2, 1)), quad((0, 0), (1, 1))])
    found, counts = shared_places.shared_places(
        twice, np.zeros(4, int), np.zeros((1, 2, 3)), np.ones(1, bool), np.zeros(1, bool)
    )
    assert counts.tolist() == [1] and found.tolist() == [[[0, 0, 0], [1, 1, 0]]]


def test_others_may_be_anywhere_in_their_box():
    floor, wall = places(quad((0, 0), (4, 4)), others=[[[1, 1, -1], [2, 2, 3]]])
    assert floor.tolist() == [[[1, 1, 0], [2, 2, 0]]]
    assert np.array_equal(wall, EVERYWHERE[None])


@pytest.mark.parametrize("limit", ["_MOST_PAIRS", "_MOST_PLACES", "_MOST_OTHERS"])
def test_many_places_are_joined(monkeypatch, limit):
    monkeypatch.setattr(shared_places, limit, 1)
    feet = [quad((x, 1), (x + 1, 2)) for x in (0, 4, 8)]
    others = [[[x, 1, 0], [x + 1, 2, 1]] for x in (2, 6)]
    floor = places(quad((0, 0), (10, 4)), *feet, others=others)[0]
    for x in (0, 2, 4, 6, 8):
        assert ((floor[:, 0] <= [x, 1, 0]).all(1) & (floor[:, 1] >= [x + 1, 2, 0]).all(1)).any()
    assert len(floor) < 5


def test_nothing_at_all():
    assert not any(map(len, places()))
