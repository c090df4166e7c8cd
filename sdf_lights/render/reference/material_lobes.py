# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the graph of a material to lobes, with the layers of Principled stacked from the top as in Cycles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..material import Node
from ..scene import Ray
from ..tables.sheen import LOWEST_ROUGHNESS, TERMS
from . import bsdfs
from .albedo_tables import Table, cosine_axis, ior_axis
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
    specular_normal,
)
from .nodes import Points
from .rare import Pane, Velvet
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
from .subsurface import scattering
from .vectors import dot, normalize

CUTOFF = 1e-5  # lobes with less weight are left out


def leaves(node, points: Points, weight: np.ndarray) -> Iterator[tuple[Node, np.ndarray]]:
    """Closure nodes below ``node``, without Mix and Add, with their weights (N,)."""
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

    def __init__(self, points: Points, table: Table, reflective_caustics: bool = True):
        self.points, self.table, self.surface = points, table, points.surface
        self.reflective_caustics = reflective_caustics
        self.emission, self.holdout = np.zeros((points.count, 3)), np.zeros(points.count)
        self.lobes: list[Lobe] = []

    def build(self, surface) -> None:
        """Add all closures of the material's last node."""
        if surface is not None and not isinstance(surface, Node):
            surface = Node("emission", {"color": surface})
        for node, weight in leaves(surface, self.points, np.ones(self.points.count)):
            method = getattr(self, "_" + node.kind, None)
            if node.kind in bsdfs.NODES:
                bsdfs.NODES[node.kind](self, node, weight[:, None])
            elif method is None:  # a value at a closure input is light, as in Blender
                self.emission += weight[:, None] * self.points.value(node, 3)
            else:
                method(node, weight[:, None])

    def color(self, node: Node, name: str = "color") -> np.ndarray:
        """An input as RGB (N, 3), not negative."""
        return np.maximum(self.points.input(node, name), 0.0)

    def fraction(self, node: Node, name: str) -> np.ndarray:
        """An input clamped to 0 … 1."""
        return np.clip(self.points.input(node, name), 0.0, 1.0)

    # --- closures of one lobe -----------------------------------------------------------------------------------------

    def _holdout(self, node, weight):
        self.holdout += weight[:, 0]

    def _emission(self, node, weight):
        self.emission += weight * self.points.input(node, "color") * self.points.input(node, "strength")[:, None]

    def _transparent(self, node, weight):
        self.lobes.append(Straight(weight * self.color(node), self.surface.ns))

    def _translucent(self, node, weight):
        # As in Cycles, although nothing is mirrored here.
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
        """Factor that compensates the loss of single scattering: Turquin 2019, coloured as in Kulla and Conty 2017.

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
        """A thin wall as in OpenPBR 1.1: any number of bounces between its sides."""
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
            film_ior=np.maximum(self.points.input(node, "thin_film_ior"), 1e-5),
        )
        r, t = side.fresnel(cosine)
        bent = np.sqrt(np.maximum(1.0 - (1.0 - cosine**2) / ior**2, 0.0))
        inner = as_facets(side, ior=1.0 / ior, film_ior=side.film_ior / ior)
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
        """Subsurface scattering, or scattering in a thin wall. Returns the weight of the diffuse part."""
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
        """The rest of ``weight`` below a layer that reflects ``reflected``: the same fraction for all colours."""
        share = np.where(weight > 0.0, reflected / np.where(weight > 0.0, weight, 1.0), 0.0)
        return weight * np.clip(1.0 - share.max(1, keepdims=True), 0.0, 1.0)

    def _layer(self, weight, normal, roughness, ior, f0, compensated, node=None):
        """A clear reflecting layer. Returns the weight of the layers below. ``node`` may make it anisotropic, and add a
        film."""
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
        cosine = dot(normal, self.surface.wo)
        share = self.table("dielectric", ior_axis(ior), cosine_axis(cosine), roughness)[:, None]
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
        taken = f0 + (1.0 - f0) * self.table("cycles_dielectric", ior_axis(ior), cosine, roughness)[:, None]
        film = covered(lobe)[:, None]
        if np.any(film):
            smooth = lobe.fresnel(cosine)[0]
            reflected, taken = np.where(film, smooth * e, reflected), np.where(film, smooth, taken)
        lobe.weight, lobe.albedo = weight * gain, weight * gain * reflected
        self.lobes.append(lobe)
        # The layers below lose what Cycles' coarse table says. A layer that loses energy takes as much from them as one
        # that does not, and layers that reflect no caustics take nothing.
        below = self._below(weight, weight * gain * taken * (e if compensated else 1.0))
        black = (self.surface.ray_kind == Ray.DIFFUSE) & (not self.reflective_caustics)
        return np.where(black[:, None], weight, below)

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
        film = covered(lobe)[:, None]
        if np.any(film):
            lobe.albedo = np.where(film, lobe.weight * lobe.fresnel(dot(lobe.normal, self.surface.wo))[0], lobe.albedo)
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
        """Add sheen of a weight. Returns its reflection."""
        place = dot(normal, self.surface.wo), np.maximum(roughness, LOWEST_ROUGHNESS)
        reflected, a, b = (self.table(f"sheen_{term}", *place) for term in TERMS)
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
