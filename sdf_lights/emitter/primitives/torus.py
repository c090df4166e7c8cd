# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A ring around the z axis: major radius, minor radius, centre at the origin. Requires minor ≤ major."""

import math

import numpy as np

from ...jit import kernel
from ...vec import dot, length, madd
from .disk import disk_point
from .regions import axis_squares, distance_flags, far, near
from .spans import overlap, slab

MOST_SPANS = 2
QUARTIC_ROUNDING = 1e-15  # rounding error of the quartic's value, relative to the fourth power of the outer radius
POLISH = 1e-5  # longest step that refines a root, relative to the minor radius


@kernel
def _quartic(t, p, q, s):
    return ((t * t + p) * t + q) * t + s


@kernel
def _root(low, high, entering, p, q, s, tolerance):
    """The root of t⁴ + p·t² + q·t + s between low and high, where it is monotonic: falling if ``entering``.

    Newton's method from the parabola that touches the quartic at the stationary end inside the torus; bisection
    wherever a step would leave the bracket. ``tolerance`` is the rounding error of the quartic's value.
    """
    bottom = high if entering else low
    t = 0.5 * (low + high)
    curvature = 12.0 * bottom * bottom + 2.0 * p
    if curvature > 0.0:
        reach = math.sqrt(-2.0 * _quartic(bottom, p, q, s) / curvature)
        guess = bottom - reach if entering else bottom + reach
        if low < guess < high:
            t = guess
    for _ in range(64):
        value = _quartic(t, p, q, s)
        if (value < 0.0) == entering:
            high = t
        else:
            low = t
        if abs(value) <= tolerance:
            break
        slope = (4.0 * t * t + 2.0 * p) * t + q
        step = t - value / slope if slope != 0.0 else math.inf
        if not low < step < high:
            step = 0.5 * (low + high)
            if not low < step < high:
                break
        t = step
    return t


@kernel
def _polish(t, o, u, major, minor):
    """One step of Newton's method on (ρ − R)² + z² − r², which keeps the digits that the quartic loses in thin tori."""
    x, y, z = madd(o, t, u)
    ring = math.sqrt(x * x + y * y)
    across = ring - major
    value = across * across + z * z - minor * minor
    slope = 2.0 * (across * (x * u[0] + y * u[1]) / ring + z * u[2])
    step = value / slope
    # Near a tangent the slope vanishes, and the root from the bracket is the better one. A NaN fails the test as well.
    return t - step if abs(step) < POLISH * minor else t


@kernel
def _stationary(p, q):
    """Real roots of the derivative 4t³ + 2p·t + q in ascending order; a single one is returned three times."""
    a, b = p / 6.0, q / 8.0  # t³ + 3a·t + 2b
    discriminant = b * b + a * a * a
    if discriminant < 0.0:
        size = 2.0 * math.sqrt(-a)
        angle = math.acos(max(-1.0, min(1.0, b / (a * math.sqrt(-a))))) / 3.0
        third = 2.0 * math.pi / 3.0
        return (size * math.cos(angle + third), size * math.cos(angle - third), size * math.cos(angle))
    u = -math.copysign(1.0, b) * (abs(b) + math.sqrt(discriminant)) ** (1.0 / 3.0)
    root = u - a / u if u != 0.0 else 0.0
    return (root, root, root)


@kernel
def torus_spans(o, d, major, minor):
    """Number of intervals (0, 1 or 2) in a torus around the z axis, and their ends (start, end, start, end).

    Around the point of the ray closest to the centre, the quartic has no cubic term. Its stationary points bracket
    every root, so none is missed, and no complex arithmetic is needed. Requires minor ≤ major.
    """
    size = length(d)
    u = (d[0] / size, d[1] / size, d[2] / size)
    middle = -dot(o, u)
    p0 = madd(o, middle, u)
    square = dot(p0, p0)
    outer = major + minor
    if square >= outer * outer:
        return 0, 0.0, 0.0, 0.0, 0.0
    reach = math.sqrt(outer * outer - square)
    low, high = overlap((-reach, reach), slab(p0[2], u[2], minor))
    if low >= high:
        return 0, 0.0, 0.0, 0.0, 0.0
    g = square + (major - minor) * outer
    scale = 4.0 * major * major
    p = 2.0 * g - scale * (u[0] * u[0] + u[1] * u[1])
    q = -2.0 * scale * (p0[0] * u[0] + p0[1] * u[1])
    s = g * g - scale * (p0[0] * p0[0] + p0[1] * p0[1])
    first, second, third = _stationary(p, q)
    tolerance = QUARTIC_ROUNDING * outer * outer * outer * outer
    middle /= size
    count, a0, b0, a1, b1 = 0, 0.0, 0.0, 0.0, 0.0

    # Between neighbours in this list the quartic is monotonic; its signs there tell where it crosses zero. Both ends
    # are outside the tube, even if rounding disagrees for a ray that touches it there.
    stops = (first, second, third, high)
    previous, inside = low, False
    start = low
    for index in range(4):
        stop = min(max(stops[index], low), high)
        if stop <= previous:
            continue
        now_inside = index < 3 and stop < high and _quartic(stop, p, q, s) < 0.0
        if now_inside and not inside:
            start = _polish(_root(previous, stop, True, p, q, s, tolerance), p0, u, major, minor)
        elif inside and not now_inside:
            end = _polish(_root(previous, stop, False, p, q, s, tolerance), p0, u, major, minor)
            if count == 0:
                a0, b0 = middle + start / size, middle + end / size
            else:
                a1, b1 = middle + start / size, middle + end / size
            count += 1
        previous, inside = stop, now_inside
    return count, a0, b0, a1, b1


@kernel
def spans(size, o, d):
    """See the package."""
    return torus_spans(o, d, size[0], size[1])


@kernel
def classify(size, c, h):
    """See the package."""
    near_square, far_square = axis_squares(c, h)
    near_z, far_z = near(c[2], h[2]), far(c[2], h[2])
    near_ring, far_ring = math.sqrt(near_square), math.sqrt(far_square)
    near_tube = max(near_ring - size[0], size[0] - far_ring, 0.0)
    far_tube = max(far_ring - size[0], size[0] - near_ring)
    return distance_flags(near_tube * near_tube + near_z * near_z, far_tube * far_tube + far_z * far_z, size[1])


@kernel
def torus_point(u1, u2, u3, major, minor):
    """Uniform point in a torus: its slice at height z is a ring whose area is proportional to the tube's width there.

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
def point(size, u1, u2, u3):
    """See the package."""
    return torus_point(u1, u2, u3, size[0], size[1])


def half_size(size) -> np.ndarray:
    """See the package."""
    return np.array([size[0] + size[1], size[0] + size[1], size[1]])
