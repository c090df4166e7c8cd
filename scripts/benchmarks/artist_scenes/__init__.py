# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole scenes as artists have them, without an SDF lamp: what an ordinary file for Cycles holds.

A scene is a function that fills an empty file; ``SCENES`` has all of them by name. The modules register them when they
are imported.
"""

from . import indoors, living, moving, outdoors, studio
from .stage import SCENES, ArtistScene, build

__all__ = ["SCENES", "ArtistScene", "build", "indoors", "living", "moving", "outdoors", "studio"]
