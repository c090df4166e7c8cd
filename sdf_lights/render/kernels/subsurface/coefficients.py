# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the colour of a surface and its scattering radius to the coefficients of a medium."""

import math

from ....jit import kernel
from ....vec import vec
from ..shading.records import RANDOM_WALK, RANDOM_WALK_SKIN

MOST_ALBEDO = 0.999999
LEAST_ALBEDO = 0.2  # below this, the walk uses this albedo, and its weight is reduced
SMALLEST = 1e-16  # metres
LEGACY_SCALE = 0.25 / math.pi  # factor on the radii of older methods

_HALVINGS = 12  # as in Cycles, so that the radius is the same


@kernel
def _polynomial(g, a, b, c, d, e, f, h):
    """a g + b g² + …"""
    return g * (a + g * (b + g * (c + g * (d + g * (e + g * (f + g * h))))))


@kernel
def _albedo_by_fit(color, g):
    """Albedo of single scattering, for g ≥ 0: the fit of Wrenninge, Villemin and Hery 2017, "Path traced subsurface
    scattering using anisotropic phase functions and non-exponential free flights", to Chiang, Kutz and Burley 2016."""
    a = 1.8260523782 + _polynomial(
        g, -1.28451056436, -1.79904629312, 9.19393289202, -22.8215585862, 32.0234874259, -23.6264803333, 7.21067002658
    )
    b = 4.98511194385 + 0.127355959438 * math.exp(
        _polynomial(
            g,
            31.1491581433,
            -201.847017512,
            841.576016723,
            -2018.09288505,
            2731.71560286,
            -1935.41424244,
            559.009054474,
        )
    )
    c = 1.09686102424 + _polynomial(
        g, -0.394704063468, 1.05258115941, -8.83963712726, 28.8643230661, -46.8802913581, 38.5402837518, -12.7181042538
    )
    d = 0.496310210422 + _polynomial(
        g, 0.360146581622, -2.15139309747, 17.8896899217, -55.2984010333, 82.065982243, -58.5106008578, 15.8478295021
    )
    e = 4.23190299701 + 0.00310603949088 * math.exp(
        _polynomial(
            g, 76.7316253952, -594.356773233, 2448.8834203, -5576.68528998, 7116.60171912, -4763.54467887, 1303.5318055
        )
    )
    f = 2.40602999408 + _polynomial(
        g, -2.51814844609, 9.18494908356, -79.2191708682, 259.082868209, -403.613804597, 302.85712436, -87.4370473567
    )
    blend = math.sqrt(math.sqrt(color))
    return (1.0 - blend) * a * math.atan(b * color) ** c + blend * d * math.atan(e * color) ** f


@kernel
def _albedo_by_inversion(color, g):
    """Albedo of single scattering by van de Hulst's formula for a half space, inverted: d'Eon 2021, "A hitchhiker's
    guide to multiple scattering", equation 53.7."""
    s = 4.09712 + 4.20863 * color - math.sqrt(9.59217 + color * (41.6808 + 17.7126 * color))
    below = 1.0 - g * s * s
    return (1.0 - s * s) / below if below != 0.0 else 0.0


@kernel
def _reflected(albedo, boundary):
    """Diffuse reflectance of a medium: Jensen et al. 2001, "A practical model for subsurface light transport", equation
    15."""
    s = math.sqrt(3.0 * (1.0 - albedo))
    return 0.5 * albedo * (1.0 + math.exp(-boundary * s)) * math.exp(-s)


@kernel
def _reduced_albedo(color, boundary):
    """The albedo that reflects ``color``: Jensen and Buhler 2002, "A rapid hierarchical rendering technique for
    translucent materials"."""
    if color < 1e-4:
        return 0.0
    if color >= 0.995:
        return MOST_ALBEDO
    low, high, middle = 0.0, 1.0, 0.5
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _reflected(middle, boundary) < color:
            low = middle
        else:
            high = middle
    return middle


@kernel
def skin_boundary(ior):
    """4/3 A of a boundary: Jensen et al. 2001, section 2.1."""
    f = (0.71 - 1.44 / ior) / ior + 0.668 + 0.0636 * ior
    return 4.0 / 3.0 * (1.0 + f) / (1.0 - f)


@kernel
def _channel(color, radius, g, method, boundary):
    """Extinction in 1/m, albedo of single scattering, and a factor on what the walk brings."""
    if method == RANDOM_WALK_SKIN:
        radius *= math.sqrt(3.0 * (1.0 - _reduced_albedo(color, boundary)))
    elif method != RANDOM_WALK:
        radius *= LEGACY_SCALE
    extinction = 1.0 / max(radius, SMALLEST)
    if method == RANDOM_WALK or g < 0.0:
        albedo = _albedo_by_inversion(color, g)
    else:
        albedo = _albedo_by_fit(color, g)
        extinction /= 1.0 - g
    albedo = min(max(albedo, 0.0), MOST_ALBEDO)
    if albedo < LEAST_ALBEDO:
        return extinction, LEAST_ALBEDO, albedo / LEAST_ALBEDO
    return extinction, albedo, 1.0


@kernel
def coefficients(closure):
    """Extinction, albedo and factor, each RGB, of a ``SUBSURFACE`` closure. The factor takes the colour from its
    weight, as the walk brings that."""
    color, radius, g, method = vec(closure.f0), vec(closure.edge), closure.a, closure.distribution
    boundary = skin_boundary(closure.ior)
    r0, a0, f0 = _channel(color[0], radius[0], g, method, boundary)
    r1, a1, f1 = _channel(color[1], radius[1], g, method, boundary)
    r2, a2, f2 = _channel(color[2], radius[2], g, method, boundary)
    return (
        (r0, r1, r2),
        (a0, a1, a2),
        (
            f0 / color[0] if color[0] > 0.0 else 0.0,
            f1 / color[1] if color[1] > 0.0 else 0.0,
            f2 / color[2] if color[2] > 0.0 else 0.0,
        ),
    )
