# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ellipses and disks sampled in solid angle.

An ellipse seen from a point fills an elliptic cone. Gamito 2016, "Solid angle sampling of disk and cylinder lights",
EGSR, samples the surrounding spherical rectangle and rejects. Here nothing is rejected. In polar coordinates (θ, φ)
around the cone's axis, φ is that of a uniform point of an ellipse in Lambert's equal-area projection with the cone's
own half axes, and cos θ is uniform out to the cone. The density is exact. It is uniform for circular cones and nearly
so for others, because the projection of an elliptic cone is nearly an ellipse.

The point looks from the origin along +z at the ellipse ((X − cx) / a)² + ((Y − cy) / b)² ≤ 1 in the plane z = h, h > 0.
"""

import math

from ....jit import kernel
from ....vec import cross, dot, frame, normalize, scale, to_world
from .cone import polar_direction
from .rectangle import area_pdf, is_small


@kernel
def is_small_ellipse(cx, cy, a, b, h):
    """Whether the ellipse must be sampled by area; see ``rectangle.is_small``."""
    return is_small(cx - a, cx + a, cy - b, cy + b, h)


@kernel
def _axis_eigenvalue(xx, yy, zz, xz, yz):
    """Smallest eigenvalue of the symmetric matrix [[xx, 0, xz], [0, yy, yz], [xz, yz, zz]] (trigonometric formula)."""
    mean = (xx + yy + zz) / 3.0
    p, q, r = xx - mean, yy - mean, zz - mean
    square = (p * p + q * q + r * r + 2.0 * (xz * xz + yz * yz)) / 6.0
    if square == 0.0:
        return mean
    half_det = 0.5 * (p * q * r - p * yz * yz - q * xz * xz)
    cosine = min(max(half_det / (square * math.sqrt(square)), -1.0), 1.0)
    value = mean + 2.0 * math.sqrt(square) * math.cos((math.acos(cosine) + 2.0 * math.pi) / 3.0)
    # Newton's step on the characteristic polynomial restores the digits that the cosine lost.
    u, v, w = xx - value, yy - value, zz - value
    polynomial = u * v * w - u * yz * yz - v * xz * xz
    slope = -(v * w + u * w + u * v) + yz * yz + xz * xz
    return value - polynomial / slope if slope != 0.0 else value


@kernel
def _cone(cx, cy, a, b, h):
    """The cone's frame (e1, e2, axis) and the tangents of its half angles along e1 and e2."""
    ex, ey, wx, wy = cx / h, cy / h, (h / a) ** 2, (h / b) ** 2
    # Quadratic form that is negative inside the cone.
    scaling = 1.0 / max(wx, wy)
    xx, yy = wx * scaling, wy * scaling
    xz, yz = -ex * xx, -ey * yy
    zz = ex * ex * xx + ey * ey * yy - scaling
    value = _axis_eigenvalue(xx, yy, zz, xz, yz)
    r0, r1, r2 = (xx - value, 0.0, xz), (0.0, yy - value, yz), (xz, yz, zz - value)
    c0, c1, c2 = cross(r0, r1), cross(r1, r2), cross(r2, r0)
    s0, s1, s2 = dot(c0, c0), dot(c1, c1), dot(c2, c2)
    axis = c0
    if s1 > s0 and s1 >= s2:
        axis = c1
    elif s2 > s0:
        axis = c2
    axis = normalize(axis)
    if axis[2] < 0.0 or (axis[2] == 0.0 and axis[0] * ex + axis[1] * ey < 0.0):
        axis = scale(axis, -1.0)
    t, s = frame(axis)
    mt = (xx * t[0] + xz * t[2], yy * t[1] + yz * t[2], xz * t[0] + yz * t[1] + zz * t[2])
    ms = (xx * s[0] + xz * s[2], yy * s[1] + yz * s[2], xz * s[0] + yz * s[1] + zz * s[2])
    tt, ts, ss = dot(t, mt), dot(t, ms), dot(s, ms)
    angle = 0.5 * math.atan2(2.0 * ts, tt - ss)
    e1 = to_world((math.cos(angle), math.sin(angle), 0.0), t, s, axis)
    e2 = to_world((-math.sin(angle), math.cos(angle), 0.0), t, s, axis)
    middle, radius = 0.5 * (tt + ss), math.hypot(0.5 * (tt - ss), ts)
    # The product of all three eigenvalues is known, which gives the smaller of the two without cancellation.
    large = middle + radius
    small = -xx * yy * scaling / (value * large)
    return e1, e2, axis, math.sqrt(-value / large), math.sqrt(-value / small)


@kernel
def _half_axes(tangent):
    """Half axis 2 sin(θ / 2) of the equal-area projection, from tan θ."""
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    return tangent * cosine * math.sqrt(2.0 / (1.0 + cosine))


@kernel
def _density(c, s, ta, tb):
    """1 − cos θ of the cone in the azimuth (c, s), and the density per solid angle there."""
    pa, pb = _half_axes(ta), _half_axes(tb)
    radius = 1.0 / ((c / pa) ** 2 + (s / pb) ** 2)
    cotangent = (c / ta) ** 2 + (s / tb) ** 2
    cosine = math.sqrt(cotangent / (1.0 + cotangent))
    width = 1.0 / ((1.0 + cotangent) * (1.0 + cosine))
    return width, radius / (2.0 * math.pi * pa * pb * width)


@kernel
def ellipse_pdf(cx, cy, a, b, h, px, py):
    """Density per solid angle of ``sample_ellipse`` towards the point (px, py) of the ellipse."""
    if is_small_ellipse(cx, cy, a, b, h):
        return area_pdf(math.pi * a * b, h, px, py)
    e1, e2, _, ta, tb = _cone(cx, cy, a, b, h)
    c, s = dot(e1, (px, py, h)), dot(e2, (px, py, h))
    square = c * c + s * s
    if square == 0.0:
        return _density(1.0, 0.0, ta, tb)[1]
    inverse = 1.0 / math.sqrt(square)
    return _density(c * inverse, s * inverse, ta, tb)[1]


@kernel
def sample_ellipse(cx, cy, a, b, h, u1, u2):
    """Point (px, py) of the ellipse and its density per solid angle."""
    phi = 2.0 * math.pi * u1
    if is_small_ellipse(cx, cy, a, b, h):
        r = math.sqrt(u2)
        px, py = cx + a * r * math.cos(phi), cy + b * r * math.sin(phi)
        return px, py, area_pdf(math.pi * a * b, h, px, py)
    e1, e2, axis, ta, tb = _cone(cx, cy, a, b, h)
    c, s = _half_axes(ta) * math.cos(phi), _half_axes(tb) * math.sin(phi)
    inverse = 1.0 / math.sqrt(c * c + s * s)
    c, s = c * inverse, s * inverse
    width, density = _density(c, s, ta, tb)
    x, _, z = polar_direction(u2 * width, 0.0)
    d = to_world((x * c, x * s, z), e1, e2, axis)
    if d[2] <= 0.0:
        return cx, cy, 0.0
    return d[0] / d[2] * h, d[1] / d[2] * h, density
