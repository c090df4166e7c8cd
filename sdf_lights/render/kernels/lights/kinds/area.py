# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights: rectangles and ellipses that emit to one side, with Blender's spread.

A light of P watts and full spread has the radiance P / (π · area). A smaller spread multiplies it like the slats of a
grid in front of the light, normalised so that P stays: for a half angle s, (tan s − tan θ) / (tan s − s) (Cycles, "Area
light spread importance sampling"). Only the part of the light whose cone reaches the point is sampled.
"""

from __future__ import annotations

import math

import numpy as np

from .....jit import kernel, table
from .....vec import dot, madd, negate, normalize, scale, sub, to_world, vec
from ....lights.area import AreaLight
from ..ellipse import ellipse_pdf, sample_ellipse
from ..extent import Extent, unit
from ..records import no_sample
from ..rectangle import rectangle_pdf, sample_rectangle

RECORD = np.dtype(
    [
        ("center", np.float64, 3),
        ("u", np.float64, 3),
        ("v", np.float64, 3),
        ("normal", np.float64, 3),  # the emitting side; (u, v, normal) is orthonormal, of either handedness
        ("half_u", np.float64),
        ("half_v", np.float64),
        ("radiance", np.float64, 3),
        ("ellipse", np.int64),
        ("tan_spread", np.float64),  # of half the angle of spread; infinite: all directions
        ("spread_gain", np.float64),
    ],
    align=True,
)

LIGHT, TABLE = AreaLight, "light_areas"
rows = table(TABLE, RECORD)


def pack(row, light, rgb) -> Extent:
    """The object's scale changes the size, not the power. A sheared light becomes the rectangle of the same base and
    height."""
    linear = light.matrix[:3, :3]
    u, v = linear[:, 0] * light.size[0], linear[:, 1] * light.size[1]
    unit_u = unit(u)
    v = v - np.dot(v, unit_u) * unit_u
    unit_v = unit(v)
    normal = np.cross(unit_u, unit_v)
    if np.dot(normal, linear[:, 2]) > 0.0:
        normal = -normal
    half = 0.5 * np.linalg.norm(u), 0.5 * np.linalg.norm(v)
    area = half[0] * half[1] * (math.pi if light.ellipse else 4.0)
    row["center"], row["u"], row["v"], row["normal"] = light.matrix[:3, 3], unit_u, unit_v, normal
    row["half_u"], row["half_v"], row["ellipse"] = half[0], half[1], light.ellipse
    radiance = rgb / (math.pi * area) if area > 0.0 else np.zeros(3)
    row["radiance"] = radiance

    spread = 0.5 * min(max(light.spread, 0.0), math.pi)
    row["tan_spread"], gain = math.inf, 1.0
    if spread == 0.0:
        row["tan_spread"] = 0.0
    elif spread < 0.5 * math.pi - 1e-6:
        tangent = math.tan(spread)
        # The series of tan s − s, where the difference has lost its digits.
        row["tan_spread"], row["spread_gain"] = tangent, 1.0 / (tangent - spread if spread > 0.05 else spread**3 / 3.0)
        gain = tangent * float(row["spread_gain"])
    reach = np.abs(unit_u) * half[0] + np.abs(unit_v) * half[1]
    center = light.matrix[:3, 3]
    # Intensity along the axis. A parallel beam has none; its irradiance replaces it, at a distance of its own size.
    intensity = np.abs(radiance).mean() * area * gain
    return Extent(
        center - reach,
        center + reach,
        intensity,
        axis=normal,
        cos_o=1.0 if area > 0.0 else -1.0,
        cos_e=math.cos(spread),
    )


@kernel
def local(light, x):
    """x in the light's frame, in which the light is at the origin and emits along +z."""
    offset = sub(x, vec(light.center))
    return dot(offset, vec(light.u)), dot(offset, vec(light.v)), dot(offset, vec(light.normal))


@kernel
def _reach(light, x, y, h):
    """Rectangle, relative to the foot of the point, around the part of the light whose cone reaches the point."""
    r = h * light.tan_spread
    return (max(-light.half_u - x, -r), min(light.half_u - x, r), max(-light.half_v - y, -r), min(light.half_v - y, r))


@kernel
def _gain(light, px, py, h):
    """Factor on the radiance towards a point at height h, from the position (px, py) relative to its foot."""
    if light.tan_spread == math.inf:
        return 1.0
    return max(light.tan_spread - math.sqrt(px * px + py * py) / h, 0.0) * light.spread_gain


@kernel
def _contains(light, qx, qy):
    if light.ellipse:
        return (qx / light.half_u) ** 2 + (qy / light.half_v) ** 2 <= 1.0
    return abs(qx) <= light.half_u and abs(qy) <= light.half_v


@kernel
def sample(light, x, u1, u2):
    """See ``interfaces.Light``."""
    lx, ly, h = local(light, x)
    if not h > 0.0 or light.half_u <= 0.0 or light.half_v <= 0.0:
        return no_sample()
    if light.tan_spread == 0.0:
        if not _contains(light, lx, ly):
            return no_sample()
        return negate(vec(light.normal)), h, scale(vec(light.radiance), math.pi), 1.0, True
    if light.ellipse and light.tan_spread == math.inf:
        px, py, pdf = sample_ellipse(-lx, -ly, light.half_u, light.half_v, h, u1, u2)
    else:
        x0, x1, y0, y1 = _reach(light, lx, ly, h)
        if not (x0 < x1 and y0 < y1):
            return no_sample()
        px, py, pdf = sample_rectangle(x0, x1, y0, y1, h, u1, u2)
        if light.ellipse and not _contains(light, px + lx, py + ly):
            pdf = 0.0
    if not 0.0 < pdf < math.inf:
        return no_sample()
    distance = math.sqrt(px * px + py * py + h * h)
    wi = to_world((px, py, -h), vec(light.u), vec(light.v), vec(light.normal))
    return normalize(wi), distance, scale(vec(light.radiance), _gain(light, px, py, h)), pdf, False


@kernel
def hit(light, o, d):
    """Distance along d to the emitting side of the light, radiance and pdf of ``sample`` there; −1: missed."""
    miss = -1.0, (0.0, 0.0, 0.0), 0.0
    lx, ly, h = local(light, o)
    slope = -dot(d, vec(light.normal))
    if not (h > 0.0 and slope > 0.0) or light.tan_spread == 0.0:
        return miss
    t = h / slope
    p = madd(o, t, d)
    qx, qy, _ = local(light, p)
    if not _contains(light, qx, qy):
        return miss
    px, py = qx - lx, qy - ly
    gain = _gain(light, px, py, h)
    if gain == 0.0:
        return miss
    if light.ellipse and light.tan_spread == math.inf:
        pdf = ellipse_pdf(-lx, -ly, light.half_u, light.half_v, h, px, py)
    else:
        x0, x1, y0, y1 = _reach(light, lx, ly, h)
        pdf = rectangle_pdf(x0, x1, y0, y1, h, px, py) if x0 < x1 and y0 < y1 else 0.0
    # A light of zero width has a solid angle within rounding: sampling skips it too.
    if not 0.0 < pdf < math.inf:
        return miss
    return t, scale(vec(light.radiance), gain), pdf


@kernel
def leave(light, u1, u2, u3, u4):
    """See ``interfaces.Light``: a uniform point, and a direction by the cosine in the cone of the spread."""
    area = light.half_u * light.half_v * (math.pi if light.ellipse else 4.0)
    x, y = 2.0 * u1 - 1.0, 2.0 * u2 - 1.0
    if light.ellipse:
        r, phi = math.sqrt(u1), 2.0 * math.pi * u2
        x, y = r * math.cos(phi), r * math.sin(phi)
    u, v, axis = vec(light.u), vec(light.v), vec(light.normal)
    origin = madd(madd(vec(light.center), x * light.half_u, u), y * light.half_v, v)
    if light.tan_spread == 0.0:
        return origin, axis, scale(vec(light.radiance), math.pi * area), math.inf
    slope = light.tan_spread
    cone = 1.0 if slope == math.inf else slope * slope / (1.0 + slope * slope)
    sine, turn = math.sqrt(u3 * cone), 2.0 * math.pi * u4
    cosine = math.sqrt(max(1.0 - u3 * cone, 0.0))
    direction = to_world((sine * math.cos(turn), sine * math.sin(turn), cosine), u, v, axis)
    gain = _gain(light, sine, 0.0, cosine) if cosine > 0.0 else 0.0
    return origin, direction, scale(vec(light.radiance), gain * math.pi * cone * area), math.inf


def flux(rows) -> np.ndarray:
    """See ``interfaces.Light``."""
    area = rows["half_u"] * rows["half_v"] * np.where(rows["ellipse"], math.pi, 4.0)
    return np.abs(rows["radiance"]).mean(axis=1) * math.pi * area


@kernel
def normal(light, back):
    """See ``interfaces.Light``."""
    return vec(light.normal)


def has_size(light) -> bool:
    """See ``interfaces.Light``."""
    return True
