# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and instances as tables, and the surface at a hit.

Positions of a baked instance (whose mesh is used once, see rays.py) are already in world space. All other corner data
stay in the mesh's local space and are transformed at the hit.
"""

from __future__ import annotations

import math

import numpy as np

from ...affine import inverse, stretch
from ...jit import kernel, table
from ...replaced import replaced_on_gpu
from ...vec import (
    cross,
    dot,
    madd,
    negate,
    normalize,
    scale,
    sub,
    transform_normal,
    transform_point,
    transform_vector,
    vec,
)
from ..material import Attribute
from ..scene import AttributeValues, Domain, Instance, Mesh, Primitive, Ray, Scene
from ..strands import radii_of, strand_of, world_scale
from .ray_origins import ALONE, exact_origin, number_of
from .rays import hit_instance, hit_normal, ray_table, world_positions
from .shading.material_records import MATERIAL
from .shading.records import NEEDS_DERIVATIVES, NEEDS_OBJECT_NORMAL, NEEDS_RADIAL, NEEDS_SHADOW_POINT, SURFACE
from .shared_places import EVERYWHERE, may_compare, shared_places
from .strands import dispatch as strands

# All indices are rows of the tables below; −1: the mesh has no such data. ``attributes`` is the first of as many rows
# as materials look up attributes.
INSTANCE = np.dtype(
    [
        ("matrix", np.float64, (3, 4)),
        ("inverse", np.float64, (3, 4)),
        ("baked", np.int64),
        ("uneven", np.int64),  # baked, and scaled differently along its axes
        ("holdout", np.int64),
        ("catcher", np.int64),
        ("positions", np.int64),
        ("triangles", np.int64),
        ("triangle_count", np.int64),
        ("normals", np.int64),
        ("attributes", np.int64),
        ("slots", np.int64),
        ("materials", np.int64),
        ("material_count", np.int64),
        ("mirrored", np.int64),
        ("index", np.int64),
        ("random", np.float64),
        ("color", np.float64, (4,)),
        ("terminator", np.float64),
        ("box_center", np.float64, (3,)),
        ("box_size", np.float64, (3,)),  # of the mesh, in its own space
        ("shared", np.int64),  # first of the boxes around places that it shares with others: ``shared_places``
        ("shared_end", np.int64),
        # For instances that move while the shutter is open: the first of their poses at even times; the number of
        # positions and normals of each vertex and corner; and the time for which ``matrix`` and ``inverse`` are valid.
        ("poses", np.int64),
        ("pose_count", np.int64),
        ("forms", np.int64),
        ("vertex_count", np.int64),
        ("time", np.float64),
        # What the triangles are; of curves and spheres also the first of their radii and of the numbers of their
        # curves.
        ("primitive", np.int64),
        ("radii", np.int64),
        ("strands", np.int64),
    ],
    align=True,
)
ATTRIBUTE = np.dtype([("start", np.int64), ("domain", np.int32), ("width", np.int32)], align=True)

POSE = np.dtype([("matrix", np.float64, (3, 4))])
POSITION = np.dtype([("p", np.float32, (3,))])
TRIANGLE = np.dtype([("v", np.int32, (3,))])
SHARED_PLACE = np.dtype([("low", np.float64, (3,)), ("high", np.float64, (3,))])
CORNER_NORMALS = np.dtype([("n", np.float32, (3, 3))])

TABLES = {
    "instances": INSTANCE,
    "instance_poses": POSE,
    "positions": POSITION,
    "triangles": TRIANGLE,
    "corner_normals": CORNER_NORMALS,
    "slots": np.dtype(np.int32),
    "instance_materials": np.dtype(np.int32),
    "attributes": ATTRIBUTE,
    "attribute_values": np.dtype(np.float32),
    "radii": np.dtype(np.float32),
    "strand_of": np.dtype(np.int32),
    "shared_places": SHARED_PLACE,
    **strands.TABLES,
}
SCALARS = strands.SCALARS

NO_DOMAIN = -1
TRIANGLES, SPHERES = int(Primitive.TRIANGLES), int(Primitive.SPHERES)
NO_TIME = -1.0
SHADOW = int(Ray.SHADOW)
CORNER, VERTEX, TRIANGLE_DOMAIN, WHOLE = (int(domain) for domain in Domain)
# Bump mapping takes differences over this fraction of a pixel (Blender's filter width), or over this distance in metres
# if the pixel's width is unknown. Bilinear texels make the result nearly independent of it.
BUMP_FILTER = 0.1
BUMP_DISTANCE = 1e-4

instance_table = table("instances", INSTANCE)
pose_table = table("instance_poses", POSE)
position_table = table("positions", POSITION)
triangle_table = table("triangles", TRIANGLE)
normal_table = table("corner_normals", CORNER_NORMALS)
attribute_table = table("attributes", ATTRIBUTE)
attribute_value_table = table("attribute_values", np.float32)
radius_table = table("radii", np.float32)
slot_table = table("slots", np.int32)
material_table = table("instance_materials", np.int32)
_place_table = table("shared_places", SHARED_PLACE)
surface_table = table("surface", SURFACE)
shading_material_table = table("materials", MATERIAL)


class _Rows:
    """Arrays to be concatenated in one table."""

    def __init__(self, dtype: np.dtype):
        self.dtype, self.parts, self.count = dtype, [], 0
        self._base = dtype if dtype.fields is None else dtype.fields[dtype.names[0]][0].base

    def add(self, array: np.ndarray) -> int:
        """Append (rows, …) values. Returns the row at which they start."""
        flat = np.ascontiguousarray(array, self._base).reshape(len(array), math.prod(array.shape[1:]))
        self.parts.append(flat)
        start, self.count = self.count, self.count + len(flat)
        return start

    def join(self) -> np.ndarray:
        if not self.parts:
            return np.zeros(0, self.dtype)
        return np.concatenate(self.parts).reshape(-1).view(self.dtype)


# Shared by all instances of a mesh.
_OF_MESH = np.dtype(
    [
        (name, INSTANCE[name])
        for name in (
            "triangles",
            "triangle_count",
            "normals",
            "slots",
            "positions",
            "forms",
            "vertex_count",
            "box_center",
            "box_size",
            "primitive",
            "radii",
            "strands",
        )
    ]
)
_MADE_HERE = {"instances", "attributes", "shared_places", *strands.TABLES}


def pack_geometry(scene: Scene, baked: np.ndarray) -> dict[str, np.ndarray]:
    """Tables of all meshes and instances. ``baked``: (instances,) bool from ``cpu.accelerator.Accelerator``."""
    rows = {name: _Rows(dtype) for name, dtype in TABLES.items() if name not in _MADE_HERE}
    wanted = scene.looked_up()
    attributes = _Attributes(wanted, rows["attribute_values"])
    instances = np.zeros(len(scene.instances), INSTANCE)
    meshes = np.array([instance.mesh for instance in scene.instances], np.int64)
    used, first = np.unique(meshes, return_index=True)
    places = np.zeros(len(scene.meshes), _OF_MESH)
    for number in np.argsort(first):  # in the order in which instances name them
        mesh, index = scene.meshes[used[number]], first[number]
        places[used[number]] = _place(mesh, scene.instances[index].matrix if baked[index] else None, rows)
    for name in _OF_MESH.names:
        instances[name] = places[name][meshes]
    matrices = np.array([instance.matrix for instance in scene.instances], np.float64).reshape(-1, 4, 4)
    instances["matrix"], instances["inverse"] = matrices[:, :3], inverse(matrices)[:, :3]
    instances["mirrored"] = np.linalg.det(matrices[:, :3, :3]) < 0.0
    instances["baked"] = baked
    instances["shared_end"] = 1
    instances["uneven"] = baked & stretch(matrices)
    for name in ("holdout", "catcher", "index", "random", "terminator"):
        instances[name] = [getattr(instance, name) for instance in scene.instances]
    instances["color"] = np.array([instance.color for instance in scene.instances]).reshape(-1, 4)
    slots = {}
    for instance in scene.instances:
        if instance.materials not in slots:
            slots[instance.materials] = rows["instance_materials"].add(np.array(instance.materials, np.int32))
    instances["materials"] = [slots[instance.materials] for instance in scene.instances]
    instances["material_count"] = [len(instance.materials) for instance in scene.instances]
    instances["attributes"] = [attributes.place(each, scene.meshes[each.mesh]) for each in scene.instances]
    for index, instance in enumerate(scene.instances):
        if instance.motion is not None:
            record = instances[index]
            record["poses"] = rows["instance_poses"].add(instance.motion[:, :3])
            record["pose_count"], record["time"] = len(instance.motion), NO_TIME
    tables = {name: part.join() for name, part in rows.items()}
    tables["instances"] = instances
    tables["shared_places"] = EVERYWHERE.reshape(-1).view(SHARED_PLACE)
    tables["attributes"] = np.array(attributes.records or [(0, NO_DOMAIN, 0)], ATTRIBUTE)
    return tables


def find_shared_places(tables: dict[str, np.ndarray], boxes: np.ndarray) -> None:
    """Put the places that instances share into tables of ``pack_geometry``. ``boxes`` (instances, 2, 3): least and
    greatest coordinates of all of them, in the world."""
    instances, triangles = tables["instances"], tables["triangles"]["v"]
    solid = instances["primitive"] == TRIANGLES
    counts = np.where(solid & (instances["baked"] != 0) & (instances["forms"] == 0), instances["triangle_count"], 0)
    counts *= may_compare(counts)
    owners = np.repeat(np.arange(len(counts)), counts)
    rows = np.arange(len(owners)) + np.repeat(instances["triangles"] - (np.cumsum(counts) - counts), counts)
    corners = tables["positions"]["p"][triangles[rows] + instances["positions"][owners][:, None]]
    places, counts = shared_places(corners, owners, boxes, counts > 0, solid & (counts == 0))
    instances["shared_end"] = np.cumsum(counts)
    instances["shared"] = instances["shared_end"] - counts
    tables["shared_places"] = places.reshape(-1).view(SHARED_PLACE)


def _place(mesh: Mesh, matrix: np.ndarray | None, rows: dict[str, _Rows]) -> np.ndarray:
    """Append the data of a mesh to ``rows``. Returns its record of ``_OF_MESH``. ``matrix``: that of a baked
    instance."""
    record = np.zeros((), _OF_MESH)
    positions = positions_of(mesh)
    record["triangles"], record["triangle_count"] = rows["triangles"].add(mesh.triangles), len(mesh.triangles)
    record["normals"] = -1 if mesh.normals is None else rows["corner_normals"].add(normals_of(mesh))
    record["slots"] = -1 if mesh.slots is None else rows["slots"].add(mesh.slots)
    record["positions"] = rows["positions"].add(positions if matrix is None else world_positions(positions, matrix))
    record["forms"] = 0 if mesh.motion is None else len(mesh.motion)
    record["vertex_count"] = len(mesh.positions)
    record["box_center"], record["box_size"] = box_around(mesh.positions)
    record["primitive"] = int(mesh.primitive)
    if mesh.primitive != Primitive.TRIANGLES:
        factor = 1.0 if matrix is None else world_scale(matrix)
        record["radii"] = rows["radii"].add(factor * radii_of(mesh))
        record["strands"] = rows["strand_of"].add(strand_of(mesh))
    return record


def positions_of(mesh: Mesh) -> np.ndarray:
    """(V, 3), or (K V, 3) for a mesh that deforms: the positions at one time after the other."""
    return mesh.positions if mesh.motion is None else mesh.motion.reshape(-1, 3)


def normals_of(mesh: Mesh) -> np.ndarray:
    """As ``positions_of``: the corner normals, (T, 3, 3) or (K T, 3, 3)."""
    if mesh.motion is None:
        return mesh.normals
    normals = mesh.motion_normals
    return np.concatenate([mesh.normals] * len(mesh.motion) if normals is None else list(normals))


class _Attributes:
    """Rows of the table of attributes: one for each of the ``wanted`` ones, for each mesh, and again for each instance
    that has values of its own."""

    def __init__(self, wanted: list[Attribute], values: _Rows):
        self.records: list[tuple[int, int, int]] = []
        self._wanted, self._values = wanted, values
        self._meshes: dict[int, int] = {}
        self._known: dict[int, tuple[int, int, int]] = {}

    def place(self, instance: Instance, mesh: Mesh) -> int:
        """Row of the first attribute of an instance."""
        own = bool(instance.attributes)
        if own or instance.mesh not in self._meshes:
            place = len(self.records)
            for attribute in self._wanted:
                found = instance.attributes.get(attribute) or attribute_values(mesh, attribute)
                self.records.append((0, NO_DOMAIN, 0) if found is None else self._record(found))
            if own:
                return place
            self._meshes[instance.mesh] = place
        return self._meshes[instance.mesh]

    def _record(self, found: AttributeValues) -> tuple[int, int, int]:
        key = id(found.values)
        if key not in self._known:
            start = self._values.add(np.ravel(found.values))
            self._known[key] = start, int(found.domain), found.values.shape[-1]
        return self._known[key]


def attribute_values(mesh: Mesh, attribute: Attribute) -> AttributeValues | None:
    """An attribute of a mesh; None if it has none."""
    if attribute.kind in ("uv", "tangent"):
        maps = mesh.uvs if attribute.kind == "uv" else mesh.tangents
        found = maps.get(attribute.name)
        if found is not None:
            return AttributeValues(Domain.CORNER, found)
    return mesh.attributes.get(attribute)


_TOGETHER = 64  # points in a row: NumPy is slow at reducing rows of three numbers


def bounds_of(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest coordinates (3,), float64, of (V, 3) positions, at least one."""
    whole = len(positions) // _TOGETHER * _TOGETHER
    rows = np.ascontiguousarray(positions[:whole]).reshape(-1, 3 * _TOGETHER)
    low, high = (
        reduce(np.concatenate([*reduce(rows, axis=0).reshape(-1, 3)[None], positions[whole:]]), axis=0)
        if whole
        else reduce(positions, axis=0)
        for reduce in (np.minimum.reduce, np.maximum.reduce)
    )
    return low.astype(np.float64), high.astype(np.float64)


