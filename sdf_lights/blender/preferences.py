# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's preferences: which back end there is, and what is lost without it."""

import functools
import importlib.util

import bpy

from .naming import ROOT


@functools.lru_cache(maxsize=1)
def back_end() -> tuple[bool, str]:
    """(whether Numba is there, one sentence about it). Looks for Numba without importing it, which takes 0.2 s."""
    if all(importlib.util.find_spec(name) for name in ("numba", "llvmlite")):
        return True, "Numba is available: renders run as machine code on all processor cores."
    return False, (
        "Numba is missing: renders run in plain NumPy, about a hundred times slower; install the extension from the "
        "zip made for this Blender version."
    )


def draw_back_end(layout) -> None:
    """Show the state of the back end in a panel."""
    available, sentence = back_end()
    column = layout.column(align=True)
    for i, line in enumerate(sentence.split(": ", 1)):
        column.label(text=line, icon="NONE" if i else "CHECKMARK" if available else "ERROR")


class SDFLIGHTS_Preferences(bpy.types.AddonPreferences):
    bl_idname = ROOT

    def draw(self, context):
        draw_back_end(self.layout)


CLASSES = (SDFLIGHTS_Preferences,)


def register():
    pass


def unregister():
    pass
