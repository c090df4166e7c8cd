# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes for the position on an object: coordinates, attributes, the geometry itself."""

from __future__ import annotations

import numpy as np

from ...graph.formula import Formula, Vector, call, constant, length, select
from ...graph.functions import Function
from ..material import Attribute
from . import lookups
from .definition import WITHOUT_SURFACE, NodeInputs, defines, mean
from .projections import light_place
from .variables import (
    BACKFACING,
    BARYCENTRIC,
    BUMP_STEP,
    INCOMING,
    NORMAL,
    POSITION,
    TRUE_NORMAL,
    as_vector,
    footprint_axes,
    where,
)

FIRST_PARTICLE = 0xDC3D74F9 / 0xFFFFFFFF  # random number of particle 0
ZERO = Vector(*[constant(0.0)] * 3)
OF_OBJECTS = {"object", "instancer", "view_layer", "instancer_generated", "instancer_uv", "texture_space"}
"""Kinds of attributes that have one value all over an object, so that points inside it have them, too."""


def attribute(node: NodeInputs, found: Attribute, function: Function = lookups.ATTRIBUTE) -> tuple[Formula, ...]:
    """Four numbers of an attribute at the point; worlds and lights have none, and volumes only those of objects."""
    if (
        node.setting("domain") in ("WORLD", "LIGHT")
        or node.setting("domain") == "VOLUME"
        and found.kind not in OF_OBJECTS
    ):
        return (constant(0.0),) * 4
    return call(function, node.parameter(found), *BARYCENTRIC)[:4]


def generated(node: NodeInputs) -> Vector:
    """Generated texture coordinates: the bounding box of the undeformed mesh is [0, 1]³. Lights have no mesh: theirs
    are object coordinates, as in Cycles. Inside a mesh they are in the undeformed box, too."""
    if node.setting("domain") == "LIGHT":
        return in_object(node)
    if node.setting("domain") == "VOLUME":
        scale, offset = (as_vector(attribute(node, Attribute("texture_space", name))) for name in ("scale", "offset"))
        return in_object(node) * scale + offset
    return as_vector(attribute(node, Attribute("generated")))


def in_object(node: NodeInputs) -> Vector:
    """The point in the space of the object, or of the light."""
    matrix = node.setting("light_matrix")
    return to_object(POSITION) if matrix is None else transformed(node, matrix, POSITION)


def uv(node: NodeInputs, name: str = "") -> Vector:
    """UV coordinates of the layer ``name``, or of the active one if it is empty; z is 0. For a light: see
    ``light_place``."""
    if node.setting("domain") == "LIGHT" and not name:
        return Vector(*light_place(node), constant(0.0))
    u, v, _, _ = attribute(node, Attribute("uv", name))
    return Vector(u, v, constant(0.0))


def to_object(vector: Vector, kind: str = "POINT") -> Vector:
    """From world to object space, for the ``kind`` POINT, VECTOR or NORMAL."""
    return as_vector(call(lookups.TO_OBJECT[kind], *vector))


def from_object(vector: Vector, kind: str = "POINT") -> Vector:
    """From object to world space, for the ``kind`` POINT, VECTOR or NORMAL."""
    return as_vector(call(lookups.FROM_OBJECT[kind], *vector))


def transformed(node: NodeInputs, matrix, vector: Vector) -> Vector:
    """A point by a matrix (3, 4) of parameters."""
    rows = [[node.parameter(float(entry)) for entry in row] for row in matrix]
    return Vector(*(row[0] * vector.x + row[1] * vector.y + row[2] * vector.z + row[3] for row in rows))


def transformed_normal(node: NodeInputs, matrix, normal: Vector) -> Vector:
    """A world normal in the space of a light; ``matrix`` (3, 3) is the transpose of the light's own."""
    rows = [[node.parameter(float(entry)) for entry in row] for row in matrix]
    return Vector(*(row[0] * normal.x + row[1] * normal.y + row[2] * normal.z for row in rows)).normalized()


