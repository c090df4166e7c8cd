# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and instances as tables, and the surface that a ray has hit.

Positions of a baked instance (one whose mesh is used once, see rays.py) are in world space already; all other corner
data stay in the mesh's local space and are brought to world space at the hit.
"""

from __future__ import annotations

import numpy as np

from ...affine import inverse
from ...jit import kernel, table
from ...vec import cross, dot, madd, negate, normalize, sub, transform_normal, transform_point, transform_vector, vec
from ..scene import Scene
from .rays import hit_instance, hit_normal, ray_table, world_positions
from .shading.records import NEEDS_DERIVATIVES, NEEDS_OBJECT, NEEDS_TANGENT, NEEDS_UV, SURFACE
from .shading.program import MATERIAL

# All indices are rows of the tables below; −1: the mesh has no such data. ``uvs`` and ``tangents`` are the first of
# as many consecutive blocks of ``triangle_count`` rows as the scene has UV layers.
INSTANCE = np.dtype(
    [("matrix", np.float64, (3, 4)), ("inverse", np.float64, (3, 4)), ("baked", np.int64), ("holdout", np.int64),
     ("positions", np.int64), ("triangles", np.int64), ("triangle_count", np.int64), ("normals", np.int64),
     ("uvs", np.int64), ("tangents", np.int64), ("slots", np.int64), ("materials", np.int64),
     ("material_count", np.int64), ("mirrored", np.int64)], align=True)

POSITION = np.dtype([("p", np.float32, (3,))])
TRIANGLE = np.dtype([("v", np.int32, (3,))])
CORNER_NORMALS = np.dtype([("n", np.float32, (3, 3))])
CORNER_UVS = np.dtype([("uv", np.float32, (3, 2))])
CORNER_TANGENTS = np.dtype([("t", np.float32, (3, 4))])

TABLES = {
    "instances": INSTANCE, "positions": POSITION, "triangles": TRIANGLE, "corner_normals": CORNER_NORMALS,
    "corner_uvs": CORNER_UVS, "corner_tangents": CORNER_TANGENTS, "slots": np.dtype(np.int32),
    "instance_materials": np.dtype(np.int32),
}

SCALARS = [("uv_layer_count", np.int64)]

instance_table = table("instances", INSTANCE)
position_table = table("positions", POSITION)
triangle_table = table("triangles", TRIANGLE)
normal_table = table("corner_normals", CORNER_NORMALS)
uv_table = table("corner_uvs", CORNER_UVS)
tangent_table = table("corner_tangents", CORNER_TANGENTS)
slot_table = table("slots", np.int32)
material_table = table("instance_materials", np.int32)
surface_table = table("surface", SURFACE)
shading_material_table = table("materials", MATERIAL)


class _Rows:
    """Arrays to be laid end to end in one table."""

    def __init__(self, dtype: np.dtype):
        self.dtype, self.parts, self.count = dtype, [], 0

    def add(self, array: np.ndarray) -> int:
        """Append (rows, …) values; the row at which they start."""
        base = self.dtype if self.dtype.fields is None else self.dtype.fields[self.dtype.names[0]][0].base
        flat = np.ascontiguousarray(array, base).reshape(len(array), -1)
        self.parts.append(flat)
        start, self.count = self.count, self.count + len(flat)
        return start

    def join(self) -> np.ndarray:
        if not self.parts:
            return np.zeros(0, self.dtype)
        return np.concatenate(self.parts).reshape(-1).view(self.dtype)


def pack_geometry(scene: Scene, baked: np.ndarray, uv_layers: list[str]) -> dict[str, np.ndarray]:
    """Tables of all meshes and instances. ``baked``: (instances,) bool from ``rays.Accelerator``.

    ``uv_layers`` names the maps that the materials read; a mesh that lacks one gives its active one, or zeros.
    """
    rows = {name: _Rows(dtype) for name, dtype in TABLES.items() if name != "instances"}
    packed: dict[int, dict[str, int]] = {}
    instances = np.zeros(len(scene.instances), INSTANCE)
    for index, instance in enumerate(scene.instances):
        mesh, record = scene.meshes[instance.mesh], instances[index]
        if instance.mesh not in packed:
            count = len(mesh.triangles)
            places = dict(
                triangles=rows["triangles"].add(mesh.triangles), triangle_count=count,
                normals=-1 if mesh.normals is None else rows["corner_normals"].add(mesh.normals),
                slots=-1 if mesh.slots is None else rows["slots"].add(mesh.slots), uvs=-1, tangents=-1)
            if mesh.uvs:
                starts = [rows["corner_uvs"].add(_layer(mesh.uvs, name, (count, 3, 2))) for name in uv_layers]
                places["uvs"] = starts[0] if starts else -1
            if mesh.tangents:
                starts = [rows["corner_tangents"].add(_layer(mesh.tangents, name, (count, 3, 4))) for name in uv_layers]
                places["tangents"] = starts[0] if starts else -1
            positions = world_positions(mesh.positions, instance.matrix) if baked[index] else mesh.positions
            places["positions"] = rows["positions"].add(positions)
            packed[instance.mesh] = places
        for name, place in packed[instance.mesh].items():
            record[name] = place
        matrix = np.asarray(instance.matrix, np.float64)
        record["matrix"], record["inverse"] = matrix[:3], inverse(matrix)[:3]
        record["baked"], record["holdout"] = baked[index], instance.holdout
        record["mirrored"] = np.linalg.det(matrix[:3, :3]) < 0.0
        record["materials"] = rows["instance_materials"].add(np.array(instance.materials, np.int32))
        record["material_count"] = len(instance.materials)
    tables = {name: part.join() for name, part in rows.items()}
    tables["instances"] = instances
    return tables


def _layer(maps: dict[str, np.ndarray], name: str, shape: tuple) -> np.ndarray:
    found = maps.get(name, maps.get(""))
    return np.zeros(shape, np.float32) if found is None else found


@kernel
def _corner(block, instance, triangle, corner):
    """World position of a vertex, in float64."""
    index = triangle_table(block)[instance.triangles + triangle].v[corner]
    p = vec(position_table(block)[instance.positions + index].p)
    return p if instance.baked else transform_point(instance.matrix, p)


@kernel
def hit_material(instance, block, triangle):
    slot = 0
    if instance.slots >= 0:
        slot = min(max(slot_table(block)[instance.slots + triangle], 0), instance.material_count - 1)
    return material_table(block)[instance.materials + slot]


@kernel
def find_surface(block, workspace, wo, ray_kind, footprint):
    """Fill ``SURFACE`` from the hit that ``rays.intersect`` left in the workspace, as far as the material needs it.

    The position comes from the barycentric coordinates in float64, not from the distance along the ray: its error
    does not grow with the distance, and it lies in the plane of the triangle.
    """
    ray = ray_table(workspace)[0]
    surface = surface_table(workspace)[0]
    index = hit_instance(ray)
    instance = instance_table(block)[index]
    triangle = np.int64(ray.primitive)
    u, v = float(ray.u), float(ray.v)
    w = 1.0 - u - v
    p0 = _corner(block, instance, triangle, 0)
    edge1 = sub(_corner(block, instance, triangle, 1), p0)
    edge2 = sub(_corner(block, instance, triangle, 2), p0)
    position = madd(madd(p0, u, edge1), v, edge2)
    ng = normalize(cross(edge1, edge2))
    if instance.mirrored:
        ng = negate(ng)
    n = ng
    object_normal = ng
    if instance.normals >= 0:
        corners = normal_table(block)[instance.normals + triangle].n
        object_normal = (
            w * corners[0, 0] + u * corners[1, 0] + v * corners[2, 0],
            w * corners[0, 1] + u * corners[1, 1] + v * corners[2, 1],
            w * corners[0, 2] + u * corners[1, 2] + v * corners[2, 2])
        smooth = normalize(transform_normal(instance.inverse, object_normal))
        if dot(smooth, smooth) > 0.5:
            n = smooth
    surface.backfacing = 0
    if dot(ng, wo) < 0.0:
        surface.backfacing = 1
        ng, n = negate(ng), negate(n)
    for axis in range(3):
        surface.position[axis] = position[axis]
        surface.wo[axis] = wo[axis]
        surface.ng[axis] = ng[axis]
        surface.n[axis] = n[axis]
    surface.instance = index
    surface.primitive = triangle
    surface.ray_kind = ray_kind
    surface.material = hit_material(instance, block, triangle)
    flags = shading_material_table(block)[surface.material].flags
    if flags & (NEEDS_UV | NEEDS_DERIVATIVES):
        _find_uvs(block, surface, instance, triangle, u, v, flags)
    if flags & NEEDS_DERIVATIVES:
        surface.footprint = footprint
        for axis in range(3):
            surface.dpdu[axis] = edge1[axis]
            surface.dpdv[axis] = edge2[axis]
    if flags & (NEEDS_TANGENT | NEEDS_OBJECT):
        if instance.normals < 0:
            object_normal = transform_normal(instance.matrix, ng if surface.backfacing == 0 else negate(ng))
        for axis in range(3):
            surface.object_normal[axis] = object_normal[axis]
            for column in range(4):
                surface.world_to_object[axis, column] = instance.inverse[axis, column]
    if flags & NEEDS_TANGENT:
        _find_tangents(block, surface, instance, triangle, u, v)


@kernel
def _find_uvs(block, surface, instance, triangle, u, v, flags):
    for layer in range(block.uv_layer_count):
        for axis in range(2):
            if instance.uvs < 0:
                surface.uv[layer, axis] = 0.0
                surface.uv_du[layer, axis] = 0.0
                surface.uv_dv[layer, axis] = 0.0
            else:
                corners = uv_table(block)[instance.uvs + layer * instance.triangle_count + triangle].uv
                first = float(corners[0, axis])
                du, dv = corners[1, axis] - first, corners[2, axis] - first
                surface.uv[layer, axis] = first + u * du + v * dv
                if flags & NEEDS_DERIVATIVES:
                    surface.uv_du[layer, axis] = du
                    surface.uv_dv[layer, axis] = dv


@kernel
def _find_tangents(block, surface, instance, triangle, u, v):
    for layer in range(block.uv_layer_count):
        for axis in range(4):
            if instance.tangents < 0:
                surface.tangent[layer, axis] = 0.0
            else:
                corners = tangent_table(block)[instance.tangents + layer * instance.triangle_count + triangle].t
                value = (1.0 - u - v) * corners[0, axis] + u * corners[1, axis] + v * corners[2, axis]
                surface.tangent[layer, axis] = value


@kernel
def find_shadow_surface(block, workspace, wo):
    """Fill what ``shading.transparency`` reads; the material's index."""
    ray = ray_table(workspace)[0]
    surface = surface_table(workspace)[0]
    instance = instance_table(block)[hit_instance(ray)]
    triangle = np.int64(ray.primitive)
    surface.material = hit_material(instance, block, triangle)
    # Embree gives the normal of the triangle as it was built: in world space if baked, in the mesh's own space if not.
    facing = dot(hit_normal(ray), wo if instance.baked else transform_vector(instance.inverse, wo))
    if instance.baked and instance.mirrored:
        facing = -facing
    surface.backfacing = 1 if facing < 0.0 else 0
    flags = shading_material_table(block)[surface.material].flags
    if flags & NEEDS_UV:
        _find_uvs(block, surface, instance, triangle, float(ray.u), float(ray.v), flags)
    return surface.material
