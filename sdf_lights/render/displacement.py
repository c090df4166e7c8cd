# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Displacement: the nodes of materials move the vertices of meshes before any ray is traced.

The model is Cycles'. A vertex is moved once, by the material of the first triangle that contains it, with the
coordinates of that triangle's corner. A mesh shared by several instances is moved for the first of them.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from .material import SHARP_FACE, UNDISPLACED, Material, Node
from .reference.geometry import Hits, Placed, Surface
from .reference.nodes import Graph, Points
from .scene import AttributeValues, Domain, Instance, Mesh, Primitive, Scene

_CHUNK = 1 << 18  # number of vertices whose formulas are evaluated together
_FLAT = 1e-5  # corner normals this close to the triangle's are the triangle's own


class CyclesVersion(NamedTuple):
    """Differences between versions of Cycles. Before Blender 5.1 it tore meshes along sharp edges. Before 5.0, the bump
    of a mesh with only flat faces started from the displaced faces."""

    splits_sharp_edges: bool = False
    bumps_moved_faces: bool = False


def displace(scene: Scene, version: CyclesVersion = CyclesVersion()) -> None:
    """Move the vertices of all meshes of ``scene`` whose materials ask for it. The images must be loaded.

    If other instances show the mesh with other materials, they get a separate copy.
    """
    moving = [index for index, material in enumerate(scene.materials) if material.displacement is not None]
    if not moving:
        return
    shown: dict[int, dict[tuple[int, ...], list[Instance]]] = {}
    for instance in scene.instances:
        shown.setdefault(instance.mesh, {}).setdefault(tuple(instance.materials), []).append(instance)
    for index, kinds in shown.items():
        mesh = scene.meshes[index]
        if mesh.primitive != Primitive.TRIANGLES:
            continue
        for materials, instances in kinds.items():
            material = _materials_of(mesh, materials)
            if not np.isin(material, moving).any():
                continue
            moved = _displaced(scene, mesh, instances[0], material, moving, version)
            if len(kinds) == 1:
                scene.meshes[index] = moved
                continue
            scene.meshes.append(moved)
            for instance in instances:
                instance.mesh = len(scene.meshes) - 1


def _materials_of(mesh: Mesh, materials: tuple[int, ...]) -> np.ndarray:
    """(T,) material of each triangle."""
    slots = np.zeros(len(mesh.triangles), np.int64) if mesh.slots is None else mesh.slots
    return np.array(materials)[np.clip(slots, 0, len(materials) - 1)]


