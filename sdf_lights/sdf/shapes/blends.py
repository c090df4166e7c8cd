# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Union, intersection and difference with a blended seam; the mixture of two shapes.

Every blend here is min(a, b) − drop(r − |a − b|) of two fields a and b. The drop has its greatest value where a = b,
and falls to zero where the fields differ by the radius r. This is the general form of a smooth minimum for which adding
a number to both fields adds it to the result. It has three consequences:

* Beyond the radius the result *is* one of the fields.
* All drops below have 0 ≤ drop′ ≤ 1, so the gradient is a convex combination of both gradients, and no Lipschitz bound
  grows, however many shapes are blended.
* With drop′ ≤ 1 the added region, where min(a, b) > 0 ≥ min(a, b) − drop, has min(a, b) ≤ drop(r) and max(a, b) ≤ r.

Intersection and difference follow by De Morgan: −union(−a, −b) and −union(−a, b).

Quilez, "Smooth minimum" has the polynomial, circular and exponential profiles; hg_sdf (Mercury, 2015) has the circular
one, chamfers and stairs. Here they are computed in the form above: the surfaces are the same, but the original
Lipschitz bounds were √2 or did not exist.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...frozen import frozen
from ...graph.formula import POINT, Formula, Vector, apply, maximum, minimum, sqrt
from ...interruption import check
from .base import Family, Shape, Slots, Term, number, part
from .operators import Composite, Difference, Intersection, SetOperation, checked, common, enclosing, guarded

_CUTOFF = 8.0  # radius of an exponential blend as a multiple of its decay length: e⁻⁸ of the drop is left there


class Profile(NamedTuple):
    """``drop(overlap, radius, …)`` for 0 ≤ overlap = r − |a − b| ≤ r, and its greatest value as a fraction of r.

    Further arguments are further numbers of the blend.
    """

    drop: Callable[..., Formula]
    greatest: Callable[..., float]


def _quadratic(overlap, radius):
    return overlap * overlap / (4.0 * radius)


def _cubic(overlap, radius):
    return overlap * overlap * overlap / (6.0 * radius * radius)


def _circular(overlap, radius):
    # If a and b are distances to perpendicular planes, an arc of this radius touches both.
    share = overlap / radius
    return 0.5 * radius * (1.0 + share - sqrt(1.0 + share * (2.0 - share)))


def _exponential(overlap, radius):
    # −k log(e^(−a/k) + e^(−b/k)), minus its value at the radius, so that the blend ends there.
    ratio = apply("exp", _CUTOFF * (overlap / radius - 1.0))
    return radius / _CUTOFF * apply("log", (1.0 + ratio) / (1.0 + math.exp(-_CUTOFF)))


def _chamfer(overlap, radius):
    return 0.5 * overlap


def _stairs(overlap, radius, steps):
    # Steps of width 2w: a triangle wave with the slopes ±1.
    width = radius / (steps + 1.0)
    turned = overlap + width
    wave = abs(turned - 2.0 * width * apply("floor", turned / (2.0 * width)) - width)
    return 0.5 * (overlap - wave)


class Blend(SetOperation, abstract=True):
    """A set operation with the given profile of its seams. Shapes are blended from left to right."""

    profile: Profile

    def _drop(self, apart: Formula, radius: Formula, *others: Formula) -> Formula:
        """Drop between two fields that differ by ``apart``."""
        return self.profile.drop(maximum(radius - abs(apart), 0.0), radius, *others)

    def _blend_width(self) -> float:
        return self.radius


class BlendedUnion(Blend, abstract=True):
    """The parts are guarded, because the bulge of the seam must be known."""

    family = Family.UNION

    @cached_property
    def _guarded(self) -> tuple[Shape, ...]:
        return tuple(map(guarded, self.children)) if len(self.children) > 1 else self.children

    def _operands(self):
        return self._guarded

    @cached_property
    def lipschitz(self):
        return max(shape.lipschitz for shape in self._guarded)

    def _join(self, a, b, *numbers):
        return minimum(a, b) - self._drop(a - b, *numbers)

    def bounds(self, matrix=None):
        boxes = [shape.bounds(matrix) for shape in self._guarded]
        lows, highs = map(np.array, zip(*boxes))
        growth = np.array([shape.growth(matrix) for shape in self._guarded])
        radius, *others = (getattr(self, field.name) for field in self.fields())
        greatest = radius * self.profile.greatest(*others)

        alike = bool((growth == growth[0]).all())  # then the box around the first k shapes grows from one to the next
        if alike:
            least, most = np.minimum.accumulate(lows), np.maximum.accumulate(highs)

        def grown(which: slice, level: float):
            margin = level * growth[which]
            if alike and which.start == 0:
                return least[which.stop - 1] - margin[0], most[which.stop - 1] + margin[0]
            return (lows[which] - margin).min(axis=0), (highs[which] + margin).max(axis=0)

        # Added points have a field up to the radius on one side of the seam, and up to the greatest drop on the other.
        # The left operand has k shapes already blended: at most k − 1 drops below the least of them.
        for index in range(1, len(lows)):
            check()
            left, right = slice(0, index), slice(index, index + 1)
            for first, second in ((greatest, radius), (radius, greatest)):
                low, high = common((grown(left, first + (index - 1) * greatest), grown(right, second)))
                if (low < high).all():
                    boxes.append((low, high))
        return enclosing(boxes)

    def growth(self, matrix=None):
        return np.max([shape.growth(matrix) for shape in self._guarded], axis=0)


