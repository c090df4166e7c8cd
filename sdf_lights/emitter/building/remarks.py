# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user is told of lamps whose intervals, or whose emission, are not certain."""

from __future__ import annotations

import numpy as np

from .build import BuiltLamp

NOTICEABLE = 1e-3  # part of a lamp's length along rays that is left open before the user is told


def doubts(built: list[BuiltLamp]) -> list[str]:
    """Sentences about lamps whose intervals are not certain to be all that there are, and about odd emissions."""
    return [remark for lamp in built for remark in lamp.remarks] + [
        f"Lamp “{lamp.name}”: nothing bounds how fast its field changes, so rays may miss thin parts of it."
        for lamp in built
        if lamp.tree is not None and not lamp.tree.certified
    ]


def unresolved(built: list[BuiltLamp], lengths: np.ndarray) -> list[str]:
    """A sentence for each lamp of which rays left too much open; ``lengths`` (lamps, 2) as ``trace`` sums them."""
    return [
        f"Lamp “{lamp.name}”: {100.0 * left / (left + inside):.2g} % of its length along rays could not be "
        "resolved, so its light may be off by as much: make its thinnest parts thicker, or simplify its shape."
        for lamp, (left, inside) in zip(built, lengths)
        if left > NOTICEABLE * (left + inside)
    ]