def _displaced(
    scene: Scene, mesh: Mesh, instance: Instance, material: np.ndarray, moving: list[int], version: CyclesVersion
) -> Mesh:
    if version.splits_sharp_edges:
        mesh = _split_at_sharp_edges(mesh)
    rows = np.flatnonzero(np.isin(material, moving))
    vertices, first = np.unique(mesh.triangles[rows].ravel(), return_index=True)
    triangles, corners = rows[first // 3], first % 3
    places = Placed(dataclasses.replace(scene, meshes=[mesh], instances=[dataclasses.replace(instance, mesh=0)]))
    surface = _surface(places, triangles, corners, vertices)
    to_object = np.linalg.inv(np.asarray(instance.matrix, np.float64)[:3, :3])
    positions = mesh.positions.astype(np.float64)
    for index in moving:
        used = np.flatnonzero(material[triangles] == index)
        if len(used):
            offsets = _offsets(places, scene.materials[index], surface.select(used)) @ to_object.T
            positions[vertices[used]] += np.where(np.isfinite(offsets), offsets, 0.0)
    moved = dataclasses.replace(mesh, positions=positions.astype(np.float32), attributes=dict(mesh.attributes))
    anew = np.isin(material, [index for index in moving if not scene.materials[index].keeps_normals])
    moved.normals = _normals(mesh, moved.positions, anew, version)
    if mesh.motion is not None:
        moved.motion = mesh.motion + (moved.positions - mesh.positions)
        forms = [
            dataclasses.replace(mesh, positions=form, normals=n) for form, n in zip(mesh.motion, _normals_over(mesh))
        ]
        turned = [_normals(form, positions, anew, version) for form, positions in zip(forms, moved.motion)]
        moved.motion_normals = np.stack(turned) if moved.normals is not None else None
    moved.tangents = {name: _along(tangents, moved.normals) for name, tangents in mesh.tangents.items()}
    moved.attributes[UNDISPLACED] = AttributeValues(Domain.VERTEX, mesh.positions)
    return moved


def _surface(places: Placed, triangles: np.ndarray, corners: np.ndarray, vertices: np.ndarray) -> Surface:
    """The surface of the only mesh at these corners of triangles, with smooth normals and no viewer."""
    mesh = places.scene.meshes[0]
    count = len(triangles)
    hits = Hits.none(count)  # points on triangles follow from u and v
    hits.distance, hits.instance, hits.triangle = np.zeros(count), np.zeros(count, int), triangles
    hits.u, hits.v = (corners == 1).astype(float), (corners == 2).astype(float)
    surface = places.surface(hits, np.zeros((count, 3)))
    if mesh.normals is None:
        normals = _vertex_normals(mesh.positions, mesh.triangles, by_angle=True)[vertices] @ places.normal_matrices[0].T
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        surface.ns = np.where(length > 0.0, normals / np.where(length > 0.0, length, 1.0), surface.ng)
    return surface


def _offsets(places: Placed, material: Material, surface: Surface) -> np.ndarray:
    """Displacement (N, 3) in world space at points on a surface."""
    graph = Graph(
        Material(material.name, Node("emission", {"color": material.displacement}), parameters=material.parameters)
    )
    count, parts = len(surface.distance), []
    for start in range(0, count, _CHUNK):
        part = surface.select(np.arange(start, min(start + _CHUNK, count)))
        points = Points(graph, part, places, places.scene.images, np.zeros(len(part.distance)))
        parts.append(points.input(graph.surface, "color"))
    return np.concatenate(parts)


def _normals_over(mesh: Mesh) -> list[np.ndarray | None]:
    """Corner normals of a mesh at each of the known times of its motion."""
    return [mesh.normals] * len(mesh.motion) if mesh.motion_normals is None else list(mesh.motion_normals)


def _vertex_normals(positions: np.ndarray, triangles: np.ndarray, by_angle: bool = False) -> np.ndarray:
    """(V, 3) unit means of the normals of the triangles at each vertex, weighted by their angles there, as in Blender,
    or equally; zero if there are none."""
    corners = positions.astype(np.float64)[triangles]
    edges = np.roll(corners, -1, axis=1) - corners
    normals = _unit(np.cross(edges[:, 0], edges[:, 1]))
    weights = np.ones(triangles.shape)
    if by_angle:
        before, after = -_unit(np.roll(edges, 1, axis=1)), _unit(edges)
        weights = np.arccos(np.clip((before * after).sum(-1), -1.0, 1.0))
    total = np.zeros((len(positions), 3))
    for corner in range(3):
        np.add.at(total, triangles[:, corner], normals * weights[:, corner, None])
    return _unit(total)


def _split_at_sharp_edges(mesh: Mesh) -> Mesh:
    """The mesh with a separate vertex for each normal that corners have at a vertex."""
    if mesh.normals is None or _at_vertices(mesh) is not None:
        return mesh
    corners = np.concatenate([mesh.triangles.reshape(-1, 1), mesh.normals.reshape(-1, 3).view(np.int32)], 1)
    rows, triangles = np.unique(corners, axis=0, return_inverse=True)
    vertices = rows[:, 0]
    attributes = {
        name: AttributeValues(found.domain, found.values[vertices]) if found.domain == Domain.VERTEX else found
        for name, found in mesh.attributes.items()
    }
    return dataclasses.replace(
        mesh,
        positions=mesh.positions[vertices],
        motion=None if mesh.motion is None else mesh.motion[:, vertices],
        shifts=None if mesh.shifts is None else mesh.shifts[:, vertices],
        attributes=attributes,
        triangles=triangles.reshape(-1, 3).astype(np.int32),
    )


def _normals(mesh: Mesh, positions: np.ndarray, anew: np.ndarray, version: CyclesVersion) -> np.ndarray | None:
    """(T, 3, 3) corner normals of a mesh whose vertices have moved to ``positions``. Those of the triangles ``anew``
    (T,) are computed again. The others stay, because their bump starts from there."""
    if mesh.normals is None:
        flat = np.ones(len(mesh.triangles), bool)
        result = np.repeat(_triangle_normals(mesh.positions, mesh.triangles)[:, None], 3, 1)
    else:
        shared = _at_vertices(mesh)
        flat = _flat_triangles(mesh, shared is not None)
        if shared is not None:
            found = _vertex_normals(positions, mesh.triangles[anew])
            touched = np.zeros(len(positions), bool)
            touched[mesh.triangles[anew]] = True
            shared[touched] = found[touched]
            result = shared[mesh.triangles].astype(np.float64)
        else:  # sharp edges stay: corners turn as the mean normals of their vertices do
            turned = _vertex_normals(positions, mesh.triangles) - _vertex_normals(mesh.positions, mesh.triangles)
            result = mesh.normals.astype(np.float64)
            result[anew] = _unit(mesh.normals[anew] + turned[mesh.triangles[anew]])
    moved = flat & (anew | (version.bumps_moved_faces and mesh.normals is None))
    if moved.all():
        return None
    result[moved] = _triangle_normals(positions, mesh.triangles[moved])[:, None]
    return result.astype(np.float32)


def _at_vertices(mesh: Mesh) -> np.ndarray | None:
    """(V, 3) normals of the vertices; None if the corners at a vertex differ."""
    normals = np.zeros((len(mesh.positions), 3), np.float32)
    normals[mesh.triangles] = mesh.normals
    return normals if np.array_equal(normals[mesh.triangles], mesh.normals) else None


def _flat_triangles(mesh: Mesh, smooth: bool) -> np.ndarray:
    """(T,) bool; ``smooth``: all corners at a vertex have one normal, so normals alone do not tell."""
    known = mesh.attributes.get(SHARP_FACE)
    if known is not None and known.domain == Domain.TRIANGLE:
        return known.values[:, 0] > 0.5
    if smooth:
        return np.zeros(len(mesh.triangles), bool)
    away = np.abs(mesh.normals - _triangle_normals(mesh.positions, mesh.triangles)[:, None])
    return (away < _FLAT).all((1, 2))


def _triangle_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = positions.astype(np.float64)[triangles].transpose(1, 0, 2)
    return _unit(np.cross(b - a, c - a))


def _along(tangents: np.ndarray, normals: np.ndarray | None) -> np.ndarray:
    """Tangents (T, 3, 4) rotated into the new surface."""
    if normals is None:
        return tangents
    directions = tangents[..., :3] - normals * (tangents[..., :3] * normals).sum(-1, keepdims=True)
    return np.concatenate([_unit(directions), tangents[..., 3:]], -1).astype(np.float32)


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)
