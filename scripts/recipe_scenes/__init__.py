# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of docs/recipes.md, built as an artist builds them: by the operators of the menus, and the properties of
the panels.

A recipe is a function that fills an empty file; its docstring has the steps. ``RECIPES`` has all of them by name, in
the order of the page.
"""

from . import flames, rooms, signs, studio, wonders
from .stage import RECIPES, Recipe, build

__all__ = ["RECIPES", "Recipe", "build", "flames", "rooms", "signs", "studio", "wonders"]
