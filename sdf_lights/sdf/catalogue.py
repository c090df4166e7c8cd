# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of shapes for people: in menus and on the reference page."""

from __future__ import annotations

from collections.abc import Iterable

# The groups follow modules, except where these group by shared code.
_TITLES = {
    "primitives": "Basic",
    "solids": "Rounded",
    "balls": "Spherical",
    "swept": "Swept",
    "curved": "Curved",
    "tubes": "Tubes",
    "coils": "Coils and Knots",
    "orbits": "Fractals",
    "operators": "Sharp",
    "warps": "Bent and Twisted",
}


def category(shape: type) -> str:
    """Title of the group of a shape."""
    module = shape.__module__.rpartition(".")[2]
    return _TITLES.get(module, module.replace("_", " ").title())


def grouped(shapes: Iterable[type]) -> dict[str, list[type]]:
    """Shapes by the title of their group; groups and shapes in the given order."""
    found: dict[str, list[type]] = {}
    for shape in shapes:
        found.setdefault(category(shape), []).append(shape)
    return found
