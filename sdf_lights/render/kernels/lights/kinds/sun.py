# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Suns: a direction, or a disk of directions."""

from __future__ import annotations

import math

import numpy as np

from .....jit import kernel, table
from .....vec import dot, sub, vec
from ....lights.sun import SunLight
from ..cone import cone_pdf, sample_cone
from ..extent import DistantLight, unit

RECORD = np.dtype(
    [
        ("direction", np.float64, 3),  # towards the sun
        ("radiance", np.float64, 3),  # of angle 0: irradiance
        ("one_minus_cos", np.float64),
    ],
    align=True,
)

LIGHT, TABLE = SunLight, "light_suns"
rows = table(TABLE, RECORD)


def pack(row, light, rgb) -> DistantLight | None:
    """Strength is irradiance on a surface that faces the sun."""
    row["direction"] = unit(light.matrix[:3, 2])
    half = 0.5 * min(max(light.angle, 0.0), math.pi)
    row["one_minus_cos"] = 2.0 * math.sin(0.5 * half) ** 2
    row["radiance"] = rgb / (math.pi * math.sin(half) ** 2 if half > 0.0 else 1.0)
    irradiance = float(np.abs(rgb).mean())
    if not row["direction"].any():
        row["radiance"] = 0.0
    elif irradiance > 0.0:
        return DistantLight(irradiance, row["direction"])
    return None


@kernel
def sample(light, x, u1, u2):
    """See ``interfaces.Light``."""
    direction = vec(light.direction)
    if light.one_minus_cos == 0.0:
        return direction, math.inf, vec(light.radiance), 1.0, True
    wi = sample_cone(direction, light.one_minus_cos, u1, u2)
    return wi, math.inf, vec(light.radiance), cone_pdf(light.one_minus_cos), False


@kernel
def hit(light, o, d):
    """See ``interfaces.Light``."""
    offset = sub(d, vec(light.direction))
    # |d − s|² / 2 is 1 − cosine without its cancellation.
    if 0.5 * dot(offset, offset) < light.one_minus_cos:
        return math.inf, vec(light.radiance), cone_pdf(light.one_minus_cos)
    return -1.0, (0.0, 0.0, 0.0), 0.0


def has_size(light) -> bool:
    """See ``interfaces.Light``."""
    return light.angle > 0.0