class BlendedIntersection(Blend, abstract=True):
    """Inside the sharp one."""

    family = Family.INTERSECTION
    bounded = Intersection.bounded
    bounds = Intersection.bounds

    def _join(self, a, b, *numbers):
        return maximum(a, b) + self._drop(a - b, *numbers)


class BlendedDifference(Blend, abstract=True):
    """Inside the sharp one."""

    family = Family.DIFFERENCE
    bounded = Difference.bounded
    bounds = Difference.bounds
    growth = Difference.growth

    def _join(self, a, b, *numbers):
        return maximum(a, -b) + self._drop(a + b, *numbers)


def _radius():
    return number(0.1, "Width of the seam: parts whose fields differ by more stay unchanged", soft_maximum=1.0)


def _steps():
    return number(3.0, "Number of steps in the seam", unit="NONE", minimum=1.0, maximum=100.0, whole=True)


def _family(name: str, seam: str, drop: Callable, greatest: Callable, **numbers) -> list[type[Blend]]:
    """Union, intersection and difference with one profile."""
    kinds = {
        "Union": (BlendedUnion, "All points that are in at least one of the shapes"),
        "Intersection": (BlendedIntersection, "The points that are in all of the shapes"),
        "Difference": (BlendedDifference, "The first shape without the others"),
    }
    made = []
    for kind, (base, summary) in kinds.items():
        namespace = {
            "__doc__": f"{summary}, with {seam}.",
            "__module__": __name__,
            "__annotations__": {"children": tuple[Shape, ...], **dict.fromkeys(numbers, float)},
            "children": (),
            "profile": Profile(drop, greatest),
            **{key: make() for key, make in numbers.items()},
        }
        made.append(frozen(type(name + kind, (base,), namespace)))
    return made


SmoothUnion, SmoothIntersection, SmoothDifference = _family(
    "Smooth", "a smooth seam: a parabola", _quadratic, lambda: 1.0 / 4.0, radius=_radius
)
CubicUnion, CubicIntersection, CubicDifference = _family(
    "Cubic",
    "a smooth seam that also bends smoothly into the shapes: a cubic",
    _cubic,
    lambda: 1.0 / 6.0,
    radius=_radius,
)
CircularUnion, CircularIntersection, CircularDifference = _family(
    "Circular",
    "a seam that is a circular arc where the surfaces meet at right angles",
    _circular,
    lambda: 1.0 - math.sqrt(0.5),
    radius=_radius,
)
ExponentialUnion, ExponentialIntersection, ExponentialDifference = _family(
    "Exponential",
    "a seam that fades out exponentially",
    _exponential,
    lambda: math.log(2.0 / (1.0 + math.exp(-_CUTOFF))) / _CUTOFF,
    radius=_radius,
)
# The same surface as the circular blend: the name that hg_sdf gives to it.
RoundUnion, RoundIntersection, RoundDifference = _family(
    "Round",
    "a rounded seam: a quarter of a circle where the surfaces meet at right angles",
    _circular,
    lambda: 1.0 - math.sqrt(0.5),
    radius=_radius,
)
ChamferUnion, ChamferIntersection, ChamferDifference = _family(
    "Chamfer",
    "a seam cut straight, at 45° to surfaces that meet at right angles",
    _chamfer,
    lambda: 1.0 / 2.0,
    radius=_radius,
)
StairsUnion, StairsIntersection, StairsDifference = _family(
    "Stairs",
    "a seam of steps",
    _stairs,
    lambda steps: ((steps + 1.0) // 2.0) / (steps + 1.0),
    radius=_radius,
    steps=_steps,
)


@frozen
class Morph(Composite):
    """A shape between two others: a mixture of their fields.

    At amount 0 it is the first, at 1 the second. Shapes that do not overlap vanish in between.
    """

    first: Shape = part("Shape at amount 0")
    second: Shape = part("Shape at amount 1")
    amount: float = number(
        0.5, "Position between the first shape and the second", unit="NONE", minimum=0.0, maximum=1.0, soft_maximum=1.0
    )

    def __post_init__(self):
        checked(self, self.first), checked(self, self.second)
        super().__post_init__()

    @property
    def children(self):
        return self.first, self.second

    @cached_property
    def size(self):
        return self.first.size + self.second.size

    @cached_property
    def depth(self):
        return 1 + max(self.first.depth, self.second.depth)

    def _mixed(self, a: Formula, b: Formula, slot: Slots) -> Formula:
        # Not a + (b − a) t, which is not quite b at t = 1.
        return a * slot(1.0 - self.amount) + b * slot(self.amount)

    def build(self, p: Vector, slot: Slots) -> Formula:
        return self._mixed(self.first.build(p, slot), self.second.build(p, slot), slot)

    def terms(self, matrix, factor):
        slots = Slots()
        formula = self._mixed(POINT.x, POINT.y, slots)
        a, b = self.first.terms(matrix, factor), self.second.terms(matrix, factor)
        steepest = max(a[-1].lipschitz, b[-1].lipschitz)
        return [*a, *b, Term(formula, np.array(slots.values), 2, Family.UNION, math.inf, steepest)]

    def bounds(self, matrix=None):
        # A mixture is at most zero only where one of the fields is.
        return enclosing(child.bounds(matrix) for child in self.children)
