# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Subsurface scattering: the lobe of the entry, and the path from there to the exit from the same instance.

The random walk draws directions by the medium's scattering, and distances by the extinction of one colour; the balance
heuristic combines the colours. There is no guiding.
"""

from __future__ import annotations

import numpy as np

from ..scene import Ray
from .closures import Lobe
from .geometry import Geometry, Hits, Surface
from .vectors import cosine_hemisphere, dot, normalize, to_world

INSIDE = 1 << 12  # kind of scattering: below the surface
STEPS, LEAST_WEIGHT, SKEWED_STEPS = 256, 1e-6, 10
TRUNCATED = 16.0  # in radii: the end of the profile of Christensen and Burley 2015
SMALLEST_RADIUS, CUTOFF = 1e-8, 1e-5

# Of Wrenninge, Villemin and Hery 2017, from the highest power of g to the lowest: A, B, C, D, E and F.
_FITS = [
    (
        7.21067002658,
        -23.6264803333,
        32.0234874259,
        -22.8215585862,
        9.19393289202,
        -1.79904629312,
        -1.28451056436,
        1.8260523782,
    ),
    (559.009054474, -1935.41424244, 2731.71560286, -2018.09288505, 841.576016723, -201.847017512, 31.1491581433, 0.0),
    (
        -12.7181042538,
        38.5402837518,
        -46.8802913581,
        28.8643230661,
        -8.83963712726,
        1.05258115941,
        -0.394704063468,
        1.09686102424,
    ),
    (
        15.8478295021,
        -58.5106008578,
        82.065982243,
        -55.2984010333,
        17.8896899217,
        -2.15139309747,
        0.360146581622,
        0.496310210422,
    ),
    (1303.5318055, -4763.54467887, 7116.60171912, -5576.68528998, 2448.8834203, -594.356773233, 76.7316253952, 0.0),
    (
        -87.4370473567,
        302.85712436,
        -403.613804597,
        259.082868209,
        -79.2191708682,
        9.18494908356,
        -2.51814844609,
        2.40602999408,
    ),
]


class Subsurface(Lobe):
    """Entry: ``color`` and ``radius`` (N, 3), ``anisotropy``, ``ior`` and ``alpha`` (N,), and the ``method``."""

    diffuse = True

    def kind(self, wi):
        return np.full(len(wi), int(Ray.TRANSMISSION) | INSIDE)

    def evaluate(self, wo, wi):
        return np.zeros(wo.shape), np.zeros(len(wo))

    def sample(self, rng, wo):
        count = len(wo)
        wi, ones = self._refracted(rng, wo), np.ones((count, 3))
        if self.method == "RANDOM_WALK_SKIN":
            wi = np.where((rng.random(count) < 0.5)[:, None], cosine_hemisphere(rng, -self.normal), wi)
        elif self.method == "BURLEY":
            wi = -self.normal
        return wi, ones, dot(wi, wi), np.ones(count, bool)

    def _refracted(self, rng, wo):
        """Directions through a rough boundary, zero where wo is below it: a visible GGX normal (Heitz 2018), and
        Snell's law."""
        above = dot(self.normal, wo) > 0.0
        n = np.where(above[:, None], self.normal, wo)
        local = np.stack([dot(axis, wo) for axis in (to_world(np.eye(3)[[k] * len(n)], n) for k in range(3))], -1)
        stretched = normalize(local * np.stack([self.alpha, self.alpha, np.ones(len(n))], -1))
        across = np.cross([0.0, 0.0, 1.0], stretched)
        across = np.where((dot(across, across) > 1e-14)[:, None], normalize(across), [1.0, 0.0, 0.0])
        other = np.cross(stretched, across)
        radius, angle = np.sqrt(rng.random(len(n))), 2.0 * np.pi * rng.random(len(n))
        x, y = radius * np.cos(angle), radius * np.sin(angle)
        s = 0.5 * (1.0 + stretched[:, 2])
        y = (1.0 - s) * np.sqrt(1.0 - x * x) + s * y
        h = (
            x[:, None] * across
            + y[:, None] * other
            + np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))[:, None] * stretched
        )
        h = normalize(np.stack([self.alpha * h[:, 0], self.alpha * h[:, 1], np.maximum(h[:, 2], 1e-9)], -1))
        h = to_world(h, n)
        cosine = dot(h, wo)
        below = np.sqrt(1.0 - (1.0 - cosine**2) / self.ior**2)
        return above[:, None] * ((cosine / self.ior - below)[:, None] * h - wo / self.ior[:, None])


