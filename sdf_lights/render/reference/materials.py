# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the graph of a material to lobes, with the layers of Principled stacked from the top as Cycles does."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...graph.formula import Vector
from ..material import Material, Node
from ..scene import Ray, Scene
from ..tables import albedo
from . import bsdfs
from .bsdfs.ray_portal import THROUGH_PORTAL, Portal
from .closures import (
    DIELECTRIC,
    F82,
    NONE,
    SINGULAR_ALPHA2,
    Diffuse,
    Lobe,
    Microfacet,
    OrenNayar,
    Sheen,
    Straight,
    Translucent,
    f0_of_ior,
    masking,
    specular_normal,
)
from .fibers import Chiang, Hair
from .geometry import Geometry, Surface
from .nodes import Graph, Points
from .rare import AshikhminShirley, Pane, Velvet
from .special import CONDUCTOR, THINNEST_FILM, conductor_reflectance
from .special_materials import (
    as_facets,
    covered,
    glass_facets,
    glossy_facets,
    mean_roughness,
    metal_facets,
    principled_facets,
)
from .subsurface import Subsurface, scattering
from .vectors import dot, normalize

CUTOFF = 1e-5  # lobes of less weight are left out
LOWEST_SHEEN = 1e-2  # roughness below which the fits of sheen do not hold


class Table:
    """Directional albedos from ``render.tables``, with multilinear interpolation."""

    def __init__(self):
        flat = albedo.load()
        self._values = {
            name: flat[start : start + int(np.prod(shape))].reshape(shape)
            for (name, shape), start in zip(albedo.SHAPES.items(), albedo.OFFSETS.values())
        }

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
    """Coordinate of the tables of glass for an index of refraction (N,)."""
    return np.sqrt(np.abs((ior - 1.0) / (ior + 1.0)))


def cosine_axis(cosine: np.ndarray) -> np.ndarray:
    """Coordinate of the tables for a cosine (N,)."""
    return np.sqrt(np.maximum(cosine, 0.0))


class Shading:
    """What surfaces emit, let through and scatter: lobes for each group of rows that share a material."""

    def __init__(self, surface: Surface):
        self.surface = surface
        count = len(surface.distance)
        self.emission, self.transparency, self.albedo, self.diffuse_albedo = np.zeros((4, count, 3))
        self.holdout, self.scatters, self.portal = np.zeros(count), np.zeros(count, bool), np.zeros(count, bool)
        self.exit = surface.position.copy()  # from where a ray goes on that ``sample`` has sent through a portal
        self.groups: list[tuple[np.ndarray, list[Lobe]]] = []
        self.entered: list[tuple[np.ndarray, Subsurface]] = []  # rows that ``sample`` has sent below the surface

    def select(self, rows: np.ndarray) -> "Shading":
        """The same for some rows, given as indices or as a mask."""
        rows = np.arange(len(self.holdout))[rows]
        result = Shading(self.surface.select(rows))
        for name in ("emission", "transparency", "albedo", "diffuse_albedo", "holdout", "scatters", "portal"):
            setattr(result, name, getattr(self, name)[rows])
        place = np.full(len(self.holdout), -1)
        place[rows] = np.arange(len(rows))
        for group, lobes in self.groups:
            kept = np.flatnonzero(place[group] >= 0)
            if len(kept):
                result.groups.append((place[group[kept]], [lobe.select(kept) for lobe in lobes]))
        return result

    def darken_microfacets(self, after_diffuse: np.ndarray, reflective: bool, refractive: bool) -> None:
        """Take reflection or refraction from microfacets where ``after_diffuse`` (N,): caustics that are switched off."""
        if reflective and refractive:
            return
        for rows, lobes in self.groups:
            light = np.where(after_diffuse[rows], 0.0, 1.0)[:, None]
            for lobe in lobes:
                if not isinstance(lobe, Microfacet):
                    continue
                if lobe.transmits and lobe.term == DIELECTRIC:
                    lobe.reflection = lobe.reflection * (1.0 if reflective else light)
                    lobe.transmission = lobe.transmission * (1.0 if refractive else light)
                elif not (refractive if lobe.transmits else reflective):
                    lobe.weight = lobe.weight * light

    def blur(self, least_pdf: np.ndarray, limit: float) -> None:
        """Raise the roughness of lobes where the ``least_pdf`` (N,) of a path is below ``limit``: Filter Glossy of Cycles."""
        blurred = least_pdf < limit
        if not blurred.any():
            return
        roughness = 0.5 * np.sqrt(np.where(blurred, 1.0 - least_pdf / limit, 0.0))
        for rows, lobes in self.groups:
            for lobe in lobes:
                for name in getattr(lobe, "widths", ()):
                    setattr(lobe, name, np.maximum(getattr(lobe, name), roughness[rows]))
                if isinstance(lobe, (Microfacet, AshikhminShirley)):
                    self.scatters[rows] |= (lobe.weight.mean(1) >= CUTOFF) & ~lobe.singular

    def evaluate(self, wi: np.ndarray, kinds: Ray = Ray.ALL) -> tuple[np.ndarray, np.ndarray]:
        """f · |cos| (N, 3), of lobes that scatter as one of these ``kinds`` of rays, and pdf (N,) of all lobes that are not
        singular."""
        value, pdf = np.zeros(wi.shape), np.zeros(len(wi))
        for rows, lobes in self.groups:
            part = self.surface.select(rows)
            value[rows], pdf[rows] = _evaluate(part, lobes, wi[rows], kinds)
        return value, pdf

    def sample(self, rng: np.random.Generator):
        """(wi, f · |cos| / pdf, pdf, kind); weight 0: nothing was drawn. pdf is 0 for singular directions, kind 0 for
        what goes straight through, THROUGH_PORTAL for what goes on from ``exit``."""
        count = len(self.holdout)
        wi, weight, pdf, kind = -self.surface.wo, np.zeros((count, 3)), np.zeros(count), np.zeros(count, int)
        self.entered = []
        for rows, lobes in self.groups:
            part = self.surface.select(rows)
            wi[rows], weight[rows], pdf[rows], kind[rows], self.exit[rows], choice = _sample(part, lobes, rng)
            for index, lobe in enumerate(lobes):
                if isinstance(lobe, Subsurface):
                    own = np.flatnonzero(choice == index)
                    self.entered.append((rows[own], lobe.select(own)))
        return wi, weight, pdf, kind


