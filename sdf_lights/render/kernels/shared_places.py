# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where several faces lie in exactly the same place, so that a ray which leaves one of them meets the others at once.

There a ray has to look from its very origin on. Elsewhere it may leave out its first roundings (``ray_origins``), and
with them the box of the face that it leaves, which is flat for a level face: Embree has less to do.

Only faces in a plane x, y or z = constant are compared. What rays meet at other faces in the same place is left to
rounding.
"""

from __future__ import annotations

import numpy as np

_MOST_FACES = 1 << 16  # of a mesh whose faces are compared: boxes of finer ones are seldom flat, and it takes time
_MOST_FACES_TOGETHER = 1 << 20
_MOST_PAIRS = 1 << 18  # that are compared, in well under 0.1 s
_MOST_PLACES = 24  # of an instance; more are joined
_MOST_OTHERS = 256  # meshes that are not compared, of which each has a box of its own here
EVERYWHERE = np.array([[-3e38] * 3, [3e38] * 3])  # as a box
_ACROSS = np.array([[1, 2], [0, 2], [0, 1]])  # the axes of a plane, by the axis that it is level along


def shared_places(
    corners: np.ndarray, owners: np.ndarray, boxes: np.ndarray, compared: np.ndarray, others: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (N, 2, 3), as least and greatest coordinates, around all places of the faces of each instance where other
    faces may lie exactly, and how many of them each instance has (instances,): those of the first instance first.

    ``corners`` (T, 3, 3) and ``owners`` (T,): triangles in the world, and their instances, of those that are
    ``compared`` (instances,). ``boxes`` (instances, 2, 3): those of all instances. ``others`` (instances,): those whose
    faces may be anywhere in their box.
    """
    count = len(boxes)
    here, there, places = _regions(corners, owners)
    found = [(here, there, places)]
    alone = np.flatnonzero(~compared)
    found.append((alone, alone, np.repeat(EVERYWHERE[None], len(alone), 0)))
    around = boxes[others]
    if len(around) > _MOST_OTHERS:
        around = np.stack([around[:, 0].min(0), around[:, 1].max(0)])[None]
    own = boxes[compared]
    for number, (low, high) in enumerate(around):
        both = np.stack([np.maximum(own[:, 0], low), np.minimum(own[:, 1], high)], 1)
        meets = (both[:, 0] <= both[:, 1]).all(1)
        met = np.flatnonzero(compared)[meets]
        found.append((met, np.full(len(met), count + number), both[meets]))
    here, there, places = (np.concatenate(parts) for parts in zip(*found))
    here, places = _joined(here, there, places)
    many = np.bincount(here, minlength=count) > _MOST_PLACES
    here, places = _joined(here, np.where(many[here], 0, np.arange(len(here))), places)
    return places, np.bincount(here, minlength=count)


def _joined(here: np.ndarray, there: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One box for each pair of ``here`` and ``there``, and its ``here``, in order."""
    order = np.lexsort((there, here))
    here, there, places = here[order], there[order], places[order]
    first = np.flatnonzero(np.append(True, (np.diff(here) != 0) | (np.diff(there) != 0))[: len(here)])
    if not len(first):
        return here, places
    low, high = np.minimum.reduceat(places[:, 0], first), np.maximum.reduceat(places[:, 1], first)
    return here[first], np.stack([low, high], 1)


def may_compare(counts: np.ndarray) -> np.ndarray:
    """(instances,) bool: those whose faces are not too many to be compared; ``counts``: numbers of them."""
    few = counts <= _MOST_FACES
    return few & (counts[few].sum() <= _MOST_FACES_TOGETHER)


def _regions(corners: np.ndarray, owners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (N, 2, 3) where level triangles overlap others in the same plane, as boxes, with the instance of the
    triangle and that of the other."""
    same = (corners[:, 0] == corners[:, 1]) & (corners[:, 0] == corners[:, 2])
    faces = np.flatnonzero(same.sum(1) == 1)
    axis, corners = same[faces].argmax(1), corners[faces].astype(np.float64)
    low, high = corners.min(1), corners.max(1)
    rows = np.arange(len(faces))
    start = low[rows, _ACROSS[axis, 0]]
    # Next to each other are those of one plane, in the order in which they begin along its first axis.
    order = np.lexsort((start, low[rows, axis], axis))
    owners, axis, corners, low, high = owners[faces][order], axis[order], corners[order], low[order], high[order]
    rows = rows[:, None]
    flat = corners[rows[:, :, None], np.arange(3)[None, :, None], _ACROSS[axis][:, None]]
    level, (first, left), (last, right) = low[rows[:, 0], axis], flat.min(1).T, flat.max(1).T
    met = _following(axis, level, first, last)
    wide = np.zeros(len(axis), bool)
    pairs = np.cumsum(len(met) - np.cumsum(np.bincount(met, minlength=1)))  # within 1, 2, … places
    if pairs[-1] > _MOST_PAIRS:
        most = np.argmax(pairs > _MOST_PAIRS)
        wide = np.isin(level, level[met > most])  # all of these planes counts
        met = np.minimum(met, most)
    a = np.repeat(rows[:, 0], met)
    b = a + 1 + np.arange(len(a)) - np.repeat(np.cumsum(met) - met, met)
    meet = (left[a] <= right[b]) & (left[b] <= right[a])  # along the second axis of the plane, too
    a, b = a[meet], b[meet]
    overlap = _overlap(flat[a], flat[b])
    a, b = a[overlap], b[overlap]
    both = np.stack([np.maximum(low[a], low[b]), np.minimum(high[a], high[b])], 1)
    found = [(owners[a], owners[b], both), (owners[b], owners[a], both)]
    found.append((owners[wide], owners[wide], np.stack([low[wide], high[wide]], 1)))
    here, there, places = (np.concatenate(parts) for parts in zip(*found))
    return here, there, places


def _following(axis: np.ndarray, level: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """(faces,) how many of the next faces are in the same plane, and begin before the face ends. Faces are sorted by
    plane, and by where they begin."""
    number = np.arange(len(axis))
    # Each end goes before what begins there, so that before it are all faces that begin earlier, and those of planes
    # before.
    order = np.lexsort((np.repeat([0, 1], len(axis)), np.append(last, first), np.tile(level, 2), np.tile(axis, 2)))
    begins = order >= len(axis)
    ends = np.empty_like(number)
    ends[order[~begins]] = np.cumsum(begins)[~begins]
    return np.maximum(ends - number - 1, 0)


def _overlap(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Whether triangles (N, 3, 2) have more than edges and corners in common: no side of either separates them."""
    apart = np.zeros(len(a), bool)
    for first, second in ((a, b), (b, a)):
        edges = np.roll(first, -1, 1) - first
        turn = np.sign(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
        for side in range(3):
            way = second - first[:, side, None]
            inside = turn[:, None] * (edges[:, side, None, 0] * way[..., 1] - edges[:, side, None, 1] * way[..., 0])
            apart |= (inside <= 0.0).all(1)
    return ~apart
