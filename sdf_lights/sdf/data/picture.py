# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The outline of a picture: where its values, joined linearly, are above a threshold, by marching squares.

Lorensen and Cline 1987, in the plane. So the edge lies between pixels to a part of one, and the distance to it is
exact.
"""

from __future__ import annotations

import numpy as np

# Of the corners of a cell, from the lower left one against the hands of a clock, those that are inside, as bits; then
# the edges that segments lead from and to, edge i from corner i to the next, with the inside on their left.
_SEGMENTS: dict[int, list[tuple[int, int]]] = {
    1: [(0, 3)],
    2: [(1, 0)],
    3: [(1, 3)],
    4: [(2, 1)],
    6: [(2, 0)],
    7: [(2, 3)],
    8: [(3, 2)],
    9: [(0, 2)],
    11: [(1, 2)],
    12: [(3, 1)],
    13: [(0, 1)],
    14: [(3, 0)],
}
_APART = {5: [(0, 3), (2, 1)], 10: [(1, 0), (3, 2)]}  # two opposite corners, that do not touch
_TOGETHER = {5: [(0, 1), (2, 3)], 10: [(1, 2), (3, 0)]}
_CORNERS = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])


def contour(values: np.ndarray, threshold: float) -> np.ndarray:
    """Segments (n, 4) around where ``values`` (height, width), the lowest row first, are above ``threshold``.

    Coordinates are pixels: the centre of the first is (0.5, 0.5). Around the picture there is nothing.
    """
    height, width = values.shape
    inside = np.zeros((height + 2, width + 2), bool)
    np.greater(values, threshold, out=inside[1:-1, 1:-1])
    case = np.zeros((height + 1, width + 1), np.uint8)
    for bit, (x, y) in enumerate(_CORNERS):
        case |= inside[y : y + height + 1, x : x + width + 1].astype(np.uint8) << bit
    row, column = np.nonzero((case != 0) & (case != 15))
    case = case[row, column]

    def at(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Values (n,) relative to the threshold; outside, as far below it as 0, and a little at least."""
        within = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        found = values[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)].astype(np.float64) - threshold
        return np.where(within, found, min(-threshold, -1e-3))

    corners = np.stack([at(row + y - 1, column + x - 1) for x, y in _CORNERS], axis=1)
    points = np.empty((len(row), 4, 2))
    for edge in range(4):
        # From the lower or left end, so that both cells that share it have the same point.
        first, last = (edge, edge + 1) if edge < 2 else ((edge + 1) % 4, edge)
        a, b = corners[:, first], corners[:, last]
        with np.errstate(all="ignore"):
            t = np.clip(np.where((a > 0.0) != (b > 0.0), a / (a - b), 0.5), 1e-6, 1.0 - 1e-6)[:, None]
        points[:, edge] = _CORNERS[first] + t * (_CORNERS[last] - _CORNERS[first])
    points += np.stack([column, row], axis=1)[:, None] - 0.5
    joined = corners.mean(axis=1) > 0.0
    found = [np.zeros((0, 4))]
    for number in range(1, 15):
        cells = case == number
        if number in _SEGMENTS:
            choices = [(cells, _SEGMENTS[number])]
        else:
            choices = [(cells & ~joined, _APART[number]), (cells & joined, _TOGETHER[number])]
        for chosen, pairs in choices:
            for first, last in pairs:
                found.append(np.concatenate([points[chosen, first], points[chosen, last]], axis=1))
    return np.concatenate(found)


MOST_PIXELS = 1 << 26
MOST_SEGMENTS = 1 << 20


class PictureError(ValueError):
    """A picture has no outline; says what it lacks, and the cure, as the rest of a sentence after the picture's
    name."""


def outline_of(pixels: np.ndarray, part: str, threshold: float) -> np.ndarray:
    """Segments (n, 4) in widths of the picture, around its middle, of pixels (height, width, channels), the lowest row
    first.

    ``part``: "opaque", "bright" or "dark". Raises ``PictureError``.
    """
    height, width, channels = pixels.shape
    if width * height > MOST_PIXELS:
        raise PictureError(
            f"has {width} × {height} pixels, and an outline is made of {MOST_PIXELS / 1e6:.0f} million at most: scale it down"
        )
    if part == "opaque":
        values = pixels[..., 3] if channels == 4 else np.ones((height, width), np.float32)
    else:
        values = pixels[..., : min(channels, 3)].mean(axis=2)
        if part == "dark":
            values, threshold = 1.0 - values, 1.0 - threshold
    segments = contour(np.nan_to_num(values), threshold)
    if not len(segments):
        raise PictureError("has nothing above the threshold: choose another threshold, or another part")
    if len(segments) > MOST_SEGMENTS:
        raise PictureError(f"has an outline of too many corners, {len(segments):,}: blur it, or scale it down")
    return (segments - 0.5 * np.array([width, height] * 2)) / width