def _picks(lobes: list[Lobe]) -> np.ndarray:
    """Probability (lobes, N) of sampling each lobe."""
    picks = np.array([np.maximum(lobe.albedo.mean(1), 0.0) for lobe in lobes])
    total = picks.sum(0)
    return picks / np.where(total > 0.0, total, 1.0)


def _evaluate(surface: Surface, lobes: list[Lobe], wi: np.ndarray, kinds: Ray = Ray.ALL):
    value, pdf = np.zeros(wi.shape), np.zeros(len(wi))
    side = np.where(dot(surface.ng, wi) < 0.0, int(Ray.TRANSMISSION), int(Ray.GLOSSY))
    for lobe, pick in zip(lobes, _picks(lobes)):
        one, density = lobe.evaluate(surface.wo, wi)
        counts = ((int(Ray.DIFFUSE) if lobe.diffuse else side) & int(kinds)) != 0
        value += lobe.weight * one * (_bump_shadowing(surface, lobe, wi) * counts)[:, None]
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
    exit_ = surface.position.copy()
    for index, (lobe, pick) in enumerate(zip(lobes, _picks(lobes))):
        rows = np.flatnonzero((choice == index) & (pick > 0.0))
        if not len(rows):
            continue
        part, lobe = surface.select(rows), lobe.select(rows)
        direction, value, probability, singular = lobe.sample(rng, part.wo)
        wi[rows], kind[rows] = direction, lobe.kind(direction)
        if isinstance(lobe, Portal):
            exit_[rows] = lobe.position
        # A direction must leave on the side that its kind says, whatever the shading normal is.
        through = (kind[rows] & Ray.TRANSMISSION) != 0
        free = (kind[rows] == 0) | (kind[rows] == THROUGH_PORTAL)
        valid = (probability > 0.0) & (free | ((dot(part.ng, direction) < 0.0) == through))
        total, density = _evaluate(part, [one.select(rows) for one in lobes], direction)
        valid &= singular | (density > 0.0)
        seen, _ = lobe.evaluate(part.wo, direction)
        own = lobe.whole(part.wo, direction)[0] if isinstance(lobe, (Hair, Chiang)) else seen
        shadowing = _bump_shadowing(part, lobe, direction)[:, None]
        darkened = lobe.diffuse and not isinstance(lobe, Translucent)  # as Cycles has it
        total = total + lobe.weight * (own * (shadowing if darkened else 1.0) - seen * shadowing)
        alone = lobe.weight * value / np.where(valid, pick[rows] * probability, 1.0)[:, None]
        mixed = total / np.where(density > 0.0, density, 1.0)[:, None]
        weight[rows] = np.where(valid[:, None], np.where(singular[:, None], alone, mixed), 0.0)
        pdf[rows] = np.where(singular, 0.0, density)
    return wi, weight, pdf, kind, exit_, choice


