# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared by both models of Principled Hair: absorption of the pigments, and distributions along and around a fiber."""

import math

from .....jit import kernel
from .....vec import add, cross, dot, frame, scale, vec
from ....scene import Primitive
from ..operands import number, vector
from ..special_lobes import option

TWO_PI = 2.0 * math.pi
_OF_MELANIN, _OF_ABSORPTION = (
    option("principled_hair", "parametrization", value) for value in ("MELANIN", "ABSORPTION")
)
_ALL_LIGHT_RAYS = option("principled_hair", "light_rays", "ALL")
RIBBONS = int(Primitive.RIBBONS)

# Indices of the arguments of the lobe.
(
    COLOR,
    MELANIN,
    REDNESS,
    TINT,
    ABSORPTION,
    ROUGHNESS,
    RADIAL_ROUGHNESS,
    COAT,
    IOR,
    OFFSET,
    RANDOM_COLOR,
    RANDOM_ROUGHNESS,
    RANDOM,
    ASPECT_RATIO,
    R_LOBE,
    TT_LOBE,
    TRT_LOBE,
    AXIS,
) = range(18)

# Absorption of the two melanins, each for a concentration of 1 (d'Eon et al. 2011, "An energy-conserving hair
# reflectance model").
_EUMELANIN, _PHEOMELANIN = (0.506, 0.841, 1.653), (0.343, 0.733, 1.924)


@kernel
def cosine_of(sine):
    """The cosine, not negative, of an angle with this sine."""
    return math.sqrt(max(1.0 - sine * sine, 0.0))


@kernel
def across(tangent, wo):
    """Unit vectors perpendicular to the fiber: y, which is also perpendicular to the view, and z, away from the viewer,
    with x × y = z for the fiber x."""
    y = cross(tangent, wo)
    square = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
    if square < 1e-24:
        return frame(tangent)
    y = scale(y, 1.0 / math.sqrt(square))
    return y, cross(tangent, y)


@kernel
def cuts_light_rays(surface, lobe):
    """Whether ``cut`` has an effect."""
    return surface.strand == 0 and lobe.features & _ALL_LIGHT_RAYS == 0


@kernel
def cut(surface, closure, n, wi):
    """Whether light rays from wi have no effect on a mesh; n is perpendicular to the fiber and to the view.

    Cycles treats n as the normal of a bump, behind which it cuts light rays; rays sampled from the fiber itself
    continue. So a lamp without a size gives less light than it should, and others lose the part of light rays. This
    engine does the same. Before Blender 5.0, Cycles cut none.
    """
    if not closure.distribution:
        return False
    smooth = vec(surface.n)
    return dot(smooth, wi) * dot(smooth, n) * dot(n, wi) < 0.0


@kernel
def _of_color(color, roughness):
    """Absorption of a fiber with the albedo ``color``: Chiang et al. 2016, equation 9."""
    x = roughness
    scale_ = ((((0.245 * x + 5.574) * x - 10.73) * x + 2.532) * x - 0.215) * x + 5.969
    r = math.log(max(color[0], 1e-30)) / scale_
    g = math.log(max(color[1], 1e-30)) / scale_
    b = math.log(max(color[2], 1e-30)) / scale_
    return (r * r, g * g, b * b)


@kernel
def random_factor(block, workspace, lobe, amount):
    """Factor on a property that varies from fiber to fiber by ``amount``."""
    return 1.0 + 2.0 * (number(block, workspace, lobe.args[RANDOM]) - 0.5) * amount


@kernel
def absorption(block, workspace, lobe, roughness):
    """Absorption coefficient (RGB) per radius of a fiber."""
    args = lobe.args
    if lobe.features & _OF_ABSORPTION:
        return vector(block, workspace, args[ABSORPTION])
    if not lobe.features & _OF_MELANIN:
        return _of_color(vector(block, workspace, args[COLOR]), roughness)
    varied = min(max(number(block, workspace, args[RANDOM_COLOR]), 0.0), 1.0)
    melanin = number(block, workspace, args[MELANIN]) * random_factor(block, workspace, lobe, varied)
    amount = -math.log(max(1.0 - melanin, 1e-4))
    red = number(block, workspace, args[REDNESS])
    pigments = add(scale(_EUMELANIN, amount * (1.0 - red)), scale(_PHEOMELANIN, amount * red))
    return add(pigments, _of_color(vector(block, workspace, args[TINT]), roughness))


@kernel
def bessel(x):
    """Modified Bessel function of the first kind and order 0, by its series."""
    square, term, total = 0.25 * x * x, 1.0, 1.0
    for i in range(1, 10):
        term *= square / (i * i)
        total += term
    return total


@kernel
def _log_bessel(x):
    if x > 12.0:
        return x + 0.5 * (-math.log(2.0 * math.pi) - math.log(x) + 1.0 / (8.0 * x))
    return math.log(bessel(x))


@kernel
def longitudinal(sine_i, cosine_i, sine_o, cosine_o, v):
    """Scattering along a fiber with the variance v: d'Eon et al. 2011."""
    a, b = cosine_i * cosine_o / v, sine_i * sine_o / v
    if v <= 0.1:
        return math.exp(_log_bessel(a) - b - 1.0 / v + 0.6931 + math.log(0.5 / v))
    return math.exp(-b) * bessel(a) / ((math.exp(1.0 / v) - math.exp(-1.0 / v)) * v)


@kernel
def tilted(sine, cosine, angle):
    """Sine and cosine of an inclination tilted by the scales' ``angle``."""
    s, c = math.sin(angle), math.cos(angle)
    return sine * c - cosine * s, abs(cosine * c + sine * s)


@kernel
def azimuthal(phi, s):
    """Density of a logistic distribution of width s, truncated at ±π, for an angle around the fiber."""
    x = abs(phi - TWO_PI * math.floor((phi + math.pi) / TWO_PI))
    e = math.exp(-x / s)
    return e / (s * (1.0 + e) * (1.0 + e)) / (1.0 - 2.0 / (1.0 + math.exp(min(math.pi / s, 80.0))))


@kernel
def sample_azimuthal(s, u):
    """A sample of ``azimuthal``: an angle."""
    low = 1.0 / (1.0 + math.exp(min(math.pi / s, 80.0)))
    inner = u * (1.0 - 2.0 * low) + low
    return min(max(-s * math.log(max(1.0 / max(inner, 1e-30) - 1.0, 1e-30)), -math.pi), math.pi)


@kernel
def sample_longitudinal(sine_o, cosine_o, v, u1, u2):
    """A sample of ``longitudinal``: the sine of an inclination."""
    u1 = max(u1, 1e-5)
    c = 1.0 + v * math.log(u1 + (1.0 - u1) * math.exp(-2.0 / v))
    s = math.sqrt(max(1.0 - c * c, 0.0))
    return min(max(-c * sine_o + s * math.cos(2.0 * math.pi * u2) * cosine_o, -1.0), 1.0)
