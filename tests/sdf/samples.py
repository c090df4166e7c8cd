# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes and points that every reading is tried on."""

import numpy as np

from sdf_lights.sdf.shapes import SHAPES, Box, BoxFrame, Cone, Cylinder, Difference, Intersection, Primitive, Sphere
from sdf_lights.sdf.shapes import Torus, Transformed, Union

SHEAR = np.array([(1.0, 0.4, 0.0, 0.3), (0.0, 0.8, -0.5, -0.2), (0.2, 0.0, 1.3, 0.1), (0.0, 0.0, 0.0, 1.0)])
MIRROR = np.diag([-1.0, 0.5, 2.0, 1.0])


def rotation() -> np.ndarray:
    """A rotation about no axis in particular, with twice the size."""
    matrix = np.eye(4)
    matrix[:3, :3] = 2.0 * np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    matrix[:3, 3] = 0.3, -0.1, 0.2
    return matrix


PRIMITIVES = {name: shape() for name, shape in SHAPES.items() if issubclass(shape, Primitive)}

COMPOSITES = {
    "hollow box": Difference(Box(0.8), Sphere(1.08)),
    "three": Difference(Union(Box(0.5), Cylinder(0.2, 3.0)), Torus(0.6, 0.3), Transformed(Cone(), rotation())),
    "lens": Intersection(Transformed(Sphere(1.0), np.eye(4)), Transformed(Sphere(1.0), SHEAR)),
    "thick frame": BoxFrame((0.4, 0.5, 0.6), 0.3),
    "one part": Union(Sphere(0.7)),
    "rotated": Transformed(Box((0.3, 0.5, 0.7)), rotation()),
    "sheared": Transformed(Torus(0.8, 0.3), SHEAR),
    "mirrored": Transformed(Cone(0.5, 1.0), MIRROR),
    "nested": Transformed(Union(Transformed(Cone(), SHEAR), Torus(), Intersection(Box(), Sphere(0.6))), MIRROR),
}

SHAPES_TO_TRY = PRIMITIVES | COMPOSITES


def points(shape, count: int = 4000, seed: int = 1) -> np.ndarray:
    """Points (n, 3) in and around the shape, on its axes and planes of symmetry, near its surface, and far away."""
    rng = np.random.default_rng(seed)
    low, high = shape.bounds()
    center, extent = (low + high) / 2, high - low
    near = center + extent * rng.uniform(-1.0, 1.0, (count, 3))
    lattice = center + extent * np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 9)] * 3), axis=-1).reshape(-1, 3)
    # Half way between a point and one across the surface, repeatedly: ends at the surface.
    inside, outside = near[shape.distance(near) <= 0.0][:300], near[shape.distance(near) > 0.0]
    outside = outside[:len(inside)]
    for _ in range(45):
        middle = (inside + outside) / 2
        is_in = (shape.distance(middle) <= 0.0)[:, None]
        inside, outside = np.where(is_in, middle, inside), np.where(is_in, outside, middle)
    # The field must also be defined where terms vanish, and far from where they matter.
    tiny = rng.normal(size=(200, 3)) * 10.0 ** rng.uniform(-300, -3, (200, 1))
    huge = rng.normal(size=(200, 3)) * 10.0 ** rng.uniform(3, 12, (200, 1))
    return np.concatenate([near, lattice, inside, outside, tiny, huge, np.zeros((1, 3))])
