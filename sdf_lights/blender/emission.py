# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The emission in a lamp's properties: the text of a preset or of the artist, and its declared parameters.

The parameters are custom properties of the Light, like those of shapes (see ``parameters``). ``PREFIX`` before their
names separates them from those of the shape.
"""

from __future__ import annotations

import functools

from ..sdf.emission import EmissionExpression
from ..sdf.emission_presets import presets
from ..sdf.expression import Declaration
from ..sdf.syntax import ExpressionError

EXPRESSION = "EXPRESSION"
PREFIX = "emission."  # no parameter name contains a point


def text_of(emission) -> str:
    """Text of a ``Light.sdf_lamp.emission``: from its preset, or from its text block if it has one."""
    if emission.source != EXPRESSION:
        return presets()[emission.source.lower()].text
    return emission.text.as_string() if emission.text is not None else emission.expression


@functools.lru_cache(maxsize=64)
def parsed(text: str) -> EmissionExpression | ExpressionError:
    """The expression, or its error. Cached, because panels ask at every redraw."""
    try:
        return EmissionExpression(text)
    except ExpressionError as error:
        return error


def declarations(emission) -> tuple[Declaration, ...]:
    """The parameters that the emission declares, with names that begin with ``PREFIX``; none if the text has a
    mistake."""
    expression = parsed(text_of(emission))
    if isinstance(expression, ExpressionError):
        return ()
    return tuple(declared._replace(name=PREFIX + declared.name) for declared in expression.parameters)