def box_around(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Center and size (3,) of the box of generated coordinates; a side of zero length counts as 1."""
    if not len(positions):
        return np.zeros(3), np.ones(3)
    low, high = bounds_of(positions)
    return 0.5 * (low + high), np.where(high > low, high - low, 1.0)


@replaced_on_gpu
@kernel
def shares(block, instance, p):
    """Whether faces of other triangles may lie exactly at a point of an instance."""
    places = _place_table(block)
    for index in range(instance.shared, instance.shared_end):
        low, high = places[index].low, places[index].high
        if low[0] <= p[0] <= high[0] and low[1] <= p[1] <= high[1] and low[2] <= p[2] <= high[2]:
            return True
    return False


@replaced_on_gpu
@kernel
def instance_at(block, index):
    """Row of an instance that a ray has hit, with its transform at the time of the path."""
    instance = instance_table(block)[index]
    if instance.pose_count > 0 and instance.time != block.time:
        _move(block, instance)
    return instance


@kernel
def _move(block, instance):
    place = block.time * (instance.pose_count - 1)
    first = min(int(place), instance.pose_count - 2)
    part = place - first
    start = pose_table(block)[instance.poses + first].matrix
    end = pose_table(block)[instance.poses + first + 1].matrix
    m, back = instance.matrix, instance.inverse
    for row in range(3):
        for column in range(4):
            m[row, column] = start[row, column] + part * (end[row, column] - start[row, column])
    x, y, z = (m[0, 0], m[1, 0], m[2, 0]), (m[0, 1], m[1, 1], m[2, 1]), (m[0, 2], m[1, 2], m[2, 2])
    a, b, c = cross(y, z), cross(z, x), cross(x, y)
    size = dot(x, a)
    invert = 1.0 / size if size != 0.0 else 0.0
    for axis in range(3):
        back[0, axis], back[1, axis], back[2, axis] = a[axis] * invert, b[axis] * invert, c[axis] * invert
    for row in range(3):
        back[row, 3] = -(back[row, 0] * m[0, 3] + back[row, 1] * m[1, 3] + back[row, 2] * m[2, 3])
    instance.time = block.time


@replaced_on_gpu
@kernel
def form_of(block, instance):
    """For a mesh that deforms: the index of the known shape before the time of the path, and the fraction of the step
    since then."""
    if instance.forms == 0:
        return 0, 0.0
    place = block.time * (instance.forms - 1)
    first = min(int(place), instance.forms - 2)
    return first, place - first


@kernel(forceinline=True)  # see ``camera_ray``
def corner_position(block, instance, triangle, corner):
    """World position of a vertex, in float64."""
    index = instance.positions + triangle_table(block)[instance.triangles + triangle].v[corner]
    p = vec(position_table(block)[index].p) if instance.forms == 0 else moving_vertex(block, instance, index)
    return p if instance.baked else transform_point(instance.matrix, p)


@kernel
def moving_vertex(block, instance, index):
    """Position of a vertex in its object, for a mesh that deforms; ``index`` is that of its first shape."""
    form, part = form_of(block, instance)
    p = vec(position_table(block)[index + form * instance.vertex_count].p)
    if part > 0.0:
        p = madd(p, part, sub(vec(position_table(block)[index + (form + 1) * instance.vertex_count].p), p))
    return p


@kernel
def _object_normal(block, instance, triangle, u, v):
    """Normal of the mesh's corners, as stored, at a hit of a triangle."""
    form, part = form_of(block, instance)
    row = instance.normals + triangle + form * instance.triangle_count
    n = _mean_normal(normal_table(block)[row].n, u, v)
    if part > 0.0:
        n = madd(n, part, sub(_mean_normal(normal_table(block)[row + instance.triangle_count].n, u, v), n))
    return n


@kernel
def corner_normal(block, instance, triangle, corner):
    """Normal of a corner of a triangle, as it is stored."""
    return _object_normal(block, instance, triangle, 1.0 if corner == 1 else 0.0, 1.0 if corner == 2 else 0.0)


@kernel
def world_corner_normal(block, instance, triangle, corner):
    """Unit normal of a corner of a triangle in the world."""
    return normalize(transform_normal(instance.inverse, corner_normal(block, instance, triangle, corner)))


@kernel
def _even_normal(block, instance, triangle, u, v):
    """Shading normal of an instance that is put into the world, as Cycles has it: the mean of the corners' normals
    there, which scales that differ do not weigh."""
    n = scale(world_corner_normal(block, instance, triangle, 0), 1.0 - u - v)
    n = madd(n, u, world_corner_normal(block, instance, triangle, 1))
    return normalize(madd(n, v, world_corner_normal(block, instance, triangle, 2)))


@kernel
def _mean_normal(corners, u, v):
    w = 1.0 - u - v
    return (
        w * corners[0, 0] + u * corners[1, 0] + v * corners[2, 0],
        w * corners[0, 1] + u * corners[1, 1] + v * corners[2, 1],
        w * corners[0, 2] + u * corners[1, 2] + v * corners[2, 2],
    )


@kernel
def hit_material(instance, block, triangle):
    """Index of the material of a triangle of an instance."""
    slot = 0
    if instance.slots >= 0:
        slot = min(max(slot_table(block)[instance.slots + triangle], 0), instance.material_count - 1)
    return material_table(block)[instance.materials + slot]


@kernel
def find_surface(block, workspace, wo, ray_kind, footprint):
    """Fill ``SURFACE`` from the hit that ``rays.intersect`` left in the workspace, as far as the material needs it."""
    ray = ray_table(workspace)[0]
    if block.has_strands and instance_table(block)[hit_instance(ray)].primitive != TRIANGLES:
        strands.fill(block, workspace, 0, wo, ray_kind, footprint)
        return
    surface = surface_table(workspace)[0]
    _fill_surface(block, ray, surface, wo, ray_kind, footprint)
    ray.id = surface.number  # a ray that passes through the triangle does not meet it again


@kernel
def _fill_surface(block, ray, surface, wo, ray_kind, footprint):
    """Fill ``SURFACE`` from a hit."""
    surface_at(
        block,
        surface,
        hit_instance(ray),
        np.int64(ray.primitive),
        float(ray.u),
        float(ray.v),
        wo,
        ray_kind,
        footprint,
    )


@kernel
def surface_at(block, surface, index, triangle, u, v, wo, ray_kind, footprint):
    """Fill ``SURFACE`` at a point of a triangle of the instance ``index``; ``u`` and ``v`` are the weights of its
    second and third corner.

    The position comes from these in float64, not from the distance along a ray. So its error does not grow with the
    distance, and it lies in the plane of the triangle.
    """
    instance = instance_at(block, index)
    p0 = corner_position(block, instance, triangle, 0)
    edge1 = sub(corner_position(block, instance, triangle, 1), p0)
    edge2 = sub(corner_position(block, instance, triangle, 2), p0)
    position = madd(madd(p0, u, edge1), v, edge2)
    ng = normalize(cross(edge1, edge2))
    if instance.mirrored:
        ng = negate(ng)
    n = ng
    object_normal = ng
    if instance.normals >= 0:
        object_normal = _object_normal(block, instance, triangle, u, v)
        smooth = normalize(transform_normal(instance.inverse, object_normal))
        if instance.uneven:
            smooth = _even_normal(block, instance, triangle, u, v)
        if dot(smooth, smooth) > 0.5:
            n = smooth
    surface.strand = 0
    surface.number = number_of(index, triangle)
    surface.exact_origin = exact_origin(position, edge1, edge2, u, v)
    if surface.exact_origin and not shares(block, instance, position):
        surface.exact_origin = ALONE
    surface.terminator = instance.terminator if instance.normals >= 0 else 0.0
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
    surface.barycentric[0] = u
    surface.barycentric[1] = v
    surface.ray_kind = ray_kind
    surface.material = hit_material(instance, block, triangle)
    flags = shading_material_table(block)[surface.material].flags
    if flags & NEEDS_DERIVATIVES:
        surface.bump_step = BUMP_FILTER * footprint if footprint > 0.0 else BUMP_DISTANCE
        for axis in range(3):
            surface.dpdu[axis] = edge1[axis]
            surface.dpdv[axis] = edge2[axis]
    if flags & NEEDS_OBJECT_NORMAL:
        if instance.normals < 0:
            flat = ng if surface.backfacing == 0 else negate(ng)
            object_normal = normalize(transform_normal(instance.matrix, flat))
        for axis in range(3):
            surface.object_normal[axis] = object_normal[axis]
    if flags & NEEDS_RADIAL:
        _find_radial(surface, instance)


@kernel
def _find_radial(surface, instance):
    """The direction around z in generated coordinates, transformed to the world like a normal."""
    p, center, size = transform_point(instance.inverse, vec(surface.position)), instance.box_center, instance.box_size
    around = (-(p[1] - center[1]) / size[1], (p[0] - center[0]) / size[0], 0.0)
    radial = transform_normal(instance.inverse, around)
    for axis in range(3):
        surface.radial[axis] = radial[axis]


@kernel
def find_shadow_surface(block, workspace, secondary, wo):
    """Fill the inputs of ``shading.transparency`` in the workspace ``secondary``, from the hit in ``workspace``.
    Returns the material's index."""
    ray = ray_table(workspace)[0]
    surface = surface_table(secondary)[0]
    instance = instance_at(block, hit_instance(ray))
    triangle = np.int64(ray.primitive)
    if block.has_strands and instance.primitive != TRIANGLES:
        strands.fill(block, workspace, 1, wo, SHADOW, 0.0)
        return surface.material
    surface.material = hit_material(instance, block, triangle)
    # Embree returns the normal of the triangle as it was built: in world space if baked, else in the mesh's local
    # space.
    facing = dot(hit_normal(ray), wo if instance.baked else transform_vector(instance.inverse, wo))
    if instance.baked and instance.mirrored:
        facing = -facing
    surface.backfacing = 1 if facing < 0.0 else 0
    surface.ray_kind = SHADOW
    surface.instance = hit_instance(ray)
    surface.primitive = triangle
    surface.barycentric[0] = ray.u
    surface.barycentric[1] = ray.v
    for axis in range(3):
        surface.wo[axis] = wo[axis]
    if shading_material_table(block)[surface.material].flags & NEEDS_SHADOW_POINT:
        _fill_surface(block, ray, surface, wo, SHADOW, 0.0)
    return surface.material
