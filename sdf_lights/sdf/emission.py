# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The brightness of a lamp at each point: formulas of the position, the depth below the surface and the height.

    width = slider(0.05, 0.001, 1)    # of the bright skin
    exp(-depth / width) * ramp(height, 0, (1, 0.2, 0), 1, (1, 0.8, 0.4))

The language is that of shapes (``expression``), with more names: ``INPUTS``. The last line is a number, a field
or a colour. Brightness is relative: a lamp's power says how much light it gives.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..frozen import frozen
from ..graph import numpy_evaluation
from ..graph.formula import PARAMETER, POINT, VARIABLE, Formula, constant, maximum, minimum, order, select
from ..graph.substitution import substitute
from ..graph.tables import Table, kept, tables_among
from .builtin_data import names_in
from .declarations import Declaration
from .evaluation import Evaluation
from .expression_values import Misuse, Work, components, kind_of, lifted
from .resolver import PlaceholderResolver, Resolver
from .shapes.base import Shape, Slots
from .syntax import ExpressionError, parse

INPUTS = ("depth", "height", "u", "v", "along")  # the first slots of the formulas of an ``Emission``
_AXES = {1: 2, 2: 0, 3: 1}  # along which an input goes from 0 to 1 across the box of the shape

GREATEST = 1e30  # greatest brightness; above it, values count as undefined

_CURE = "end with a line that is a brightness or a colour, such as exp(-20 * depth) or blackbody(2000)"


class Placed(NamedTuple):
    """The emission of a shape: formulas of the position alone, in the shape's local space."""

    colour: tuple[Formula, ...]  # red, green, blue; negative and undefined values are 0
    written: tuple[Formula, ...]  # the same as the artist wrote them
    parameters: np.ndarray  # of their slots
    tables: tuple[Table, ...] = ()  # that the parameters have addresses of

    def evaluate(self, points: np.ndarray) -> np.ndarray:
        """Colours (…, 3) at points (…, 3)."""
        return np.stack(numpy_evaluation.evaluate_all(self.colour, points, self.parameters), axis=-1)


@frozen
class Emission:
    """A relative emission in three channels. Its formulas have the ``INPUTS`` and then ``numbers`` in their slots."""

    colour: tuple[Formula, ...]  # red, green, blue
    numbers: tuple[float, ...] = ()

    @property
    def varies(self) -> bool:
        """Whether it varies in space."""
        return any(
            node.kind == VARIABLE or node.kind == PARAMETER and node.value < len(INPUTS) for node in order(*self.colour)
        )

    def placed(self, shape: Shape) -> Placed:
        """The emission inside a shape.

        The depth is −φ, so it is in metres where φ is a distance. The height is 0 at the bottom of the shape's bounding
        box and 1 at its top, along z; u and v are the same along x and y. ``along`` is ``Shape.along``, 0 where there
        is none.
        """
        slots = Slots()
        used = {node.value for node in order(*self.colour) if node.kind == PARAMETER}
        inputs = [constant(0.0)] * len(INPUTS)
        if 0 in used:
            inputs[0] = maximum(-shape.build(POINT, slots), 0.0)
        for index, axis in _AXES.items():
            if index in used:
                low, high = (float(corner[axis]) for corner in shape.bounds())
                inputs[index] = minimum(maximum((POINT[axis] - slots(low)) / slots(high - low), 0.0), 1.0)
        if 4 in used:
            along = shape.along(POINT, slots)
            inputs[4] = inputs[4] if along is None else along
        inputs += [slots(number) for number in self.numbers]
        written = tuple(substitute(channel, POINT, inputs) for channel in self.colour)
        parameters = np.array(slots.values, np.float64)
        return Placed(tuple(map(_usable, written)), written, parameters, tables_among(slots.values))


def in_colours(emission: Emission, colours: Table, width: float, height: float) -> Emission:
    """The emission times the colours of a picture (``data.texture``) of this size in metres, around z in the xy
    plane."""
    from .data.texture import colour  # it needs Numba, whose import takes a second

    slots = Slots()
    slots.values = [*[0.0] * len(INPUTS), *emission.numbers]
    address, across, up = slots(colours.address), slots(width), slots(height)
    tint = colour(address, POINT.x / across + 0.5, POINT.y / up + 0.5)
    glow = tuple(channel * factor for channel, factor in zip(emission.colour, tint))
    return Emission(glow, tuple(slots.values[len(INPUTS) :]))


def _usable(channel: Formula) -> Formula:
    """The formula with 0 where it is negative, not a number or above ``GREATEST``."""
    return maximum(select(channel <= GREATEST, channel, 0.0), 0.0)


class EmissionExpression:
    """A checked expression of an emission: its ``parameters``, and the emission for any of their values."""

    def __init__(self, text: str):
        """Raises ``ExpressionError`` if the text does not define a brightness or a colour."""
        self._tree, self._remarks = parse(text)
        self.parameters: tuple[Declaration, ...] = tuple(self._run({}, PlaceholderResolver())[1].values())

    @cached_property
    def data(self) -> frozenset[tuple[str, str]]:
        """As of ``Expression``."""
        return names_in(self._tree)

    def emission(self, values: Mapping[str, object] | None = None, resolver: Resolver | None = None) -> Emission:
        """The emission with ``values`` of parameters by name in place of their defaults, held to their limits.

        Values of other names are ignored. ``resolver`` gives the shapes that data make. Raises ``ExpressionError``
        where these values do not make one.
        """
        return self._run(values or {}, resolver)[0]

    def _run(self, given: Mapping[str, object], resolver: Resolver | None) -> tuple[Emission, dict[str, Declaration]]:
        evaluation = Evaluation(given, self._remarks, resolver)
        name_inputs(evaluation)
        last, value = evaluation.last(
            self._tree, "write a brightness, for instance exp(-20 * depth)", "how bright the lamp is", _CURE
        )
        emission = evaluation.attempt(last, lambda: as_emission(value, evaluation.slots))
        return emission, evaluation.declarations


def name_inputs(evaluation: Evaluation) -> None:
    """Gives a new evaluation the names ``INPUTS``."""
    evaluation.names |= {name: evaluation.slots.input() for name in INPUTS}


def as_emission(value, slots: Work) -> Emission:
    """The emission for the value of such an evaluation. Raises ``Misuse`` if the value is no brightness or colour."""
    channels = components(lifted(value, slots)) if kind_of(value) in ("number", "field", "vector") else ()
    if len(channels) not in (1, 3):
        raise Misuse(f"the result is a {kind_of(value)}", _CURE)
    colour = tuple(c if isinstance(c, Formula) else constant(c) for c in channels)
    return Emission(colour * (3 // len(colour)), tuple(map(kept, slots.values[len(INPUTS) :])))


__all__ = ["INPUTS", "Emission", "EmissionExpression", "ExpressionError", "Placed", "as_emission", "name_inputs"]