class Materials:
    """All materials of a scene. ``emissive`` (materials,) says whose triangles light sampling looks for."""

    def __init__(self, scene: Scene, geometry: Geometry):
        self.scene, self.geometry, self.table = scene, geometry, Table()
        self.materials = scene.materials or [Material("Default", Node("diffuse"))]
        self.graphs = [Graph(material) for material in self.materials]
        self.emissive = np.array([m.sample_emission and _may_emit(g) for m, g in zip(self.materials, self.graphs)])
        self.clear = np.array([_may_pass(graph) for graph in self.graphs])

    def _groups(self, surface: Surface):
        material = self.geometry.material(surface.instance, surface.triangle)
        for index in np.unique(material):
            yield index, np.flatnonzero(material == index)

    def shade(self, surface: Surface, footprint: np.ndarray, rng: np.random.Generator | None = None) -> Shading:
        """``footprint`` (N,) is the width of a pixel's ray at each point in metres. Without ``rng`` nodes send no rays."""
        shading = Shading(surface)
        for index, rows in self._groups(surface):
            part = surface.select(rows)
            graph = self.graphs[index]
            points = Points(graph, part, self.geometry, self.scene.images, footprint[rows], rng)
            if graph.normal is not None:
                part.ns = surface.ns[rows] = points.unit_or_own(points.value(graph.normal, 3))
            builder = Builder(points, self.table)
            builder.build(graph.surface)
            shading.emission[rows], shading.holdout[rows] = builder.emission, builder.holdout
            lobes = [lobe for lobe in builder.lobes if (lobe.weight.mean(1) >= CUTOFF).any()]
            for lobe in lobes:
                if isinstance(lobe, (Straight, Portal)):
                    shading.transparency[rows] += lobe.weight
                    shading.portal[rows] |= isinstance(lobe, Portal) & (lobe.weight.mean(1) >= CUTOFF)
                else:
                    shading.albedo[rows] += lobe.albedo
                    if lobe.diffuse if lobe.counts_as_diffuse is None else lobe.counts_as_diffuse:
                        shading.diffuse_albedo[rows] += lobe.albedo
                    singular = isinstance(lobe, Subsurface) or getattr(lobe, "singular", False)
                    shading.scatters[rows] |= (lobe.weight.mean(1) >= CUTOFF) & ~np.asarray(singular)
            if lobes:
                shading.groups.append((rows, lobes))
        return shading

    def exits(self, surface: Surface, footprint: np.ndarray) -> Shading:
        """White diffuse surfaces where light leaves from below; bumped as what it has scattered in would be there."""
        shading = Shading(surface)
        for index, rows in self._groups(surface):
            part, normal = surface.select(rows), surface.ns[rows]
            if any(
                node.kind in ("subsurface", "principled") and node["normal"] is not None
                for node in self.graphs[index].nodes()
            ):
                builder = Builder(
                    Points(self.graphs[index], part, self.geometry, self.scene.images, footprint[rows]), self.table
                )
                builder.build(self.graphs[index].surface)
                bent = sum(
                    (
                        lobe.normal * lobe.weight.mean(1, keepdims=True)
                        for lobe in builder.lobes
                        if isinstance(lobe, Subsurface)
                    ),
                    np.zeros((len(rows), 3)),
                )
                normal = np.where((dot(bent, bent) > 0.0)[:, None], normalize(bent), normal)
            shading.groups.append((rows, [Diffuse(np.ones((len(rows), 3)), normal)]))
            shading.scatters[rows] = True
        return shading

    def transparency(self, surface: Surface) -> np.ndarray:
        """What passes straight through (N, 3)."""
        result = np.zeros((len(surface.distance), 3))
        for index, rows in self._groups(surface):
            if self.clear[index]:
                part = surface.select(rows)
                part.ray_kind = np.full(len(rows), int(Ray.SHADOW))
                graph = self.graphs[index]
                points = Points(graph, part, self.geometry, self.scene.images, np.zeros(len(rows)))
                result[rows] = self._clear(points, graph)
        return result

    def _clear(self, points: Points, graph: Graph) -> np.ndarray:
        """What passes straight through, and portals where anything does (N, 3)."""
        portals, clear = np.zeros((2, points.count, 3))
        for node, weight in leaves(graph.surface, points, np.ones(points.count)):
            if node.kind == "transparent":
                clear += weight[:, None] * np.maximum(points.input(node, "color"), 0.0)
            elif node.kind == "ray_portal":
                portals += weight[:, None] * np.maximum(points.input(node, "color"), 0.0)
            elif node.kind == "principled" and np.any(points.input(node, "thin_wall") > 0.0):
                builder = Builder(points, self.table)
                builder._principled(node, weight[:, None])
                clear += sum(lobe.weight for lobe in builder.lobes if isinstance(lobe, Straight))
            elif node.kind == "principled":
                clear += (weight * (1.0 - np.clip(points.input(node, "alpha"), 0.0, 1.0)))[:, None]
        return clear + np.where((clear.mean(1) >= CUTOFF)[:, None], portals, 0.0)


