# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobes of hair over arrays of points. See ``closures.py``."""

from __future__ import annotations

import numpy as np

from ..scene import Ray
from .closures import Lobe, dielectric, masking
from .vectors import dot, frame, luminance, normalize

TWO_PI = 2.0 * np.pi
EUMELANIN, PHEOMELANIN = np.array([0.506, 0.841, 1.653]), np.array([0.343, 0.733, 1.924])
FIT = 0.245, 5.574, -10.73, 2.532, -0.215, 5.969


def absorption_of(color: np.ndarray, roughness: np.ndarray) -> np.ndarray:
    """Absorption of a fiber with the albedo ``color`` (N, 3): Chiang et al. 2016, equation 9."""
    return (np.log(np.maximum(color, 1e-30)) / np.polyval(FIT, roughness)[:, None]) ** 2


class Fiber(Lobe):
    """Base of all models of hair: ``tangent`` (N, 3), and the geometric normal ``facing`` (N, 3) of the surface.
    ``strand`` (N,) bool: on a curve, not on a mesh.

    Their samples continue in any direction; light rays do not see all of it.
    """

    glossy = True

    def kind(self, wi):
        through = np.where(self.strand, self.is_transmission(), dot(self.facing, wi) < 0.0)
        return np.where(through, int(Ray.TRANSMISSION), int(Ray.GLOSSY))

    def is_transmission(self):
        """Whether the directions that were drawn on a curve count as transmission."""
        raise NotImplementedError

    def cut(self, wo, wi):
        """Whether light rays from wi have no effect, as in Cycles on a mesh."""
        raise NotImplementedError

    def whole(self, wo, wi):
        """f · |cos| and pdf without that."""
        raise NotImplementedError

    def evaluate(self, wo, wi):
        value, pdf = self.whole(wo, wi)
        return np.where(self.cut(wo, wi)[:, None], 0.0, value), pdf


class Hair(Fiber):
    """Marschner's lobe of reflection, or of transmission where it ``transmits``: Cauchy distributions of widths
    ``along`` and ``around`` (N,), tilted by ``tilt`` (N,)."""

    def is_transmission(self):
        return self.transmits

    def _seen(self, w):
        sine = np.clip(dot(self.tangent, w), -1.0, 1.0)
        return np.arcsin(sine), normalize(w - sine[:, None] * self.tangent)

    def _ends(self, theta_o):
        return (
            np.arctan(((0.5 * np.pi + theta_o) / 2 - self.tilt) / self.along),
            np.arctan(((theta_o - 0.5 * np.pi) / 2 - self.tilt) / self.along),
        )

    def cut(self, wo, wi):
        other = (dot(self.normal, wi) < 0.0) != self.transmits
        return other if self.transmits else other | (dot(self._seen(wo)[1], self._seen(wi)[1]) < 0.0)

    def whole(self, wo, wi):
        (theta_o, across_o), (theta_i, across_i) = self._seen(wo), self._seen(wi)
        first, last = self._ends(theta_o)
        t = 0.5 * (theta_o + theta_i) - self.tilt
        pdf = self.along / (2.0 * (t * t + self.along**2) * (first - last) * np.cos(theta_i))
        phi = np.arccos(np.clip(dot(across_o, across_i), -1.0, 1.0))
        if self.transmits:
            pdf = (
                pdf * self.around / (2.0 * np.arctan(0.5 * np.pi / self.around) * ((np.pi - phi) ** 2 + self.around**2))
            )
        else:
            pdf = np.where(
                phi <= np.pi * self.around,
                pdf * np.cos(0.5 * phi / self.around) / (4.0 * self.around),
                0.0,
            )
        pdf = np.where(np.abs(theta_i) <= 0.5 * np.pi - 0.001, pdf, 0.0)
        return np.repeat(pdf[:, None], 3, 1), pdf

    def direction(self, rng, wo):
        theta_o, y = self._seen(wo)
        first, last = self._ends(theta_o)
        theta = 2.0 * (self.along * np.tan(last + rng.random(len(wo)) * (first - last)) + self.tilt) - theta_o
        u = rng.random(len(wo))
        if self.transmits:
            phi = np.pi + self.around * np.tan(2.0 * np.arctan(0.5 * np.pi / self.around) * (u - 0.5))
        else:
            phi = 2.0 * np.arcsin(1.0 - 2.0 * u) * self.around
        x = np.cross(self.tangent, y)
        c = np.cos(theta)
        return (c * np.cos(phi))[:, None] * y + (c * np.sin(phi))[:, None] * x + np.sin(theta)[:, None] * self.tangent


