# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed meshes of lamps, for engines without signed distance fields.

A mesh is (vertices, faces): (V, 3) float64 in metres, and an array (F, corners) of indices, counter-clockwise from
outside.
"""

from __future__ import annotations

import itertools
import math

import bmesh
import bpy
import numpy as np

Solid = tuple[np.ndarray, np.ndarray]


def _grid(rows: int, columns: int) -> np.ndarray:
    """Quads of a grid of rows × columns vertices that is closed both ways."""
    row, column = np.divmod(np.arange(rows * columns), columns)
    down, right = (row + 1) % rows, (column + 1) % columns
    return np.stack(
        [row * columns + column, down * columns + column, down * columns + right, row * columns + right], axis=1
    )


def torus(major: float, minor: float, around: int = 256, across: int = 128) -> Solid:
    """A ring around the z axis; the tube is slightly wider so that the volume is right."""
    minor *= (math.tau / across / math.sin(math.tau / across) * math.tau / around / math.sin(math.tau / around)) ** 0.5
    turns = [math.tau * np.arange(count) / count for count in (around, across)]
    u, v = np.meshgrid(*turns, indexing="ij")
    ring = major + minor * np.cos(v)
    return np.stack([ring * np.cos(u), ring * np.sin(u), minor * np.sin(v)], axis=-1).reshape(-1, 3), _grid(
        around, across
    )


def box(half) -> Solid:
    """A box around the origin with the half sizes ``half``."""
    return voxels(np.ones((1, 1, 1), bool), 2.0 * np.asarray(half))


def sphere(radius: float, segments: int = 256, rings: int = 128) -> Solid:
    """A ball around the origin; slightly larger so that the volume is right."""
    theta = np.linspace(0.0, np.pi, rings + 1)[1:-1, None]
    phi = np.arange(segments) * 2.0 * np.pi / segments
    middle = np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1)
    vertices = np.concatenate([middle.reshape(-1, 3), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]]) * radius
    faces = _grid(rings - 1, segments)[: (rings - 2) * segments]
    top, bottom = len(vertices) - 2, len(vertices) - 1
    first, after = np.arange(segments), (np.arange(segments) + 1) % segments
    last = (rings - 2) * segments
    caps = [np.stack([first * 0 + top, first, after], 1), np.stack([last + first, first * 0 + bottom, last + after], 1)]
    ball = vertices, np.concatenate([triangles(faces), *caps])
    return vertices * (4.0 / 3.0 * math.pi * radius**3 / volume(ball)) ** (1.0 / 3.0), ball[1]


def triangles(faces: np.ndarray) -> np.ndarray:
    """Faces as triangles."""
    if faces.shape[1] == 3:
        return faces
    return np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])


def voxels(solid: np.ndarray, size) -> Solid:
    """Boundary of the cells that are ``solid`` (x, y, z), in a box around the origin of full ``size``."""
    padded = np.pad(solid, 1)
    shape = np.array(solid.shape) + 1
    corners, faces = [], []
    for axis in range(3):
        across = [(axis + 1) % 3, (axis + 2) % 3]
        for side in (0, 1):
            beyond = np.roll(padded, 1 - 2 * side, axis=axis)
            cells = np.argwhere(padded & ~beyond) - 1
            for corner in (((0, 0), (1, 0), (1, 1), (0, 1)), ((0, 0), (0, 1), (1, 1), (1, 0)))[1 - side]:
                place = cells.copy()
                place[:, axis] += side
                place[:, across] += corner
                corners.append(np.ravel_multi_index(place.T, shape))
            faces.append(np.stack(corners[-4:], axis=1))
    keys, faces = np.unique(np.concatenate(faces), return_inverse=True)
    vertices = (np.stack(np.unravel_index(keys, shape), axis=1) / solid.shape - 0.5) * size
    return vertices, faces.reshape(-1, 4)


def sponge(half: float, levels: int) -> Solid:
    """Menger's sponge."""
    solid = np.ones((1, 1, 1), bool)
    part = (np.indices((3, 3, 3)) == 1).sum(axis=0) < 2
    for _ in range(levels):
        solid = np.kron(solid, part)
    return voxels(solid, np.full(3, 2.0 * half))


def difference(whole: Solid, hole: Solid) -> Solid:
    """``whole`` without ``hole``, by Blender's exact Boolean modifier; triangles."""
    things = [bpy.data.objects.new("Part", mesh("Part", part)) for part in (whole, hole)]
    for thing in things:
        bpy.context.scene.collection.objects.link(thing)
    modifier = things[0].modifiers.new("Difference", "BOOLEAN")
    modifier.operation, modifier.object, modifier.solver = "DIFFERENCE", things[1], "EXACT"
    evaluated = things[0].evaluated_get(bpy.context.evaluated_depsgraph_get())
    result = evaluated.to_mesh()
    result.calc_loop_triangles()
    vertices, faces = np.empty(3 * len(result.vertices)), np.empty(3 * len(result.loop_triangles), np.int32)
    result.vertices.foreach_get("co", vertices)
    result.loop_triangles.foreach_get("vertices", faces)
    evaluated.to_mesh_clear()
    for thing in things:
        data = thing.data
        bpy.data.objects.remove(thing)
        bpy.data.meshes.remove(data)
    return vertices.reshape(-1, 3), faces.reshape(-1, 3)


