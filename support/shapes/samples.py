# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes and points on which every evaluator is tested."""

import dataclasses
import functools
import math

import numpy as np
from scipy.optimize.elementwise import find_root

from sdf_lights.graph import numpy_evaluation
from sdf_lights.graph.gradient import gradient
from sdf_lights.sdf.shapes import (
    SHAPES,
    Box,
    BoxFrame,
    Cone,
    Cylinder,
    Difference,
    Intersection,
    Shape,
    Sphere,
    Torus,
    Transformed,
    Union,
)
from sdf_lights.sdf.shapes.balls import CutHollowSphere, CutSphere, DeathStar, Lens, SolidAngle
from sdf_lights.sdf.shapes.polygons import Polygon
from sdf_lights.sdf.shapes.polyhedra import Bipyramid, Prism, Pyramid, RegularPyramid, Rhombus, Wedge
from sdf_lights.sdf.shapes.primitives import Frustum
from sdf_lights.sdf.shapes.profiles import PROFILES
from sdf_lights.sdf.shapes.solids import (
    CappedTorus,
    CrossedBars,
    HalfSpace,
    Link,
    PieSlice,
    RoundCone,
    RoundedBox,
    RoundedCylinder,
    Slab,
)
from sdf_lights.sdf.shapes.swept import Extrusion, PartialRevolution, Revolution
from support.shapes.operated import OPERATED, SHEAR

MIRROR = np.diag([-1.0, 0.5, 2.0, 1.0])


def rotation() -> np.ndarray:
    """A rotation about a general axis, with twice the size."""
    matrix = np.eye(4)
    matrix[:3, :3] = 2.0 * np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    matrix[:3, 3] = 0.3, -0.1, 0.2
    return matrix


PRIMITIVES = {name: shape() for name, shape in SHAPES.items() if len(dataclasses.fields(shape)) == len(shape.fields())}
"""Every shape defined by numbers, with default values."""

# More shapes of the same classes: each case of a formula, and the ends of the limits.
VARIATIONS = {
    "solid angle, most of the ball": SolidAngle(0.5, 4.5),
    "solid angle, half of the ball": SolidAngle(0.5, math.pi),
    "cut sphere, less than half": CutSphere(0.5, 0.3),
    "lens, almost a ball": Lens(0.5, 0.98),
    "bowl, less than half": CutHollowSphere(0.5, -0.3, 0.3),
    "bowl, thick": CutHollowSphere(0.5, 0.45, 0.4),
    "death star, small dent": DeathStar(0.5, 0.2, 0.4),
    "death star, large dent": DeathStar(0.5, 0.7, 0.35),
    "short arc": CappedTorus(0.5, 0.2, 0.7),
    "half of a ring": CappedTorus(0.5, 0.5, math.pi),
    "arc of no length": CappedTorus(0.5, 0.2, 0.0),
    "link without bars": Link(0.3, 0.1, 0.0),
    "slice, most of the cake": PieSlice(0.6, 0.3, 5.5),
    "slice, half": PieSlice(0.6, 0.3, math.pi),
    "rounded box, flat core": RoundedBox((0.2, 0.5, 0.7), 0.2),
    "rounded box, sharp": RoundedBox((0.2, 0.5, 0.7), 0.0),
    "rounded box, a ball": RoundedBox(0.5, 0.5),
    "rounded disk": RoundedCylinder(0.6, 0.4, 0.2),
    "rounded cylinder, thin core": RoundedCylinder(0.4, 1.2, 0.3),
    "rounded cylinder, a capsule": RoundedCylinder(0.3, 1.0, 0.3),
    "rounded cylinder, sharp": RoundedCylinder(0.3, 1.0, 0.0),
    "flat frustum": Frustum(0.1, 0.8, 0.2),
    "cone upside down": Frustum(0.0, 0.5, 1.0),
    "round cone, a ball almost": RoundCone(0.2, 0.5, 0.31),
    "round cone, a capsule": RoundCone(0.3, 0.3, 0.5),
    "crossed bars, thick": CrossedBars(1.0, 0.9),
    "prism, 3": Prism(3, 0.5, 1.5),
    "prism, 4": Prism(4, 0.6, 0.3),
    "prism, 7": Prism(7, 0.5, 0.8),
    "prism, 64": Prism(64, 0.5, 0.2),
    "flat pyramid": Pyramid(0.8, 0.2),
    "spire": Pyramid(0.2, 1.5),
    "pyramid, 3": RegularPyramid(3, 0.7, 0.6),
    "pyramid, 12": RegularPyramid(12, 0.4, 1.0),
    "bipyramid, 3": Bipyramid(3, 0.7, 0.4),
    "bipyramid, 5": Bipyramid(5, 0.2, 1.4),
    "steep rhombus": Rhombus((0.1, 0.8, 0.5)),
    "steep wedge": Wedge((0.1, 0.2, 0.7)),
    "tilted half space": HalfSpace((1.0, 2.0, -3.0), 0.2),
    "thick frame": BoxFrame((0.4, 0.5, 0.6), 0.3),
}


