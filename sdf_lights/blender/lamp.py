# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the properties of a lamp to its shape: shared by sync and by the panels that describe a lamp."""

from __future__ import annotations

import functools

from ..render.errors import RenderError
from ..sdf.expression import ExpressionError, evaluate
from ..sdf.shapes import Shape
from .properties import PRIMITIVES


def expression_of(lamp) -> str:
    """Text of a lamp's expression: that of its text block where there is one."""
    return lamp.text.as_string() if lamp.text is not None else lamp.expression


@functools.lru_cache(maxsize=64)
def _expression_shape(text: str) -> Shape:
    # Cached because panels ask at every redraw.
    try:
        return evaluate(text)
    except ExpressionError as error:
        raise RenderError(f"In its expression: {error}") from error


def shape_of(lamp) -> Shape:
    """Shape of a ``Light.sdf_lamp``.

    Raises RenderError with a sentence where there is none, or where its parameters do not go together.
    """
    if lamp.source == "EXPRESSION":
        shape = _expression_shape(expression_of(lamp))
    else:
        name = lamp.shape.lower()
        values = getattr(lamp, name)
        read = {about.name: getattr(values, about.name) for about in PRIMITIVES[name].fields()}
        shape = PRIMITIVES[name](
            **{key: value if isinstance(value, float) else tuple(value) for key, value in read.items()})
    problem = shape.validate()
    if problem:
        raise RenderError(problem)
    return shape
