# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials as artists build them, each with a small scene that shows it.

A material is a function of a ``Shader`` that gives its surface; ``MATERIALS`` has all of them by name. The modules
register them when they are imported.
"""

from . import cloth, ground, liquids, living, metals, painted, stone, stylized, wood
from .shader import MATERIALS, Entry, Shader
from .stage import build

__all__ = ["MATERIALS", "Entry", "Shader", "build"]
