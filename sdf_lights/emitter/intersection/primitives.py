# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed-form intervals of a ray inside each primitive.

Every function takes the ray o + s·d in the primitive's own space, where d has any length but zero, and returns values
of the ray's own parameter s: an affine map keeps them, so they are world distances when the world direction was of unit
length. Each solves about the ray's closest approach to the primitive, where no digits are lost to the distance of o.
The interval is (start, end); start > end means that the ray misses.
"""

import math

from ...jit import kernel
from ...vec import dot, length, madd

MISS = (math.inf, -math.inf)
QUARTIC_ROUNDING = 1e-15  # of the value of a torus's quartic, relative to the fourth power of its outer radius
POLISH = 1e-5  # longest step that improves a root of it, relative to the minor radius


@kernel
def overlap(a, b):
    """Intersection of two intervals."""
    return (max(a[0], b[0]), min(a[1], b[1]))


@kernel
def slab(o, d, half):
    """Where |o + s·d| ≤ half, for scalars."""
    if d == 0.0:
        if abs(o) > half:
            return MISS
        return (-math.inf, math.inf)
    centre, reach = -o / d, abs(half / d)
    return (centre - reach, centre + reach)


@kernel
def sphere_span(o, d, radius):
    """Interval (start, end) of the ray o + t d in a sphere about the origin; ``MISS`` where there is none."""
    square = dot(d, d)
    middle = -dot(o, d) / square
    distance = length(madd(o, middle, d))
    if distance >= radius:
        return MISS
    # The product keeps the digits of a grazing ray that radius² − distance² would cancel.
    half = math.sqrt((radius - distance) * (radius + distance) / square)
    return (middle - half, middle + half)


@kernel
def box_span(o, d, half_x, half_y, half_z):
    """Interval (start, end) of the ray o + t d in a box about the origin, of these half sizes."""
    return overlap(overlap(slab(o[0], d[0], half_x), slab(o[1], d[1], half_y)), slab(o[2], d[2], half_z))


@kernel
def tube_span(o, d, radius):
    """Infinite cylinder round the z axis."""
    square = d[0] * d[0] + d[1] * d[1]
    if square == 0.0:
        if o[0] * o[0] + o[1] * o[1] > radius * radius:
            return MISS
        return (-math.inf, math.inf)
    middle = -(o[0] * d[0] + o[1] * d[1]) / square
    # The distance of the two lines from a cross product: o + middle·d would cancel for rays along the axis.
    distance = abs(o[0] * d[1] - o[1] * d[0]) / math.sqrt(square)
    if distance >= radius:
        return MISS
    half = math.sqrt((radius - distance) * (radius + distance) / square)
    return (middle - half, middle + half)


@kernel
def cylinder_span(o, d, radius, half_height):
    """Capped cylinder along z, |z| ≤ half_height."""
    side = slab(o[2], d[2], half_height)
    if side[0] > side[1]:
        return MISS
    return overlap(side, tube_span(o, d, radius))


@kernel
def capsule_span(o, d, radius, half_height):
    """All points within ``radius`` of the segment |z| ≤ half_height of the z axis.

    The capsule is convex and the union of a cylinder and two spheres, so the interval is the hull of theirs.
    """
    tube = cylinder_span(o, d, radius, half_height)
    upper = sphere_span((o[0], o[1], o[2] - half_height), d, radius)
    lower = sphere_span((o[0], o[1], o[2] + half_height), d, radius)
    start, end = math.inf, -math.inf
    if tube[0] <= tube[1]:
        start, end = tube
    if upper[0] <= upper[1]:
        start, end = min(start, upper[0]), max(end, upper[1])
    if lower[0] <= lower[1]:
        start, end = min(start, lower[0]), max(end, lower[1])
    return (start, end)


@kernel
def half_space_span(o, d):
    """Where z ≤ 0: one end, or both, is infinite."""
    if d[2] == 0.0:
        return (-math.inf, math.inf) if o[2] <= 0.0 else MISS
    crossing = -o[2] / d[2]
    return (-math.inf, crossing) if d[2] > 0.0 else (crossing, math.inf)


@kernel
def frustum_span(o, d, bottom, top, half_height):
    """Solid between the circles of radius ``bottom`` at z = −half_height and ``top`` at z = +half_height.

    Within the slab of its height only one of the two nappes of x² + y² = r(z)² is left, r the radius at height z, which
    is linear; there the solid is convex. Equal radii make it a cylinder, and no radius at one end a cone.
    """
    side = slab(o[2], d[2], half_height)
    if side[0] > side[1]:
        return MISS
    middle = -dot(o, d) / dot(d, d)
    p = madd(o, middle, d)
    # Weighted ends keep the digits of the radius near an apex, whichever end it is at.
    radius = (bottom * (half_height - p[2]) + top * (half_height + p[2])) / (2.0 * half_height)
    rate = (top - bottom) / (2.0 * half_height) * d[2]
    across = d[0] * d[0] + d[1] * d[1]
    a = across - rate * rate
    b = p[0] * d[0] + p[1] * d[1] - radius * rate
    c = p[0] * p[0] + p[1] * p[1] - radius * radius
    # b² − a·c without its cancellation: the Gram determinant of p and d in the cone's indefinite metric.
    turn = abs(p[0] * d[1] - p[1] * d[0])
    swing = math.hypot(p[0] * rate - radius * d[0], p[1] * rate - radius * d[1])
    discriminant = (swing - turn) * (swing + turn)
    if a == 0.0 and b == 0.0:  # the side is neither nearer nor farther anywhere along the ray
        return side if c < 0.0 else MISS
    if discriminant <= 0.0:
        # A line steeper than the cone always meets both nappes: at best together, in the apex.
        if a >= 0.0:
            return MISS
        discriminant = 0.0
    q = -(b + math.copysign(math.sqrt(discriminant), b))
    other = c / q if q != 0.0 else 0.0
    if a == 0.0:
        # Parallel to a line of the cone: one crossing; inside where the linear function 2b·s + c is negative.
        first = middle - c / (2.0 * b)
        return overlap(side, (first, math.inf) if b < 0.0 else (-math.inf, first))
    near, far = middle + min(q / a, other), middle + max(q / a, other)
    if a > 0.0:
        return overlap(side, (near, far))
    if rate > 0.0:
        return overlap(side, (far, math.inf))
    return overlap(side, (-math.inf, near))


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
    # Near a tangent the slope vanishes and the root from the bracket is the better one; a NaN fails the test as well.
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
    """Number of intervals (0, 1 or 2) in a torus round the z axis, and their ends (start, end, start, end).

    About the point of the ray closest to the centre the quartic has no cubic term; its stationary points bracket every
    root, so none is missed and none needs complex arithmetic. Requires minor ≤ major.
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

    # Between neighbours of this list the quartic is monotonic; its sign at each tells where it crosses zero.
    # Both ends are outside the tube, whatever rounding says of a ray that touches it there.
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