def _may_emit(graph: Graph) -> bool:
    def zero(value):
        return isinstance(value, (float, tuple)) and not isinstance(value, Vector) and not np.any(value)

    return any(
        node.kind == "emission"
        and not zero(node["strength"])
        and not zero(node["color"])
        or node.kind == "principled"
        and not zero(node["emission_strength"])
        and not zero(node["emission_color"])
        for node in graph.nodes()
    )


def _may_pass(graph: Graph) -> bool:
    return any(
        node.kind == "transparent" or node.kind == "principled" and (node["alpha"] != 1.0 or node["thin_wall"] != 0.0)
        for node in graph.nodes()
    )


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


class Builder:
    """Lobes, emission (N, 3) and holdout (N,) of one material at ``points``."""

    def __init__(self, points: Points, table: Table):
        self.points, self.table, self.surface = points, table, points.surface
        self.emission, self.holdout = np.zeros((points.count, 3)), np.zeros(points.count)
        self.lobes: list[Lobe] = []

    def build(self, surface) -> None:
        """Add all closures of the node that a material ends in."""
        if surface is not None and not isinstance(surface, Node):
            surface = Node("emission", {"color": surface})
        for node, weight in leaves(surface, self.points, np.ones(self.points.count)):
            method = getattr(self, "_" + node.kind, None)
            if node.kind in bsdfs.NODES:
                bsdfs.NODES[node.kind](self, node, weight[:, None])
            elif method is None:  # a value where a closure is wanted is light, as in Blender
                self.emission += weight[:, None] * self.points.value(node, 3)
            else:
                method(node, weight[:, None])

    def color(self, node: Node, name: str = "color") -> np.ndarray:
        """An input as RGB (N, 3), not negative."""
        return np.maximum(self.points.input(node, name), 0.0)

    def fraction(self, node: Node, name: str) -> np.ndarray:
        """An input held to 0 … 1."""
        return np.clip(self.points.input(node, name), 0.0, 1.0)

    # --- closures of one lobe -----------------------------------------------------------------------------------------

    def _holdout(self, node, weight):
        self.holdout += weight[:, 0]

    def _emission(self, node, weight):
        self.emission += weight * self.points.input(node, "color") * self.points.input(node, "strength")[:, None]

    def _transparent(self, node, weight):
        self.lobes.append(Straight(weight * self.color(node), self.surface.ns))

    def _translucent(self, node, weight):
        # As in Cycles, though nothing mirrors here.
        normal = specular_normal(self.surface, self.points.normal(node))
        self.lobes.append(Translucent(weight * self.color(node), normal))

    def _diffuse(self, node, weight):
        self._add_diffuse(weight, self.color(node), self.points.input(node, "roughness"), self.points.normal(node))

    def _add_diffuse(self, weight, color, roughness, normal):
        if np.any(roughness >= 1e-5):
            self.lobes.append(OrenNayar(weight * color, normal, color=color, roughness=roughness))
        else:
            self.lobes.append(Diffuse(weight * color, normal))

    def _subsurface(self, node, weight):
        color = self.color(node)
        radius = self.points.input(node, "radius") * self.points.input(node, "scale")[:, None]
        self._scatter_below(
            node,
            np.repeat(weight, 3, 1) * color,
            color,
            radius,
            self.points.input(node, "anisotropy"),
            self.points.input(node, "ior"),
            self.fraction(node, "roughness"),
        )

    def _scatter_below(self, node, weight, color, radius, anisotropy, ior, alpha):
        normal = specular_normal(self.surface, self.points.normal(node))
        shallow, lobe = scattering(
            node, self.surface, color, weight, np.maximum(radius, 0.0), anisotropy, ior, alpha, normal
        )
        self.lobes += [Diffuse(shallow, normal), lobe]

    def _glossy(self, node, weight):
        color, roughness = self.color(node), self.fraction(node, "roughness")
        normal = specular_normal(self.surface, self.points.normal(node))
        weight = weight * color
        lobe = glossy_facets(
            self.points,
            node,
            Microfacet(weight, normal, alpha=roughness**2, ior=np.ones(self.points.count), term=NONE, transmits=False),
        )
        if not isinstance(lobe, Microfacet):  # of Ashikhmin and Shirley
            self.lobes.append(lobe)
            return
        roughness = mean_roughness(lobe)
        if _compensated(node):
            lobe.weight = weight * self._gain(normal, roughness, color)
        lobe.albedo = lobe.weight * self._lossless(normal, roughness)
        self.lobes.append(lobe)

    def _metallic(self, node, weight):
        roughness, normal = self.fraction(node, "roughness"), specular_normal(self.surface, self.points.normal(node))
        weight, white = np.repeat(weight, 3, 1), np.ones(self.points.count)
        if node.settings.get("fresnel_type") == "PHYSICAL_CONDUCTOR":
            self._conductor(
                node,
                Microfacet(
                    weight,
                    normal,
                    alpha=roughness**2,
                    ior=white,
                    term=CONDUCTOR,
                    transmits=False,
                    n=self.color(node, "ior"),
                    k=self.color(node, "extinction"),
                ),
            )
            return
        lobe = metal_facets(
            self.points,
            node,
            Microfacet(
                weight,
                normal,
                alpha=roughness**2,
                ior=white,
                term=F82,
                transmits=False,
                f0=self.fraction(node, "base_color"),
                tint=self.fraction(node, "edge_tint"),
            ),
        )
        self._finish_metal(node, lobe, mean_roughness(lobe))
        film = covered(lobe)[:, None]
        if np.any(film):
            lobe.albedo = np.where(film, lobe.weight * lobe.fresnel(dot(lobe.normal, self.surface.wo))[0], lobe.albedo)

    def _conductor(self, node, lobe):
        lobe = metal_facets(self.points, node, lobe)
        roughness = mean_roughness(lobe)
        if _compensated(node):
            # The mean reflectance of F82 that has the same values at 0° and 82°.
            at_0, at_82 = (
                conductor_reflectance(np.full((1, 1), cosine), lobe.n, lobe.k) for cosine in (1.0, 1.0 / 7.0)
            )
            edge = (at_0 + (1.0 - at_0) * (6 / 7) ** 5 - at_82) / (1 / 7 * (6 / 7) ** 6)
            mean = np.clip(at_0 + (1.0 - at_0) / 21.0 - edge / 126.0, 0.0, 1.0)
            lobe.weight = lobe.weight * self._gain(lobe.normal, roughness, mean)
        smooth = lobe.fresnel(dot(lobe.normal, self.surface.wo))[0]
        lobe.albedo = lobe.weight * smooth * self._lossless(lobe.normal, roughness)
        self.lobes.append(lobe)

    def _sheen(self, node, weight):
        color, normal = weight * self.color(node), self.points.normal(node)
        if node.settings.get("distribution") == "ASHIKHMIN":
            self.lobes.append(Velvet(color, normal, sigma=np.maximum(self.fraction(node, "roughness"), 0.01)))
        else:
            self._add_sheen(color, normal, self.points.input(node, "roughness"))

    def _refraction(self, node, weight):
        ior = self._relative(np.maximum(self.points.input(node, "ior"), 1e-5))
        self.lobes.append(
            glass_facets(
                self.points,
                node,
                Microfacet(
                    weight * self.color(node),
                    specular_normal(self.surface, self.points.normal(node)),
                    alpha=self.fraction(node, "roughness") ** 2,
                    ior=ior,
                    term=NONE,
                    transmits=True,
                ),
                self.surface.backfacing,
            )
        )

    def _glass(self, node, weight):
        ior, color = np.maximum(self.points.input(node, "ior"), 1e-5), self.color(node)
        normal = specular_normal(self.surface, self.points.normal(node))
        f0 = np.repeat(f0_of_ior(ior)[:, None], 3, 1)
        self._add_glass(node, np.repeat(weight, 3, 1), normal, self.fraction(node, "roughness"), ior, f0, color, color)

    def _relative(self, ior):
        return np.where(self.surface.backfacing, 1.0 / ior, ior)

    def _add_glass(self, node, weight, normal, roughness, ior, f0, reflection, transmission):
        ior = self._relative(ior)
        if _compensated(node):
            weight = weight * self._gain(normal, roughness, transmission, ior)
        lobe = Microfacet(
            weight,
            normal,
            alpha=roughness**2,
            ior=ior,
            term=DIELECTRIC,
            f0=np.clip(f0, 0.0, 1.0),
            transmits=True,
            reflection=reflection,
            transmission=transmission,
        )
        if node.kind == "principled":
            lobe = principled_facets(self.points, node, lobe, self.surface.backfacing)
        else:
            lobe = glass_facets(self.points, node, lobe, self.surface.backfacing)
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
                for name, rest in (("", (cosine, roughness)), ("_average", (roughness,)))
            )
        missing = np.where((1.0 - e) / e < 1e-4, 0.0, (1.0 - e) / e)[:, None]
        f, mean = np.minimum(single, 1.0), mean[:, None]
        return 1.0 + missing * f * mean / (1.0 - f * (1.0 - mean))

    # --- Principled ---------------------------------------------------------------------------------------------------

    def _principled(self, node, weight):
        surface, points = self.surface, self.points
        weight = np.repeat(weight, 3, 1)
        alpha = self.fraction(node, "alpha")[:, None]
        if np.any(alpha < 1.0):
            self.lobes.append(Straight(weight * (1.0 - alpha), surface.ns))
            weight = weight * alpha
        normal = points.normal(node)
        weight = self._sheen_layer(node, weight, normal)
        weight = self._coat(node, weight)
        strength = points.input(node, "emission_strength")[:, None]
        self.emission += weight * points.input(node, "emission_color") * strength

        base, tint = self.color(node, "base_color"), self.color(node, "specular_tint")
        color, roughness = np.minimum(base, 1.0), self.fraction(node, "roughness")
        mirror = specular_normal(surface, normal)
        metallic = self.fraction(node, "metallic")[:, None]
        if np.any(metallic > CUTOFF):
            self._metal(node, weight * metallic, mirror, roughness, color, np.minimum(tint, 1.0))
            weight = weight * (1.0 - metallic)
        ior = np.maximum(points.input(node, "ior"), 1e-5)
        f0 = f0_of_ior(ior)
        transmission = self.fraction(node, "transmission_weight")[:, None]
        if np.any(transmission > CUTOFF):
            # Two crossings tint by the colour.
            thin, share = points.input(node, "thin_wall")[:, None] > 0.0, weight * transmission
            if np.any(thin):
                self._add_pane(node, share * thin, mirror, roughness, ior, tint, color)
            if not np.all(thin):
                self._add_glass(
                    node, share * ~thin, mirror, roughness, ior, tint * f0[:, None], np.ones_like(color), np.sqrt(color)
                )
            weight = weight * (1.0 - transmission)
        level = np.maximum(points.input(node, "specular_ior_level"), 0.0)
        f0 = f0 * 2.0 * level
        root = np.sqrt(np.clip(f0, 0.0, 0.99))
        adjusted = (1.0 + root) / (1.0 - root)
        ior = np.where(level == 0.5, ior, np.where(ior < 1.0, 1.0 / adjusted, adjusted))
        if np.any(ior != 1.0) or np.any(points.input(node, "thin_film_thickness") > THINNEST_FILM):
            weight = self._layer(weight, mirror, roughness, ior, tint * f0[:, None], _compensated(node), node)
        weight = self._principled_below(node, weight, color, roughness, ior)
        self._add_diffuse(weight, base, self.fraction(node, "diffuse_roughness"), normal)

    def _add_pane(self, node, weight, normal, roughness, ior, tint, color):
        """A thin wall as OpenPBR 1.1 has it: any number of bounces between its sides."""
        white, cosine = np.ones_like(color), dot(normal, self.surface.wo)
        film = self.points.input(node, "thin_film_thickness")
        side = as_facets(
            Microfacet(
                weight,
                normal,
                alpha=roughness**2,
                ior=ior,
                term=DIELECTRIC,
                f0=np.clip(tint * f0_of_ior(ior)[:, None], 0.0, 1.0),
                transmits=True,
                reflection=white,
                transmission=white,
            ),
            thickness=np.where(film > THINNEST_FILM, film, 0.0),
            film=np.maximum(self.points.input(node, "thin_film_ior"), 1e-5),
        )
        r, t = side.fresnel(cosine)
        bent = np.sqrt(np.maximum(1.0 - (1.0 - cosine**2) / ior**2, 0.0))
        inner = as_facets(side, ior=1.0 / ior, film=side.film / ior)
        back, out = (
            np.where(covered(side)[:, None], inside, outside) for inside, outside in zip(inner.fresnel(bent), (r, t))
        )
        kept = np.where(bent[:, None] > 0.0, color ** (1.0 / np.maximum(bent, 1e-6))[:, None], 0.0)
        through = kept * t * out / np.maximum(1.0 - (back * kept) ** 2, 1e-9)
        through = np.where(bent[:, None] > 0.0, through, 0.0)
        mirror = Microfacet(
            weight * (r + through * back * kept),
            normal,
            alpha=roughness**2,
            ior=np.ones(len(ior)),
            term=NONE,
            transmits=False,
        )
        mirror.weight = mirror.weight * self._gain(normal, roughness, tint)
        mirror.albedo = mirror.weight * self._lossless(normal, roughness)
        self.lobes.append(mirror)
        alpha = np.clip(
            roughness**2 * np.sqrt(np.maximum(3.4 * (ior - 1.0) * (ior - 0.5) ** 2 / ior**3, 0.0)), 0.0, 1.0
        )
        straight = ((alpha**2 <= SINGULAR_ALPHA2) & (self.surface.ray_kind != Ray.CAMERA))[:, None]
        through = weight * through
        if np.any(straight):
            self.lobes.append(Straight(through * straight, self.surface.ns))
        if not np.all(straight):
            gain = self._gain(normal, np.sqrt(alpha), white)
            self.lobes.append(
                Pane(
                    through * gain * ~straight,
                    normal,
                    albedo=through * ~straight,
                    alpha=alpha,
                    ior=np.ones(len(ior)),
                    term=NONE,
                    transmits=False,
                )
            )

    def _principled_below(self, node, weight, color, roughness, ior):
        """Scattering below the surface, or within a thin wall; the weight of what is diffuse."""
        points, amount = self.points, self.fraction(node, "subsurface_weight")[:, None]
        if not np.any(amount > CUTOFF):
            return weight
        below, anisotropy = weight * amount * color, points.input(node, "subsurface_anisotropy")
        thin = (points.input(node, "thin_wall") > 0.0)[:, None]
        if np.any(thin):
            back = np.clip(0.5 - 0.5 * anisotropy, 0.0, 1.0)[:, None]
            normal = points.normal(node)
            self._add_diffuse(
                below / np.where(color > 0.0, color, 1.0) * thin * back,
                color,
                self.fraction(node, "diffuse_roughness"),
                normal,
            )
            self.lobes.append(Translucent(below * thin * (1.0 - back), normal))
        if not np.all(thin):
            if node.settings.get("subsurface_method") == "RANDOM_WALK_SKIN":
                ior = points.input(node, "subsurface_ior")
            radius = points.input(node, "subsurface_radius") * points.input(node, "subsurface_scale")[:, None]
            self._scatter_below(node, below * ~thin, color, radius, anisotropy, ior, roughness**2)
        return weight * (1.0 - amount)

    def _below(self, weight, reflected):
        """What a layer that reflects ``reflected`` leaves of ``weight``: the same share of all colours."""
        share = np.where(weight > 0.0, reflected / np.where(weight > 0.0, weight, 1.0), 0.0)
        return weight * np.clip(1.0 - share.max(1, keepdims=True), 0.0, 1.0)

    def _layer(self, weight, normal, roughness, ior, f0, compensated, node=None):
        """A clear reflecting layer; the weight of what lies below it. ``node`` may make it anisotropic, and add a film."""
        f0 = np.clip(f0, 0.0, 1.0)
        lobe = Microfacet(
            weight,
            normal,
            alpha=roughness**2,
            ior=ior,
            term=DIELECTRIC,
            f0=f0,
            transmits=False,
            reflection=np.ones_like(f0),
            transmission=np.zeros_like(f0),
        )
        if node is not None:
            lobe = principled_facets(self.points, node, lobe, self.surface.backfacing)
        roughness = mean_roughness(lobe)
        cosine = cosine_axis(dot(normal, self.surface.wo))
        share = self.table("dielectric", ior_axis(ior), cosine, roughness)[:, None]
        gain = 1.0
        if compensated:
            # Average of a dielectric's reflectance over the hemisphere: fits of Kulla and Conty 2017.
            mean = np.where(
                ior < 1.0,
                0.997118 + ior * (0.1014 - ior * (0.965241 + ior * 0.130607)),
                (ior - 1.0) / (4.08567 + 1.00071 * ior),
            )
            bottom = f0_of_ior(ior)
            mean = np.clip((mean - bottom) / (1.0 - bottom), 0.0, 1.0)[:, None]
            gain = self._gain(normal, roughness, f0 + (1.0 - f0) * mean)
        e = self._lossless(normal, roughness)
        reflected = f0 * e + (1.0 - f0) * share
        film = covered(lobe)[:, None]
        if np.any(film):
            smooth = lobe.fresnel(dot(normal, self.surface.wo))[0]
            reflected = np.where(film, smooth * e, reflected)
        lobe.weight, lobe.albedo = weight * gain, weight * gain * reflected
        self.lobes.append(lobe)
        # As in Cycles, a layer that loses energy takes as much from what is below as one that does not.
        return self._below(weight, lobe.albedo if compensated else lobe.albedo / e)

    def _metal(self, node, weight, normal, roughness, color, tint):
        lobe = Microfacet(
            weight, normal, alpha=roughness**2, ior=np.ones(len(color)), term=F82, f0=color, tint=tint, transmits=False
        )
        lobe = principled_facets(self.points, node, lobe, self.surface.backfacing)
        self._finish_metal(node, lobe, mean_roughness(lobe))

    def _finish_metal(self, node, lobe, roughness):
        color, tint = lobe.f0, lobe.tint
        schlick = self.table("schlick", cosine_axis(dot(lobe.normal, self.surface.wo)), roughness)[:, None]
        if _compensated(node):
            mu, step = np.polynomial.legendre.leggauss(16)
            mu, step = 0.5 + 0.5 * mu, 0.5 * step
            edge = (color + (1.0 - color) * (6 / 7) ** 5) * (1.0 - tint) / (1 / 7 * (6 / 7) ** 6)
            average = sum(
                2.0 * m * s * (color + (1.0 - color) * (1.0 - m) ** 5 - edge * m * (1.0 - m) ** 6)
                for m, s in zip(mu, step)
            )
            lobe.weight = lobe.weight * self._gain(lobe.normal, roughness, average)
        lobe.albedo = lobe.weight * (color * self._lossless(lobe.normal, roughness) + (1.0 - color) * schlick)
        self.lobes.append(lobe)

    def _sheen_layer(self, node, weight, normal):
        amount = np.maximum(self.points.input(node, "sheen_weight"), 0.0)[:, None]
        if not np.any(amount):
            return weight
        if node["coat_normal"] is not None and node["coat_normal"] != node["normal"]:
            blend = self.fraction(node, "coat_weight")[:, None]
            normal = normalize((1.0 - blend) * normal + blend * self.points.normal(node, "coat_normal"))
        own = self._add_sheen(
            weight * self.color(node, "sheen_tint") * amount, normal, self.points.input(node, "sheen_roughness")
        )
        return self._below(weight, own)

    def _add_sheen(self, weight, normal, roughness):
        """Add sheen of a weight; what it reflects of it."""
        y = np.clip(roughness, LOWEST_SHEEN, 1.0)
        x = np.clip(dot(normal, self.surface.wo), 0.0, 1.0)
        # Fits of MaterialX 1.39 to the tables of Zeltner et al. 2022: albedo and the inverse transform.
        width = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y))
        middle = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y)
        offset = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y))
        reflected = np.exp(-0.5 * ((x - middle) / width) ** 2) / (width * np.sqrt(2.0 * np.pi)) + offset
        a = (2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y)
        b = np.sqrt(1.0 - x) * (y - 1.0) * y**3
        b = b / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y)
        usable = (reflected > CUTOFF) & (np.abs(a) >= CUTOFF)
        own = weight * np.where(usable, reflected, 0.0)[:, None]
        self.lobes.append(Sheen(own, normal, a=np.where(usable, a, 1.0), b=b))
        return own

    def _coat(self, node, weight):
        amount = self.fraction(node, "coat_weight")[:, None]
        if not np.any(amount > CUTOFF):
            return weight
        ior = np.maximum(self.points.input(node, "coat_ior"), 1.0)
        normal = specular_normal(self.surface, self.points.normal(node, "coat_normal"))
        f0 = np.repeat(f0_of_ior(ior)[:, None], 3, 1)
        below = self._layer(weight * amount, normal, self.fraction(node, "coat_roughness"), ior, f0, True)
        # Beer's law along the refracted ray; the tint is that of a ray straight in and out.
        depth = 1.0 / np.sqrt(1.0 - (1.0 - dot(normal, self.surface.wo) ** 2) / ior**2)
        tint = self.color(node, "coat_tint") ** depth[:, None]
        return (weight * (1.0 - amount) + below) * (1.0 - amount + amount * tint)


def _compensated(node: Node) -> bool:
    return node.settings.get("distribution", "MULTI_GGX") == "MULTI_GGX"
