# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emissions to start from: text files of this folder, in the language of ``sdf.emission``, as the examples of shapes."""

from __future__ import annotations

import functools
import pathlib

from ..examples import Example, read

ORDER = ("uniform", "shell", "core", "flame", "neon")
"""Names of the presets, as menus list them."""


@functools.cache
def presets() -> dict[str, Example]:
    """Every preset by the name of its file without the suffix."""
    found = read(pathlib.Path(__file__).parent)
    return {name: found[name] for name in ORDER}
