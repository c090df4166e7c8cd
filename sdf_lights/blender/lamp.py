# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the properties of a lamp to its shape and emission. Shared by sync and by the panels of a lamp."""

from __future__ import annotations

from collections import OrderedDict

import bpy
import numpy as np

from ..render.errors import RenderError
from ..sdf.emission import Emission
from ..sdf.resolver import Cache, Resolver
from ..sdf.shapes import Shape
from ..sdf.syntax import ExpressionError
from . import emission, network_lamps, objects, parameters, picture_lamps
from .nodes import reading
from .properties import PRIMITIVES, values_of
from .sources import FileResolver


def _anew(error: ExpressionError) -> ExpressionError:
    """A copy of the error for raising. A kept error would keep its whole call stack alive, such as the engine of a
    viewport."""
    return ExpressionError(error.message, error.line, error.column, error.cure)


_shapes, _emissions = Cache(64), Cache(64)  # because panels ask at every redraw


def _expression_shape(text: str, values: tuple, resolver: Resolver) -> Shape:
    expression = parameters.parsed(text)
    try:
        if isinstance(expression, ExpressionError):
            raise _anew(expression)
        return _shapes.get((text, values), resolver, lambda found: expression.shape(dict(values), found))
    except ExpressionError as error:
        raise RenderError(f"In its expression: {error}") from error


def shape_of(lamp, owner: np.ndarray | None = None) -> Shape:
    """Shape of a ``Light.sdf_lamp``.

    ``owner`` is the world matrix (4 × 4) of the lamp's object. Nodes use it to find other objects.

    Raises RenderError with a sentence if there is no shape, or if its parameters contradict each other. Its cause is an
    ``ExpressionError`` if the expression is wrong.
    """
    if lamp.source == "EXPRESSION":
        shape = _expression_shape(parameters.text_of(lamp), tuple(parameters.values(lamp).items()), FileResolver(lamp))
    elif lamp.source == "OBJECT":
        shape = objects.shape_of(lamp.object, lamp)
    elif lamp.source == "IMAGE":
        shape = picture_lamps.shape_of(lamp)
    elif lamp.source == "NETWORK":
        shape = network_lamps.shape_of(lamp)
    elif lamp.source == "NODES":
        shape = reading.shape_of(lamp.nodes, parameters.values(lamp), owner, lamp)
    else:
        name = lamp.shape.lower()
        shape = PRIMITIVES[name](**values_of(getattr(lamp, name), name))
    problem = shape.validate()
    if problem:
        raise RenderError(problem)
    return shape


LAST_GOOD = "is left out of renders, and shown with its last good shape in viewports."
_MOST_KEPT = 512
_good: OrderedDict[int, tuple[Shape, Emission | None]] = OrderedDict()  # by the light's identity in this session


def keep(light: bpy.types.Light, shape: Shape, pattern: Emission | None) -> None:
    """Store the shape and emission of a lamp while both are valid. ``light`` must not be an evaluated copy."""
    _good[light.session_uid] = shape, pattern
    _good.move_to_end(light.session_uid)
    while len(_good) > _MOST_KEPT:
        _good.popitem(last=False)


def last_good(light: bpy.types.Light) -> tuple[Shape, Emission | None] | None:
    """The last valid shape and emission of a lamp; None if it never was valid."""
    return _good.get(light.session_uid)


def _emission(text: str, values: tuple, resolver: Resolver) -> Emission:
    expression = emission.parsed(text)
    try:
        if isinstance(expression, ExpressionError):
            raise _anew(expression)
        return _emissions.get((text, values), resolver, lambda found: expression.emission(dict(values), found))
    except ExpressionError as error:
        raise RenderError(f"In its emission: {error}") from error


def pattern_of(lamp, owner: np.ndarray | None = None) -> Emission | None:
    """Emission of a ``Light.sdf_lamp``; None if it is uniform. ``owner`` (4 × 4) is as for ``shape_of``.

    Raises RenderError with a sentence if its text or nodes define no emission. Its cause is the ``ExpressionError`` of
    a text.
    """
    if parameters.emission_is_in_nodes(lamp):
        return reading.emission_of(lamp.nodes, parameters.values(lamp), owner, lamp)
    declared = emission.declarations(lamp.emission)
    values = parameters.values_of(lamp.id_data, declared)
    found = _emission(
        emission.text_of(lamp.emission),
        tuple((name.removeprefix(emission.PREFIX), value) for name, value in values.items()),
        FileResolver(lamp),
    )
    if lamp.source == "IMAGE" and lamp.image_colors:
        return picture_lamps.in_own_colours(lamp, found)
    return None if lamp.emission.source == "UNIFORM" else found
