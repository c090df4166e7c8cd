# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads lights from Blender. Their data are objects with Blender's properties; nothing here imports bpy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..scene import Light


class Kind(NamedTuple):
    """``read(data, name, matrix, power, common)`` makes a light from its data: its transform, Blender's power in watts
    (W/m² for a light at infinite distance), and the keyword arguments of all lights. Raises RenderError, with a
    sentence that names the light, if the light is unusable.

    ``nodes_see(data, scale)`` is the shape of the light for its nodes, in the form of ``projections.light_place``; the
    scale (3,) is that of its object.
    """

    read: Callable[[Any, str, np.ndarray, float, dict], Light]
    nodes_see: Callable[[Any, np.ndarray], tuple]
