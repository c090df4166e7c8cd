# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of the demo scene: boxes, turned shapes and tubes with UVs in metres."""

from __future__ import annotations

import math

import bmesh
import bpy
from mathutils import Matrix, Vector


def add(
    name: str,
    mesh,
    *materials,
    location=(0.0, 0.0, 0.0),
    rotation=(0.0, 0.0, 0.0),
    scale=(1.0, 1.0, 1.0),
    collection=None,
):
    """An object in ``collection`` (default: the scene's); rotation is XYZ Euler in degrees."""
    if materials:
        mesh.materials.clear()
        for material in materials:
            mesh.materials.append(material)
    thing = bpy.data.objects.new(name, mesh)
    thing.location, thing.scale = location, scale
    thing.rotation_euler = [math.radians(angle) for angle in rotation]
    (collection or bpy.context.scene.collection).objects.link(thing)
    return thing


def _finish(work, name: str, smooth: bool, uv_scale: float | None, grain: int | None = None):
    """The bmesh as a mesh; with ``uv_scale``, UVs by projection along each face's main axis, that many repeats a metre.

    ``grain`` is the axis (0, 1, 2) that the texture's width follows; default: the longest horizontal one of the face.
    """
    bmesh.ops.recalc_face_normals(work, faces=work.faces)
    if uv_scale is not None:
        layer = work.loops.layers.uv.verify()
        for face in work.faces:
            axis = max(range(3), key=lambda i: abs(face.normal[i]))
            across, up = [i for i in range(3) if i != axis]
            if grain == up:
                across, up = up, across
            for loop in face.loops:
                loop[layer].uv = (loop.vert.co[across] * uv_scale, loop.vert.co[up] * uv_scale)
    for face in work.faces:
        face.smooth = smooth
    mesh = bpy.data.meshes.new(name)
    work.to_mesh(mesh)
    work.free()
    return mesh


def box(name: str, size, bevel: float = 0.0, segments: int = 3, uv_scale: float = 1.0, grain: int | None = None):
    """A box centred on the origin, its edges rounded with radius ``bevel``."""
    work = bmesh.new()
    bmesh.ops.create_cube(work, size=1.0, matrix=Matrix.Diagonal((*size, 1.0)))
    if bevel:
        bmesh.ops.bevel(work, geom=work.edges[:], offset=bevel, segments=segments, profile=0.5, affect="EDGES")
    return _finish(work, name, bool(bevel), uv_scale, grain)


def plane(name: str, size, uv_scale: float | None = 1.0):
    """A rectangle in the xy plane that faces +z; with ``uv_scale`` None one copy of a texture covers it."""
    work = bmesh.new()
    x, y = size[0] / 2.0, size[1] / 2.0
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    face = work.faces.new([work.verts.new((*corner, 0.0)) for corner in corners])
    layer = work.loops.layers.uv.verify()
    for loop in face.loops:
        u, v = loop.vert.co[0], loop.vert.co[1]
        loop[layer].uv = (u / size[0] + 0.5, v / size[1] + 0.5) if uv_scale is None else (u * uv_scale, v * uv_scale)
    mesh = bpy.data.meshes.new(name)
    work.to_mesh(mesh)
    work.free()
    return mesh


def turned(name: str, profile, steps: int = 64):
    """A solid of revolution about z from (radius, height) pairs; u goes once round, v along the profile in metres."""
    work = bmesh.new()
    layer = work.loops.layers.uv.verify()
    rings, lengths = [], [0.0]
    for (r0, z0), (r1, z1) in zip(profile, profile[1:]):
        lengths.append(lengths[-1] + math.hypot(r1 - r0, z1 - z0))
    for radius, height in profile:
        angles = [2.0 * math.pi * step / steps for step in range(steps)] if radius > 0.0 else [0.0]
        rings.append([work.verts.new((radius * math.cos(a), radius * math.sin(a), height)) for a in angles])
    for index, (low, high) in enumerate(zip(rings, rings[1:])):
        for step in range(steps):
            corners = []
            for ring, at, row in ((low, step, 0), (low, step + 1, 0), (high, step + 1, 1), (high, step, 1)):
                vertex = ring[at % len(ring)]
                if vertex not in [corner[0] for corner in corners]:
                    corners.append((vertex, (at / steps, lengths[index + row])))
            if len(corners) < 3:
                continue
            face = work.faces.new([corner[0] for corner in corners])
            for loop, (_, uv) in zip(face.loops, corners):
                loop[layer].uv = uv
    return _finish(work, name, True, None)


def smooth_profile(points, per_span: int = 8):
    """A Catmull-Rom curve through (radius, height) points, for ``turned``."""
    padded = [points[0], *points, points[-1]]
    curve = []
    for a, b, c, d in zip(padded, padded[1:], padded[2:], padded[3:]):
        for step in range(per_span):
            t = step / per_span
            curve.append(
                tuple(
                    0.5
                    * (
                        2.0 * q
                        + (r - p) * t
                        + (2.0 * p - 5.0 * q + 4.0 * r - s) * t**2
                        + (3.0 * q - p - 3.0 * r + s) * t**3
                    )
                    for p, q, r, s in zip(a, b, c, d)
                )
            )
    return [(max(radius, 0.0), height) for radius, height in [*curve, points[-1]]]


def rod(name: str, start, end, radius: float, material, collection=None, steps: int = 16):
    """A capped cylinder between two points."""
    start, end = Vector(start), Vector(end)
    length = (end - start).length
    bevel = 0.25 * radius
    mesh = turned(
        name,
        [
            (0.0, 0.0),
            (radius - bevel, 0.0),
            (radius, bevel),
            (radius, length - bevel),
            (radius - bevel, length),
            (0.0, length),
        ],
        steps,
    )
    thing = add(name, mesh, material, collection=collection)
    thing.matrix_world = Matrix.Translation(start) @ (end - start).to_track_quat("Z", "X").to_matrix().to_4x4()
    return thing


def leaf(name: str, length: float = 0.34, width: float = 0.11, segments: int = 10):
    """A leaf along +y that droops and folds along its rib."""
    work = bmesh.new()
    layer = work.loops.layers.uv.verify()
    rows = []
    for index in range(segments + 1):
        t = index / segments
        half = 0.5 * width * math.sin(math.pi * t**0.8) ** 0.8 if 0.0 < t < 1.0 else 0.001
        y, z = length * t, 0.55 * length * (0.45 * t - t * t)
        rows.append(
            [work.verts.new((side * half, y, z + 0.35 * abs(side) * half)) for side in (-1.0, -0.5, 0.0, 0.5, 1.0)]
        )
    for index, (low, high) in enumerate(zip(rows, rows[1:])):
        for side in range(4):
            face = work.faces.new((low[side], low[side + 1], high[side + 1], high[side]))
            for loop, (i, j) in zip(face.loops, ((side, 0), (side + 1, 0), (side + 1, 1), (side, 1))):
                loop[layer].uv = (i / 4.0, (index + j) / segments)
    return _finish(work, name, True, None)
