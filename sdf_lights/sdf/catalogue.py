# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How shapes are grouped where people look for them: in menus and on the reference page."""

from __future__ import annotations

from collections.abc import Iterable

# By the module that they are in, which groups them too, but by what their code has in common.
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
    """Shapes by the title of their group; groups, and shapes in a group, in the order given."""
    found: dict[str, list[type]] = {}
    for shape in shapes:
        found.setdefault(category(shape), []).append(shape)
    return found
