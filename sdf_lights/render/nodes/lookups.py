# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions of formulas that look up data of the scene: attributes, transforms, tables, images.

Each is a kernel of the CPU, which the GPU's translator also reads. The NumPy reference has its own versions
(``reference/nodes.py``).
"""

from __future__ import annotations

import math

import numpy as np

from ...graph.functions import Function
from ...jit import kernel, table
from ...vec import dot, length, normalize, scale, sub, transform_normal, transform_point, transform_vector, vec
from ..kernels.camera import FIRST_PANORAMA, MIRROR_BALL, ORTHOGRAPHIC, camera_table, panorama_place
from ..kernels.geometry import (
    CORNER,
    SPHERES,
    TRIANGLE_DOMAIN,
    TRIANGLES,
    VERTEX,
    attribute_table,
    attribute_value_table,
    corner_position,
    form_of,
    instance_table,
    radius_table,
    surface_table,
    triangle_table,
)
from ..kernels.textures import texture_lookup
from ..kernels.voxels import BY_CHANCE, CUBIC, LINEAR, grid_value

_constants = table("constants", np.float64)


@kernel
def _attribute_value(block, start, width, row):
    """A row of an attribute as four numbers: a single number is grey, and a missing alpha is 1."""
    values = attribute_value_table(block)
    first = start + row * width
    x = float(values[first])
    if width == 1:
        return x, x, x, 1.0
    y = float(values[first + 1])
    if width == 2:
        return x, y, 0.0, 1.0
    z = float(values[first + 2])
    if width == 3:
        return x, y, z, 1.0
    return x, y, z, float(values[first + 3])


@kernel
def _attribute(block, workspace, missing_alpha, place, u, v):
    surface = surface_table(workspace)[0]
    instance = instance_table(block)[surface.instance]
    record = attribute_table(block)[instance.attributes + int(place)]
    start, width, domain = record.start, record.width, record.domain
    if domain < 0:
        return 0.0, 0.0, 0.0, float(missing_alpha), 0.0
    if domain == CORNER or domain == VERTEX:
        first = surface.primitive * 3
        i, j, k = first, first + 1, first + 2
        if domain == VERTEX:
            triangle = triangle_table(block)[instance.triangles + surface.primitive]
            i, j, k = np.int64(triangle.v[0]), np.int64(triangle.v[1]), np.int64(triangle.v[2])
        a, b = _attribute_value(block, start, width, i), _attribute_value(block, start, width, j)
        c = _attribute_value(block, start, width, k)
        w = 1.0 - u - v
        x, y = w * a[0] + u * b[0] + v * c[0], w * a[1] + u * b[1] + v * c[1]
        z, alpha = w * a[2] + u * b[2] + v * c[2], w * a[3] + u * b[3] + v * c[3]
    else:
        x, y, z, alpha = _attribute_value(block, start, width, surface.primitive if domain == TRIANGLE_DOMAIN else 0)
    return x, y, z, alpha, x if width <= 2 else (x + y + z) / 3.0


@kernel
def attribute_here(block, workspace, place):
    """Attribute number ``place`` at the workspace's surface: (x, y, z, alpha, grey). If there is none, alpha is 1 and
    the rest 0."""
    barycentric = surface_table(workspace)[0].barycentric
    return _attribute(block, workspace, 1, place, barycentric[0], barycentric[1])


@kernel
def _object_matrix(block, workspace):
    return instance_table(block)[surface_table(workspace)[0].instance]


@kernel
def _to_object_point(block, workspace, x, y, z):
    return transform_point(_object_matrix(block, workspace).inverse, (x, y, z))


@kernel
def _to_object_vector(block, workspace, x, y, z):
    return transform_vector(_object_matrix(block, workspace).inverse, (x, y, z))


@kernel
def _to_object_normal(block, workspace, x, y, z):
    return normalize(transform_normal(_object_matrix(block, workspace).matrix, (x, y, z)))


@kernel
def _from_object_point(block, workspace, x, y, z):
    return transform_point(_object_matrix(block, workspace).matrix, (x, y, z))


@kernel
def _from_object_vector(block, workspace, x, y, z):
    return transform_vector(_object_matrix(block, workspace).matrix, (x, y, z))


@kernel
def _from_object_normal(block, workspace, x, y, z):
    return normalize(transform_normal(_object_matrix(block, workspace).inverse, (x, y, z)))


@kernel
def _object_info(block, workspace):
    instance = _object_matrix(block, workspace)
    m, color = instance.matrix, instance.color
    return m[0, 3], m[1, 3], m[2, 3], color[0], color[1], color[2], color[3], float(instance.index), instance.random


@kernel
def _seen(camera, x, y, z):
    """A vector in the view of the camera: x to the right, y up, z into the picture."""
    m = camera.matrix
    return (
        m[0, 0] * x + m[1, 0] * y + m[2, 0] * z,
        m[0, 1] * x + m[1, 1] * y + m[2, 1] * z,
        -(m[0, 2] * x + m[1, 2] * y + m[2, 2] * z),
    )


@kernel
def _to_camera_vector(block, workspace, x, y, z):
    """Camera space of Blender's nodes: x to the right, y up, z into the picture. For panoramas it is that of Cycles: x
    into the picture, y to the left, z up; for mirror balls x to the right, y out of the picture, z up."""
    camera = camera_table(block)[0]
    x, y, z = _seen(camera, x, y, z)
    if camera.projection == MIRROR_BALL:
        return x, -z, y
    if camera.projection >= FIRST_PANORAMA:
        return z, -x, y
    return x, y, z


@kernel
def _to_camera_point(block, workspace, x, y, z):
    m = camera_table(block)[0].matrix
    return _to_camera_vector(block, workspace, x - m[0, 3], y - m[1, 3], z - m[2, 3])


@kernel
def _from_camera_vector(block, workspace, x, y, z):
    camera = camera_table(block)[0]
    if camera.projection == MIRROR_BALL:
        x, y, z = x, z, -y
    elif camera.projection >= FIRST_PANORAMA:
        x, y, z = -y, z, x
    return transform_vector(camera.matrix, (x, y, -z))


@kernel
def _from_camera_point(block, workspace, x, y, z):
    m = camera_table(block)[0].matrix
    x, y, z = _from_camera_vector(block, workspace, x, y, z)
    return x + m[0, 3], y + m[1, 3], z + m[2, 3]


@kernel
def _to_window(block, workspace, x, y, z):
    """Position in the frame, 0 to 1 from its lower left corner, of a world point."""
    camera = camera_table(block)[0]
    m = camera.matrix
    x, y, z = _seen(camera, x - m[0, 3], y - m[1, 3], z - m[2, 3])
    width, height = camera.step[0] * camera.columns, camera.step[1] * camera.rows
    if camera.projection >= FIRST_PANORAMA:
        x, y = panorama_place(camera, x, y, z)
    elif camera.projection != ORTHOGRAPHIC:
        if z <= 0.0:
            return 0.0, 0.0, 0.0
        x, y = x / z, y / z
    return (x - camera.corner[0]) / width, (y - camera.corner[1]) / height, 0.0


@kernel
def _table(block, workspace, columns, extrapolates, start, rows, position):
    """The row at a position from 0 to 1, interpolated; beyond the ends the last row, or an extrapolation of the last
    slope."""
    values, first, count = _constants(block), int(start), int(rows)
    x = position * (count - 1)
    inside = min(max(x, 0.0), count - 1.0)
    row = min(int(inside), count - 2)
    share = x - row if extrapolates else inside - row
    a, b = first + columns * row, first + columns * (row + 1)
    if columns == 1:
        value = values[a] + share * (values[b] - values[a])
        return value, value, value, value
    if columns == 3:
        return (
            values[a] + share * (values[b] - values[a]),
            values[a + 1] + share * (values[b + 1] - values[a + 1]),
            values[a + 2] + share * (values[b + 2] - values[a + 2]),
            1.0,
        )
    return (
        values[a] + share * (values[b] - values[a]),
        values[a + 1] + share * (values[b + 1] - values[a + 1]),
        values[a + 2] + share * (values[b + 2] - values[a + 2]),
        values[a + 3] + share * (values[b + 3] - values[a + 3]),
    )


@kernel
def _edge_distance(p, a, b):
    """Distance of a point to the line through a and b."""
    along = normalize(sub(b, a))
    to = sub(p, a)
    return length(sub(to, scale(along, dot(to, along))))


@kernel
def _wireframe(block, workspace, x, y, z):
    """Distance in metres to the nearest edge of the triangle."""
    surface = surface_table(workspace)[0]
    instance = instance_table(block)[surface.instance]
    if instance.primitive != TRIANGLES:
        return np.inf
    triangle = np.int64(surface.primitive)
    a, b, c = (
        corner_position(block, instance, triangle, 0),
        corner_position(block, instance, triangle, 1),
        corner_position(block, instance, triangle, 2),
    )
    p = (x, y, z)
    return min(_edge_distance(p, a, b), _edge_distance(p, b, c), _edge_distance(p, c, a))


_THIRD = 1.0 / math.sqrt(3.0)


@kernel
def _vertex_radius(block, instance, vertex):
    form, part = form_of(block, instance)
    radii, place = radius_table(block), instance.radii + vertex
    if len(radii) == instance.radii + instance.vertex_count or part <= 0.0:
        return float(radii[place])
    first = float(radii[place + form * instance.vertex_count])
    return first + part * (float(radii[place + (form + 1) * instance.vertex_count]) - first)


@kernel
def _in_world(instance, size):
    """A radius or a thickness in world space: scaled like the diagonal."""
    if instance.baked:
        return size
    return length(transform_vector(instance.matrix, (size * _THIRD, size * _THIRD, size * _THIRD)))


@kernel
def _strand_info(block, workspace, scaled):
    surface = surface_table(workspace)[0]
    if surface.strand == 0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    instance = instance_table(block)[surface.instance]
    row = triangle_table(block)[instance.triangles + surface.primitive]
    first = _vertex_radius(block, instance, np.int64(row.v[0]))
    last = _vertex_radius(block, instance, np.int64(row.v[1]))
    thickness = 2.0 * (first + surface.barycentric[0] * (last - first))
    tangent, wo = vec(surface.dpdu), vec(surface.wo)
    n = normalize(sub(wo, scale(tangent, dot(tangent, wo) / max(dot(tangent, tangent), 1e-300))))
    return 1.0, _in_world(instance, thickness) if scaled else thickness, n[0], n[1], n[2]


@kernel
def _point_info(block, workspace):
    surface = surface_table(workspace)[0]
    instance = instance_table(block)[surface.instance]
    if instance.primitive != SPHERES:
        return 0.0, 0.0, 0.0, 0.0
    x, y, z = corner_position(block, instance, np.int64(surface.primitive), 0)
    vertex = np.int64(triangle_table(block)[instance.triangles + surface.primitive].v[0])
    return x, y, z, _in_world(instance, _vertex_radius(block, instance, vertex))


def _scene(name: str, kernel, results: int, *static: int) -> Function:
    return Function(name, kernel, static, results, scene=True)


def _of_object(name: str, kernel, results: int, *static: int) -> Function:
    return Function(name, kernel, static, results, scene=True, of_object=True)


ATTRIBUTE = _of_object("attribute", _attribute, 5, 1)
"""(place, u, v) → four numbers, and their conversion to one by Blender; ``place`` is a parameter that is an
``Attribute``. If there is no such attribute, alpha is 1 and the rest 0."""

COLOR_ATTRIBUTE = _of_object("attribute", _attribute, 5, 0)
"""The same, but everything is 0 if there is none."""
ATTRIBUTE_HERE = _of_object("attribute_here", attribute_here, 5)
"""(place) → as ``ATTRIBUTE``, at the point itself, which bumps do not shift."""

GRID = {
    "LINEAR": _of_object("grid", grid_value, 5, LINEAR),
    "CUBIC": _of_object("grid", grid_value, 5, CUBIC),
    "BY_CHANCE": _of_object("grid", grid_value, 5, BY_CHANCE),
}
"""(place, x, y, z) → as ``COLOR_ATTRIBUTE``, of a grid of voxels at a world point: by Cycles' interpolation of a
material, or see ``kernels.voxels``."""

TO_OBJECT = {
    "POINT": _of_object("to_object_point", _to_object_point, 3),
    "VECTOR": _of_object("to_object_vector", _to_object_vector, 3),
    "NORMAL": _of_object("to_object_normal", _to_object_normal, 3),
}
FROM_OBJECT = {
    "POINT": _of_object("from_object_point", _from_object_point, 3),
    "VECTOR": _of_object("from_object_vector", _from_object_vector, 3),
    "NORMAL": _of_object("from_object_normal", _from_object_normal, 3),
}
TO_CAMERA = {
    "POINT": _scene("to_camera_point", _to_camera_point, 3),
    "VECTOR": _scene("to_camera_vector", _to_camera_vector, 3),
    "NORMAL": _scene("to_camera_vector", _to_camera_vector, 3),
}
FROM_CAMERA = {
    "POINT": _scene("from_camera_point", _from_camera_point, 3),
    "VECTOR": _scene("from_camera_vector", _from_camera_vector, 3),
    "NORMAL": _scene("from_camera_vector", _from_camera_vector, 3),
}
TO_WINDOW = _scene("to_window", _to_window, 3)
OBJECT_INFO = _of_object("object_info", _object_info, 9)
"""→ location, colour, alpha, index, random number of the object."""

STRAND_INFO = _of_object("strand_info", _strand_info, 5, 1)
"""→ 1 on a curve of hair, its thickness, and its normal nearest to the view."""
UNSCALED_STRAND_INFO = _of_object("strand_info", _strand_info, 5, 0)
"""The same, but the thickness is in object space, as before Blender 5.0."""
POINT_INFO = _of_object("point_info", _point_info, 4)
"""→ center and radius of the sphere of a point cloud."""
WIREFRAME = _of_object("wireframe", _wireframe, 1)


def table_of(columns: int, extrapolates: bool = False) -> Function:
    """(start, rows, position) → four numbers; ``start`` is a parameter that is a ``Table``."""
    return _scene("table", _table, 4, columns, int(extrapolates))


IMAGE = _scene("image", texture_lookup, 4)
"""(place, u, v) → RGBA; ``place`` is a parameter that is a ``Texture``, below 0 for nothing at all."""
