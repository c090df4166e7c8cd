# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes and rays on which crossings are easily missed, for tests and benchmarks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sdf_lights.sdf.shapes import Box, Cone, Cylinder, Difference, Shape, Sphere, Torus, Transformed, Union
from sdf_lights.sdf.shapes.base import part
from sdf_lights.sdf.shapes.blends import ChamferUnion, RoundUnion, SmoothDifference, SmoothUnion, StairsDifference
from sdf_lights.sdf.shapes.displacement import NoiseDisplacement
from sdf_lights.sdf.shapes.fractals import MengerSponge
from sdf_lights.sdf.shapes.layers import Onion
from sdf_lights.sdf.shapes.primitives import Capsule
from sdf_lights.sdf.shapes.repetition import PolarRepetition, Repetition
from sdf_lights.sdf.shapes.warps import Twist
from support.lamps.shapes_under_test import moved, scaled, sheared, turned


@dataclass(frozen=True)
class Steeper(Shape, abstract=True):
    """A field that is ``factor`` times the distance, with a correct Lipschitz bound."""

    child: Shape = part("Shape whose field is multiplied")
    factor: float = 1.0

    exactness = "none"

    @property
    def children(self):
        return (self.child,)

    @property
    def lipschitz(self):
        return self.factor * self.child.lipschitz

    def build(self, p, slot):
        return self.child.build(p, slot) * slot(self.factor)

    def bounds(self, matrix=None):
        return self.child.bounds(matrix)


