# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The brightness of a lamp at each point: formulas of the position, the depth below the surface and the height.

    width = slider(0.05, 0.001, 1)    # of the bright skin
    exp(-depth / width) * ramp(height, 0, (1, 0.2, 0), 1, (1, 0.8, 0.4))

The language is that of shapes (``expression``), with two more names, ``depth`` and ``height``. The last line is a
number, a field or a colour. Brightness is relative: the power of the lamp sets the amount of light.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..graph import numpy_evaluation
from ..graph.formula import PARAMETER, POINT, VARIABLE, Formula, constant, maximum, minimum, order, select
from ..graph.substitution import substitute
from .declarations import Declaration
from .evaluation import Evaluation
from .expression_values import Misuse, Work, components, kind_of, lifted
from .shapes.base import Shape, Slots
from .syntax import ExpressionError, parse

INPUTS = ("depth", "height")  # slots 0 and 1 of the formulas of an ``Emission``

GREATEST = 1e30  # greatest brightness; above it, values count as undefined

_CURE = "end with a line that is a brightness or a colour, such as exp(-20 * depth) or blackbody(2000)"


class Placed(NamedTuple):
    """The emission of a shape: formulas of the position alone, in the shape's local space."""

    colour: tuple[Formula, ...]  # red, green, blue; negative and undefined values are 0
    written: tuple[Formula, ...]  # the same as the artist wrote them
    parameters: np.ndarray  # of their slots

    def evaluate(self, points: np.ndarray) -> np.ndarray:
        """Colours (…, 3) at points (…, 3)."""
        return np.stack(numpy_evaluation.evaluate_all(self.colour, points, self.parameters), axis=-1)


@dataclass(frozen=True)
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

        The depth is −φ, so it is in metres if φ is a distance. The height is 0 at the bottom of the shape's bounding
        box and 1 at its top, along z.
        """
        slots = Slots()
        used = {node.value for node in order(*self.colour) if node.kind == PARAMETER}
        inputs = [maximum(-shape.build(POINT, slots), 0.0) if 0 in used else constant(0.0), constant(0.0)]
        if 1 in used:
            low, high = shape.bounds()
            inputs[1] = minimum(maximum((POINT.z - slots(float(low[2]))) / slots(float(high[2] - low[2])), 0.0), 1.0)
        inputs += [slots(number) for number in self.numbers]
        written = tuple(substitute(channel, POINT, inputs) for channel in self.colour)
        return Placed(tuple(map(_usable, written)), written, np.array(slots.values, np.float64))


def _usable(channel: Formula) -> Formula:
    """The formula with 0 where it is negative, not a number or above ``GREATEST``."""
    return maximum(select(channel <= GREATEST, channel, 0.0), 0.0)


class EmissionExpression:
    """A checked expression of an emission: its ``parameters``, and the emission for any of their values."""

    def __init__(self, text: str):
        """Raises ``ExpressionError`` if the text does not define a brightness or a colour."""
        self._tree, self._remarks = parse(text)
        self.parameters: tuple[Declaration, ...] = tuple(self._run({})[1].values())

    def emission(self, values: Mapping[str, object] | None = None) -> Emission:
        """The emission with ``values`` of parameters by name, clamped to their limits; others have their defaults.

        Values of unknown names are ignored. Raises ``ExpressionError`` if these values define no emission.
        """
        return self._run(values or {})[0]

    def _run(self, given: Mapping[str, object]) -> tuple[Emission, dict[str, Declaration]]:
        evaluation = Evaluation(given, self._remarks)
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
    return Emission(colour * (3 // len(colour)), tuple(map(float, slots.values[len(INPUTS) :])))


__all__ = ["INPUTS", "Emission", "EmissionExpression", "ExpressionError", "Placed", "as_emission", "name_inputs"]