@defines("ShaderNodeTexCoord")
def texture_coordinate(node: NodeInputs):
    """All outputs, of the object and from its instancer."""
    if node.setting("domain") == "WORLD":
        return _world_coordinates()
    instanced = node.setting("from_instancer")
    results = {}
    if "Generated" in node.wanted:
        results["Generated"] = (
            as_vector(attribute(node, Attribute("instancer_generated"))) if instanced else generated(node)
        )
    if "Normal" in node.wanted:
        turn = node.setting("light_normals")
        results["Normal"] = to_object(NORMAL, "NORMAL") if turn is None else transformed_normal(node, turn, NORMAL)
    if "UV" in node.wanted:
        results["UV"] = as_vector(attribute(node, Attribute("instancer_uv"))) if instanced else uv(node)
    if "Object" in node.wanted:
        matrix = node.setting("object_matrix")
        results["Object"] = in_object(node) if matrix is None else transformed(node, matrix, POSITION)
    if "Camera" in node.wanted:
        results["Camera"] = as_vector(call(lookups.TO_CAMERA["POINT"], *POSITION))
    if "Window" in node.wanted:
        results["Window"] = as_vector(call(lookups.TO_WINDOW, *POSITION))
    if "Reflection" in node.wanted:
        results["Reflection"] = NORMAL * (2.0 * NORMAL.dot(INCOMING)) - INCOMING
    return results


def _world_coordinates():
    """Coordinates of a direction: without a surface, it replaces the position."""
    eye = as_vector(call(lookups.FROM_CAMERA["POINT"], 0.0, 0.0, 0.0))
    return {
        "Generated": POSITION,
        "Normal": NORMAL,
        "UV": ZERO,
        "Object": POSITION,
        "Reflection": INCOMING,
        "Camera": as_vector(call(lookups.TO_CAMERA["VECTOR"], *POSITION)),
        "Window": as_vector(call(lookups.TO_WINDOW, *(POSITION + eye))),
    }


@defines("ShaderNodeUVMap")
def uv_map(node: NodeInputs):
    """The UV map by name, or the active one; or the position of an instance on its instancer."""
    if node.setting("from_instancer"):
        return {"UV": as_vector(attribute(node, Attribute("instancer_uv")))}
    return {"UV": uv(node, node.setting("uv_map") or "")}


def radial_tangent(node: NodeInputs, axis: str = "Z") -> Vector:
    """Unit tangent around an axis of the object through the middle of its generated coordinates; worlds and lights use
    positions instead."""
    p = POSITION if node.setting("domain") in ("WORLD", "LIGHT") else generated(node)
    centred = {
        "X": Vector(constant(0.0), -(p.z - 0.5), p.y - 0.5),
        "Y": Vector(-(p.z - 0.5), constant(0.0), p.x - 0.5),
        "Z": Vector(-(p.y - 0.5), p.x - 0.5, constant(0.0)),
    }[axis]
    turn = node.setting("light_normals")
    if turn is not None:
        return _across(transformed_normal(node, np.linalg.inv(turn), centred))
    return _across(from_object(centred, "NORMAL"))


def _across(along: Vector) -> Vector:
    """Unit vector in the surface nearest to ``along``."""
    return NORMAL.cross(along.cross(NORMAL).normalized()).normalized()


@defines("ShaderNodeTangent")
def tangent(node: NodeInputs):
    """Radial about each axis, or along a UV map."""
    if node.setting("direction_type") == "UV_MAP":
        found = attribute(node, Attribute("tangent", node.setting("uv_map") or ""))
        return {"Tangent": _across(from_object(as_vector(found), "NORMAL"))}
    return {"Tangent": radial_tangent(node, node.setting("axis"))}