def varied(shape: Shape, seed: int) -> Shape:
    """A shape of the same class with other numbers, drawn within the limits or near the present ones.

    They are valid, and the shape exists.
    """
    rng = np.random.default_rng(seed)

    def draw(about, value):
        if about.whole:
            return float(rng.integers(about.minimum, about.soft_maximum + 1.0))
        if about.unit == "ANGLE" and math.isfinite(about.minimum):
            return rng.uniform(about.minimum, about.soft_maximum)
        return value + 0.2 * rng.normal() if value == 0.0 else value * 10.0 ** rng.uniform(-0.5, 0.5)

    while True:
        numbers = {about.name: getattr(shape, about.name) for about in shape.fields()}
        for about in shape.fields():
            old = numbers[about.name]
            numbers[about.name] = tuple(draw(about, v) for v in old) if about.size == 3 else draw(about, old)
        found = dataclasses.replace(shape, **numbers)
        if found.validate():
            continue
        try:
            surface(found)
        except NoSurface:  # a kaleidoscope can turn everything away
            continue
        return found


COMPOSITES = {
    "hollow box": Difference(Box(0.8), Sphere(1.08)),
    "three": Difference(Union(Box(0.5), Cylinder(0.2, 3.0)), Torus(0.6, 0.3), Transformed(Cone(), rotation())),
    "lens of two spheres": Intersection(Transformed(Sphere(1.0), np.eye(4)), Transformed(Sphere(1.0), SHEAR)),
    "one part": Union(Sphere(0.7)),
    "rotated": Transformed(Box((0.3, 0.5, 0.7)), rotation()),
    "sheared": Transformed(Torus(0.8, 0.3), SHEAR),
    "mirrored": Transformed(Cone(0.5, 1.0), MIRROR),
    "nested": Transformed(Union(Transformed(Cone(), SHEAR), Torus(), Intersection(Box(), Sphere(0.6))), MIRROR),
    "cut by what has no end": Intersection(Sphere(0.7), Slab(0.3), Transformed(HalfSpace((1.0, 1.0, 0.0), 0.1), SHEAR)),
}

PROFILES_TO_TRY = {
    name: Polygon((0.5, -0.2), (0.1, 0.1), (0.3, 0.5), (-0.4, 0.2)) if profile is Polygon else profile()
    for name, profile in PROFILES.items()
}

SWEEPS = (
    lambda profile: Extrusion(profile, 0.4),
    lambda profile: Revolution(profile, 0.9),
    lambda profile: PartialRevolution(profile, 0.7, 4.0),
)

SWEPT = {f"{name}, swept": SWEEPS[index % 3](profile) for index, (name, profile) in enumerate(PROFILES_TO_TRY.items())}

SHAPES_TO_TRY = PRIMITIVES | VARIATIONS | COMPOSITES | OPERATED | SWEPT
"""Every shape, operator and profile, each at least once."""


