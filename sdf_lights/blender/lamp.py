# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the properties of a lamp to its shape and emission: shared by sync and by the panels that describe a lamp."""

from __future__ import annotations

import functools

import numpy as np

from ..render.errors import RenderError
from ..sdf.emission import Emission
from ..sdf.shapes import Shape
from ..sdf.syntax import ExpressionError
from . import emission, parameters
from .nodes import reading
from .properties import PRIMITIVES


@functools.lru_cache(maxsize=64)
def _expression_shape(text: str, values: tuple) -> Shape:
    # Kept, because panels ask at every redraw.
    expression = parameters.parsed(text)
    try:
        if isinstance(expression, ExpressionError):
            raise expression.with_traceback(None)  # or it would remember every call
        return expression.shape(dict(values))
    except ExpressionError as error:
        raise RenderError(f"In its expression: {error}") from error


def shape_of(lamp, owner: np.ndarray | None = None) -> Shape:
    """Shape of a ``Light.sdf_lamp``.

    ``owner`` is the matrix (4 × 4) of the lamp's object in the world, from which nodes see other objects.

    Raises RenderError with a sentence where there is none, or where its parameters do not go together. Its cause is an
    ``ExpressionError`` if that is where the problem lies.
    """
    if lamp.source == "EXPRESSION":
        shape = _expression_shape(parameters.text_of(lamp), tuple(parameters.values(lamp).items()))
    elif lamp.source == "NODES":
        shape = reading.shape_of(lamp.nodes, parameters.values(lamp), owner)
    else:
        name = lamp.shape.lower()
        values = getattr(lamp, name)
        read = {about.name: getattr(values, about.name) for about in PRIMITIVES[name].fields()}
        shape = PRIMITIVES[name](
            **{key: value if isinstance(value, (int, float)) else tuple(value) for key, value in read.items()}
        )
    problem = shape.validate()
    if problem:
        raise RenderError(problem)
    return shape


@functools.lru_cache(maxsize=64)
def _emission(text: str, values: tuple) -> Emission:
    expression = emission.parsed(text)
    try:
        if isinstance(expression, ExpressionError):
            raise expression.with_traceback(None)  # or it would remember every call
        return expression.emission(dict(values))
    except ExpressionError as error:
        raise RenderError(f"In its emission: {error}") from error


def pattern_of(lamp, owner: np.ndarray | None = None) -> Emission | None:
    """Emission of a ``Light.sdf_lamp``; None where it is the same everywhere. ``owner`` is as for ``shape_of``.

    Raises RenderError with a sentence where its text or nodes do not say one; its cause is the ``ExpressionError`` of a
    text.
    """
    if parameters.emission_is_in_nodes(lamp):
        return reading.emission_of(lamp.nodes, parameters.values(lamp), owner)
    declared = emission.declarations(lamp.emission)
    values = parameters.values_of(lamp.id_data, declared)
    found = _emission(
        emission.text_of(lamp.emission),
        tuple((name.removeprefix(emission.PREFIX), value) for name, value in values.items()),
    )
    return None if lamp.emission.source == "UNIFORM" else found
