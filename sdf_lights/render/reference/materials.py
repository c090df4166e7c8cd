# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the graph of a material to lobes, with the layers of Principled stacked from the top as Cycles does."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..material import Material, Node
from ..scene import Ray, Scene
from ..tables import albedo
from .closures import (
    DIELECTRIC, F82, NONE, Diffuse, Lobe, Microfacet, OrenNayar, Sheen, Straight, Translucent, f0_of_ior, masking)
from .geometry import Geometry, Surface
from .nodes import Points
from .vectors import dot, normalize, reflect

CUTOFF = 1e-5  # lobes of less weight are left out
LOWEST_SHEEN = 1e-2  # roughness below which the fits of sheen do not hold


class Table:
    """Directional albedos from ``render.tables``, with multilinear interpolation."""

    def __init__(self):
        flat = albedo.load()
        self._values = {name: flat[start:start + int(np.prod(shape))].reshape(shape)
                        for (name, shape), start in zip(albedo.SHAPES.items(), albedo.OFFSETS.values())}

    def __call__(self, name: str, *coordinates: np.ndarray) -> np.ndarray:
        """Values at coordinates in [0, 1], one array for each axis of the table."""
        table = self._values[name]
        total = np.zeros(np.broadcast(*coordinates).shape)
        cells = []
        for x, size in zip(coordinates, table.shape):
            x = np.clip(x, 0.0, 1.0) * (size - 1)
            low = np.minimum(x.astype(int), size - 2)
            cells.append((low, x - low))
        for corner in np.ndindex((2,) * table.ndim):
            weight = np.prod([t if k else 1.0 - t for k, (_, t) in zip(corner, cells)], axis=0)
            total += weight * table[tuple(low + k for k, (low, _) in zip(corner, cells))]
        return total


def ior_axis(ior: np.ndarray) -> np.ndarray:
    return np.sqrt(np.abs((ior - 1.0) / (ior + 1.0)))


def cosine_axis(cosine: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(cosine, 0.0))


