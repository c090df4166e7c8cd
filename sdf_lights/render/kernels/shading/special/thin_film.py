# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflectance of a surface below a thin film with interference.

Belcour and Barla 2017, "A practical extension to microfacet theory for the modeling of varying iridescence": Airy's sum
over reflections inside the film, each seen through the Fourier transform of the eye's sensitivity
(``tables/thin_film.py``).
"""

import math

import numpy as np

from .....jit import kernel, table
from ....tables.thin_film import LONGEST, SIZE
from .. import fresnel

TABLES = {"thin_film": np.dtype("f8")}
_thin_film = table("thin_film", TABLES["thin_film"])

_TERMS = 3  # of the sum over reflections; later ones are hardly visible


@kernel
def _sensitivity(block, channel, path):
    """Means of cos 2πΔ/λ and sin 2πΔ/λ over the sensitivity of a channel, for the path difference Δ in nanometres."""
    values = _thin_film(block)
    x = min(max(path / LONGEST, 0.0), 1.0) * (SIZE - 1)
    i = min(int(x), SIZE - 2)
    t = x - i
    at = channel * SIZE + i
    cosine = values[at] + t * (values[at + 1] - values[at])
    at += 3 * SIZE
    return cosine, values[at] + t * (values[at + 1] - values[at])


@kernel
def _airy(block, channel, top, bottom, path, re, im):
    """Reflectance of two interfaces with reflectances ``top`` and ``bottom``; re + i · im is the phase that both
    together give to light inside the film."""
    product = top * bottom
    passed = 1.0 - top
    inside = passed * passed * bottom / max(1.0 - product, 1e-9)
    total, factor = top + inside, inside - passed
    root = math.sqrt(product)
    a, b = re, im
    for order in range(1, _TERMS + 1):
        factor *= root
        cosine, sine = _sensitivity(block, channel, order * path)
        total += 2.0 * factor * (a * cosine - b * sine)
        a, b = a * re - b * im, a * im + b * re
    return total


@kernel
def _index(ior, thickness):
    """Index of a film; films thinner than a nanometre fade out."""
    if thickness >= 1.0:
        return ior
    t = max(thickness, 0.0)
    return 1.0 + t * t * (3.0 - 2.0 * t) * (ior - 1.0)


@kernel
def _mean(block, channel, s, p, bottom_s, bottom_p, path, re_s, im_s, re_p, im_p):
    """Both polarisations together. ``s``, ``p``: amplitudes at the top; the phases are those of the bottom."""
    # Light from below meets the top with the opposite sign.
    turn_s, turn_p = -math.copysign(1.0, s), -math.copysign(1.0, p)
    return min(
        max(
            0.5
            * (
                _airy(block, channel, s * s, bottom_s, path, turn_s * re_s, turn_s * im_s)
                + _airy(block, channel, p * p, bottom_p, path, turn_p * re_p, turn_p * im_p)
            ),
            0.0,
        ),
        1.0,
    )


@kernel
def dielectric(block, cosine, ior, film_ior, thickness):
    """Reflectance (RGB) of a dielectric under a film; all indices are relative to that of the side of the ray."""
    inner = _index(film_ior, thickness)
    s, p, cosine_film = fresnel.polarized(cosine, inner)
    if cosine_film == 0.0:
        return (1.0, 1.0, 1.0)
    bottom_s, bottom_p, cosine_t = fresnel.polarized(cosine_film, ior / inner)
    if cosine_t == 0.0:
        return (1.0, 1.0, 1.0)
    path = 2.0 * inner * thickness * cosine_film
    sign_s, sign_p = math.copysign(1.0, bottom_s), math.copysign(1.0, bottom_p)
    square_s, square_p = bottom_s * bottom_s, bottom_p * bottom_p
    return (
        _mean(block, 0, s, p, square_s, square_p, path, sign_s, 0.0, sign_p, 0.0),
        _mean(block, 1, s, p, square_s, square_p, path, sign_s, 0.0, sign_p, 0.0),
        _mean(block, 2, s, p, square_s, square_p, path, sign_s, 0.0, sign_p, 0.0),
    )


@kernel
def conductor(block, channel, cosine, n, k, at_82, film_ior, thickness):
    """Reflectance of a channel of a conductor of index n + ik under a film. If ``at_82`` is not negative, it is a metal
    of F82-Tint with that reflectance at 82° in air; n and k then only give the phases."""
    inner = _index(film_ior, thickness)
    s, p, cosine_film = fresnel.polarized(cosine, inner)
    if cosine_film == 0.0:
        return 1.0
    re_s, im_s, re_p, im_p = fresnel.conductor_amplitudes(cosine_film, inner, n, k)
    square_s, square_p = re_s * re_s + im_s * im_s, re_p * re_p + im_p * im_p
    size_s, size_p = math.sqrt(square_s), math.sqrt(square_p)
    if size_s > 0.0:
        re_s, im_s = re_s / size_s, im_s / size_s
    else:
        re_s = 1.0
    if size_p > 0.0:
        re_p, im_p = re_p / size_p, im_p / size_p
    else:
        re_p = 1.0
    if at_82 >= 0.0:
        f0 = ((n - inner) * (n - inner) + k * k) / ((n + inner) * (n + inner) + k * k)
        square_s = fresnel.f82(cosine_film, f0, fresnel.f82_edge_through(f0, at_82))
        square_p = square_s
    path = 2.0 * inner * thickness * cosine_film
    return _mean(block, channel, s, p, min(square_s, 1.0), min(square_p, 1.0), path, re_s, im_s, re_p, im_p)


@kernel
def index_of_metal(f0, at_82):
    """n and k of a metal from its reflectances at normal incidence and at 82°: Gulbrandsen 2014, "Artist friendly
    metallic Fresnel", with the latter as the colour of the edge."""
    r = min(f0, 0.999)
    root = math.sqrt(r)
    n = at_82 * (1.0 - r) / (1.0 + r) + (1.0 - at_82) * (1.0 + root) / (1.0 - root)
    square = (r * (n + 1.0) * (n + 1.0) - (n - 1.0) * (n - 1.0)) / (1.0 - r)
    return n, math.sqrt(max(square, 0.0))