@defines("ShaderNodeNewGeometry")
def geometry(node: NodeInputs):
    """All outputs."""
    u, v = BARYCENTRIC
    domain = node.setting("domain")
    results = {
        "Position": POSITION,
        "Normal": NORMAL,
        "True Normal": TRUE_NORMAL,
        "Incoming": INCOMING,
        "Backfacing": BACKFACING,
        "Parametric": Vector(1.0 - u - v, u, constant(0.0)),
    }
    if domain == "LIGHT" and "Parametric" in node.wanted:
        results["Parametric"] = uv(node)
    if "Tangent" in node.wanted:
        if domain == "WORLD" and node.setting("blender_version") >= (5, 2):
            results["Tangent"] = footprint_axes()[0]
        else:
            results["Tangent"] = ZERO if domain in WITHOUT_SURFACE else radial_tangent(node)
    if "Pointiness" in node.wanted:
        results["Pointiness"] = attribute(node, Attribute("pointiness"))[0]
    if "Random Per Island" in node.wanted:
        results["Random Per Island"] = attribute(node, Attribute("island"))[0]
    return results


@defines("ShaderNodeObjectInfo")
def object_info(node: NodeInputs):
    """All outputs."""
    known = node.setting("object_info")
    info = call(lookups.OBJECT_INFO) if known is None else [node.parameter(float(number)) for number in known]
    return {
        "Location": Vector(*info[:3]),
        "Color": Vector(*info[3:6]),
        "Alpha": info[6],
        "Object Index": info[7],
        "Random": info[8],
        "Material Index": node.parameter(float(node.setting("material_index"))),
    }


def grid(node: NodeInputs, name: str) -> tuple[Formula, ...]:
    """As ``lookups.GRID``: a grid of voxels of the volume; zeros if it has none of this name."""
    if node.setting("domain") != "VOLUME" or name not in node.setting("grids"):
        return (constant(0.0),) * 5
    function = lookups.GRID[node.setting("volume_interpolation")]
    return call(function, node.parameter(Attribute("grid", name)), *POSITION)


@defines("ShaderNodeAttribute")
def attribute_node(node: NodeInputs):
    """Attributes of geometry, object, instancer and view layer; in volumes grids of voxels."""
    kind = node.setting("attribute_type").lower()
    name = node.setting("attribute_name")
    if node.setting("domain") in ("WORLD", "LIGHT"):
        known = node.setting("attribute_value")
        if known is not None:
            numbers = [node.parameter(float(number)) for number in known]
            color = Vector(*(numbers * 3 if len(numbers) == 1 else [*numbers, constant(0.0)])[:3])
            return {
                "Color": color,
                "Vector": color,
                "Fac": numbers[0] if len(numbers) <= 2 else mean(color),
                "Alpha": numbers[3] if len(numbers) == 4 else constant(1.0),
            }
        return {"Color": ZERO, "Vector": ZERO, "Fac": constant(0.0), "Alpha": constant(1.0)}
    if kind == "geometry" and node.setting("domain") == "VOLUME":
        x, y, z, alpha, factor = grid(node, name)
        return {"Color": Vector(x, y, z), "Vector": Vector(x, y, z), "Fac": factor, "Alpha": alpha}
    if kind == "geometry" and not name:
        return {"Color": ZERO, "Vector": ZERO, "Fac": constant(0.0), "Alpha": constant(1.0)}
    function = lookups.ATTRIBUTE if kind == "geometry" else lookups.COLOR_ATTRIBUTE
    x, y, z, alpha, factor = call(function, node.parameter(Attribute(kind, name)), *BARYCENTRIC)
    color = Vector(x, y, z)
    return {"Color": color, "Vector": color, "Fac": factor, "Alpha": alpha}


@defines("ShaderNodeVertexColor")
def color_attribute(node: NodeInputs):
    """The colour attribute by name, or the active one."""
    x, y, z, alpha = attribute(node, Attribute("geometry", node.setting("layer_name") or ""), lookups.COLOR_ATTRIBUTE)
    return {"Color": Vector(x, y, z), "Alpha": alpha}


