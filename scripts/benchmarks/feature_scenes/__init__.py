# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small scene for each feature of Cycles beside shader nodes: passes, control of lights, motion, geometry, volumes.

A feature is a function that changes the table of ``stage``; ``FEATURES`` has all of them by name. Modules register
them when they are imported.
"""

from . import cameras, geometry, lights, motion, passes, settings, volumes
from .stage import FEATURES, Feature, build

__all__ = [
    "FEATURES",
    "Feature",
    "build",
    "cameras",
    "geometry",
    "lights",
    "motion",
    "passes",
    "settings",
    "volumes",
]
