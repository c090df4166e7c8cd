# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages to the user about lamps whose intervals or emission are uncertain."""

from __future__ import annotations

import numpy as np

from .build import BuiltLamp

NOTICEABLE = 1e-3  # unresolved part of a lamp's length along rays that is reported to the user


def doubts(built: list[BuiltLamp]) -> list[str]:
    """Sentences about lamps whose intervals may be incomplete, and about unusual emissions."""
    return [remark for lamp in built for remark in lamp.remarks] + [
        f"Lamp “{lamp.name}”: its field has no known bound of its slope, so rays may miss thin parts: use shapes or "
        "operators whose field has a bound."
        for lamp in built
        if lamp.tree is not None and not lamp.tree.certified
    ]


def unresolved(built: list[BuiltLamp], lengths: np.ndarray) -> list[str]:
    """A sentence for each lamp with too much unresolved length; ``lengths`` (lamps, 2) are the sums of ``trace``."""
    return [
        f"Lamp “{lamp.name}”: {100.0 * left / (left + inside):.2g} % of its length along rays could not be "
        "resolved, so its light may be off by as much: make its thinnest parts thicker, or simplify its shape."
        for lamp, (left, inside) in zip(built, lengths)
        if left > NOTICEABLE * (left + inside)
    ]
