# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A wave of paths, and what they contribute to the passes: rows of arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

EVERY_SET = -1


@dataclass
class Paths:
    """Live paths, as rows of arrays. ``sample`` is the row of ``Samples`` to which a path adds.

    ``origin`` is the point of the last scattering, with the density ``pdf`` (0: singular, or the camera), and ``kind``
    the kind of ray. ``near`` is the distance along the ray through transparent surfaces so far, ``start`` the point
    there.
    """

    sample: np.ndarray
    origin: np.ndarray
    start: np.ndarray
    direction: np.ndarray
    near: np.ndarray
    far: np.ndarray
    throughput: np.ndarray
    pdf: np.ndarray
    kind: np.ndarray
    bounces: np.ndarray  # (N, 5): all, diffuse, glossy, transmission, transparent
    last: np.ndarray  # only gathers emission
    catches: np.ndarray  # has hit a shadow catcher
    least_pdf: np.ndarray  # of all directions so far that are not singular
    light_set: np.ndarray  # of the instance of the last scattering; EVERY_SET for the camera
    inside: np.ndarray  # (N, columns of ``Media``): the media around
    channel: np.ndarray  # of RGB, which alone has light in a scene with media
    volume: np.ndarray  # bounces in media
    left: np.ndarray  # number of the curve or sphere that the ray leaves, which it does not hit again
    stopped: np.ndarray  # it has passed a surface that stops light rays

    def select(self, rows: np.ndarray) -> "Paths":
        """Some of the paths, given as indices (n,) or as a mask (N,)."""
        return Paths(**{name: value[rows] for name, value in vars(self).items()})


def together(parts: list[Paths]) -> Paths:
    """The rows of all parts, of which there is at least one."""
    return Paths(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0])})


class Samples:
    """The contribution of one sample of each of ``count`` pixels to the passes."""

    def __init__(self, count: int):
        self.combined, self.lamps, self.emission, self.environment = np.zeros((4, count, 3))
        self.position, self.normal, self.albedo, self.diffuse_albedo = np.zeros((4, count, 3))
        self.alpha, self.depth, self.found = np.ones(count), np.zeros(count), np.zeros(count, bool)
        # Of shadow catchers: see ``passes.CATCHER_SUMS``, and the light of paths that have hit one.
        self.bare, self.backdrop, self.light = np.zeros((3, count, 3))
        self.caught, self.uncaught = np.zeros(count, bool), np.zeros(count)
