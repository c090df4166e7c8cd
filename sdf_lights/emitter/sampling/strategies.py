# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The strategies for light rays towards a lamp, by name: integers, which kernels compare."""

import numpy as np

# How the direction of a light ray is drawn (``CUT["strategy"]``).
NO_LIGHT_RAYS, PROJECTION, BOXES, EXTERNAL = range(4)
# None: BSDF rays find the lamp · uniform points of the interior (``projection``) · the boxes of a cut (``cut``) · a
# strategy registered from outside (``external``).

# What represents the lamp at the end of a light ray (``CUT["points"]``).
WHOLE_RAYS, POINTS, UNIFORM_POINTS = range(3)
# The whole interval of the ray · a point, drawn by the lamp's light there (``cut_points``) · a uniform point of the
# lamp.

NO_BSDF_RAYS = 0.0  # MIS scale at which BSDF rays of a diffuse surface have no weight and need not look for the lamp

SCALARS = [
    ("lamp_strategy", np.int64),  # of all lamps; BOXES also if a cut turns out not to be needed
    # For other strategies than BOXES: the factor of the BSDF's pdf in the balance heuristic.
    ("lamp_bsdf_mis_scale", np.float64),
]
