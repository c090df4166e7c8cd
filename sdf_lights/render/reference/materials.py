# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All materials of a scene: emission, transmission and scattering of surfaces, by the lobes of ``material_lobes``."""

from __future__ import annotations

import numpy as np

from ...graph.formula import Vector
from ..material import Material, Node
from ..scene import Ray, Scene
from .albedo_tables import Table
from .bsdfs.ray_portal import THROUGH_PORTAL, Portal
from .closures import (
    DIELECTRIC,
    Diffuse,
    Lobe,
    Microfacet,
    Straight,
    Translucent,
    masking,
)
from .fibers import Chiang, Hair
from .geometry import Geometry, Surface
from .material_lobes import CUTOFF, Builder, leaves
from .nodes import Graph, Points
from .rare import AshikhminShirley, Velvet
from .subsurface import Subsurface
from .vectors import dot, normalize

LEAST_LEFT = 0.05  # of the probability of a lobe that loses reflection or refraction, as in the kernels


class Shading:
    """Emission, transmission and scattering of surfaces: lobes for each group of rows that share a material."""

    def __init__(self, surface: Surface):
        self.surface = surface
        count = len(surface.distance)
        self.emission, self.transparency, self.albedo, self.diffuse_albedo = np.zeros((4, count, 3))
        self.holdout, self.scatters, self.portal = np.zeros(count), np.zeros(count, bool), np.zeros(count, bool)
        self.exit = surface.position.copy()  # origins of rays that ``sample`` has sent through a portal
        self.groups: list[tuple[np.ndarray, list[Lobe]]] = []
        self.entered: list[tuple[np.ndarray, Subsurface]] = []  # rows that ``sample`` has sent below the surface

    def select(self, rows: np.ndarray) -> "Shading":
        """The same for some rows, given as indices (n,) or as a mask (N,)."""
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
        """Remove reflection or refraction from microfacets where ``after_diffuse`` (N,): caustics switched off."""
        if reflective and refractive:
            return
        for rows, lobes in self.groups:
            light = np.where(after_diffuse[rows], 0.0, 1.0)[:, None]
            for lobe in lobes:
                if not isinstance(lobe, Microfacet):
                    continue
                if lobe.transmits and lobe.term == DIELECTRIC and (reflective or refractive):
                    parts = [part.mean(1) for part in lobe.fresnel(np.abs(dot(lobe.normal, self.surface.wo[rows])))[:2]]
                    whole, rest = sum(parts), parts[0 if reflective else 1]
                    left = np.maximum(rest, LEAST_LEFT * whole) / np.where(whole > 0.0, whole, 1.0)
                    lobe.albedo = lobe.albedo * np.where(light > 0.0, 1.0, left[:, None])
                    lobe.reflection = lobe.reflection * (1.0 if reflective else light)
                    lobe.transmission = lobe.transmission * (1.0 if refractive else light)
                elif not (refractive if lobe.transmits else reflective):
                    # Black lobes draw no directions: what other lobes scatter there would count as glossy.
                    lobe.weight, lobe.albedo = lobe.weight * light, lobe.albedo * light

    def blur(self, least_pdf: np.ndarray, limit: float) -> None:
        """Raise the roughness of lobes where the ``least_pdf`` (N,) of a path is below ``limit``: Filter Glossy of
        Cycles."""
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
        """f · |cos| (N, 3), of lobes that scatter as one of these ``kinds`` of rays, and pdf (N,) of all lobes that are
        not singular."""
        value, pdf = np.zeros(wi.shape), np.zeros(len(wi))
        for rows, lobes in self.groups:
            part = self.surface.select(rows)
            value[rows], pdf[rows] = _evaluate(part, lobes, wi[rows], kinds)
        return value, pdf

    def sample(self, rng: np.random.Generator):
        """(wi, f · |cos| / pdf, pdf, kind); weight 0: nothing was drawn. pdf is 0 for singular directions. kind is 0
        for straight transmission, THROUGH_PORTAL for rays that continue from ``exit``."""
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
        counts = ((int(Ray.DIFFUSE) if lobe.diffuse and not isinstance(lobe, Velvet) else side) & int(kinds)) != 0
        value += lobe.weight * one * (_bump_shadowing(surface, lobe, wi) * counts)[:, None]
        pdf += pick * density
    return value, pdf