def scattering(node, surface: Surface, color, weight, radius, anisotropy, ior, alpha, normal) -> list[tuple]:
    """Subsurface scattering with ``weight`` (N, 3). Returns the weight (N, 3) of the diffuse part, and the lobe."""
    method = node.settings.get("subsurface_method", "RANDOM_WALK")
    deep = radius >= SMALLEST_RADIUS
    if node.settings.get("subsurface_once", False):
        deep = deep & (surface.depth[:, 1] == 0)[:, None]
    lobe = Subsurface(
        weight * deep,
        normal,
        color=color,
        radius=radius,
        method=method,
        ior=np.clip(ior, 1.01, 3.8),
        anisotropy=np.clip(anisotropy, -0.99, 0.99 if method == "RANDOM_WALK" else 0.9),
        alpha=np.ones(len(alpha)) if method == "RANDOM_WALK_SKIN" else alpha,
    )
    return weight * ~deep, lobe


# --- the medium -------------------------------------------------------------------------------------------------------


def _reduced_albedo(color, ior):
    """(N, 3) albedo of a medium that reflects ``color``: Jensen and Buhler 2002, by twelve halvings."""
    f = (-1.44 / ior + 0.71) / ior + 0.668 + 0.0636 * ior
    a = (4.0 / 3.0 * (1.0 + f) / (1.0 - f))[:, None]
    low, high = np.zeros(color.shape), np.ones(color.shape)
    for _ in range(12):
        middle = 0.5 * (low + high)
        s = np.sqrt(3.0 * (1.0 - middle))
        less = 0.5 * middle * (1.0 + np.exp(-a * s)) * np.exp(-s) < color
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    return np.where(color < 1e-4, 0.0, np.where(color >= 0.995, 0.999999, middle))


