# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scattering lobes over arrays of points: evaluate, sample and pdf.

A lobe holds its ``weight`` (N, 3), ``normal`` (N, 3) and parameters of N points. ``evaluate(wo, wi)`` returns (f ·
|cos| (N, 3) without the weight, pdf (N,)), zero where the lobe is a Dirac delta. ``sample(rng, wo)`` returns (wi,
weight of the path (N, 3) where singular, probability (N,) of that, singular (N,) bool).
"""

from __future__ import annotations

import numpy as np

from ..scene import Ray
from .geometry import Surface
from .vectors import cosine_hemisphere, dot, frame, normalize, reflect

SINGULAR_ALPHA2 = 2e-10  # a smoother GGX is a perfect mirror, as in Cycles


def grey(values: np.ndarray) -> np.ndarray:
    """Values (N,) as RGB (N, 3)."""
    return np.repeat(values[:, None], 3, 1)


class Lobe:
    """``albedo`` (N, 3) is an estimate of the lobe's total scattering, with its weight."""

    diffuse = False  # darkens gradually if its normal is not the surface's
    widths: tuple[str, ...] = ()  # parameters that Filter Glossy raises
    counts_as_diffuse: bool | None = None  # in passes; None: as ``diffuse``

    def __init__(self, weight: np.ndarray, normal: np.ndarray, albedo: np.ndarray | None = None, **parameters):
        self.weight, self.normal = weight, normal
        self.albedo = weight if albedo is None else albedo
        vars(self).update(parameters)

    def select(self, rows: np.ndarray) -> "Lobe":
        """The lobe of some points, given as indices (n,) or as a mask (N,)."""
        return type(self)(
            **{name: value[rows] if isinstance(value, np.ndarray) else value for name, value in vars(self).items()}
        )

    def kind(self, wi: np.ndarray) -> np.ndarray:
        """Kind (N,) of the continuing ray along wi (N, 3); 0: the same ray goes straight through."""
        return np.full(len(wi), int(Ray.DIFFUSE))

    def evaluate(self, wo: np.ndarray, wi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """f · |cos| (N, 3) without the weight, and pdf (N,), for wo and wi (N, 3)."""
        raise NotImplementedError

    def direction(self, rng: np.random.Generator, wo: np.ndarray) -> np.ndarray:
        """Directions wi (N, 3) by the pdf of ``evaluate``."""
        return cosine_hemisphere(rng, self.normal)

    def sample(self, rng: np.random.Generator, wo: np.ndarray):
        """wi (N, 3), weights where singular (N, 3), probability (N,) that there is a direction, singular (N,)."""
        count = len(wo)
        return self.direction(rng, wo), np.zeros((count, 3)), np.ones(count), np.zeros(count, bool)


class Diffuse(Lobe):
    """Lambert."""

    diffuse = True

    def evaluate(self, wo, wi):
        pdf = np.maximum(dot(self.normal, wi), 0.0) / np.pi
        return grey(pdf), pdf


class Translucent(Lobe):
    """Lambert to the far side."""

    diffuse = True

    def kind(self, wi):
        return np.full(len(wi), int(Ray.TRANSMISSION))

    def evaluate(self, wo, wi):
        pdf = np.maximum(-dot(self.normal, wi), 0.0) / np.pi
        return grey(pdf), pdf

    def direction(self, rng, wo):
        return cosine_hemisphere(rng, -self.normal)


class OrenNayar(Lobe):
    """Fujii's improved Oren–Nayar with multiple scattering as in OpenPBR 1.1; ``color``, ``roughness``.

    The weight contains the colour once; multiple scattering adds its higher powers.
    """

    diffuse = True

    @staticmethod
    def _g(cosine):
        # Below this angle tan θ overflows; the limit of G there is a straight line.
        c = np.clip(cosine, 1e-6, 1.0)
        s = np.sqrt(1.0 - c * c)
        g = s * (np.arccos(c) - 2 / 3 - s * c) + 2 / 3 * s / c * (1.0 - s**3)
        return np.where(cosine < 1e-6, np.pi / 2 - 2 / 3 - cosine, g)

    def evaluate(self, wo, wi):
        sigma = np.clip(self.roughness, 0.0, 1.0)
        a = 1.0 / (np.pi + (np.pi / 2 - 2 / 3) * sigma)
        b = sigma * a
        ci, co = np.maximum(dot(self.normal, wi), 0.0), np.maximum(dot(self.normal, wo), 0.0)
        s = dot(wi, wo) - ci * co
        t = np.where(s > 0.0, s / np.maximum(np.maximum(ci, co), 1e-12), s)
        mean = np.pi * a + (2 * np.pi - 5.6) / 3 * b
        lost_o, lost_i = (1.0 - (np.pi * a + b * self._g(c)) for c in (co, ci))
        rho = np.clip(self.color, 0.0, 1.0)
        many = rho / np.pi * (mean / (1 - mean) * lost_o * lost_i)[:, None] / (1 - rho * (1 - mean)[:, None])
        return ci[:, None] * ((a + b * t)[:, None] + many), ci / np.pi


class Sheen(Lobe):
    """Sheen of Zeltner et al. 2022, a linearly transformed cosine whose inverse has coefficients ``a`` and ``b``."""

    diffuse = True

    def _frame(self, wo):
        n = self.normal
        t = wo - dot(n, wo)[:, None] * n
        degenerate = dot(t, t) < 1e-12
        t = np.where(degenerate[:, None], frame(n)[0], normalize(t))
        return t, np.cross(n, t)

    def evaluate(self, wo, wi):
        t, b = self._frame(wo)
        z = np.maximum(dot(self.normal, wi), 0.0)
        square = (self.a * dot(t, wi) + self.b * z) ** 2 + (self.a * dot(b, wi)) ** 2 + z * z
        pdf = z / np.pi * (self.a / np.maximum(square, 1e-300)) ** 2
        return grey(pdf), pdf

    def direction(self, rng, wo):
        t, b = self._frame(wo)
        cosine = cosine_hemisphere(rng, np.broadcast_to([0.0, 0.0, 1.0], wo.shape))
        # cosine_hemisphere may rotate its frame about z: any rotation of a cosine lobe is the same lobe.
        local = normalize(np.stack([cosine[:, 0] - cosine[:, 2] * self.b, cosine[:, 1], cosine[:, 2] * self.a], -1))
        return local[:, :1] * t + local[:, 1:2] * b + local[:, 2:] * self.normal


class Straight(Lobe):
    """Transparency: nothing is scattered."""

    def kind(self, wi):
        return np.zeros(len(wi), int)

    def evaluate(self, wo, wi):
        return np.zeros(wo.shape), np.zeros(len(wo))

    def sample(self, rng, wo):
        count = len(wo)
        return -wo, np.ones((count, 3)), np.ones(count), np.ones(count, bool)


def dielectric(cosine: np.ndarray, ior: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unpolarised reflectance (N,), and cosine (N,) of the refracted ray (0 if there is none); ior of far over near
    side."""
    c = np.clip(np.abs(cosine), 0.0, 1.0)
    ct2 = 1.0 - (1.0 - c * c) / ior**2
    ct = np.sqrt(np.maximum(ct2, 0.0))
    s, p = (c - ior * ct) / (c + ior * ct), (ior * c - ct) / (ior * c + ct)
    return np.where(ct2 > 0.0, 0.5 * (s * s + p * p), 1.0), ct


def f0_of_ior(ior):
    """Reflectance at normal incidence."""
    return ((ior - 1.0) / (ior + 1.0)) ** 2


def remapped_dielectric(cosine, ior, f0):
    """Reflectance (N, 3) with the shape of a dielectric's curve, from ``f0`` (N, 3) to 1."""
    real, bottom = dielectric(cosine, ior)[0], f0_of_ior(ior)
    return f0 + (1.0 - f0) * np.clip((real - bottom) / (1.0 - bottom), 0.0, 1.0)[:, None]


def f82(cosine, f0, tint):
    """F82-Tint of Kutz, Hasan and Edmondson 2021: Schlick's curve, ``tint`` times it at the cosine 1/7."""
    c = np.clip(np.abs(cosine), 0.0, 1.0)[:, None]
    edge = (f0 + (1 - f0) * (6 / 7) ** 5) * (1 - tint) / (1 / 7 * (6 / 7) ** 6)
    return np.clip(f0 + (1 - f0) * (1 - c) ** 5 - edge * c * (1 - c) ** 6, 0.0, 1.0)


NONE, DIELECTRIC, F82 = "none", "dielectric", "f82"


def masking(alpha2: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Smith's Λ (N,) of GGX, for α² (N,) and cosines (N,)."""
    c2 = np.maximum(cosine * cosine, 1e-300)
    return 0.5 * (np.sqrt(1.0 + alpha2 * np.maximum(1.0 / c2 - 1.0, 0.0)) - 1.0)


class Microfacet(Lobe):
    """GGX of roughness ``alpha`` (N,), with the height-correlated masking of Heitz 2014.

    ``ior`` (N,) is that of the far side over that of the side of wo. ``term`` is the Fresnel term. DIELECTRIC goes from
    ``f0`` (N, 3) to 1 like the real curve, and tints reflection and transmission. F82 has ``f0`` and ``tint``. NONE
    reflects all, or refracts all where it ``transmits``. Visible normals are drawn as in Dupuy and Benyoub 2023.
    """

    widths = ("alpha",)

    def kind(self, wi):
        return np.where(dot(self.normal, wi) < 0.0, int(Ray.TRANSMISSION), int(Ray.GLOSSY))

    @property
    def singular(self):
        """Where (N,) it is a perfect mirror."""
        return self.alpha**2 <= SINGULAR_ALPHA2

    def fresnel(self, cosine: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reflectance and transmittance of a microfacet, both (N, 3)."""
        nothing, all_ = np.zeros((len(cosine), 3)), np.ones((len(cosine), 3))
        if self.term == F82:
            return f82(cosine, self.f0, self.tint), nothing
        if self.term == NONE and not self.transmits:
            return all_, nothing
        open_ = (dielectric(cosine, self.ior)[1] > 0.0)[:, None]
        if self.term == NONE:
            return nothing, all_ * open_
        r = remapped_dielectric(cosine, self.ior, self.f0)
        if not self.transmits:
            return r, nothing
        return r * self.reflection, (1.0 - r) * self.transmission * open_

    def evaluate(self, wo, wi):
        """Walter et al. 2007, equations 20 and 21; for refraction also where no microfacet is, as in Cycles."""
        n = self.normal
        co, ci = dot(n, wo), dot(n, wi)
        through = ci < 0.0
        h = wo + wi * np.where(through, self.ior, 1.0)[:, None]
        square = dot(h, h)
        usable = (co > 0.0) & (ci != 0.0) & (square > 1e-16) & ~self.singular
        h = h / np.sqrt(np.where(usable, square, 1.0))[:, None]
        ho, hi, hn = dot(h, wo), dot(h, wi), dot(h, n)
        r, t = self.fresnel(np.abs(ho))
        total = (r + t).mean(1)
        usable &= total > 0.0
        with np.errstate(all="ignore"):  # of rows that are not usable
            density, lo, li = self.density(h), self.masking(wo), self.masking(wi)
        jacobian = np.where(through, self.ior**2 * np.abs(ho * hi) / np.where(usable, square, 1.0), 0.25)
        common = np.where(usable, density * jacobian / np.where(usable, co, 1.0), 0.0)
        lo, li, hn = (np.where(usable, x, 0.0) for x in (lo, li, np.abs(hn)))
        value = np.where(through[:, None], t, r)
        share = value.mean(1) / np.where(usable, total, 1.0)
        return value * (common / (1.0 + lo + li))[:, None], common * share * self.visible(co, hn, lo)

    def density(self, h):
        """Distribution of normals D (N,)."""
        return self.alpha**2 / (np.pi * (1.0 + np.minimum(dot(h, self.normal) ** 2, 1.0) * (self.alpha**2 - 1.0)) ** 2)

    def masking(self, w):
        """Smith's Λ (N,)."""
        return masking(self.alpha**2, dot(w, self.normal))

    def visible(self, co, hn, lo):
        """Factor by which the density of ``_normals`` exceeds D · |wo · h| / (wo · n)."""
        return 1.0 / (1.0 + lo)

    def _normals(self, rng, wo):
        """Microfacet normals as visible from wo."""
        t, b = frame(self.normal)
        local = np.stack([dot(t, wo), dot(b, wo), dot(self.normal, wo)], -1)
        stretch = np.stack([self.alpha, self.alpha, np.ones_like(self.alpha)], -1)
        view = normalize(local * stretch)
        z = (1.0 - rng.random(len(wo))) * (1.0 + view[:, 2]) - view[:, 2]
        phi = 2.0 * np.pi * rng.random(len(wo))
        s = np.sqrt(np.clip(1.0 - z * z, 0.0, 1.0))
        h = normalize((np.stack([s * np.cos(phi), s * np.sin(phi), z], -1) + view) * stretch)
        return h[:, :1] * t + h[:, 1:2] * b + h[:, 2:] * self.normal

    def sample(self, rng, wo):
        singular = self.singular
        h = np.where(singular[:, None], self.normal, self._normals(rng, wo))
        ho = dot(h, wo)
        r, t = self.fresnel(ho)
        total = (r + t).mean(1)
        share = r.mean(1) / np.where(total > 0.0, total, 1.0)
        through = rng.random(len(wo)) >= share
        cosine_t = dielectric(ho, self.ior)[1]
        refracted = ((ho / self.ior - cosine_t)[:, None] * h) - wo / self.ior[:, None]
        wi = np.where(through[:, None], refracted, reflect(wo, h))
        # Equal indices do not bend light: a delta for any roughness.
        singular = singular | (through & (self.ior == 1.0))
        valid = (dot(self.normal, wo) > 0.0) & ((dot(self.normal, wi) < 0.0) == through) & (total > 0.0)
        probability = np.where(valid, np.where(through, 1.0 - share, share), 0.0)
        return wi, np.where(through[:, None], t, r), probability, singular


def specular_normal(surface: Surface, normal: np.ndarray) -> np.ndarray:
    """``normal`` (N, 3) turned towards the geometric one just so far that the mirror direction of wo leaves the
    surface; of a curve, or where bumps stay uncorrected, as it is, as in Cycles.

    By bisection of the way between the two normals.
    """
    height = dot(surface.ng, surface.wo)
    least = np.minimum(0.9 * height, 0.01)
    free = (surface.strand != 0) | surface.uncorrected
    rows = np.flatnonzero((dot(reflect(surface.wo, normal), surface.ng) < least) & ~free)
    if not len(rows):
        return normal
    n, g, wo = normal[rows], surface.ng[rows], surface.wo[rows]
    low, high = np.zeros(len(rows)), np.ones(len(rows))
    for _ in range(50):
        middle = 0.5 * (low + high)
        trial = normalize(n + middle[:, None] * (g - n))
        good = dot(reflect(wo, trial), g) >= least[rows]
        low, high = np.where(good, low, middle), np.where(good, middle, high)
    result = normal.copy()
    result[rows] = normalize(n + high[:, None] * (g - n))
    return result
