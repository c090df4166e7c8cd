# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preset emissions: text files of this folder, in the language of ``sdf.emission``, like the examples of shapes."""

from __future__ import annotations

import functools
import pathlib

from ..examples import Example, read

ORDER = ("uniform", "shell", "core", "flame", "neon")
"""Names of the presets, in the order of menus."""


@functools.cache
def presets() -> dict[str, Example]:
    """Every preset by the name of its file without the suffix."""
    found = read(pathlib.Path(__file__).parent)
    return {name: found[name] for name in ORDER}