def directions(rng: np.random.Generator, n: int) -> np.ndarray:
    """(n, 3) uniform unit vectors."""
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def towards(origins: np.ndarray, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    d = targets - origins
    return origins, d / np.linalg.norm(d, axis=1, keepdims=True)


def around(shape: Shape, rng: np.random.Generator, n: int, distances=(0.2, 0.7, 2.0)):
    """Rays from in and around the bounding box to points in it. ``distances`` are relative to the box's diagonal."""
    low, high = shape.bounds()
    origins = 0.5 * (low + high) + directions(rng, n) * np.linalg.norm(high - low) * rng.choice(distances, (n, 1))
    return towards(origins, low + rng.random((n, 3)) * (high - low))


def far(shape: Shape, rng: np.random.Generator, n: int):
    """Rays from 10,000 diagonals away."""
    return around(shape, rng, n, (1e4,))


def inside(shape: Shape, rng: np.random.Generator, n: int):
    """Rays from points in the shape."""
    low, high = shape.bounds()
    points = np.zeros((0, 3))
    while len(points) < n:
        more = low + rng.random((4 * n, 3)) * (high - low)
        points = np.concatenate([points, more[shape.distance(more) < 0.0]])
    return points[:n], directions(rng, n)


def grazing(shape: Shape, rng: np.random.Generator, n: int):
    """Rays almost in the tangent plane at points almost on the surface, by 1e-6 to 1e-2 of the size."""
    low, high = shape.bounds()
    size = np.linalg.norm(high - low)
    points = low + rng.random((8 * n, 3)) * (high - low)
    step = 1e-6 * size
    for _ in range(12):
        value = shape.distance(points)
        slope = np.stack([shape.distance(points + step * axis) - value for axis in np.eye(3)], axis=1) / step
        points = points - np.clip(value, -0.1 * size, 0.1 * size)[:, None] * slope / np.maximum(
            (slope * slope).sum(axis=1, keepdims=True), 0.1
        )
    good = np.abs(shape.distance(points)) < 1e-6 * size
    points, slope = points[good][:n], slope[good][:n]
    assert len(points) == n
    normal = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    off = size * 10.0 ** rng.uniform(-6.0, -2.0, (n, 1)) * rng.choice([-1.0, 1.0], (n, 1))
    d = np.cross(normal, directions(rng, n)) + normal * 10.0 ** rng.uniform(-6.0, -2.0, (n, 1))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return points + off * normal - 0.7 * size * d, d


def published(shape: Shape, rng: np.random.Generator, n: int):
    """Rays of the published table about three slabs."""
    d = np.column_stack([np.ones(n), rng.choice([-0.1, 0.1], (n, 2))])
    origins = np.column_stack([rng.uniform(-1.55, -1.30, n), np.zeros((n, 2))])
    return origins, d / np.linalg.norm(d, axis=1, keepdims=True)


@dataclass(frozen=True)
class Case:
    shape: Shape
    rays: Callable = around
    smooth: bool = False  # a field without creases, or few


SLABS = Union(*(Transformed(Box((half, 2.0, 2.0)), moved(x)) for x, half in ((-1.0, 0.03), (-0.45, 0.4), (0.45, 0.4))))


def scattered(n: int, seed: int = 0, smooth: bool = True, space: float = 1.0, size: float | None = None) -> Shape:
    """n primitives of about ``size``, in a cube of half size ``space``; by default that leaves them some room."""
    rng = np.random.default_rng(seed)
    kinds = (Sphere(0.5), Torus(0.5, 0.2), Box((0.4, 0.3, 0.2)), Capsule(0.2, 0.6), Cylinder(0.4, 0.5), Cone(0.5, 0.8))
    size = 0.9 * space * n ** (-1.0 / 3.0) if size is None else size
    parts = []
    for index in range(n):
        place = (
            moved(*rng.uniform(-space, space, 3))
            @ turned(rng.uniform(0, 7), rng.integers(3))
            @ turned(rng.uniform(0, 7), rng.integers(3))
        )
        parts.append(Transformed(kinds[index % len(kinds)], place @ scaled(size, size, size)))
    if n == 1:
        return parts[0]
    return SmoothUnion(*parts, radius=0.3 * size) if smooth else Union(*parts)


SMOOTH = SmoothDifference(
    SmoothUnion(
        Torus(0.7, 0.25),
        Transformed(Capsule(0.2, 1.0), turned(0.4, 0)),
        Transformed(Sphere(0.4), moved(0.5)),
        radius=0.2,
    ),
    Transformed(Sphere(0.35), moved(-0.6, 0.2, 0.1)),
    radius=0.1,
)
SHEETS = Onion(Onion(Sphere(0.8), 0.02), 1e-4)
FACES = Difference(
    Union(Transformed(Box((0.3, 0.5, 0.4)), moved(-0.3)), Transformed(Box((0.4, 0.5, 0.4)), moved(0.4))),
    Transformed(Box((0.2, 0.5, 0.2)), moved(0.1, 0.0, 0.2)),
    Transformed(Cylinder(0.1, 0.8), moved(-0.4)),
)
TWISTED = Twist(Transformed(Torus(0.5, 0.2), scaled(1.0, 0.6, 2.0)), 1.5)

HARD_CASES = {
    "slabs, field three times too steep": Case(Steeper(SLABS, 3.0), published),
    "onions 1e-4 thick": Case(SHEETS),
    "onions 1e-4 thick, grazing": Case(SHEETS, grazing),
    "coincident faces": Case(FACES),
    "coincident faces, smooth": Case(SmoothUnion(FACES, Transformed(Box((0.1, 0.5, 0.4)), moved(0.9)), radius=0.05)),
    "torus, grazing": Case(Torus(0.7, 0.25), grazing, smooth=True),
    "smooth combination": Case(SMOOTH, smooth=True),
    "smooth combination, grazing": Case(SMOOTH, grazing, smooth=True),
    "smooth combination, from far away": Case(SMOOTH, far, smooth=True),
    "smooth combination, from inside": Case(SMOOTH, inside, smooth=True),
    "smooth combination of 10": Case(scattered(10), smooth=True),
    "smooth combination of 200": Case(scattered(200), smooth=True),
    "smooth combination, size 1e-3": Case(Transformed(SMOOTH, scaled(1e-3, 1e-3, 1e-3)), smooth=True),
    "smooth combination, size 1e4": Case(Transformed(SMOOTH, scaled(1e4, 1e4, 1e4)), smooth=True),
    "smooth combination, sheared and mirrored": Case(
        Transformed(SMOOTH, turned(1.0, 1) @ scaled(-1.0, 1.3, 0.8) @ sheared(1.2)), smooth=True
    ),
    "torus, stretched and twisted": Case(TWISTED, smooth=True),
    "Menger sponge of 5 levels": Case(MengerSponge(levels=5.0)),
    "round and chamfered seams": Case(
        RoundUnion(
            ChamferUnion(Box(0.4), Transformed(Cylinder(0.2, 1.6), turned(0.5, 0)), radius=0.1),
            Transformed(Torus(0.5, 0.1), moved(0.2)),
            radius=0.1,
        )
    ),
    "stairs": Case(StairsDifference(Sphere(0.7), Box(0.4), radius=0.2, steps=5.0)),
    "thin spokes": Case(PolarRepetition(Transformed(Capsule(0.004, 0.8), moved(0.5) @ turned(np.pi / 2, 1)), 24.0)),
    "grid of shells": Case(Repetition(Onion(Sphere(0.3), 0.01), (4.0, 4.0, 4.0), (0.7, 0.7, 0.7))),
    "noise": Case(NoiseDisplacement(Sphere(0.7), 0.1, 0.2, 3.0)),
}