@functools.cache
def window(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Corners (low, high) of the shape's box, or of the part near the origin of an infinite one."""
    low, high = shape.bounds()
    low, high = np.where(np.isfinite(low), low, -1.5), np.where(np.isfinite(high), high, 1.5)
    low.flags.writeable = high.flags.writeable = False
    return low, high


def crossings(shape: Shape, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """One point (n, 3) on the surface between each of the points a and b, of which one is inside the shape."""
    if not len(a):
        return np.zeros((0, 3))

    def between(t, rows):
        return a[rows] + t[:, None] * (b - a)[rows]

    rows = np.arange(len(a))
    found = find_root(
        lambda t, rows: shape.distance(between(t, rows)), (np.zeros(len(a)), np.ones(len(a))), args=(rows,)
    )
    assert found.success.all()
    return between(found.x, rows)


def _descended(shape: Shape, at: np.ndarray) -> np.ndarray:
    """The points (m, 3) of the surface to which the gradient leads from points (n, 3)."""
    slope = gradient(shape.formula())
    low, high = window(shape)
    for step in range(30):
        direction = np.stack([numpy_evaluation.evaluate(part, at, shape.parameters()) for part in slope], axis=-1)
        steepness = np.linalg.norm(direction, axis=1, keepdims=True)
        # Never past the surface at first; then Newton's method near the surface.
        length = steepness if step < 15 else steepness**2
        at = at - shape.distance(at)[:, None] * direction / np.where(length > 0.0, length, 1.0)
    return at[np.abs(shape.distance(at)) < 1e-13 * np.linalg.norm(high - low)]


class NoSurface(Exception):
    """A shape with certain numbers has no surface, or one that cannot be found."""


@functools.cache
def surface(shape: Shape, count: int = 2000) -> np.ndarray:
    """About ``count`` points on the surface, or more: where segments between random points cross it.

    Such segments hardly ever hit dust and threads: there the field must lead to the surface.
    """
    rng = np.random.default_rng(11)
    low, high = window(shape)
    center, extent = (low + high) / 2, high - low

    def around(*size):
        return center + 0.75 * extent * rng.uniform(-1.0, 1.0, (*size, 3))

    found, total = [], 0
    for rounds in range(1, 25):
        a, b = around(2, 4 * count)
        crossing = (shape.distance(a) <= 0.0) != (shape.distance(b) <= 0.0)
        found.append((a[crossing], b[crossing]))
        total += len(found[-1][0])
        if total >= count or (rounds >= 4 and total * 24 < count * rounds):
            break
    points = crossings(shape, *map(np.concatenate, zip(*found)))
    if len(points) < count:
        points = np.concatenate([points, _descended(shape, around(count // 2))])
    if len(points) < count // 10:
        raise NoSurface(str(shape))
    return points


@functools.cache
def points(shape: Shape, count: int = 2000) -> np.ndarray:
    """Points (n, 3) in and around the shape, on its axes and planes of symmetry, close to its surface and far away."""
    rng = np.random.default_rng(1)
    low, high = window(shape)
    center, extent = (low + high) / 2, high - low
    near = center + extent * rng.uniform(-1.0, 1.0, (count, 3))
    lattice = center + extent * np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 9)] * 3), axis=-1).reshape(-1, 3)
    beside = surface(shape)[300:1300]
    beside = beside + extent * rng.normal(size=beside.shape) * 10.0 ** rng.uniform(-5, -1, (len(beside), 1))
    # The field must also be defined where terms vanish, and far from where they matter.
    tiny = rng.normal(size=(200, 3)) * 10.0 ** rng.uniform(-300, -3, (200, 1))
    huge = rng.normal(size=(200, 3)) * 10.0 ** rng.uniform(3, 12, (200, 1))
    axes = np.concatenate([huge[:50, None] * np.eye(3), tiny[:50, None] * np.eye(3)]).reshape(-1, 3)
    return np.concatenate([near, lattice, surface(shape)[:300], beside, tiny, huge, axes, np.zeros((1, 3))])
