# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves and spheres as Embree has them."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from .scene import Instance, Mesh, Primitive, Scene

# Kinds of geometry in Embree's C API (rtcore_geometry.h).
EMBREE_TYPES = {
    Primitive.CONES: 16,
    Primitive.SPHERES: 50,
    Primitive.STRANDS: 58,
    Primitive.RIBBONS: 59,
}


_SAME = 1e-6  # tolerance within which Cycles treats scales as equal


class Buffers(NamedTuple):
    """Data for Embree: ``vertices`` (N, 4) float32 for each time, with radii; ``indices`` (S,) uint32 of the first
    vertex of each segment, None for spheres."""

    vertices: list[np.ndarray]
    indices: np.ndarray | None


def has_strands(scene: Scene) -> bool:
    """Whether the scene has curves or spheres."""
    return any(scene.meshes[instance.mesh].primitive != Primitive.TRIANGLES for instance in scene.instances)


def strand_of(mesh: Mesh) -> np.ndarray:
    """(S,) int32 number of the curve of each segment; for spheres their own."""
    rows = mesh.triangles
    if mesh.primitive == Primitive.SPHERES:
        return np.arange(len(rows), dtype=np.int32)
    begins = np.ones(len(rows), bool)
    begins[1:] = rows[1:, 0] != rows[:-1, 1]
    return (np.cumsum(begins) - 1).astype(np.int32)


def can_be_baked(mesh: Mesh, instance: Instance) -> bool:
    """Whether an instance can be baked into world space: scaled curves and spheres are no longer round there."""
    if mesh.primitive == Primitive.TRIANGLES:
        return True
    squares = (np.asarray(instance.matrix, float)[:3, :3] ** 2).sum(0)
    return float(np.ptp(squares)) < _SAME * max(float(squares.max()), 1.0)


def baked_instances(scene: Scene) -> np.ndarray:
    """(instances,) bool: those that are put into the world, as no other has their mesh and they stand still."""
    uses = np.bincount([instance.mesh for instance in scene.instances], minlength=len(scene.meshes))
    return np.array(
        [
            uses[instance.mesh] == 1 and instance.motion is None and can_be_baked(scene.meshes[instance.mesh], instance)
            for instance in scene.instances
        ],
        dtype=bool,
    )


def world_scale(matrix: np.ndarray) -> float:
    """Factor on radii when ``matrix`` (4 × 4) bakes curves or spheres into world space."""
    return abs(float(np.linalg.det(matrix[:3, :3]))) ** (1.0 / 3.0)


def radii_of(mesh: Mesh) -> np.ndarray:
    """(V,), or (K V,) for a mesh that deforms: the radii at one time after the other."""
    return mesh.radii if mesh.motion_radii is None else mesh.motion_radii.ravel()


def margin(mesh: Mesh) -> float:
    """How far the geometry extends beyond its vertices; a curve may swing slightly further out."""
    if mesh.primitive == Primitive.TRIANGLES or not len(mesh.positions):
        return 0.0
    swing = 0.0
    if mesh.primitive in (Primitive.RIBBONS, Primitive.STRANDS) and len(mesh.triangles):
        forms = mesh.positions[None] if mesh.motion is None else mesh.motion
        ways = forms[:, mesh.triangles[:, 1]] - forms[:, mesh.triangles[:, 0]]
        swing = 0.3 * float(np.sqrt((ways.astype(np.float64) ** 2).sum(-1).max()))
    return float(radii_of(mesh).max()) + swing


def buffers(mesh: Mesh, matrix: np.ndarray | None = None) -> Buffers:
    """Curves or spheres for Embree, in world space by ``matrix`` (4 × 4), or in local space."""
    forms = [mesh.positions] if mesh.motion is None else list(mesh.motion)
    sizes = [mesh.radii] * len(forms) if mesh.motion_radii is None else list(mesh.motion_radii)
    factor = 1.0
    if matrix is not None:
        forms = [form.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3] for form in forms]
        factor = world_scale(matrix)
    vertices = [
        np.concatenate([form, factor * size[:, None]], 1).astype(np.float32) for form, size in zip(forms, sizes)
    ]
    if mesh.primitive == Primitive.SPHERES:
        return Buffers(vertices, None)
    first = mesh.triangles[:, 0].astype(np.int64)
    if mesh.primitive == Primitive.CONES:
        return Buffers(vertices, first.astype(np.uint32))
    # Embree's curves begin and end one vertex further, so the end vertices are repeated.
    strand = strand_of(mesh)
    begins = np.flatnonzero(np.diff(strand, prepend=-1))
    ends = np.append(begins[1:], len(strand)) - 1
    curve, places = strand[begins].astype(np.int64), np.zeros(len(mesh.positions) + 2 * len(begins), np.int64)
    places[first + 2 * strand + 1] = first
    last = mesh.triangles[ends, 1].astype(np.int64)
    places[last + 2 * curve + 1] = places[last + 2 * curve + 2] = last
    places[first[begins] + 2 * curve] = first[begins]
    return Buffers([form[places] for form in vertices], (first + 2 * strand).astype(np.uint32))


def tessellation(mesh: Mesh) -> float:
    """Embree's rate for ribbons."""
    return float((1 << mesh.subdivisions) + 1)


def without_strands(scene: Scene, name: str) -> Scene:
    """The scene with only its triangles. If it has more, it gets a warning with the ``name`` of the back end."""
    known = [scene.meshes[instance.mesh].primitive == Primitive.TRIANGLES for instance in scene.instances]
    if all(known):
        return scene
    left_out = sorted({repr(instance.name) for instance, there in zip(scene.instances, known) if not there})
    scene.warnings.append(
        f"{name} leaves hair and point clouds out, those of {', '.join(left_out)}: choose the CPU as the device to "
        "see them."
    )
    instances = [instance for instance, there in zip(scene.instances, known) if there]
    return dataclasses.replace(scene, instances=instances)
