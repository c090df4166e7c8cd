# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobes of Ashikhmin's papers and thin panes over arrays of points. See ``closures.py``."""

from __future__ import annotations

import numpy as np

from ..scene import Ray
from .closures import Lobe, Microfacet, grey
from .special import frame_about
from .vectors import dot, normalize, reflect, uniform_cone


class AshikhminShirley(Lobe):
    """Ashikhmin and Shirley 2000, without their Fresnel term, of roughness ``alpha`` along ``tangent`` and ``across``
    it (N,).

    As in Cycles, the lobe is divided by the larger of both cosines.
    """

    glossy = True
    widths = ("alpha", "across")

    def kind(self, wi):
        return np.full(len(wi), int(Ray.GLOSSY))

    @property
    def singular(self):
        """Where (N,) it is a perfect mirror."""
        return np.maximum(self.alpha, self.across) <= 1e-4

    def _exponents(self):
        return tuple(2.0 / np.maximum(a, 1e-4) ** 2 - 2.0 for a in (self.alpha, self.across))

    def evaluate(self, wo, wi):
        n, (x, y) = self.normal, self._exponents()
        co, ci = dot(n, wo), dot(n, wi)
        h = normalize(wo + wi)
        t, b = frame_about(n, self.tangent)
        hn, ho = np.maximum(dot(h, n), 1e-6), np.maximum(np.abs(dot(h, wo)), 1e-6)
        p, q = dot(t, h) ** 2, dot(b, h) ** 2
        power = np.where(p + q > 0.0, (x * p + y * q) / np.where(p + q > 0.0, p + q, 1.0), x)
        pdf = np.sqrt((x + 1.0) * (y + 1.0)) * hn**power / (8.0 * np.pi * ho)
        pdf = np.where((co > 0.0) & (ci > 0.0) & ~self.singular, pdf, 0.0)
        return grey(pdf * ci / np.maximum(np.maximum(co, ci), 1e-6)), pdf

    def sample(self, rng, wo):
        count, n, (x, y) = len(wo), self.normal, self._exponents()
        # A normal vector of variances 1 / (x + 1), 1 / (y + 1) has the azimuth of the paper's half vectors.
        azimuth = np.arctan2(
            rng.standard_normal(count) / np.sqrt(y + 1.0), rng.standard_normal(count) / np.sqrt(x + 1.0)
        )
        c, s = np.cos(azimuth), np.sin(azimuth)
        height = rng.random(count) ** (1.0 / (x * c * c + y * s * s + 1.0))
        radius = np.sqrt(np.maximum(1.0 - height**2, 0.0))
        t, b = frame_about(n, self.tangent)
        h = (radius * c)[:, None] * t + (radius * s)[:, None] * b + height[:, None] * n
        h = np.where(self.singular[:, None], n, h)
        return reflect(wo, h), np.ones((count, 3)), np.where(dot(n, wo) > 0.0, 1.0, 0.0), self.singular


class Velvet(Lobe):
    """Ashikhmin's distribution of inverted Gaussians, of width ``sigma`` (N,), with the masking of Torrance and
    Sparrow."""

    counts_as_diffuse = False  # in passes, as in Cycles
    diffuse = True

    def evaluate(self, wo, wi):
        n = self.normal
        co, ci = dot(n, wo), dot(n, wi)
        h = normalize(wo + wi)
        hn, ho = dot(n, h), np.abs(dot(wo, h))
        usable = (co > 1e-5) & (ci > 0.0) & (hn < 1.0 - 1e-5) & (ho > 1e-5)
        sine2 = np.where(usable, 1.0 - hn**2, 1.0)
        a = 1.0 / self.sigma**2
        density = np.exp(-a * hn**2 / sine2) * a / (np.pi * sine2**2)
        ratio = np.maximum(hn / np.where(usable, ho, 1.0), 1e-5)
        masking = np.minimum(1.0, 2.0 * ratio * np.minimum(co, ci))
        value = np.where(usable, 0.25 * density * masking / np.where(usable, co, 1.0), 0.0)
        return grey(value), np.where(usable, 0.5 / np.pi, 0.0)

    def direction(self, rng, wo):
        return uniform_cone(rng, self.normal, np.ones(len(wo)))


class Pane(Microfacet):
    """Transmission of a thin pane: its reflection, on the other side. Its normal is that of the surface."""

    def _mirrored(self, w):
        return w - 2.0 * dot(self.normal, w)[:, None] * self.normal

    def kind(self, wi):
        return np.full(len(wi), int(Ray.TRANSMISSION))

    def evaluate(self, wo, wi):
        return super().evaluate(wo, self._mirrored(wi))

    def sample(self, rng, wo):
        wi, value, probability, singular = super().sample(rng, wo)
        return self._mirrored(wi), value, probability, singular
