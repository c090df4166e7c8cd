# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scattering lobes that few materials have. See ``closures.py``."""

from __future__ import annotations

import numpy as np

from ..tables import cie
from .closures import DIELECTRIC, F82, Microfacet, dielectric, f0_of_ior, f82
from .vectors import dot, frame, normalize

CONDUCTOR = "conductor"
THINNEST_FILM = 0.1  # nanometres


def frame_about(n: np.ndarray, tangent: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors t, b that complete n to a right-handed frame, with t as near to ``tangent`` as possible; all (N,
    3)."""
    b = np.cross(n, tangent)
    size = np.linalg.norm(b, axis=1, keepdims=True)
    b = np.where(size > 0.0, b / np.where(size > 0.0, size, 1.0), frame(n)[1])
    return np.cross(b, n), b


class Facets(Microfacet):
    """Microfacets of roughness ``alpha`` along ``tangent`` (N, 3) and ``across`` it, of the GGX distribution or of
    Beckmann's (``beckmann``), under a film where its ``thickness`` (N,) in nanometres is not 0, with index ``film_ior``
    (N,).

    The Fresnel term may be CONDUCTOR, too, of indices ``n`` and ``k`` (N, 3).
    """

    widths = ("alpha", "across")

    @property
    def singular(self):
        """Where (N,) it is a perfect mirror."""
        return self.alpha * self.across <= 2e-10

    def _slopes(self, w):
        """The coordinates of w, (3, N), in the frame of the tangent."""
        t, b = frame_about(self.normal, self.tangent)
        return np.array([dot(t, w), dot(b, w), dot(self.normal, w)])

    def density(self, h):
        x, y, z = self._slopes(h)
        x, y = x / self.alpha, y / self.across
        tan2 = (x * x + y * y) / (z * z)
        shape = np.exp(-tan2) if self.beckmann else 1.0 / (1.0 + tan2) ** 2
        return shape / (np.pi * self.alpha * self.across * z**4)

    def masking(self, w):
        x, y, z = self._slopes(w)
        tan2 = ((x * self.alpha) ** 2 + (y * self.across) ** 2) / (z * z)
        if not self.beckmann:
            return 0.5 * (np.sqrt(1.0 + tan2) - 1.0)
        a = 1.0 / np.sqrt(np.maximum(tan2, 1e-12))
        # The fit of Walter et al. 2007, as Heitz 2014 states it.
        return np.where(a < 1.6, (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a), 0.0)

    def visible(self, co, hn, lo):
        if not self.beckmann:
            return super().visible(co, hn, lo)
        # All normals are drawn, not only visible ones: their density is D · |h · n|.
        return hn * co / np.maximum(np.abs(self._seen), 1e-12)

    def evaluate(self, wo, wi):
        through = dot(self.normal, wi) < 0.0
        h = wo + wi * np.where(through, self.ior, 1.0)[:, None]
        size = np.linalg.norm(h, axis=1)
        self._seen = dot(h, wo) / np.where(size > 0.0, size, 1.0)
        return super().evaluate(wo, wi)

    def _normals(self, rng, wo):
        t, b = frame_about(self.normal, self.tangent)
        if self.beckmann:
            radius = np.sqrt(-np.log1p(-rng.random(len(wo))))
            phi = 2.0 * np.pi * rng.random(len(wo))
            local = np.stack(
                [self.alpha * radius * np.cos(phi), self.across * radius * np.sin(phi), np.ones(len(wo))], -1
            )
            h = normalize(local)
            return h[:, :1] * t + h[:, 1:2] * b + h[:, 2:] * self.normal
        stretch = np.stack([self.alpha, self.across, np.ones_like(self.alpha)], -1)
        view = normalize(self._slopes(wo).T * stretch)
        z = (1.0 - rng.random(len(wo))) * (1.0 + view[:, 2]) - view[:, 2]
        phi = 2.0 * np.pi * rng.random(len(wo))
        s = np.sqrt(np.clip(1.0 - z * z, 0.0, 1.0))
        h = normalize((np.stack([s * np.cos(phi), s * np.sin(phi), z], -1) + view) * stretch)
        return h[:, :1] * t + h[:, 1:2] * b + h[:, 2:] * self.normal

    def fresnel(self, cosine):
        nothing = np.zeros((len(cosine), 3))
        covered = np.asarray(self.thickness) > THINNEST_FILM
        if self.term == CONDUCTOR:
            bare = conductor_reflectance(np.abs(cosine)[:, None], self.n, self.k), nothing
        else:
            bare = super().fresnel(cosine)
        if not np.any(covered):
            return bare
        r, t = self._under_film(np.abs(cosine))
        return np.where(covered[:, None], r, bare[0]), np.where(covered[:, None], t, bare[1])

    def _under_film(self, cosine):
        inner = 1.0 + (self.film_ior - 1.0) * _smooth(self.thickness)
        if self.term == DIELECTRIC:
            f = thin_film_reflectance(cosine, inner, np.repeat(self.ior[:, None], 3, 1), self.thickness)
            bottom = f0_of_ior(self.ior)[:, None]
            near = np.clip((1.0 - f) / (1.0 - bottom), 0.0, 1.0)
            whole = (f == 1.0).all(1, keepdims=True) | (bottom <= 1e-5)
            f = np.where(whole, f, f * (1.0 + near * (self.f0 / np.maximum(bottom, 1e-12) - 1.0)))
            if not self.transmits:
                return f, np.zeros_like(f)
            open_ = (dielectric(cosine, self.ior)[1] > 0.0)[:, None]
            return f * self.reflection, (1.0 - f) * self.transmission * open_
        if self.term == F82:
            at_82 = f82(np.full(len(cosine), 1.0 / 7.0), self.f0, self.tint)
            f = thin_film_reflectance(cosine, inner, gulbrandsen(self.f0, at_82), self.thickness, at_82)
        else:
            f = thin_film_reflectance(cosine, inner, self.n + 1j * self.k, self.thickness)
        return f, np.zeros_like(f)


def _smooth(thickness):
    t = np.clip(thickness, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def conductor(cosine, outside, index):
    """Reflected amplitudes (s, p) of a medium of complex ``index`` below one of index ``outside``."""
    bent = np.sqrt(index**2 - outside**2 * (1.0 - cosine**2) + 0j)  # index · cosine of the refracted ray
    return (
        (outside * cosine - bent) / (outside * cosine + bent),
        (index**2 * cosine - outside * bent) / (index**2 * cosine + outside * bent),
    )


def conductor_reflectance(cosine, n, k):
    """Unpolarised reflectance of a conductor of index n + ik in air."""
    s, p = conductor(cosine, 1.0, n + 1j * k)
    return 0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2)


def gulbrandsen(r, g):
    """Complex index of a metal of reflectance r, with the colour g of its edge: Gulbrandsen 2014."""
    r = np.minimum(r, 0.999)
    n = g * (1.0 - r) / (1.0 + r) + (1.0 - g) * (1.0 + np.sqrt(r)) / (1.0 - np.sqrt(r))
    return n + 1j * np.sqrt(np.maximum((r * (n + 1.0) ** 2 - (n - 1.0) ** 2) / (1.0 - r), 0.0))


def thin_film_reflectance(cosine, inner, index, thickness, at_82=None):
    """Reflectance (N, 3) of media of ``index`` (N, 3) below a film of index ``inner`` (N,), by wavelengths.

    Belcour and Barla 2017, equation 10, up to the third order. ``at_82``: reflectances at 82° of metals of F82-Tint.
    """
    sine2 = (1.0 - cosine**2) / inner**2
    whole = sine2 >= 1.0
    below = np.sqrt(np.maximum(1.0 - sine2, 1e-12))[:, None]
    # Amplitudes at the top, seen from above.
    top = conductor(cosine[:, None], 1.0, inner[:, None])
    bottom = conductor(below, inner[:, None], index)
    delta = 2.0 * inner[:, None] * np.asarray(thickness)[:, None] * below  # (N, 1)
    weights = cie.RGB_OF_XYZ @ cie.MATCHING.T
    weights /= weights.sum(1, keepdims=True)
    total = np.zeros((len(cosine), 3))
    for a, b in zip(top, bottom):
        r12, r23 = np.abs(a) ** 2, np.abs(b) ** 2
        if at_82 is not None:
            n, k = index.real, index.imag
            f0 = ((n - inner[:, None]) ** 2 + k**2) / ((n + inner[:, None]) ** 2 + k**2)
            edge = (f0 + (1.0 - f0) * (6 / 7) ** 5 - at_82) / (1 / 7 * (6 / 7) ** 6)
            r23 = np.clip(f0 + (1.0 - f0) * (1.0 - below) ** 5 - edge * below * (1.0 - below) ** 6, 0.0, 1.0)
        inside = (1.0 - r12) ** 2 * r23 / np.maximum(1.0 - r12 * r23, 1e-9)
        sum_ = r12 + inside
        phase = np.angle(b) + np.angle(-a.conj())  # of the bottom, and of the top from below
        for order in (1, 2, 3):
            size = 2.0 * (inside - (1.0 - r12)) * np.sqrt(r12 * r23) ** order
            waves = np.exp(2j * np.pi * order * delta / cie.wavelengths()) @ weights.T
            sum_ = sum_ + size * (np.exp(1j * order * phase) * waves).real
        total += 0.5 * np.broadcast_to(sum_, total.shape)
    lost = np.iscomplexobj(index)
    tir = whole if lost else whole | (np.abs(index[:, 0]) ** 2 <= 1.0 - cosine**2)
    return np.where(tir[:, None], 1.0, np.clip(total, 0.0, 1.0))
