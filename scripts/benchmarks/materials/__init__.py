# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials as artists build them, each with a small scene.

A material is a function of a ``Shader`` that returns its surface; ``MATERIALS`` has all of them by name. Modules
register them when they are imported.
"""

from . import cloth, ground, liquids, living, metals, painted, stone, stylized, wood
from .shader import MATERIALS, Entry, Shader
from .stage import build

__all__ = ["MATERIALS", "Entry", "Shader", "build"]
