# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Targets of caustic paths: balls around the mirrors and sharp glass of a scene.

Points of triangles whose materials may be mirrors are shaded, because a texture may decide. Those that are mirrors are
divided into groups, the one that lamps see under the largest angle first, by a plane across its longest side. So a
large sheet of water has many targets, and a far ball has one.
"""

from __future__ import annotations

import numpy as np

from ...frozen import frozen
from ..kernels.caustic_paths.records import TARGET, TARGETS, UNAIMED, UNKNOWN
from ..kernels.caustic_paths.trace import find_mirrors
from ..kernels.shading.material_records import (
    LOBE_GLASS,
    LOBE_GLOSSY,
    LOBE_PRINCIPLED,
    LOBE_REFRACTION,
    NO_GRAPH,
)
from ..scene import Instance, Mesh, Primitive, Ray, Scene
from .block import PackedScene, Workspace

MIRRORS = (LOBE_GLOSSY, LOBE_GLASS, LOBE_REFRACTION, LOBE_PRINCIPLED)
MOST_PIECES, PIECES = 1 << 14, 1 << 10  # of triangles: in all, and of an instance
MOST_INSTANCES = 1 << 11  # of which pieces are shaded
FINE, MOST_SPLITS = 64, 3  # an instance with fewer pieces has its triangles divided in four, so often at most
SMALL = 1e-3  # part of all directions: a target that fills less is not divided
WIDER = 1.0 + 1e-6  # factor of radii, for rounding
SCATTERED = int(Ray.DIFFUSE | Ray.GLOSSY | Ray.TRANSMISSION)


@frozen
class Sources:
    """Where caustic paths start: centers (lamps, 3) and powers (lamps,) of lamps, 0 for those that do not count; and
    areas (lamps,) that they show, about, seen from anywhere (m²)."""

    centers: np.ndarray
    powers: np.ndarray
    areas: np.ndarray

    @classmethod
    def of(cls, lamps: np.ndarray, powers: np.ndarray) -> Sources:
        """Of ``lamps`` (n,) with the powers (n,)."""
        x, y, z = lamps["half"].T
        # A lamp shows more than the shade of a ball of its volume, and less than that of its bounding box.
        filled = np.minimum(lamps["volume"] / np.maximum(8.0 * x * y * z, 1e-300), 1.0)
        areas = np.maximum(2.0 * (x * y + y * z + z * x) * np.sqrt(filled), 1e-300)
        return cls(lamps["center"].copy(), powers, areas)


def may_be_mirrors(packed: PackedScene, known: np.ndarray) -> np.ndarray:
    """(materials,) whether a material has lobes that may be mirrors, by the ``known`` (materials,) of ``records``."""
    kinds = packed.table("lobes")["kind"]
    ranges = packed.table("materials")["lobes"]
    return (known != UNKNOWN) & np.array([np.isin(kinds[first:end], MIRRORS).any() for first, end in ranges], bool)


def find_targets(
    scene: Scene, packed: PackedScene, workspace: Workspace, usable: np.ndarray, sources: Sources
) -> np.ndarray:
    """(targets,) ``TARGET``; none if nothing is a mirror. ``usable``: (materials,) of ``may_be_mirrors``."""
    constant = packed.table("materials")["graph"] == NO_GRAPH
    candidates: list[int] = []
    known: dict[tuple[int, ...], bool] = {}  # whether instances with these materials may have mirrors
    for index, instance in enumerate(scene.instances):
        slots = instance.materials
        if known.get(slots) is False or not int(instance.visibility) & SCATTERED:
            continue
        if scene.meshes[instance.mesh].primitive != Primitive.TRIANGLES:
            continue
        if slots not in known:
            used = list(slots)
            known[slots] = bool(usable[used].any())
            if known[slots] and constant[used].all():  # one instance tells for all
                known[slots] = len(_mirrors_of(scene, workspace, index, usable, PIECES)) > 0
        if known[slots]:
            candidates.append(index)
    candidates = candidates[:: max(-(-len(candidates) // MOST_INSTANCES), 1)]
    limit = max(min(MOST_PIECES // max(len(candidates), 1), PIECES), 1)
    pieces = [_mirrors_of(scene, workspace, index, usable, limit) for index in candidates]
    corners = np.concatenate(pieces) if pieces else np.zeros((0, 3, 3))
    if not len(corners):
        return np.zeros(0, TARGET)
    groups = _divided(corners, sources)
    targets = np.zeros(len(groups), TARGET)
    targets["position"], targets["radius"] = (np.array(values) for values in zip(*(_ball(each) for each in groups)))
    return targets


def put_lines(targets: np.ndarray, chances: np.ndarray, sources: Sources, paths: int) -> None:
    """Fill ``lines`` and ``lamp_pdf`` of the targets, for so many paths of a set, which are aimed by ``chances``
    (lamps, targets)."""
    part = sources.powers / sources.powers.sum()
    apart = np.linalg.norm(targets["position"][None] - sources.centers[:, None], axis=2)
    aimed = (1.0 - UNAIMED) * chances / (4.0 * np.pi * _seen(targets["position"], targets["radius"], sources.centers))
    lines = paths * (part / sources.areas)[:, None] * aimed
    targets["lines"] = lines.sum(axis=0)
    targets["lamp_pdf"] = (lines * apart**2 / sources.areas[:, None]).sum(axis=0) / targets["lines"]


def chances_of(targets: np.ndarray, sources: Sources) -> np.ndarray:
    """(lamps, targets) of each target, for each lamp: by the angle that it fills as seen from the lamp."""
    seen = _seen(targets["position"], targets["radius"], sources.centers)
    return seen / seen.sum(axis=1, keepdims=True)


def _mirrors_of(scene: Scene, workspace: Workspace, index: int, usable: np.ndarray, limit: int) -> np.ndarray:
    """(n, 3, 3) corners, in world space, of pieces of an instance's triangles that are mirrors."""
    instance = scene.instances[index]
    mesh = scene.meshes[instance.mesh]
    primitives = _triangles_with(mesh, instance, usable)
    primitives = primitives[:: max(-(-len(primitives) // limit), 1)].astype(np.int64)
    weights = np.tile([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], (len(primitives), 1, 1))
    for _ in range(MOST_SPLITS):
        if 4 * len(primitives) <= min(limit, 4 * FINE):
            primitives, weights = np.tile(primitives, 4), _in_four(weights)
    found = np.zeros(len(primitives), np.int64)
    middles = np.ascontiguousarray(weights.mean(axis=1))
    find_mirrors(workspace.scene, workspace.block, np.int64(index), primitives, middles, found)
    primitives, weights = primitives[found > 0], weights[found > 0]
    positions = mesh.positions[mesh.triangles[primitives]].astype(float) @ instance.matrix[:3, :3].T
    positions += instance.matrix[:3, 3]
    whole = np.concatenate([1.0 - weights.sum(axis=2, keepdims=True), weights], axis=2)
    return whole @ positions


def _triangles_with(mesh: Mesh, instance: Instance, usable: np.ndarray) -> np.ndarray:
    """Numbers of the triangles that have a ``usable`` material."""
    if mesh.slots is None:
        return np.arange(len(mesh.triangles) if usable[instance.materials[0]] else 0)
    slots = np.minimum(mesh.slots, len(instance.materials) - 1)
    return np.flatnonzero(usable[np.array(instance.materials)][slots])


def _in_four(weights: np.ndarray) -> np.ndarray:
    """(4 n, 3, 2) weights of corners of the quarters of triangles, from those (n, 3, 2) of the triangles."""
    middles = 0.5 * (weights + np.roll(weights, -1, axis=1))
    a, b, c = (weights[:, corner] for corner in range(3))
    ab, bc, ca = (middles[:, corner] for corner in range(3))
    return np.concatenate([np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])


def _ball(corners: np.ndarray) -> tuple[np.ndarray, float]:
    """Center and radius of a ball around triangles (n, 3, 3)."""
    points = corners.reshape(-1, 3)
    center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return center, WIDER * float(np.linalg.norm(points - center, axis=1).max()) + 1e-9


def _seen(centers: np.ndarray, radii: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(places, balls) parts of all directions that balls fill, seen from places."""
    distance = np.linalg.norm(centers[None] - places[:, None], axis=2)
    sine = np.minimum(radii / np.maximum(distance, 1e-30), 1.0)
    return np.where(distance <= radii, 1.0, 0.5 * (1.0 - np.sqrt(1.0 - sine * sine))) + 1e-12


def _divided(corners: np.ndarray, sources: Sources) -> list[np.ndarray]:
    """The triangles (n, 3, 3) in groups."""

    def size(group: np.ndarray) -> float:
        center, radius = _ball(group)
        seen = _seen(center[None], np.array([radius]), sources.centers)[:, 0]
        part = float(sources.powers @ seen) / float(sources.powers.sum())
        return part if len(group) > 1 and part > SMALL else 0.0

    groups = [corners]
    sizes = [size(corners)]
    while len(groups) < TARGETS and max(sizes) > 0.0:
        at = int(np.argmax(sizes))
        middles = groups[at].mean(axis=1)
        axis = int(np.argmax(np.ptp(middles, axis=0)))
        order = np.argsort(middles[:, axis], kind="stable")
        parts = [groups[at][half] for half in np.array_split(order, 2)]
        groups[at : at + 1] = parts
        sizes[at : at + 1] = [size(part) for part in parts]
    return groups
