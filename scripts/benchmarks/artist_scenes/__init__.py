# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole scenes typical of artists' work, without an SDF lamp: the contents of ordinary files for Cycles.

A scene is a function that fills an empty file; ``SCENES`` has all of them by name. Modules register them when they are
imported.
"""

from . import indoors, living, moving, outdoors, studio
from .stage import SCENES, ArtistScene, build

__all__ = ["SCENES", "ArtistScene", "build", "indoors", "living", "moving", "outdoors", "studio"]
