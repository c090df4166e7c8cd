# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How lights are read from Blender. Their data come as objects with Blender's properties; nothing here knows bpy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..scene import Light


class Kind(NamedTuple):
    """``read(data, name, matrix, power, common)`` makes a light of its data: its transform, Blender's power in watts (W/m² of a
    light at infinite distance), and keyword arguments that all lights have. It raises RenderError, with a sentence that
    names the light, where it cannot be used.

    ``nodes_see(data, scale)`` is what nodes of the light learn of its form, as ``projections.light_place`` takes it; the scale (3,) is
    that of its object.
    """

    read: Callable[[Any, str, np.ndarray, float, dict], Light]
    nodes_see: Callable[[Any, np.ndarray], tuple]