class Round(Fiber):
    """Base of both models of Principled Hair:
    ``sigma`` (N, 3), ``ior``, ``tilt`` (N,), and the shading normal ``smooth`` (N, 3) of the surface. ``cuts`` (N,)
    bool: on a mesh, light rays do not see all directions."""

    def axes(self, wo):
        """Unit vectors across the view, and towards the viewer, both perpendicular to the fiber."""
        x = np.cross(self.tangent, wo)
        size = np.linalg.norm(x, axis=1, keepdims=True)
        x = np.where(size > 1e-12, x / np.where(size > 1e-12, size, 1.0), frame(self.tangent)[0])
        return x, np.cross(x, self.tangent)

    def seen(self, wo, wi):
        """Sine of the inclination of wi, and its angle about the fiber from wo."""
        x, z = self.axes(wo)
        return np.clip(dot(self.tangent, wi), -1.0, 1.0), np.arctan2(dot(x, wi), dot(z, wi))

    def direction_of(self, wo, sine, phi):
        """Directions (N, 3) of an inclination and an azimuth about the fiber."""
        x, z = self.axes(wo)
        c = np.sqrt(np.maximum(1.0 - sine * sine, 0.0))
        return sine[:, None] * self.tangent + (c * np.sin(phi))[:, None] * x + (c * np.cos(phi))[:, None] * z

    def cut(self, wo, wi):
        n = self.axes(wo)[0]
        return self.cuts & (dot(self.smooth, wi) * dot(self.smooth, n) * dot(n, wi) < 0.0)


def cosine_of(sine):
    """The cosine, not negative, of angles with these sines."""
    return np.sqrt(np.maximum(1.0 - sine * sine, 0.0))


def _scaled_bessel(x):
    """exp(−x) I₀(x), by its asymptotic series (Abramowitz and Stegun 9.7.1) where x is large."""
    large = np.maximum(x, 100.0)
    series = (1.0 + 1.0 / (8.0 * large) + 9.0 / (128.0 * large**2) + 225.0 / (3072.0 * large**3)) / np.sqrt(
        TWO_PI * large
    )
    small = np.minimum(x, 100.0)
    return np.where(x < 100.0, np.i0(small) * np.exp(-small), series)


def along(sine_i, sine_o, v):
    """d'Eon et al. 2011: density of inclinations."""
    x = cosine_of(sine_i) * cosine_of(sine_o) / v
    return _scaled_bessel(x) * np.exp(x - sine_i * sine_o / v - 1.0 / v) / (v * (1.0 - np.exp(-2.0 / v)))


def draw_along(rng, sine_o, v):
    """Sines of inclinations."""
    u = np.maximum(rng.random(len(v)), 1e-5)
    c = 1.0 + v * np.log(u + (1.0 - u) * np.exp(-2.0 / v))
    return np.clip(-c * sine_o + cosine_of(c) * np.cos(TWO_PI * rng.random(len(v))) * cosine_of(sine_o), -1.0, 1.0)


def logistic(x, s):
    """Logistic distribution of width s, truncated at ±π."""
    x = (x + np.pi) % TWO_PI - np.pi
    return 1.0 / (4.0 * s * np.cosh(0.5 * x / s) ** 2) / np.tanh(0.5 * np.pi / s)


def draw_logistic(rng, s):
    """Angles in −π … π by the density of ``logistic``."""
    edge = 1.0 / (1.0 + np.exp(np.minimum(np.pi / s, 700.0)))
    u = edge + (1.0 - 2.0 * edge) * rng.random(len(s))
    return np.clip(s * np.log(u / (1.0 - u)), -np.pi, np.pi)


