# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Phase functions of Blender, converted to those of ``medium.Scattering``."""

from __future__ import annotations

import math

import numpy as np

MOST_G = 1.0 - 1e-3  # as in Cycles: beyond, light would hardly be scattered
_DRAINE_OF_SMALL = 250.0  # α of Draine's part for droplets much smaller than the wavelength


def limited(g: float) -> float:
    """The anisotropy g, clamped to ``MOST_G`` in magnitude."""
    return math.copysign(min(abs(g), MOST_G), g)


def mie(diameter: float) -> tuple[tuple[float, float, float], ...]:
    """(share, g, α) of the phase functions that together represent droplets of so many micrometres.

    Jendersie and d'Eon 2023, "An approximate Mie scattering function for fog and cloud rendering".
    """
    d = max(diameter, 0.0)
    if d <= 0.1:
        g, draine, alpha = 13.8 * d * d, 1.1456 * d * math.sin(9.29044 * d), _DRAINE_OF_SMALL
        share = 0.252977 - 312.983 * d**4.3
    elif d < 1.5:
        log = math.log(d)
        wave = math.cos((log - 0.238604) * (log + 1.00667) / (0.507522 - 0.15677 * log))
        g, alpha = 0.862 - 0.143 * log * log, _DRAINE_OF_SMALL
        draine = 0.379685 * math.cos(1.19692 * wave + 1.37932 * log + 0.0625835) + 0.344213
        share = 0.146209 * math.cos(3.38707 * log + 2.11193) + 0.316072 + 0.0778917 * log
    elif d < 5.0:
        log = math.log(d)
        inner = math.log(log)
        g, alpha = 0.0604931 * inner + 0.940256, 7.30354 * log + 6.31675
        draine = 0.500411 - 0.081287 / (-2.0 * log + math.tan(log) + 1.27551)
        share = 0.026914 * (log - math.cos(5.68947 * (inner - 0.0292149))) + 0.3764
    else:
        g, draine = math.exp(-0.0990567 / (d - 1.67154)), math.exp(-2.20679 / (d + 3.91029) - 0.428934)
        alpha = math.exp(3.62489 - 8.29288 / (d + 5.52825))
        share = math.exp(-0.599085 / (d - 0.641583) - 0.665888)
    return (1.0 - share, limited(g), 0.0), (share, limited(draine), alpha)


def fournier_forand_mean(index: float, backscatter: float) -> float:
    """Mean cosine of particles with this refractive index that scatter this fraction backwards.

    Fournier and Jonasz 1999, "Computer-based underwater imaging analysis", SPIE 3761.
    """
    index, backscatter = max(index, 1.0 + 1e-3), min(abs(backscatter), 0.5 - 1e-3)
    cosine = np.cos(np.linspace(0.0, math.pi, 20001)[1:-1])
    sine = np.sqrt(1.0 - cosine * cosine)
    half, whole = 0.5 * (1.0 - cosine), 4.0 / (3.0 * (index - 1.0) ** 2)
    slope = -math.log(2.0 * backscatter * (0.5 * whole - 1.0) + 1.0) / math.log(0.5 * whole)
    delta = whole * half
    delta = np.where(np.abs(delta - 1.0) < 1e-6, 1.0 + 1e-6, delta)
    power = delta**slope
    value = (slope * (1.0 - delta) - (1.0 - power) + (delta * (1.0 - power) - slope * (1.0 - delta)) / half) / (
        4.0 * (1.0 - delta) ** 2 * power
    )
    value += (1.0 - whole**slope) / (16.0 * (whole - 1.0) * whole**slope) * (3.0 * cosine * cosine - 1.0)
    return float(np.clip((value * sine * cosine).sum() / (value * sine).sum(), -MOST_G, MOST_G))
