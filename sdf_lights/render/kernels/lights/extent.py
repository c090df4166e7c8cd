# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The properties of a light that the selection of lights needs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Extent(NamedTuple):
    """For one or many lights of finite extent: the box, and the cone of emission directions (``tree_build.Bounds``)."""

    lo: np.ndarray  # (3,), or (n, 3)
    hi: np.ndarray
    intensity: float
    axis: np.ndarray | tuple = (0.0, 0.0, 1.0)
    cos_o: float = -1.0
    cos_e: float = 0.0
    two_sided: bool = False


class DistantLight(NamedTuple):
    """For a light at infinity: its irradiance on a surface that faces it, and the direction to it."""

    irradiance: float
    direction: np.ndarray


def unit(vector) -> np.ndarray:
    """The unit vector along ``vector``; zero for zero."""
    length = np.linalg.norm(vector)
    return vector / length if length > 0.0 else np.zeros(3)