def medium(lobe: Subsurface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Extinction in 1/m, albedo, and the factor that takes the colour from the lobe's weight, each (N, 3)."""
    color, radius, g = lobe.color, lobe.radius, lobe.anisotropy[:, None]
    if lobe.method == "RANDOM_WALK_SKIN":
        radius = radius * np.sqrt(3.0 * (1.0 - _reduced_albedo(color, lobe.ior)))
    elif lobe.method != "RANDOM_WALK":
        radius = radius * 0.25 / np.pi
    s = (4.20863 * color - np.sqrt(9.59217 + 41.6808 * color + 17.7126 * color**2) + 4.09712) ** 2
    hulst = (1.0 - s) / np.where(1.0 - g * s == 0.0, 1.0, 1.0 - g * s)
    a, b, c, d, e, f = (np.polyval(fit, np.maximum(g, 0.0)) for fit in _FITS)
    b, e = 4.98511194385 + 0.127355959438 * np.exp(b), 4.23190299701 + 0.00310603949088 * np.exp(e)
    blend = color**0.25
    fitted = (1.0 - blend) * a * np.arctan(b * color) ** c + blend * d * np.arctan(e * color) ** f
    inverted = (g < 0.0) | (lobe.method == "RANDOM_WALK")
    extinction = 1.0 / np.maximum(radius, 1e-16) / np.where(inverted, 1.0, 1.0 - g)
    albedo = np.clip(np.where(inverted, hulst, fitted), 0.0, 0.999999)
    factor = np.where(color > 0.0, np.minimum(albedo / 0.2, 1.0) / np.where(color > 0.0, color, 1.0), 0.0)
    return extinction, np.maximum(albedo, 0.2), factor


# --- ways through an instance -----------------------------------------------------------------------------------------


def _fill(found: Hits, rows: np.ndarray, hits: Hits, which: np.ndarray) -> None:
    """Write the hits ``which`` (N,) bool into the ``rows`` of ``found``."""
    for name, values in vars(hits).items():
        getattr(found, name)[rows] = values[which]


def _own_hits(geometry: Geometry, instance, origin, direction, far) -> Hits:
    """Nearest hits with each ray's own instance, closer than ``far``."""
    found, begin, left = Hits.none(len(instance)), np.zeros(len(instance)), np.arange(len(instance))
    while len(left):
        o = origin[left] + begin[left, None] * direction[left]
        hits = geometry.intersect(o, direction[left], far[left] - begin[left], np.full(len(left), int(Ray.ALL)))
        hits.distance = begin[left] + hits.distance
        own = hits.found & (hits.instance == instance[left])
        _fill(found, left[own], hits, own)
        others = hits.found & ~own
        begin[left[others]] = hits.distance[others] + geometry.epsilon
        left = left[others]
    return found


def _scattered(rng, direction, g):
    """Directions by the phase function of Henyey and Greenstein."""
    u, even = rng.random(len(g)), np.abs(g) < 1e-3
    safe = np.where(even, 1.0, g)
    cosine = np.where(
        even, 1.0 - 2.0 * u, (1.0 + safe**2 - ((1.0 - safe**2) / (1.0 + safe - 2.0 * safe * u)) ** 2) / (2.0 * safe)
    )
    cosine = np.clip(cosine, -1.0, 1.0)
    sine, angle = np.sqrt(1.0 - cosine**2), 2.0 * np.pi * rng.random(len(g))
    return to_world(np.stack([sine * np.cos(angle), sine * np.sin(angle), cosine], -1), direction)


def _drawn(rng, share):
    """Column chosen by its probability (N, 3)."""
    return np.minimum((np.cumsum(share, 1) <= rng.random((len(share), 1))).sum(1), 2)


def pass_below(geometry: Geometry, lobe: Subsurface, surface: Surface, wi, throughput, rng):
    """Exit of light that enters ``surface`` along wi: (hits, directions (N, 3), throughput (N, 3))."""
    if lobe.method == "BURLEY":
        return _pass_by_profile(geometry, lobe, surface, throughput, rng)
    count = len(wi)
    found, out = Hits.none(count), np.zeros((count, 3))
    extinction, albedo, factor = medium(lobe)
    throughput = throughput * factor
    position, direction = geometry.offset(surface.position, surface.ng, wi), wi.copy()
    g, alive = lobe.anisotropy.copy(), np.flatnonzero(throughput.max(1) >= LEAST_WEIGHT)
    for step in range(STEPS):
        if step == SKEWED_STEPS:  # similarity relation
            absorption, scattered = extinction * (1.0 - albedo), extinction * albedo * (1.0 - g)[:, None]
            extinction, albedo, g = absorption + scattered, scattered / (absorption + scattered), np.zeros(count)
        if step:
            direction[alive] = _scattered(rng, direction[alive], g[alive])
        sigma, share = extinction[alive], throughput[alive] * albedo[alive]
        share = share / share.sum(1, keepdims=True)
        one = np.take_along_axis(sigma, _drawn(rng, share)[:, None], 1)[:, 0]
        distance = -np.log(1.0 - rng.random(len(alive))) / one
        hits = _own_hits(geometry, surface.instance[alive], position[alive], direction[alive], distance)
        met = hits.found
        distance = np.where(met, hits.distance, distance)
        left = np.exp(-sigma * distance[:, None])
        density = np.where(met[:, None], left, sigma * left)
        value = np.where(met[:, None], left, sigma * albedo[alive] * left)
        throughput[alive] *= value / (share * density).sum(1, keepdims=True)
        position[alive] += distance[:, None] * direction[alive]
        rows = alive[met]
        _fill(found, rows, hits, met)
        out[rows] = direction[rows]
        alive = alive[~met]
        alive = alive[throughput[alive].max(1) >= LEAST_WEIGHT]
        if not len(alive):
            break
    return found, out, throughput


def _profile(radius, r):
    """2 π r R(r) of Christensen and Burley 2015, not normalised."""
    safe = np.where(radius > 0.0, radius, 1.0)
    return np.where(r < TRUNCATED * radius, (np.exp(-r / safe) + np.exp(-r / (3.0 * safe))) / (4.0 * safe), 0.0)


def _pass_by_profile(geometry: Geometry, lobe: Subsurface, surface: Surface, throughput, rng):
    """As ``pass_below``: one of the hits of a line through a disk around the entry with the instance."""
    count, n = len(throughput), surface.ng
    radius = lobe.radius * 0.25 / np.pi
    deep = radius > 0.0
    drawn = radius[np.arange(count), _drawn(rng, deep / deep.sum(1, keepdims=True))]
    # Distances from a table of the inverse distribution function.
    r = np.linspace(0.0, TRUNCATED, 200_001)
    part = 1.0 - 0.25 * np.exp(-r) - 0.75 * np.exp(-r / 3.0)
    r = np.interp(rng.random(count) * part[-1], part, r) * drawn
    half = np.sqrt(np.maximum((TRUNCATED * drawn) ** 2 - r**2, 0.0))
    # Axes as in Cycles: results in corners depend on them.
    t = np.stack([n[:, 2] - n[:, 1], n[:, 0] - n[:, 2], n[:, 1] - n[:, 0]], -1)
    same = (n == n[:, :1]).all(1)
    t = normalize(np.where(same[:, None], np.stack([n[:, 2] - n[:, 1], n[:, 0] + n[:, 2], -n[:, 1] - n[:, 0]], -1), t))
    axes, chances = np.stack([n, t, np.cross(n, t)], 1), np.array([0.5, 0.25, 0.25])
    which = rng.choice(3, count, p=chances)
    axis, first, second = (axes[np.arange(count), (which + k) % 3] for k in range(3))
    angle = 2.0 * np.pi * rng.random(count)
    start = (
        surface.position
        + half[:, None] * axis
        + (r * np.cos(angle))[:, None] * first
        + (r * np.sin(angle))[:, None] * second
    )
    density = _profile(radius, r[:, None]).sum(1) / deep.sum(1)
    found, out, chosen, total = Hits.none(count), n.copy(), np.zeros((count, 3)), np.zeros(count)
    begin, alive = np.zeros(count), np.flatnonzero(density > 0.0)
    while len(alive):
        origin = start[alive] - begin[alive, None] * axis[alive]
        hits = _own_hits(geometry, surface.instance[alive], origin, -axis[alive], 2.0 * half[alive] - begin[alive])
        alive, hits = alive[hits.found], hits.select(hits.found)
        if not len(alive):
            break
        begin[alive] += hits.distance + geometry.epsilon
        point = geometry.surface(hits, -axis[alive])
        front = point.ng * np.where(point.backfacing, -1.0, 1.0)[:, None]
        cosines = np.abs(np.einsum("nki,ni->nk", axes[alive], front)) * chances
        own = cosines[np.arange(len(alive)), which[alive]] / (cosines**2).sum(1)
        away = np.sqrt(((point.position - surface.position[alive]) ** 2).sum(1))
        weight = _profile(radius[alive], away[:, None]) * (own / density[alive])[:, None]
        amount = weight.mean(1)
        total[alive] += amount
        taken = (amount > 0.0) & (rng.random(len(alive)) * total[alive] < amount)
        rows = alive[taken]
        _fill(found, rows, hits, taken)
        chosen[rows] = weight[taken] / amount[taken, None]
        out[rows] = front[taken] * np.where(surface.backfacing[rows], -1.0, 1.0)[:, None]
    return found, out, throughput * chosen * total[:, None]
