# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair, and Principled Hair, over arrays of points: from nodes to the lobes of
``fibers.py``. See ``bsdfs/__init__.py``."""

from __future__ import annotations

import numpy as np

from ...material import Node
from ...scene import Primitive
from ..closures import Lobe, Straight, dielectric, specular_normal
from ..fibers import EUMELANIN, PHEOMELANIN, Chiang, Hair, Huang, absorption_of, cosine_of
from ..vectors import dot, normalize


def _hair(points, node: Node, weight: np.ndarray, normal: np.ndarray) -> Lobe:
    given, strand = node["tangent"] is not None, points.surface.strand > 0
    tilt = -points.input(node, "offset")
    if given:
        tangent = normalize(points.value(node["tangent"], 3))
    else:  # on a mesh the direction of hair is unknown
        edges = points.edges()
        tangent = normalize(np.where(strand[:, None], edges[:, 0], edges[:, 1]))
        tilt = np.where(strand, tilt, 0.0)
    return Hair(
        weight,
        normal,
        facing=points.surface.ng,
        strand=strand,
        tangent=tangent,
        tilt=tilt,
        transmits=node.settings.get("component") == "TRANSMISSION",
        along=np.clip(points.input(node, "roughness_u"), 0.001, 1.0),
        around=np.clip(points.input(node, "roughness_v"), 0.001, 1.0),
    )


def _absorption(points, node: Node, roughness: np.ndarray) -> np.ndarray:
    parametrization = node.settings.get("parametrization", "COLOR")
    if parametrization == "ABSORPTION":
        return points.input(node, "absorption_coefficient")
    if parametrization == "COLOR":
        return absorption_of(points.input(node, "color"), roughness)
    varied = 1.0 + 2.0 * (points.input(node, "random") - 0.5) * np.clip(points.input(node, "random_color"), 0.0, 1.0)
    amount = -np.log(np.maximum(1.0 - points.input(node, "melanin") * varied, 1e-4))[:, None]
    red = points.input(node, "melanin_redness")[:, None]
    return amount * ((1.0 - red) * EUMELANIN + red * PHEOMELANIN) + absorption_of(points.input(node, "tint"), roughness)


def _principled_hair(points, node: Node, weight: np.ndarray, table) -> Lobe:
    """``table``: the albedos of ``materials.Table``."""
    surface = points.surface
    varied = 1.0 + 2.0 * (points.input(node, "random") - 0.5) * points.input(node, "random_roughness")
    roughness, huang = points.input(node, "roughness") * varied, node.settings.get("model") == "HUANG"
    radial = roughness if huang else points.input(node, "radial_roughness") * varied
    tangent = normalize(points.edges()[:, 0])
    shared = dict(
        weight=np.repeat(weight, 3, 1),
        normal=surface.ns,
        smooth=surface.ns,
        facing=surface.ng,
        strand=surface.strand > 0,
        cuts=(surface.strand == 0) & (node.settings.get("light_rays") != "ALL"),
        tangent=tangent,
        sigma=_absorption(points, node, radial),
        ior=points.input(node, "ior"),
        tilt=-points.input(node, "offset"),
    )
    if huang:

        def glass(name, rough, cosine, ior):
            return table(name, np.sqrt(np.abs((ior - 1.0) / (ior + 1.0))), np.sqrt(np.maximum(cosine, 0.0)), rough)

        factors = np.stack(
            [np.maximum(points.input(node, name), 0.0) for name in ("r_lobe", "tt_lobe", "trt_lobe")], -1
        )
        lobe = Huang(
            **shared,
            alpha=np.clip(roughness, 0.001, 1.0),
            factors=factors,
            glass=glass,
            aspect=np.maximum(points.input(node, "aspect_ratio"), 1e-3),
        )
        lobe.albedo = lobe.weight * _estimated(lobe, surface.wo)
        return lobe
    coat, s = np.clip(points.input(node, "coat"), 0.0, 1.0), np.clip(radial, 0.001, 1.0)
    x = normalize(np.cross(tangent, surface.wo))
    offset = dot(np.cross(surface.ng, tangent), np.cross(tangent, x))
    offset = np.clip(np.where(surface.strand == Primitive.RIBBONS, -surface.barycentric[:, 2], offset), -1.0, 1.0)
    lobe = Chiang(
        **shared,
        offset=offset,
        v=_variance(roughness),
        v0=_variance((1.0 - coat) * np.clip(roughness, 0.001, 1.0)),
        s=(0.265 * s + 1.194 * s**2 + 5.372 * s**22) * np.sqrt(np.pi / 8.0),
    )
    lobe.albedo = lobe.weight * lobe.orders(surface.wo)[0].sum(0)
    return lobe


def _estimated(lobe: Huang, wo: np.ndarray) -> np.ndarray:
    """(N, 3) how much a fiber scatters, as the path tracer estimates it for its passes."""
    sine = np.clip(dot(lobe.tangent, wo), -1.0, 1.0)
    f = dielectric(0.8 * cosine_of(sine), lobe.ior)[0][:, None]
    kept = np.exp(-lobe.sigma * (1.7 / cosine_of(sine / lobe.ior))[:, None])
    r, tt, trt = lobe.factors.T[:, :, None]
    return r * f + (1.0 - f) ** 2 * (tt * kept + trt * f * kept**2)


def _is_missed(points, node: Node) -> np.ndarray:
    """(N,) whether rays that hit round strands miss the ellipse in them."""
    surface = points.surface
    aspect = np.maximum(points.input(node, "aspect_ratio"), 1e-3)
    aspect = np.minimum(aspect, 1.0 / aspect)
    tangent = surface.tangent
    axis = np.zeros((points.count, 3)) if node["axis"] is None else points.value(node["axis"], 3)
    along = normalize(tangent)
    side = normalize(np.roll(along, 1, 1) - np.roll(along, -1, 1))
    major = normalize(np.cross(tangent, normalize(np.cross(axis, tangent))))
    major = np.where((dot(major, major) > 0.5)[:, None], major, np.cross(along, side))
    x, z = dot(surface.wo, major), dot(surface.wo, normalize(np.cross(major, tangent)))
    radius = np.sqrt(1.0 - (1.0 - aspect**2) * x * x / np.maximum(x * x + z * z, 1e-30))
    place = dot(normalize(np.cross(tangent, surface.wo)), surface.ns)
    place = np.where(surface.strand == Primitive.RIBBONS, surface.barycentric[:, 2], place)
    return (surface.strand > 0) & (np.abs(place) >= radius)


def _variance(roughness: np.ndarray) -> np.ndarray:
    """Chiang et al. 2016, equation 7."""
    x = np.clip(roughness, 0.001, 1.0)
    return (0.726 * x + 0.812 * x**2 + 3.7 * x**20) ** 2


def _add_hair(builder, node, weight):
    normal = specular_normal(builder.surface, builder.surface.ns)
    builder.lobes.append(_hair(builder.points, node, weight * builder.color(node), normal))


def _add_principled_hair(builder, node, weight):
    if node.settings.get("model") == "HUANG":
        missed = _is_missed(builder.points, node)[:, None]
        if missed.any():
            builder.lobes.append(Straight(np.repeat(weight * missed, 3, 1), builder.surface.ns))
            weight = weight * ~missed
    builder.lobes.append(_principled_hair(builder.points, node, weight, builder.table))


NODES = {"hair": _add_hair, "principled_hair": _add_principled_hair}
