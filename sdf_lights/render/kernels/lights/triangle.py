# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emissive triangles, sampled uniformly in solid angle: Arvo 1995, "Stratified sampling of spherical triangles"."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ....jit import kernel, table
from ....vec import ZERO, cross, dot, length, madd, normalize, scale, sub, vec
from .extent import Extent
from .records import no_sample

RECORD = np.dtype(
    [
        ("corners", np.float64, (3, 3)),
        ("radiance", np.float64, 3),
        ("area", np.float64),
        ("instance", np.int32),
        ("primitive", np.int32),
        ("textured", np.int64),
    ],
    align=True,
)

TABLES = {"light_triangles": RECORD}

rows = table("light_triangles", RECORD)

# Below this solid angle the angles of the spherical triangle sum to π except for their last digits. The area is sampled
# instead, which is as good there.
SMALL = 1e-4


@dataclass
class Triangles:
    """Triangles that emit light, in world space, on both sides."""

    instance: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # (n,)
    primitive: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # (n,) index in the mesh
    corners: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 3)))  # (n, corner, xyz)
    radiance: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))  # (n, RGB), an estimate where textured
    textured: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))  # (n,)


def pack(tables, scene, triangles: Triangles, first: int) -> Extent:
    """Fill the tables of the triangles, of which there is at least one; ``first`` is the index of the first among
    emitters."""
    count = len(triangles.instance)
    corners = np.asarray(triangles.corners, float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    made = tables["light_triangles"] = np.zeros(count, RECORD)
    made["corners"], made["radiance"], made["area"] = corners, triangles.radiance, 0.5 * length
    made["instance"], made["primitive"] = triangles.instance, triangles.primitive
    made["textured"] = triangles.textured
    emitter = first + np.arange(count)
    emitters = tables["light_emitters"]
    if scene.instances:
        seen_by = np.array([int(instance.visibility) for instance in scene.instances], np.int32)
        emitters["visibility"][emitter] = seen_by[triangles.instance]

    instances = int(triangles.instance.max()) + 1
    sizes = np.zeros(instances, np.int64)
    np.maximum.at(sizes, triangles.instance, triangles.primitive.astype(np.int64) + 1)
    offsets = tables["light_triangle_offset"] = np.concatenate(([0], np.cumsum(sizes)))
    lookup = tables["light_triangle_map"] = np.full(offsets[-1], -1, np.int32)
    lookup[offsets[triangles.instance] + triangles.primitive] = emitter

    axis = normal / np.where(length > 0.0, length, 1.0)[:, None]
    intensity = np.abs(np.asarray(triangles.radiance, float)).mean(axis=1) * 0.5 * length
    return Extent(corners.min(axis=1), corners.max(axis=1), intensity, axis=axis, cos_o=1.0, two_sided=True)


@kernel
def area(triangle):
    """The area (m²) of what its corners are now: between two times, that of its row is interpolated itself."""
    a, b, c = _sides(triangle, ZERO)
    return 0.5 * length(cross(sub(b, a), sub(c, a)))


@kernel
def _sides(triangle, x):
    """Corners relative to x."""
    c = triangle.corners
    return (
        (c[0, 0] - x[0], c[0, 1] - x[1], c[0, 2] - x[2]),
        (c[1, 0] - x[0], c[1, 1] - x[1], c[1, 2] - x[2]),
        (c[2, 0] - x[0], c[2, 1] - x[1], c[2, 2] - x[2]),
    )


@kernel
def solid_angle(a, b, c):
    """Solid angle of the triangle with the unit vectors a, b, c as corners: Van Oosterom and Strackee 1983."""
    return 2.0 * math.atan2(abs(dot(a, cross(b, c))), 1.0 + dot(a, b) + dot(b, c) + dot(c, a))


@kernel
def _area_pdf(p, q, r, area, d, distance):
    """Density per solid angle of uniform points: the normal is not normalised, its length is twice the area."""
    cosine = abs(dot(cross(sub(q, p), sub(r, p)), d))
    return 2.0 * distance * distance / cosine if cosine > 0.0 and area > 0.0 else 0.0


@kernel
def density(triangle, x, d, distance):
    """Density of ``sample`` at x in the direction d, in which the triangle is hit at ``distance``."""
    p, q, r = _sides(triangle, x)
    omega = solid_angle(normalize(p), normalize(q), normalize(r))
    if omega >= SMALL:
        return 1.0 / omega
    return _area_pdf(p, q, r, triangle.area, d, distance)


@kernel
def _orthogonal(a, b):
    """Unit vector in the plane of the unit vectors a and b that is orthogonal to b."""
    return normalize(madd(a, -dot(a, b), b))


@kernel
def _arvo(a, b, c, omega, u1, u2):
    """Uniform direction in the spherical triangle a, b, c of solid angle omega."""
    to_b, to_c = _orthogonal(b, a), _orthogonal(c, a)
    cos_alpha = min(max(dot(to_b, to_c), -1.0), 1.0)
    alpha = math.acos(cos_alpha)
    sin_alpha = math.sin(alpha)
    area = u1 * omega
    s, t = math.sin(area - alpha), math.cos(area - alpha)
    cos_side = dot(a, b)
    u, v = t - cos_alpha, s + sin_alpha * cos_side
    below = (v * s + u * t) * sin_alpha
    q = ((v * t - u * s) * cos_alpha - v) / below if below != 0.0 else 1.0
    q = min(max(q, -1.0), 1.0)
    corner = madd(scale(a, q), math.sqrt(max(1.0 - q * q, 0.0)), to_c)
    z = 1.0 - u2 * (1.0 - dot(corner, b))
    return normalize(madd(scale(b, z), math.sqrt(max(1.0 - z * z, 0.0)), _orthogonal(corner, b)))


@kernel
def sample(triangle, x, u1, u2):
    """As ``emitters.sample_light``, for an emissive triangle."""
    p, q, r = _sides(triangle, x)
    a, b, c = normalize(p), normalize(q), normalize(r)
    omega = solid_angle(a, b, c)
    if omega >= SMALL:
        wi = _arvo(a, b, c, omega, u1, u2)
        normal = cross(sub(q, p), sub(r, p))
        cosine = dot(wi, normal)
        distance = dot(p, normal) / cosine if cosine != 0.0 else 0.0
        if not 0.0 < distance < math.inf:
            return no_sample()
        return wi, distance, vec(triangle.radiance), 1.0 / omega, False
    root = math.sqrt(u1)
    point = madd(madd(p, root * (1.0 - u2), sub(q, p)), root * u2, sub(r, p))
    distance = length(point)
    if distance == 0.0:
        return no_sample()
    wi = scale(point, 1.0 / distance)
    pdf = _area_pdf(p, q, r, triangle.area, wi, distance)
    if not 0.0 < pdf < math.inf:
        return no_sample()
    return wi, distance, vec(triangle.radiance), pdf, False


@kernel
def barycentric(triangle, x, d):
    """Weights of the second and third corner where the ray x + t d meets the triangle's plane."""
    p, q, r = _sides(triangle, x)
    e1, e2 = sub(q, p), sub(r, p)
    h = cross(d, e2)
    determinant = dot(e1, h)
    if determinant == 0.0:
        return 0.0, 0.0
    k = cross(p, e1)
    return -dot(p, h) / determinant, -dot(d, k) / determinant
