# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways to send light rays towards a lamp, by name: whole numbers, as kernels compare them."""

import numpy as np

# How the direction of a light ray is drawn (``CUT["strategy"]``).
NO_LIGHT_RAYS, PROJECTION, BOXES, EXTERNAL = range(4)
# None: rays of the BSDF find the lamp · uniform points of the interior (``projection``) · the boxes of a cut (``cut``) · what
# is registered from outside (``external``).

# What stands for the lamp at the end of a light ray (``CUT["points"]``).
WHOLE_RAYS, POINTS, UNIFORM_POINTS = range(3)
# All of it that the ray crosses · a point, drawn by what the lamp gives there (``cut_points``) · a uniform point of it.

NO_BSDF_RAYS = 0.0  # MIS scale with which rays of a diffuse BSDF count nothing and need not look for the lamp

SCALARS = [
    ("lamp_strategy", np.int64),  # of all lamps; BOXES also where a cut turns out not to be needed
    # With other strategies than BOXES: the factor of the pdf of a BSDF in the balance heuristic.
    ("lamp_bsdf_mis_scale", np.float64),
]