class Chiang(Round):
    """Chiang et al. 2016. ``offset`` (N,) is that of the ray from the middle of the fiber; ``v``, ``v0`` (N,) variances
    along it and of R, ``s`` (N,) the width about it."""

    widths = ("v", "v0", "s")

    def is_transmission(self):
        return self._order > 0

    def orders(self, wo):
        """Fractions that R, TT, TRT and all later orders keep, (4, N, 3); the turns of the first three (3, N); the sine
        of wo."""
        sine = np.clip(dot(self.tangent, wo), -1.0, 1.0)
        c = cosine_of(sine)
        inside = np.arcsin(np.clip(self.offset * c / np.sqrt(self.ior**2 - sine**2), -1.0, 1.0))
        path = 2.0 * np.cos(inside) / cosine_of(sine / self.ior)
        t = np.exp(-self.sigma * path[:, None])
        f = dielectric(c * cosine_of(self.offset), self.ior)[0][:, None]
        a = [np.broadcast_to(f, t.shape), (1.0 - f) ** 2 * t, (1.0 - f) ** 2 * t * t * f]
        a.append(a[2] * t * f / np.maximum(1.0 - t * f, 1e-9))
        turns = [2.0 * p * inside - 2.0 * np.arcsin(self.offset) + p * np.pi for p in range(3)]
        return np.array(a), np.array(turns), sine

    def _lobes(self, sine):
        angle = np.arcsin(sine)
        centres = [np.sin(angle - 2.0 * self.tilt), np.sin(angle + self.tilt), np.sin(angle + 4.0 * self.tilt), sine]
        return list(zip(centres, (self.v0, 0.25 * self.v, 4.0 * self.v, 4.0 * self.v)))

    def whole(self, wo, wi):
        keeps, turns, sine_o = self.orders(wo)
        sine_i, phi = self.seen(wo, wi)
        value = np.zeros(wo.shape)
        for p, (centre, v) in enumerate(self._lobes(sine_o)):
            about = logistic(phi - turns[p], self.s) if p < 3 else 1.0 / TWO_PI
            value += keeps[p] * (along(sine_i, centre, v) * about)[:, None]
        return value, luminance(value) / np.maximum(luminance(keeps.sum(0)), 1e-30)

    def direction(self, rng, wo):
        keeps, turns, sine_o = self.orders(wo)
        share = np.cumsum([luminance(keep) for keep in keeps], 0)
        choice = np.minimum((share <= rng.random(len(wo)) * share[-1]).sum(0), 3)
        self._order = choice
        sine, phi = np.zeros(len(wo)), TWO_PI * rng.random(len(wo))
        for p, (centre, v) in enumerate(self._lobes(sine_o)):
            drawn = draw_along(rng, centre, v)
            sine = np.where(choice == p, drawn, sine)
            if p < 3:
                phi = np.where(choice == p, turns[p] + draw_logistic(rng, self.s), phi)
        return self.direction_of(wo, sine, phi)


