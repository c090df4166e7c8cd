# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From nodes to the lobes of ``special.py``, for ``materials.py``."""

from __future__ import annotations

import numpy as np

from ..material import Node
from .closures import F82, Lobe, Microfacet
from .rare import AshikhminShirley
from .special import THINNEST_FILM, Facets
from .vectors import dot, normalize


def radial(points) -> np.ndarray:
    """Directions (N, 3) around the z axis of the generated coordinates at points, transformed to the world like
    normals."""
    surface, geometry = points.surface, points.geometry
    result = np.zeros((points.count, 3))
    for index in np.unique(surface.instance):
        rows = surface.instance == index
        positions = geometry.scene.meshes[geometry.mesh_of[index]].positions.astype(float)
        low, high = positions.min(0), positions.max(0)
        inverse = np.linalg.inv(geometry.matrices[index])
        local = surface.position[rows] @ inverse[:3, :3].T + inverse[:3, 3]
        place = (local - 0.5 * (low + high)) / np.where(high > low, high - low, 1.0)
        around = np.stack([-place[:, 1], place[:, 0], np.zeros(len(place))], -1)
        result[rows] = around @ inverse[:3, :3]
    n = surface.ns
    return np.cross(n, normalize(np.cross(result, n)))


def turned(v: np.ndarray, axis: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """v (N, 3) rotated about unit vectors by so many turns (N,)."""
    along = dot(v, axis)[:, None] * axis
    c, s = np.cos(2.0 * np.pi * turns)[:, None], np.sin(2.0 * np.pi * turns)[:, None]
    return along + c * (v - along) + s * np.cross(axis, v)


def tangent(points, node: Node, axis: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Tangents (N, 3) of a node, rotated about ``axis``."""
    given = radial(points) if node["tangent"] is None else points.value(node["tangent"], 3)
    return turned(given, axis, turns)


def as_facets(lobe: Microfacet, **changes) -> Facets:
    """A lobe of plain microfacets as one of ``Facets``, isotropic and without film unless ``changes`` say otherwise."""
    count = len(lobe.alpha)
    values = {
        **vars(lobe),
        "across": lobe.alpha,
        "tangent": np.zeros((count, 3)),
        "beckmann": False,
        "thickness": np.zeros(count),
        "film_ior": np.ones(count),
        **changes,
    }
    return Facets(**values)


def principled_facets(points, node: Node, lobe: Microfacet, backfacing: np.ndarray) -> Microfacet:
    """Microfacets (N points) of Principled, some of them ``backfacing`` (N,), with the anisotropy and the film of the
    node."""
    anisotropy = np.clip(points.input(node, "anisotropic"), 0.0, 1.0)
    thickness = points.input(node, "thin_film_thickness")
    if lobe.term == F82 and not node.settings.get("film_on_metal", True):
        thickness = np.zeros_like(thickness)
    if not np.any(anisotropy > 0.0) and not np.any(thickness > THINNEST_FILM):
        return lobe
    film = np.maximum(points.input(node, "thin_film_ior"), 1e-5)
    changes = dict(thickness=np.where(thickness > THINNEST_FILM, thickness, 0.0), film_ior=film)
    if lobe.transmits:
        changes["film_ior"] = np.where(backfacing, film * lobe.ior, film)
    elif np.any(anisotropy > 0.0):
        aspect = np.sqrt(1.0 - 0.9 * anisotropy)
        axis, turns = points.normal(node), points.input(node, "anisotropic_rotation")
        changes |= dict(
            alpha=np.minimum(lobe.alpha / aspect, 1.0),
            across=lobe.alpha * aspect,
            tangent=tangent(points, node, axis, turns),
        )
    return as_facets(lobe, **changes)


def mean_roughness(lobe: Microfacet) -> np.ndarray:
    """Roughness (N,) for the look-up of a lobe's albedo."""
    return np.sqrt(np.sqrt(lobe.alpha * lobe.across)) if isinstance(lobe, Facets) else np.sqrt(lobe.alpha)


def covered(lobe: Microfacet) -> np.ndarray:
    """Rows (N,) that have a film."""
    return lobe.thickness > 0.0 if isinstance(lobe, Facets) else np.zeros(len(lobe.alpha), bool)


def glossy_facets(points, node: Node, lobe: Microfacet) -> Lobe:
    """Microfacets of Glossy with the anisotropy and the distribution of the node."""
    anisotropy = np.clip(points.input(node, "anisotropy"), -0.99, 0.99)
    distribution = node.settings.get("distribution", "MULTI_GGX")
    changes = {"beckmann": True} if distribution == "BECKMANN" else {}
    if np.any(np.abs(anisotropy) > 1e-4):
        wide = 1.0 / (1.0 - np.abs(anisotropy))
        changes |= dict(
            alpha=np.minimum(lobe.alpha * np.where(anisotropy < 0.0, wide, 1.0 / wide), 1.0),
            across=np.minimum(lobe.alpha * np.where(anisotropy < 0.0, 1.0 / wide, wide), 1.0),
            tangent=tangent(points, node, lobe.normal, points.input(node, "rotation")),
        )
    if distribution == "ASHIKHMIN_SHIRLEY":
        alpha, across = changes.get("alpha", lobe.alpha), changes.get("across", lobe.alpha)
        return AshikhminShirley(
            lobe.weight,
            lobe.normal,
            alpha=np.maximum(alpha, 1e-4),
            across=np.maximum(across, 1e-4),
            tangent=changes.get("tangent", np.zeros((len(alpha), 3))),
        )
    return as_facets(lobe, **changes) if changes else lobe


def metal_facets(points, node: Node, lobe: Microfacet) -> Facets:
    """Microfacets of Metallic with the anisotropy, the film and the distribution of the node."""
    anisotropy, thickness = (
        np.clip(points.input(node, "anisotropy"), 0.0, 1.0),
        points.input(node, "thin_film_thickness"),
    )
    changes = dict(
        beckmann=node.settings.get("distribution", "MULTI_GGX") == "BECKMANN",
        thickness=np.where(thickness > THINNEST_FILM, thickness, 0.0),
        film_ior=np.maximum(points.input(node, "thin_film_ior"), 1e-5),
    )
    if np.any(anisotropy > 0.0):
        aspect = np.sqrt(1.0 - 0.9 * anisotropy)
        changes |= dict(
            alpha=np.minimum(lobe.alpha / aspect, 1.0),
            across=lobe.alpha * aspect,
            tangent=tangent(points, node, points.normal(node), points.input(node, "rotation")),
        )
    return as_facets(lobe, **changes)


def glass_facets(points, node: Node, lobe: Microfacet, backfacing: np.ndarray) -> Microfacet:
    """Microfacets of Glass or Refraction, some of them ``backfacing`` (N,), with the film and the distribution of the
    node."""
    beckmann, filmed = node.settings.get("distribution", "MULTI_GGX") == "BECKMANN", node.kind == "glass"
    thickness = points.input(node, "thin_film_thickness") if filmed else np.zeros(points.count)
    if not beckmann and not np.any(thickness > THINNEST_FILM):
        return lobe
    film = np.maximum(points.input(node, "thin_film_ior"), 1e-5) if filmed else np.ones(points.count)
    return as_facets(
        lobe,
        beckmann=beckmann,
        thickness=np.where(thickness > THINNEST_FILM, thickness, 0.0),
        film_ior=np.where(backfacing, film * lobe.ior, film),
    )
