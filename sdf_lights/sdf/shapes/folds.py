# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Symmetry by reflections: a mirror, a kaleidoscope, and the mirrors of the regular solids.

Points are reflected until they are in one chamber, where the child is evaluated. The part of the child in the chamber
appears in all its images; the part outside does not appear. A reflection of the points on one side of a plane never
increases the distance of two points, so the Lipschitz bound of the child stays.
"""

from __future__ import annotations

import math
from functools import cache, cached_property

import numpy as np

from ...frozen import frozen
from ...graph.formula import Vector, apply, cos, length, minimum, sin
from ..program import NoClosedForm
from .base import EXACT, LARGEST, SMALLEST, Shape, number, part
from .operators import Folded, Intersection, images, images_growth, images_program
from .solids import HalfSpace

_OVERLAP = 1e-12  # overlap of images, in closed form, as a fraction of the shape's size
_GOLDEN = (1.0 + math.sqrt(5.0)) / 2.0


def _reflection(normal) -> np.ndarray:
    normal = np.asarray(normal, np.float64)
    return np.eye(3) - 2.0 * np.outer(normal, normal) / (normal @ normal)


def _reflected(p: Vector, normal: tuple[float, float, float]) -> Vector:
    """p, or its mirror image if it is behind the plane through the origin with the given normal."""
    behind = minimum(p.dot(normal), 0.0) * (2.0 / math.fsum(n * n for n in normal))
    return Vector(*(q - behind * n for q, n in zip(p, normal)))


class Fold(Folded, abstract=True):
    """Reflections that lead every point into a chamber; their group is finite."""

    def _normals(self) -> np.ndarray:
        """Normals (n, 3) of the chamber's walls, pointing into the chamber."""
        raise NotImplementedError

    def _elements(self) -> np.ndarray:
        """Matrices (n, 3, 3) that map the chamber to all its images."""
        raise NotImplementedError

    @cached_property
    def _places(self) -> np.ndarray:
        """``_elements`` as affine matrices (n, 4, 4)."""
        elements = self._elements()
        places = np.tile(np.eye(4), (len(elements), 1, 1))
        places[:, :3, :3] = elements
        return places

    @cached_property
    def _in_chamber(self) -> bool:
        """Whether the shape is certainly in the chamber, clear of its walls."""
        low, high = self.child.bounds()
        normals = self._normals()
        if not (np.isfinite(low).all() and np.isfinite(high).all()):
            return False
        return bool((np.minimum(normals * low, normals * high).sum(axis=1) > 0.0).all())

    @cached_property
    def _seen(self) -> tuple[np.ndarray, np.ndarray]:
        """A box around the part in the chamber."""
        low, high = map(np.copy, self.child.bounds())
        for normal in self._normals():
            axes = np.flatnonzero(normal)
            if len(axes) > 1:
                continue
            if normal[axes] > 0.0:
                low[axes] = np.maximum(low[axes], 0.0)
            else:
                high[axes] = np.minimum(high[axes], 0.0)
        return np.minimum(low, high), np.maximum(low, high)

    @cached_property
    def exact_outside(self):
        # If all of the shape is in the chamber, the image in the point's own chamber is the nearest.
        return self.child.exact_outside and self._in_chamber

    @cached_property
    def exactness(self):
        # The images do not touch.
        return EXACT if self.child.exactness == EXACT and self._in_chamber else super().exactness

    def bounds(self, matrix=None):
        return images(self._seen, self._places if matrix is None else matrix @ self._places)

    def growth(self, matrix=None):
        return images_growth(self.child.growth(), self._places if matrix is None else matrix @ self._places)

    def volume(self):
        volume = self.child.volume()
        return len(self._elements()) * volume if self._in_chamber and volume is not None else None

    def program(self, matrix=None):
        walls = ()
        if not self._in_chamber:
            # Walls that overlap slightly: rounding must not leave cracks between the images.
            size = np.abs(self.child.bounds()).max()
            overlap = _OVERLAP * (size if math.isfinite(size) else 1.0)
            walls = [HalfSpace(tuple(-normal), overlap) for normal in self._normals()]
        return images_program(Intersection(self.child, *walls), self._places, matrix)


@frozen
class Mirror(Fold):
    """The part of a shape on one side of a plane through the origin, and its mirror image on the other side.

    With a smoothness, both halves blend into each other near the plane.
    """

    child: Shape = part("Shape that is mirrored")
    normal: tuple[float, float, float] = number(
        (1.0, 0.0, 0.0),
        "Direction across the plane, to the side that is kept; its length does not matter",
        unit="NONE",
        minimum=-LARGEST,
        soft_maximum=1.0,
    )
    smoothness: float = number(
        0.0, "Distance from the plane within which both halves blend", minimum=0.0, soft_maximum=1.0
    )

    @cached_property
    def _in_chamber(self):
        return not self.smoothness and super()._in_chamber

    @property
    def _unit(self) -> tuple[float, float, float]:
        return tuple(np.divide(self.normal, np.linalg.norm(self.normal)).tolist())

    def _normals(self):
        return np.array([self._unit])

    def _elements(self):
        return np.array([np.eye(3), _reflection(self._unit)])

    def _asked(self, p, slot):
        normal = slot(self._unit)
        across = p.dot(normal)
        # A hyperbola instead of the absolute value: its slope is at most 1, too.
        away = length(across, slot(self.smoothness)) - across
        return Vector(*(q + n * away for q, n in zip(p, normal)))

    def bounds(self, matrix=None):
        low, high = super().bounds(matrix)
        linear = np.eye(3) if matrix is None else matrix[:3, :3]
        margin = self.smoothness * np.abs(linear @ self._unit)
        return low - margin, high + margin

    def relation(self):
        if np.linalg.norm(self.normal) < SMALLEST:
            return "Mirror: the normal has no length: give at least one of its components a value other than 0."
        return ""

    def program(self, matrix=None):
        if self.smoothness:
            raise NoClosedForm("A smooth mirror has no closed form.")
        return super().program(matrix)