class Huang(Round):
    """Huang, Hullin and Hanika 2022, by following a ray through the fiber: roughness ``alpha``, ``aspect`` (N,),
    ``factors`` (N, 3) of R, TT and TRT. Light rays do not see it: samples count as singular. ``glass(name, roughness,
    cosine, ior)`` is the albedo of rough glass from "glass" outside or "glass_inside"."""

    widths = ("alpha",)

    def is_transmission(self):
        return False

    def evaluate(self, wo, wi):
        return np.zeros(wo.shape), np.zeros(len(wo))

    def sample(self, rng, wo):
        count = len(wo)
        x, z = self.axes(wo)
        local = np.stack([np.zeros(count), dot(self.tangent, wo), dot(z, wo)], -1)
        wi, value = self.trace(rng, local)
        keep = value.mean(1)
        wi = wi[:, :1] * x + wi[:, 1:2] * self.tangent + wi[:, 2:] * z
        return wi, value, np.where(keep > 0.0, 1.0, 0.0), np.ones(count, bool)

    def _normal(self, tilt, gamma):
        s, c = self.aspect * np.sin(gamma), np.cos(gamma)
        return np.stack(
            [s / np.hypot(s, c) * np.cos(tilt), np.sin(tilt) + 0.0 * gamma, c / np.hypot(s, c) * np.cos(tilt)], -1
        )

    def _facet(self, rng, w, m):
        t, b = frame(m)
        stretch = np.stack([self.alpha, self.alpha, np.ones_like(self.alpha)], -1)
        view = normalize(np.stack([dot(t, w), dot(b, w), dot(m, w)], -1) * stretch)
        height = (1.0 - rng.random(len(w))) * (1.0 + view[:, 2]) - view[:, 2]
        phi, s = TWO_PI * rng.random(len(w)), np.sqrt(np.clip(1.0 - height**2, 0.0, 1.0))
        h = normalize((np.stack([s * np.cos(phi), s * np.sin(phi), height], -1) + view) * stretch)
        return h[:, :1] * t + h[:, 1:2] * b + h[:, 2:] * m

    def _shadowed(self, cosine_o, cosine_i):
        lost = masking(self.alpha**2, cosine_o)
        return (1.0 + lost) / (1.0 + lost + masking(self.alpha**2, cosine_i))

    def _on_ellipse(self, w):
        return np.arctan2(self.aspect * w[:, 0], w[:, 2])

    def _kept(self, first, second, w):
        x, z = np.sin(first) - np.sin(second), self.aspect * (np.cos(first) - np.cos(second))
        return np.exp(-self.sigma * (np.hypot(x, z) / np.hypot(w[:, 0], w[:, 2]))[:, None])

    def _refracted(self, w, h, ior):
        cosine = dot(w, h)
        r, cosine_t = dielectric(cosine, ior)
        return r, (cosine / ior - cosine_t)[:, None] * h - w / ior[:, None]

    def trace(self, rng, wo):
        """wi and the light scattered there (N, 3), in the frame (across the view, along the fiber, towards the
        viewer)."""
        count, tilt, ior = len(wo), self.tilt, self.ior
        roughness, back_ior = np.sqrt(self.alpha), 1.0 / self.ior
        seen = lambda w, m, h: (dot(w, h) > 0.0) & (dot(w, m) > 0.0)
        gamma = -np.arcsin(2.0 * rng.random(count) - 1.0)
        m, plain = self._normal(tilt, gamma), self._normal(0.0 * tilt, gamma)
        h = self._facet(rng, wo, m)
        cosine = dot(wo, m)
        lit = (cosine > 0.0) & seen(wo, plain, h)
        r, inside = self._refracted(wo, h, ior)
        mirrored = 2.0 * dot(wo, h)[:, None] * h - wo
        gain = 1.0 / self.glass("glass", roughness, cosine, ior)
        share_r = (
            self.factors[:, 0] * r * gain * self._shadowed(cosine, dot(m, mirrored)) * (lit & seen(mirrored, plain, h))
        )
        # Across the fiber.
        back = -inside
        second = 2.0 * self._on_ellipse(inside) - gamma
        n, plain2 = self._normal(-tilt, second), self._normal(0.0 * tilt, second)
        h2 = self._facet(rng, back, n)
        cosine2 = dot(back, n)
        entered = lit & (cosine2 > 0.0) & seen(back, plain, h) & seen(back, plain2, h2)
        kept = self._kept(gamma, second + np.pi, inside)
        t = (
            (1.0 - r)
            * gain
            * self._shadowed(cosine, dot(m, back))
            / self.glass("glass_inside", roughness, cosine2, back_ior)
        )
        r2, out = self._refracted(back, h2, back_ior)
        leaves = entered & (r2 < 1.0) & (dot(n, -out) > 0.0) & seen(-out, plain2, h2)
        share_tt = self.factors[:, 1] * t * (1.0 - r2) * self._shadowed(cosine2, dot(n, -out)) * leaves
        # Reflected inside.
        away = back - 2.0 * dot(back, h2)[:, None] * h2
        third = gamma - 2.0 * (self._on_ellipse(inside) - self._on_ellipse(away)) + np.pi
        k, plain3 = self._normal(-tilt, third), self._normal(0.0 * tilt, third)
        h3 = self._facet(rng, away, k)
        cosine3 = dot(away, k)
        stays = entered & (cosine3 > 0.0)
        again = self._kept(second, third, away)
        t = (
            t
            * r2
            * self._shadowed(cosine2, dot(n, -away))
            / self.glass("glass_inside", roughness, cosine3, back_ior)
            * stays
        )
        r3, last = self._refracted(away, h3, back_ior)
        share_trt = (
            self.factors[:, 2]
            * t
            * (1.0 - r3)
            * self._shadowed(cosine3, dot(k, -last))
            * ((r3 < 1.0) & seen(away, plain3, h3))
        )
        bounced = 2.0 * dot(away, h3)[:, None] * h3 - away
        share_more = (self.factors[:, 2] > 0.0) * t * r3 * self._shadowed(cosine3, dot(k, bounced))
        leaving, part = np.maximum(1.0 - 0.5 * (r2 + r3), 1e-5)[:, None], np.sqrt(kept * again)
        sine, phi = draw_along(rng, wo[:, 1], 4.0 * self.alpha), TWO_PI * rng.random(count)
        anywhere = np.stack([np.sin(phi) * cosine_of(sine), sine, np.cos(phi) * cosine_of(sine)], -1)
        shares = np.array(
            [
                share_r[:, None] * np.ones(3),
                share_tt[:, None] * kept,
                share_trt[:, None] * kept * again,
                share_more[:, None] * kept * again * part * leaving / np.maximum(1.0 - part * (1.0 - leaving), 1e-9),
            ]
        )
        shares = np.where(np.isfinite(shares), shares, 0.0)
        weights = shares.mean(2)
        total = weights.sum(0)
        choice = np.minimum((np.cumsum(weights, 0) <= rng.random(count) * total).sum(0), 3)
        rows = np.arange(count)
        picked = weights[choice, rows]
        value = shares[choice, rows] * (total / np.where(picked > 0.0, picked, 1.0))[:, None]
        return np.array([mirrored, out, last, anywhere])[choice, rows], value
