# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Uniform points in primitives: smooth maps of the unit cube that keep the stratification of their numbers.

An affine map of a uniform point is uniform in the mapped shape, so one map serves every placement.
"""

import math

from ...jit import kernel
from ..intersection.membership import BOX, CAPSULE, CONE, CYLINDER, SPHERE, TORUS


@kernel
def disk_point(u1, u2):
    """Uniform point (x, y) in the unit disk. Shirley and Chiu 1997, "A low distortion map between disk and square"."""
    a, b = 2.0 * u1 - 1.0, 2.0 * u2 - 1.0
    if a == 0.0 and b == 0.0:
        return 0.0, 0.0
    if abs(a) > abs(b):
        radius, angle = a, math.pi / 4.0 * (b / a)
    else:
        radius, angle = b, math.pi / 2.0 - math.pi / 4.0 * (a / b)
    return radius * math.cos(angle), radius * math.sin(angle)


@kernel
def ball_point(u1, u2, u3):
    """Uniform point in the unit ball."""
    radius = u1 ** (1.0 / 3.0)
    z = 1.0 - 2.0 * u2
    ring = math.sqrt(max(1.0 - z * z, 0.0))
    angle = 2.0 * math.pi * u3
    return (radius * ring * math.cos(angle), radius * ring * math.sin(angle), radius * z)


@kernel
def torus_point(u1, u2, u3, major, minor):
    """Uniform point in a torus: its slice at height z is a ring whose area is in proportion to the tube's width there.

    So z is distributed as in a disk, and the square of the distance from the axis is uniform within the ring.
    """
    x, z = disk_point(u1, u2)
    width = math.sqrt(max(1.0 - z * z, 0.0))
    part = 0.5 * (x / width + 1.0) if width > 0.0 else 0.5
    width *= minor
    inner = major - width
    ring = math.sqrt(inner * inner + 4.0 * major * width * min(max(part, 0.0), 1.0))
    angle = 2.0 * math.pi * u3
    return (ring * math.cos(angle), ring * math.sin(angle), minor * z)


@kernel
def capsule_point(u1, u2, u3, radius, height):
    """Uniform point in a capsule: its two ends are the halves of one ball, moved apart."""
    straight = height / (height + 4.0 / 3.0 * radius)
    if u1 < straight:
        x, y = disk_point(u2, u3)
        return (radius * x, radius * y, height * (u1 / straight - 0.5))
    x, y, z = ball_point((u1 - straight) / (1.0 - straight), u2, u3)
    return (radius * x, radius * y, radius * z + math.copysign(0.5 * height, z))


@kernel
def cylinder_point(u1, u2, u3, radius, height):
    """Uniform point in a cylinder about the z axis, centred at the origin."""
    x, y = disk_point(u2, u3)
    return (radius * x, radius * y, height * (u1 - 0.5))


@kernel
def frustum_point(u1, u2, u3, bottom, top, height):
    """Uniform point in a frustum of the radii ``bottom`` at z = −height/2 and ``top`` at +height/2.

    The volume below grows with the cube of the radius; the quotient of two differences of cubes gives the height, and
    needs no special case where the radii are equal.
    """
    first, last = bottom * bottom * bottom, top * top * top
    radius = (first + u1 * (last - first)) ** (1.0 / 3.0)
    square = bottom * bottom + bottom * radius + radius * radius
    part = u1 * (bottom * bottom + bottom * top + top * top) / square if square > 0.0 else 0.0
    x, y = disk_point(u2, u3)
    return (radius * x, radius * y, height * (part - 0.5))


@kernel
def primitive_point(op, size, u1, u2, u3):
    """Uniform point in the primitive ``op`` with parameters ``size``, in its own space."""
    if op == SPHERE:
        x, y, z = ball_point(u1, u2, u3)
        return (size[0] * x, size[0] * y, size[0] * z)
    if op == BOX:
        return (size[0] * (2.0 * u1 - 1.0), size[1] * (2.0 * u2 - 1.0), size[2] * (2.0 * u3 - 1.0))
    if op == TORUS:
        return torus_point(u1, u2, u3, size[0], size[1])
    if op == CAPSULE:
        return capsule_point(u1, u2, u3, size[0], size[1])
    if op == CYLINDER:
        return cylinder_point(u1, u2, u3, size[0], size[1])
    if op == CONE:
        return frustum_point(u1, u2, u3, size[0], 0.0, size[1])
    return frustum_point(u1, u2, u3, size[0], size[1], size[2])