class Shading:
    """What surfaces emit, let through and scatter: lobes for each group of rows that share a material."""

    def __init__(self, surface: Surface):
        self.surface = surface
        count = len(surface.distance)
        self.emission, self.transparency, self.albedo, self.diffuse_albedo = np.zeros((4, count, 3))
        self.holdout, self.scatters = np.zeros(count), np.zeros(count, bool)
        self.groups: list[tuple[np.ndarray, list[Lobe]]] = []

    def select(self, rows: np.ndarray) -> "Shading":
        """The same for some rows, given as indices or as a mask."""
        rows = np.arange(len(self.holdout))[rows]
        result = Shading(self.surface.select(rows))
        for name in ("emission", "transparency", "albedo", "diffuse_albedo", "holdout", "scatters"):
            setattr(result, name, getattr(self, name)[rows])
        place = np.full(len(self.holdout), -1)
        place[rows] = np.arange(len(rows))
        for group, lobes in self.groups:
            kept = np.flatnonzero(place[group] >= 0)
            if len(kept):
                result.groups.append((place[group[kept]], [lobe.select(kept) for lobe in lobes]))
        return result

    def evaluate(self, wi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """f · |cos| (N, 3) and pdf (N,) of all lobes that are not singular."""
        value, pdf = np.zeros(wi.shape), np.zeros(len(wi))
        for rows, lobes in self.groups:
            part = self.surface.select(rows)
            value[rows], pdf[rows] = _evaluate(part, lobes, wi[rows])
        return value, pdf

    def sample(self, rng: np.random.Generator):
        """(wi, f · |cos| / pdf, pdf, kind); weight 0: nothing was drawn. pdf is 0 for singular directions, kind 0 for
        what goes straight through."""
        count = len(self.holdout)
        wi, weight, pdf, kind = -self.surface.wo, np.zeros((count, 3)), np.zeros(count), np.zeros(count, int)
        for rows, lobes in self.groups:
            wi[rows], weight[rows], pdf[rows], kind[rows] = _sample(self.surface.select(rows), lobes, rng)
        return wi, weight, pdf, kind


def _picks(lobes: list[Lobe]) -> np.ndarray:
    """Probability (lobes, N) of sampling each lobe."""
    picks = np.array([np.maximum(lobe.albedo.mean(1), 0.0) for lobe in lobes])
    total = picks.sum(0)
    return picks / np.where(total > 0.0, total, 1.0)


def _evaluate(surface: Surface, lobes: list[Lobe], wi: np.ndarray):
    value, pdf = np.zeros(wi.shape), np.zeros(len(wi))
    for lobe, pick in zip(lobes, _picks(lobes)):
        one, density = lobe.evaluate(surface.wo, wi)
        value += lobe.weight * one * _bump_shadowing(surface, lobe, wi)[:, None]
        pdf += pick * density
    return value, pdf


def _bump_shadowing(surface: Surface, lobe: Lobe, wi: np.ndarray) -> np.ndarray:
    """Conty Estevez, Lecocq and Stein 2019, "A microfacet-based shadowing function to solve the bump terminator
    problem"; for specular lobes only the cut at the horizon of the surface."""
    bumped = (lobe.normal != surface.ns).any(1)
    cosine, tilt = dot(surface.ns, wi), dot(surface.ns, lobe.normal)
    factor = np.ones(len(wi))
    if lobe.diffuse:
        tilt2 = np.clip(tilt * tilt, 1e-12, 1.0)
        factor = 1.0 / (1.0 + masking(np.minimum(0.125 * (1.0 / tilt2 - 1.0), 1.0), np.minimum(np.abs(cosine), 1.0)))
    return np.where(bumped, factor * (cosine * tilt * dot(lobe.normal, wi) >= 0.0), 1.0)


def _sample(surface: Surface, lobes: list[Lobe], rng: np.random.Generator):
    count = len(surface.distance)
    choice = np.minimum((np.cumsum(_picks(lobes), 0) <= rng.random(count)).sum(0), len(lobes) - 1)
    wi, weight, pdf, kind = -surface.wo, np.zeros((count, 3)), np.zeros(count), np.zeros(count, int)
    for index, (lobe, pick) in enumerate(zip(lobes, _picks(lobes))):
        rows = np.flatnonzero((choice == index) & (pick > 0.0))
        if not len(rows):
            continue
        part, lobe = surface.select(rows), lobe.select(rows)
        direction, value, probability, singular = lobe.sample(rng, part.wo)
        wi[rows], kind[rows] = direction, lobe.kind(direction)
        # A direction must leave on the side that its kind says, whatever the shading normal is.
        through = (kind[rows] & Ray.TRANSMISSION) != 0
        valid = (probability > 0.0) & ((kind[rows] == 0) | ((dot(part.ng, direction) < 0.0) == through))
        total, density = _evaluate(part, [one.select(rows) for one in lobes], direction)
        valid &= singular | (density > 0.0)
        alone = lobe.weight * value / np.where(valid, pick[rows] * probability, 1.0)[:, None]
        mixed = total / np.where(density > 0.0, density, 1.0)[:, None]
        weight[rows] = np.where(valid[:, None], np.where(singular[:, None], alone, mixed), 0.0)
        pdf[rows] = np.where(singular, 0.0, density)
    return wi, weight, pdf, kind


class Materials:
    """All materials of a scene. ``emissive`` (materials,) says whose triangles light sampling looks for."""

    def __init__(self, scene: Scene, geometry: Geometry):
        self.scene, self.geometry, self.table = scene, geometry, Table()
        self.materials = scene.materials or [Material("Default", Node("diffuse"))]
        self.emissive = np.array([m.sample_emission and _may_emit(m.surface) for m in self.materials])
        self.clear = np.array([_may_pass(m.surface) for m in self.materials])

    def _groups(self, surface: Surface):
        material = self.geometry.material(surface.instance, surface.triangle)
        for index in np.unique(material):
            yield index, np.flatnonzero(material == index)

    def shade(self, surface: Surface, footprint: np.ndarray) -> Shading:
        """``footprint`` (N,) is the width of a pixel's ray at each point in metres."""
        shading = Shading(surface)
        for index, rows in self._groups(surface):
            part = surface.select(rows)
            builder = _Builder(Points(part, self.geometry, self.scene.images, footprint[rows]), self.table)
            builder.build(self.materials[index].surface)
            shading.emission[rows], shading.holdout[rows] = builder.emission, builder.holdout
            lobes = [lobe for lobe in builder.lobes if (lobe.weight.mean(1) >= CUTOFF).any()]
            for lobe in lobes:
                if isinstance(lobe, Straight):
                    shading.transparency[rows] += lobe.weight
                else:
                    shading.albedo[rows] += lobe.albedo
                    if lobe.diffuse:
                        shading.diffuse_albedo[rows] += lobe.albedo
                    singular = lobe.singular if isinstance(lobe, Microfacet) else False
                    shading.scatters[rows] |= (lobe.weight.mean(1) >= CUTOFF) & ~np.asarray(singular)
            if lobes:
                shading.groups.append((rows, lobes))
        return shading

    def transparency(self, surface: Surface) -> np.ndarray:
        """What passes straight through (N, 3)."""
        result = np.zeros((len(surface.distance), 3))
        for index, rows in self._groups(surface):
            if self.clear[index]:
                part = surface.select(rows)
                points = Points(part, self.geometry, self.scene.images, np.zeros(len(rows)))
                for node, weight in leaves(self.materials[index].surface, points, np.ones(len(rows))):
                    if node.kind == "transparent":
                        result[rows] += weight[:, None] * np.maximum(points.input(node, "color"), 0.0)
                    elif node.kind == "principled":
                        result[rows] += (weight * (1.0 - np.clip(points.input(node, "alpha"), 0.0, 1.0)))[:, None]
        return result


def nodes_of(surface) -> Iterator[Node]:
    pending, seen = [surface], set()
    while pending:
        node = pending.pop()
        if isinstance(node, Node) and id(node) not in seen:
            seen.add(id(node))
            yield node
            pending.extend(node.inputs.values())


def _may_emit(surface) -> bool:
    def zero(value):
        return not isinstance(value, Node) and not np.any(value)

    return any(
        node.kind == "emission" and not zero(node["strength"]) and not zero(node["color"])
        or node.kind == "principled" and not zero(node["emission_strength"]) and not zero(node["emission_color"])
        for node in nodes_of(surface))


def _may_pass(surface) -> bool:
    return any(node.kind == "transparent" or node.kind == "principled" and node["alpha"] != 1.0
               for node in nodes_of(surface))


def leaves(node, points: Points, weight: np.ndarray) -> Iterator[tuple[Node, np.ndarray]]:
    """Closure nodes below ``node`` other than Mix and Add, with their weights (N,)."""
    if not isinstance(node, Node) or not np.any(weight):
        return
    if node.kind == "mix_closure":
        factor = np.clip(points.input(node, "factor"), 0.0, 1.0)
        yield from leaves(node["a"], points, weight * (1.0 - factor))
        yield from leaves(node["b"], points, weight * factor)
    elif node.kind == "add_closure":
        yield from leaves(node["a"], points, weight)
        yield from leaves(node["b"], points, weight)
    else:
        yield node, weight


class _Builder:
    """Lobes, emission (N, 3) and holdout (N,) of one material at ``points``."""

    def __init__(self, points: Points, table: Table):
        self.points, self.table, self.surface = points, table, points.surface
        self.emission, self.holdout = np.zeros((points.count, 3)), np.zeros(points.count)
        self.lobes: list[Lobe] = []

    def build(self, surface) -> None:
        if surface is not None and not isinstance(surface, Node):
            surface = Node("emission", {"color": surface})
        for node, weight in leaves(surface, self.points, np.ones(self.points.count)):
            method = getattr(self, "_" + node.kind, None)
            if method is None:  # a value where a closure is wanted is light, as in Blender
                self.emission += weight[:, None] * self.points.value(node, 3)
            else:
                method(node, weight[:, None])

    def _color(self, node: Node, name: str = "color") -> np.ndarray:
        return np.maximum(self.points.input(node, name), 0.0)

    def _share(self, node: Node, name: str) -> np.ndarray:
        return np.clip(self.points.input(node, name), 0.0, 1.0)

    # --- closures of one lobe -----------------------------------------------------------------------------------------

    def _holdout(self, node, weight):
        self.holdout += weight[:, 0]

    def _emission(self, node, weight):
        self.emission += weight * self.points.input(node, "color") * self.points.input(node, "strength")[:, None]

    def _transparent(self, node, weight):
        self.lobes.append(Straight(weight * self._color(node), self.surface.ns))

    def _translucent(self, node, weight):
        self.lobes.append(Translucent(weight * self._color(node), self.points.normal(node)))

    def _diffuse(self, node, weight):
        self._add_diffuse(weight, self._color(node), self.points.input(node, "roughness"), self.points.normal(node))

    def _add_diffuse(self, weight, color, roughness, normal):
        if np.any(roughness >= 1e-5):
            self.lobes.append(OrenNayar(weight * color, normal, color=color, roughness=roughness))
        else:
            self.lobes.append(Diffuse(weight * color, normal))

    def _glossy(self, node, weight):
        color, roughness = self._color(node), self._share(node, "roughness")
        normal = specular_normal(self.surface, self.points.normal(node))
        weight = weight * color
        if _compensated(node):
            weight = weight * self._gain(normal, roughness, color)
        self.lobes.append(Microfacet(weight, normal, weight * self._lossless(normal, roughness), alpha=roughness**2,
                                     ior=np.ones(self.points.count), term=NONE, transmits=False))

    def _refraction(self, node, weight):
        ior = self._relative(np.maximum(self.points.input(node, "ior"), 1e-5))
        self.lobes.append(Microfacet(
            weight * self._color(node), specular_normal(self.surface, self.points.normal(node)),
            alpha=self._share(node, "roughness")**2, ior=ior, term=NONE, transmits=True))

    def _glass(self, node, weight):
        ior, color = np.maximum(self.points.input(node, "ior"), 1e-5), self._color(node)
        normal = specular_normal(self.surface, self.points.normal(node))
        f0 = np.repeat(f0_of_ior(ior)[:, None], 3, 1)
        self._add_glass(node, np.repeat(weight, 3, 1), normal, self._share(node, "roughness"), ior, f0, color, color)

    def _relative(self, ior):
        return np.where(self.surface.backfacing, 1.0 / ior, ior)

    def _add_glass(self, node, weight, normal, roughness, ior, f0, reflection, transmission):
        ior = self._relative(ior)
        if _compensated(node):
            weight = weight * self._gain(normal, roughness, transmission, ior)
        lobe = Microfacet(weight, normal, alpha=roughness**2, ior=ior, term=DIELECTRIC, f0=np.clip(f0, 0.0, 1.0),
                          transmits=True, reflection=reflection, transmission=transmission)
        r, t = lobe.fresnel(dot(normal, self.surface.wo))
        lobe.albedo = weight * (r + t)
        self.lobes.append(lobe)

    def _lossless(self, normal, roughness):
        """Albedo (N, 1) of GGX off microfacets that reflect everything."""
        return self.table("reflection", cosine_axis(dot(normal, self.surface.wo)), roughness)[:, None]

    def _gain(self, normal, roughness, single, ior=None):
        """Factor that gives back what single scattering loses: Turquin 2019, coloured as in Kulla and Conty 2017.

        ``single`` (N, 3) is the average reflectance of one bounce; with ``ior`` that of glass.
        """
        cosine = cosine_axis(dot(normal, self.surface.wo))
        if ior is None:
            e, mean = self.table("reflection", cosine, roughness), self.table("reflection_average", roughness)
        else:
            z = ior_axis(ior)
            e, mean = (
                np.where(ior < 1.0, self.table("glass_inside" + name, z, *rest), self.table("glass" + name, z, *rest))
                for name, rest in (("", (cosine, roughness)), ("_average", (roughness,))))
        missing = np.where((1.0 - e) / e < 1e-4, 0.0, (1.0 - e) / e)[:, None]
        f, mean = np.minimum(single, 1.0), mean[:, None]
        return 1.0 + missing * f * mean / (1.0 - f * (1.0 - mean))

    # --- Principled ---------------------------------------------------------------------------------------------------

    def _principled(self, node, weight):
        surface, points = self.surface, self.points
        weight = np.repeat(weight, 3, 1)
        alpha = self._share(node, "alpha")[:, None]
        if np.any(alpha < 1.0):
            self.lobes.append(Straight(weight * (1.0 - alpha), surface.ns))
            weight = weight * alpha
        normal = points.normal(node)
        weight = self._sheen(node, weight, normal)
        weight = self._coat(node, weight)
        strength = points.input(node, "emission_strength")[:, None]
        self.emission += weight * points.input(node, "emission_color") * strength

        base, tint = self._color(node, "base_color"), self._color(node, "specular_tint")
        color, roughness = np.minimum(base, 1.0), self._share(node, "roughness")
        mirror = specular_normal(surface, normal)
        metallic = self._share(node, "metallic")[:, None]
        if np.any(metallic > CUTOFF):
            self._metal(node, weight * metallic, mirror, roughness, color, np.minimum(tint, 1.0))
            weight = weight * (1.0 - metallic)
        ior = np.maximum(points.input(node, "ior"), 1e-5)
        f0 = f0_of_ior(ior)
        transmission = self._share(node, "transmission_weight")[:, None]
        if np.any(transmission > CUTOFF):
            # Two crossings tint by the colour.
            self._add_glass(
                node, weight * transmission, mirror, roughness, ior, tint * f0[:, None], np.ones_like(color),
                np.sqrt(color))
            weight = weight * (1.0 - transmission)
        level = np.maximum(points.input(node, "specular_ior_level"), 0.0)
        f0 = f0 * 2.0 * level
        root = np.sqrt(np.clip(f0, 0.0, 0.99))
        adjusted = (1.0 + root) / (1.0 - root)
        ior = np.where(level == 0.5, ior, np.where(ior < 1.0, 1.0 / adjusted, adjusted))
        if np.any(ior != 1.0):
            weight = self._layer(weight, mirror, roughness, ior, tint * f0[:, None], _compensated(node))
        self._add_diffuse(weight, base, self._share(node, "diffuse_roughness"), normal)

    def _below(self, weight, reflected):
        """What a layer that reflects ``reflected`` leaves of ``weight``: the same share of all colours."""
        share = np.where(weight > 0.0, reflected / np.where(weight > 0.0, weight, 1.0), 0.0)
        return weight * np.clip(1.0 - share.max(1, keepdims=True), 0.0, 1.0)

    def _layer(self, weight, normal, roughness, ior, f0, compensated):
        """A clear reflecting layer; the weight of what lies below it."""
        f0 = np.clip(f0, 0.0, 1.0)
        cosine = cosine_axis(dot(normal, self.surface.wo))
        share = self.table("dielectric", ior_axis(ior), cosine, roughness)[:, None]
        gain = 1.0
        if compensated:
            # Average of a dielectric's reflectance over the hemisphere: fits of Kulla and Conty 2017.
            mean = np.where(ior < 1.0, 0.997118 + ior * (0.1014 - ior * (0.965241 + ior * 0.130607)),
                            (ior - 1.0) / (4.08567 + 1.00071 * ior))
            bottom = f0_of_ior(ior)
            mean = np.clip((mean - bottom) / (1.0 - bottom), 0.0, 1.0)[:, None]
            gain = self._gain(normal, roughness, f0 + (1.0 - f0) * mean)
        reflected = weight * gain * (f0 * self._lossless(normal, roughness) + (1.0 - f0) * share)
        self.lobes.append(Microfacet(weight * gain, normal, reflected, alpha=roughness**2, ior=ior, term=DIELECTRIC,
                                     f0=f0, transmits=False))
        return self._below(weight, reflected)

    def _metal(self, node, weight, normal, roughness, color, tint):
        schlick = self.table("schlick", cosine_axis(dot(normal, self.surface.wo)), roughness)[:, None]
        gain = 1.0
        if _compensated(node):
            mu, step = np.polynomial.legendre.leggauss(16)
            mu, step = 0.5 + 0.5 * mu, 0.5 * step
            edge = (color + (1.0 - color) * (6 / 7)**5) * (1.0 - tint) / (1 / 7 * (6 / 7)**6)
            average = sum(2.0 * m * s * (color + (1.0 - color) * (1.0 - m)**5 - edge * m * (1.0 - m)**6)
                          for m, s in zip(mu, step))
            gain = self._gain(normal, roughness, average)
        weight = weight * gain
        self.lobes.append(Microfacet(
            weight, normal, weight * (color * self._lossless(normal, roughness) + (1.0 - color) * schlick),
            alpha=roughness**2, ior=np.ones(len(color)), term=F82, f0=color, tint=tint, transmits=False))

    def _sheen(self, node, weight, normal):
        amount = np.maximum(self.points.input(node, "sheen_weight"), 0.0)[:, None]
        if not np.any(amount):
            return weight
        if node["coat_normal"] is not None and node["coat_normal"] is not node["normal"]:
            blend = self._share(node, "coat_weight")[:, None]
            normal = normalize((1.0 - blend) * normal + blend * self.points.normal(node, "coat_normal"))
        y = np.clip(self.points.input(node, "sheen_roughness"), LOWEST_SHEEN, 1.0)
        x = np.clip(dot(normal, self.surface.wo), 0.0, 1.0)
        # Fits of MaterialX 1.39 to the tables of Zeltner et al. 2022: albedo and the inverse transform.
        width = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y))
        middle = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y)
        offset = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y))
        reflected = np.exp(-0.5 * ((x - middle) / width)**2) / (width * np.sqrt(2.0 * np.pi)) + offset
        a = (2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y)
        b = np.sqrt(1.0 - x) * (y - 1.0) * y**3
        b = b / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y)
        usable = (reflected > CUTOFF) & (np.abs(a) >= CUTOFF)
        own = weight * self._color(node, "sheen_tint") * amount * np.where(usable, reflected, 0.0)[:, None]
        self.lobes.append(Sheen(own, normal, a=np.where(usable, a, 1.0), b=b))
        return self._below(weight, own)

    def _coat(self, node, weight):
        amount = self._share(node, "coat_weight")[:, None]
        if not np.any(amount > CUTOFF):
            return weight
        ior = np.maximum(self.points.input(node, "coat_ior"), 1.0)
        normal = specular_normal(self.surface, self.points.normal(node, "coat_normal"))
        f0 = np.repeat(f0_of_ior(ior)[:, None], 3, 1)
        below = self._layer(weight * amount, normal, self._share(node, "coat_roughness"), ior, f0, True)
        # Beer's law along the refracted ray; the tint is that of a ray straight in and out.
        depth = 1.0 / np.sqrt(1.0 - (1.0 - dot(normal, self.surface.wo)**2) / ior**2)
        tint = self._color(node, "coat_tint")**depth[:, None]
        return (weight * (1.0 - amount) + below) * (1.0 - amount + amount * tint)


def _compensated(node: Node) -> bool:
    return node.settings.get("distribution", "MULTI_GGX") == "MULTI_GGX"


def specular_normal(surface: Surface, normal: np.ndarray) -> np.ndarray:
    """``normal`` turned towards the geometric one just so far that the mirror direction of wo leaves the surface.

    By bisection of the way between the two normals.
    """
    height = dot(surface.ng, surface.wo)
    least = np.minimum(0.9 * height, 0.01)
    rows = np.flatnonzero(dot(reflect(surface.wo, normal), surface.ng) < least)
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