# Kuhn's six tetrahedra of a cube share its diagonal, so those of neighbouring cubes fit together.
_TETRAHEDRA = np.array([[0, 1 << a, (1 << a) | (1 << b), 7] for a, b, _ in itertools.permutations(range(3))])


def isosurface(field, low, high, cells: int) -> Solid:
    """Where ``field`` ((N, 3) points -> (N,) values, negative inside) is zero, by marching tetrahedra; triangles.

    The longest side of the box from ``low`` to ``high``, which is enlarged slightly, has so many ``cells``. Vertices
    are found by bisection, so that they lie on the surface.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    step = float((high - low).max()) / cells
    low = low - 1.013 * step
    count = np.ceil((high - low) / step + 1.01).astype(int) + 1
    points = low + step * np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), axis=-1).reshape(-1, 3)
    inside = np.concatenate([field(part) for part in np.array_split(points, max(len(points) // 100_000, 1))]) < 0.0
    grid = np.arange(len(points)).reshape(count)
    corners = np.stack(
        [
            grid[x : count[0] - 1 + x, y : count[1] - 1 + y, z : count[2] - 1 + z].ravel()
            for z in (0, 1)
            for y in (0, 1)
            for x in (0, 1)
        ],
        axis=1,
    )
    some = inside[corners].sum(axis=1)
    tetrahedra = corners[(some > 0) & (some < 8)][:, _TETRAHEDRA].reshape(-1, 4)
    some = inside[tetrahedra].sum(axis=1)
    edges = []
    for number in (1, 2, 3):
        chosen = tetrahedra[some == number]
        # Corners inside first.
        order = np.argsort(~inside[chosen], axis=1, kind="stable")
        a, b, c, d = np.take_along_axis(chosen, order, axis=1).T
        if number == 2:
            edges += [((a, c), (a, d), (b, d)), ((a, c), (b, d), (b, c))]
        else:
            edges.append(((a, b), (a, c), (a, d)) if number == 1 else ((a, d), (b, d), (c, d)))
    ends = np.concatenate([np.stack([np.stack(edge, axis=1) for edge in face], axis=1) for face in edges])
    keys, faces = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    faces = faces.reshape(-1, 3)
    within, beyond = points[keys[:, 0]], points[keys[:, 1]]
    for _ in range(24):
        middle = 0.5 * (within + beyond)
        here = (np.concatenate([field(part) for part in np.array_split(middle, max(len(middle) // 100_000, 1))]) < 0.0)[
            :, None
        ]
        within, beyond = np.where(here, middle, within), np.where(here, beyond, middle)
    vertices = 0.5 * (within + beyond)
    corner = vertices[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    outwards = (points[ends[:, :, 1]] - points[ends[:, :, 0]]).sum(axis=1)
    turned = (normal * outwards).sum(axis=1) < 0.0
    faces[turned] = faces[turned][:, ::-1]
    return vertices, faces


def volume(solid: Solid) -> float:
    """Volume inside, in m³."""
    vertices, faces = solid
    a, b, c = vertices[triangles(faces)].transpose(1, 0, 2)
    return float((np.cross(a, b) * c).sum() / 6.0)


def measures(mesh: bpy.types.Mesh) -> tuple[float, float]:
    """Volume inside a closed mesh, in m³, and its area, in m²."""
    work = bmesh.new()
    work.from_mesh(mesh)
    found = work.calc_volume(), sum(face.calc_area() for face in work.faces)
    work.free()
    return found


def close(mesh: bpy.types.Mesh) -> None:
    """Merge vertices at the same position, as between the caps of a text and its sides, and turn faces outwards. Raises
    ValueError if a hole is left."""
    work = bmesh.new()
    work.from_mesh(mesh)
    bmesh.ops.remove_doubles(work, verts=work.verts, dist=1e-5)
    bmesh.ops.recalc_face_normals(work, faces=work.faces)
    holes = sum(len(edge.link_faces) % 2 for edge in work.edges)
    work.to_mesh(mesh)
    work.free()
    mesh.shade_flat()
    if holes:
        raise ValueError(f"{mesh.name} is not closed: {holes} edges have faces on one side alone.")


def moved(solid: Solid, matrix: np.ndarray) -> Solid:
    """The solid under an affine ``matrix`` (4 × 4)."""
    vertices, faces = solid
    mirrored = np.linalg.det(matrix[:3, :3]) < 0.0
    return vertices @ matrix[:3, :3].T + matrix[:3, 3], faces[:, ::-1] if mirrored else faces


def mesh(name: str, solid: Solid) -> bpy.types.Mesh:
    """Blender's mesh, flat-shaded."""
    vertices, faces = solid
    data = bpy.data.meshes.new(name)
    data.vertices.add(len(vertices))
    data.loops.add(faces.size)
    data.polygons.add(len(faces))
    data.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
    data.loops.foreach_set("vertex_index", faces.astype(np.int32).ravel())
    data.polygons.foreach_set("loop_start", faces.shape[1] * np.arange(len(faces), dtype=np.int32))
    data.polygons.foreach_set("use_smooth", np.zeros(len(data.polygons), bool))
    data.update(calc_edges=True)
    return data
