# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lamp's properties say of its emission: the text of a preset or of the artist, and the parameters it declares.

The parameters are custom properties of the Light, as those of shapes (see ``parameters``); ``PREFIX`` before their names
keeps the two apart.
"""

from __future__ import annotations

import functools

from ..sdf.emission import EmissionExpression
from ..sdf.emission_presets import presets
from ..sdf.expression import Declaration
from ..sdf.syntax import ExpressionError

EXPRESSION = "EXPRESSION"
PREFIX = "emission."  # no name of a parameter has a point in it


def text_of(emission) -> str:
    """Text of a ``Light.sdf_lamp.emission``: of its preset, or of its text block where there is one."""
    if emission.source != EXPRESSION:
        return presets()[emission.source.lower()].text
    return emission.text.as_string() if emission.text is not None else emission.expression


@functools.lru_cache(maxsize=64)
def parsed(text: str) -> EmissionExpression | ExpressionError:
    """The expression, or what is wrong with it. Kept, because panels ask at every redraw."""
    try:
        return EmissionExpression(text)
    except ExpressionError as error:
        return error


def declarations(emission) -> tuple[Declaration, ...]:
    """What the emission declares, with names that begin with ``PREFIX``; nothing of a text with a mistake in it."""
    expression = parsed(text_of(emission))
    if isinstance(expression, ExpressionError):
        return ()
    return tuple(declared._replace(name=PREFIX + declared.name) for declared in expression.parameters)