@defines("ShaderNodeCameraData")
def camera_data(node: NodeInputs):
    """All outputs."""
    seen = as_vector(call(lookups.TO_CAMERA["POINT"], *POSITION))
    distance = length(*seen)
    return {"View Vector": seen.normalized(), "View Z Depth": abs(seen.z), "View Distance": distance}


@defines("ShaderNodeWireframe")
def wireframe(node: NodeInputs):
    """Edges of triangles, in metres or pixels."""
    size = node.number("Size")
    if node.setting("use_pixel_size"):
        # A pixel is ten steps. As in Cycles, its width is the mean of two axes of the surface, as the camera sees them.
        seen = [axis - INCOMING * axis.dot(INCOMING) for axis in footprint_axes()]
        size = size * BUMP_STEP * 5.0 * (seen[0].length() + seen[1].length())
    if node.setting("domain") in WITHOUT_SURFACE:
        return {"Fac": constant(0.0)}
    (distance,) = call(lookups.WIREFRAME, *POSITION)
    return {"Fac": select(distance < 0.5 * abs(size), 1.0, 0.0)}


@defines("ShaderNodeParticleInfo")
def particle_info(node: NodeInputs):
    """Zero, as in Cycles for objects without a particle system."""
    return {
        "Index": constant(0.0),
        "Random": constant(FIRST_PARTICLE),
        "Age": constant(0.0),
        "Lifetime": constant(0.0),
        "Location": ZERO,
        "Size": constant(0.0),
        "Velocity": ZERO,
        "Angular Velocity": ZERO,
    }


@defines("ShaderNodeHairInfo")
def hair_info(node: NodeInputs):
    """All outputs, of hair curves and particle hair; zero elsewhere."""
    results = {"Intercept": constant(0.0), "Length": constant(0.0), "Random": constant(0.0)}
    for name in results:
        if name in node.wanted:
            results[name] = attribute(node, Attribute("strand", name.lower()))[0]
    if node.setting("domain") in WITHOUT_SURFACE:
        return {**results, "Is Strand": constant(0.0), "Thickness": constant(0.0), "Tangent Normal": ZERO}
    older = node.setting("blender_version") < (5, 0)
    strand, thickness, x, y, z = call(lookups.UNSCALED_STRAND_INFO if older else lookups.STRAND_INFO)
    return {**results, "Is Strand": strand, "Thickness": thickness, "Tangent Normal": Vector(x, y, z)}


def strand_random(place: Formula, otherwise: Formula) -> Formula:
    """The random number of a strand, for a parameter that is its ``Attribute``; ``otherwise`` if there is none."""
    number, _, _, known = call(lookups.COLOR_ATTRIBUTE, place, *BARYCENTRIC)[:4]
    return select(known < 0.5, otherwise, number)


@defines("ShaderNodePointInfo")
def point_info(node: NodeInputs):
    """All outputs, of point clouds; zero elsewhere."""
    if node.setting("domain") in WITHOUT_SURFACE:
        return {"Position": ZERO, "Radius": constant(0.0), "Random": constant(0.0)}
    x, y, z, radius = call(lookups.POINT_INFO)
    random = attribute(node, Attribute("point", "random"))[0] if "Random" in node.wanted else constant(0.0)
    return {"Position": Vector(x, y, z), "Radius": radius, "Random": random}


@defines("ShaderNodeVolumeInfo")
def volume_info(node: NodeInputs):
    """The grids "color", "density", "flame" and "temperature" of a volume; zero where there are none."""
    # As in Cycles, a grid that nothing reads does not count.
    found = {
        name: grid(node, name.lower()) for name in ("Color", "Density", "Flame", "Temperature") if name in node.wanted
    }
    return {name: Vector(*values[:3]) if name == "Color" else values[4] for name, values in found.items()}


def facing(normal: Vector) -> Vector:
    """A normal on the side of the viewer."""
    return Vector(*(where(BACKFACING, -axis, axis) for axis in normal))