def _bump_shadowing(surface: Surface, lobe: Lobe, wi: np.ndarray) -> np.ndarray:
    """Conty Estevez, Lecocq and Stein 2019, "A microfacet-based shadowing function to solve the bump terminator
    problem"; for specular lobes only the cut at the horizon of the surface."""
    bumped = (lobe.normal != surface.ns).any(1) & (surface.strand == 0)
    cosine, tilt = dot(surface.ns, wi), dot(surface.ns, lobe.normal)
    factor = np.ones(len(wi))
    if lobe.diffuse:
        tilt2 = np.clip(tilt * tilt, 1e-12, 1.0)
        factor = 1.0 / (1.0 + masking(np.minimum(0.125 * (1.0 / tilt2 - 1.0), 1.0), np.minimum(np.abs(cosine), 1.0)))
        factor = np.where(surface.uncorrected, 1.0, factor)
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
        # A direction must leave on the side of its kind, for any shading normal. Curves have no other normal.
        through = (kind[rows] & Ray.TRANSMISSION) != 0
        free = (kind[rows] == 0) | (kind[rows] == THROUGH_PORTAL) | (part.strand > 0)
        valid = (probability > 0.0) & (free | ((dot(part.ng, direction) < 0.0) == through))
        total, density = _evaluate(part, [one.select(rows) for one in lobes], direction)
        valid &= singular | (density > 0.0)
        seen, _ = lobe.evaluate(part.wo, direction)
        own = lobe.whole(part.wo, direction)[0] if isinstance(lobe, (Hair, Chiang)) else seen
        shadowing = _bump_shadowing(part, lobe, direction)[:, None]
        darkened = lobe.diffuse and not isinstance(lobe, Translucent)  # as in Cycles
        total = total + lobe.weight * (own * (shadowing if darkened else 1.0) - seen * shadowing)
        alone = lobe.weight * value / np.where(valid, pick[rows] * probability, 1.0)[:, None]
        mixed = total / np.where(density > 0.0, density, 1.0)[:, None]
        weight[rows] = np.where(valid[:, None], np.where(singular[:, None], alone, mixed), 0.0)
        pdf[rows] = np.where(singular, 0.0, density)
    return wi, weight, pdf, kind, exit_, choice


class Materials:
    """All materials of a scene. ``emissive`` (materials,) marks those whose triangles light sampling uses."""

    def __init__(self, scene: Scene, geometry: Geometry):
        self.scene, self.geometry, self.table = scene, geometry, Table()
        self.materials = scene.materials or [Material("Default", Node("diffuse"))]
        self.graphs = [Graph(material) for material in self.materials]
        self.emissive = np.array([m.sample_emission and _may_emit(g) for m, g in zip(self.materials, self.graphs)])
        passable = np.array([_may_pass(graph) for graph in self.graphs])
        opens = np.array([material.transparent_shadows for material in self.materials])
        self.clear, self.stops = passable & opens, passable & ~opens

    def _groups(self, surface: Surface):
        material = self.geometry.material(surface.instance, surface.triangle)
        for index in np.unique(material):
            yield index, np.flatnonzero(material == index)

    def shade(self, surface: Surface, footprint: np.ndarray, rng: np.random.Generator | None = None) -> Shading:
        """``footprint`` (N,) is the width of a pixel's ray at each point in metres. Without ``rng`` nodes trace no
        rays."""
        shading = Shading(surface)
        for index, rows in self._groups(surface):
            surface.uncorrected[rows] = not self.materials[index].bump_correction
            part = surface.select(rows)
            graph = self.graphs[index]
            points = Points(graph, part, self.geometry, self.scene.images, footprint[rows], rng)
            if graph.normal is not None:
                part.ns = surface.ns[rows] = points.unit_or_own(points.value(graph.normal, 3))
            builder = Builder(points, self.table, self.scene.settings.caustics_reflective)
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
        """White diffuse surfaces where light leaves from below, for footprints (N,) in metres, with the bump of the
        subsurface closures there."""
        shading = Shading(surface)
        for index, rows in self._groups(surface):
            surface.uncorrected[rows] = not self.materials[index].bump_correction
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
        """Straight transmission (N, 3)."""
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
        """Straight transmission, and portals where anything is transmitted (N, 3)."""
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