@frozen
class Kaleidoscope(Fold):
    """The part of a shape in a wedge along the z axis, repeated in all sectors of a circle, every other one mirrored.

    The wedge begins at the x axis and reaches to the angle 180° / sectors towards y.
    """

    child: Shape = part("Shape of which a wedge is shown")
    sectors: float = number(
        6.0,
        "Pairs of a wedge and its mirror image",
        unit="NONE",
        minimum=1.0,
        maximum=1000.0,
        soft_maximum=32.0,
        whole=True,
    )

    @property
    def _angle(self) -> float:
        return math.pi / self.sectors

    def _normals(self):
        return np.array([(0.0, 1.0, 0.0), (math.sin(self._angle), -math.cos(self._angle), 0.0)])

    def _elements(self):
        turns = 2.0 * self._angle * np.arange(self.sectors)
        zero, one = np.zeros_like(turns), np.ones_like(turns)
        rows = [(np.cos(turns), -np.sin(turns), zero), (np.sin(turns), np.cos(turns), zero), (zero, zero, one)]
        turned = np.moveaxis(np.array(rows), -1, 0)
        return np.concatenate([turned, turned @ np.diag([1.0, -1.0, 1.0])])

    def _asked(self, p, slot):
        pair = slot(2.0 * self._angle)
        turn = pair * apply("floor", apply("atan2", p.y, p.x) / pair + 0.5)
        c, s = cos(turn), sin(turn)
        return Vector(c * p.x + s * p.y, abs(c * p.y - s * p.x), p.z)


class Coxeter(Fold, abstract=True):
    """The full symmetry of a regular solid: a finite reflection group of rank 3 with three ``mirrors``.

    The walls of a chamber are the mirrors. Let h be the order of the product of all three reflections. Then h / 2
    rounds through them, in an order in which commuting reflections are neighbours, are the longest element of the group
    (Humphreys, "Reflection Groups and Coxeter Groups", 3.17). If only points behind each mirror are reflected, every
    point ends in the chamber.
    """

    mirrors: tuple[tuple[float, float, float], ...]
    rounds: int

    def _normals(self):
        return np.array(self.mirrors)

    def _elements(self):
        return _group(self.mirrors)

    def _asked(self, p, slot):
        for normal in self.rounds * self.mirrors:
            p = _reflected(p, normal)
        return p


@cache
def _group(mirrors) -> np.ndarray:
    """All products (n, 3, 3) of reflections."""
    reflections = [_reflection(normal) for normal in mirrors]
    found = {tuple(np.eye(3).round(6).ravel()): np.eye(3)}
    new = list(found.values())
    while new:
        products = {tuple((r @ m).round(6).ravel() + 0.0): r @ m for m in new for r in reflections}
        new = [m for key, m in products.items() if key not in found]
        found |= {key: m for key, m in products.items() if key not in found}
    return np.array(list(found.values()))


@frozen
class TetrahedralFold(Coxeter):
    """The part of a shape in one of 24 chambers, repeated with the mirror symmetry of a tetrahedron.

    The chamber is z ≥ y ≥ |x|. Around (0, 0, 1) are 6 images, around (1, 1, 1) and (−1, 1, 1) 4 each.
    """

    mirrors = ((0.0, -1.0, 1.0), (-1.0, 1.0, 0.0), (1.0, 1.0, 0.0))
    rounds = 2

    child: Shape = part("Shape of which the part in the chamber is repeated")


@frozen
class OctahedralFold(Coxeter):
    """The part of a shape in one of 48 chambers, repeated with the mirror symmetry of a cube and an octahedron.

    The chamber is z ≥ y ≥ x ≥ 0. A part on (0, 0, 1) is repeated 6 times, on (0, 1, 1) 12 times, on (1, 1, 1) 8 times.
    """

    mirrors = ((0.0, -1.0, 1.0), (-1.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    rounds = 3

    child: Shape = part("Shape of which the part in the chamber is repeated")


@frozen
class IcosahedralFold(Coxeter):
    """The part of a shape in one of 120 chambers, repeated with the mirror symmetry of an icosahedron and a
    dodecahedron.

    The chamber has x, y ≥ 0 and is around the z axis. A part on (0, 0, 1) is repeated 30 times, on (0.526, 0, 0.851) 12
    times, on (0, 0.357, 0.934) 20 times.
    """

    mirrors = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-0.5, -0.5 * _GOLDEN, 0.5 * (_GOLDEN - 1.0)))
    rounds = 5

    child: Shape = part("Shape of which the part in the chamber is repeated")
