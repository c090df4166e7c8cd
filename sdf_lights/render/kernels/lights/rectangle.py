# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rectangles sampled uniformly in solid angle.

Ureña, Fajardo and King 2013, "An area-preserving parametrization for spherical rectangles", EGSR. The point looks from
the origin along +z at the rectangle [x0, x1] × [y0, y1] in the plane z = h, h > 0.
"""

import math

from ....jit import kernel

# Below this bound of the solid angle its closed form, a difference of angles, has lost digits, and sampling the area is
# as good.
SMALL = 1e-5


@kernel
def is_small(x0, x1, y0, y1, h):
    """Whether the rectangle must be sampled by area: its solid angle is at most area · h / (nearest distance)³."""
    x = max(x0, -x1, 0.0)
    y = max(y0, -y1, 0.0)
    nearest = x * x + y * y + h * h
    return (x1 - x0) * (y1 - y0) * h < SMALL * nearest * math.sqrt(nearest)


@kernel
def _constants(x0, x1, y0, y1, h):
    """Cosines b0 and b1 of the planes through the lower and upper side, k = 2π − γ2 − γ3, and the solid angle."""
    h2 = h * h
    n0 = -y0 / math.sqrt(h2 + y0 * y0)
    n1 = x1 / math.sqrt(h2 + x1 * x1)
    n2 = y1 / math.sqrt(h2 + y1 * y1)
    n3 = -x0 / math.sqrt(h2 + x0 * x0)
    g0 = math.acos(min(max(-n0 * n1, -1.0), 1.0))
    g1 = math.acos(min(max(-n1 * n2, -1.0), 1.0))
    g2 = math.acos(min(max(-n2 * n3, -1.0), 1.0))
    g3 = math.acos(min(max(-n3 * n0, -1.0), 1.0))
    k = 2.0 * math.pi - g2 - g3
    return n0, n2, k, g0 + g1 - k


@kernel
def area_pdf(area, h, px, py):
    """Density per solid angle of uniform points of an area in the plane, towards (px, py)."""
    square = px * px + py * py + h * h
    return square * math.sqrt(square) / (area * h)


@kernel
def rectangle_pdf(x0, x1, y0, y1, h, px, py):
    """Density per solid angle of ``sample_rectangle`` towards the point (px, py) of the rectangle."""
    if is_small(x0, x1, y0, y1, h):
        return area_pdf((x1 - x0) * (y1 - y0), h, px, py)
    solid_angle = _constants(x0, x1, y0, y1, h)[3]
    return 1.0 / solid_angle if solid_angle > 0.0 else 0.0


@kernel
def sample_rectangle(x0, x1, y0, y1, h, u1, u2):
    """Point (px, py) of the rectangle and its density per solid angle."""
    if is_small(x0, x1, y0, y1, h):
        px, py = x0 + u1 * (x1 - x0), y0 + u2 * (y1 - y0)
        return px, py, area_pdf((x1 - x0) * (y1 - y0), h, px, py)
    b0, b1, k, solid_angle = _constants(x0, x1, y0, y1, h)
    if not solid_angle > 0.0:
        return x0, y0, 0.0
    angle = u1 * solid_angle + k
    f = (math.cos(angle) * b0 - b1) / math.sin(angle)
    c = min(max(math.copysign(1.0, f) / math.sqrt(f * f + b0 * b0), -1.0), 1.0)
    px = min(max(c * h / math.sqrt(max(1.0 - c * c, 1e-300)), x0), x1)
    d2 = px * px + h * h
    h0 = y0 / math.sqrt(d2 + y0 * y0)
    h1 = y1 / math.sqrt(d2 + y1 * y1)
    s = h0 + u2 * (h1 - h0)
    py = s * math.sqrt(d2 / max(1.0 - s * s, 1e-300))
    return px, min(max(py, y0), y1), 1.0 / solid_angle
