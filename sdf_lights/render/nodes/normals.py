# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that make normals: maps, bumps, displacement."""

from __future__ import annotations

from collections.abc import Sequence

from ...graph.formula import Formula, Vector, call, clamp, constant, length, maximum, select
from ...graph.substitution import rewritten
from ..material import Attribute, Node
from .definition import NodeInputs, defines
from .geometry import attribute, facing, from_object, to_object
from .lookups import ATTRIBUTE, ATTRIBUTE_HERE
from .variables import (
    BARYCENTRIC,
    BUMP_STEP,
    EDGES,
    NORMAL,
    OBJECT_NORMAL,
    POSITION,
    as_vector,
    footprint_axes,
    shifted,
)


def unit_or(vector: Vector, otherwise: Vector) -> Vector:
    """The vector with length 1, or another one if it vanishes."""
    square = vector.dot(vector)
    unit = vector.normalized()
    return Vector(*(select(square < 1e-24, b, a) for a, b in zip(unit, otherwise)))


@defines("ShaderNodeNormalMap")
def normal_map(node: NodeInputs):
    """Tangent, object and world space, with Blender's swapped axes too."""
    x, y, z = node.color("Color") * 2.0 - 1.0
    if node.setting("convention") == "DIRECTX":
        y = -y
    strength = node.number("Strength")
    space = node.setting("space")
    if space == "TANGENT":
        # MikkTSpace: interpolated vectors are used without normalisation, as when the map was baked.
        tx, ty, tz, sign = attribute(node, Attribute("tangent", node.setting("uv_map") or ""))
        tangent = Vector(tx, ty, tz)
        bitangent = OBJECT_NORMAL.cross(tangent) * sign
        local = tangent * (x * strength) + bitangent * (y * strength)
        local = local + OBJECT_NORMAL * (1.0 + (z - 1.0) * clamp(strength, 0.0, 1.0))
        mapped = facing(from_object(local, "NORMAL"))
        found = unit_or(mapped, NORMAL)
        return {"Normal": Vector(*(select(tangent.dot(tangent) <= 0.0, b, a) for a, b in zip(found, NORMAL)))}
    if space.startswith("BLENDER"):
        y, z = -y, -z
    given = Vector(x, y, z)
    mapped = from_object(given, "NORMAL") if space.endswith("OBJECT") else given.normalized()
    mapped = facing(mapped)
    return {"Normal": unit_or(NORMAL + (mapped - NORMAL) * maximum(strength, 0.0), NORMAL)}


def bumped(
    normal: Vector, height: Formula, distance: Formula, strength: Formula, steps: Formula | float = 1.0
) -> Vector:
    """Normal of the surface raised by ``distance`` × height: Mikkelsen 2010, "Bump mapping unparametrized surfaces on
    the GPU", equation 4, with differences over so many ``steps`` along two axes of the surface."""
    step = BUMP_STEP * steps
    axes = footprint_axes()
    slopes = [(shifted(height, axis, step) - height) / step for axis in axes]
    return _tilted(normal, axes, slopes, distance, strength)


def _tilted(
    normal: Vector, along: Sequence[Vector], slopes: list[Formula], distance: Formula, strength: Formula
) -> Vector:
    """``bumped`` from the slopes of the height along two unit vectors."""
    du, dv = along
    ru, rv = dv.cross(normal), normal.cross(du)
    determinant = du.dot(ru)
    rise = select(determinant < 0.0, -distance, distance)
    gradient = ru * slopes[0] + rv * slopes[1]
    raised = unit_or(normal * abs(determinant) - gradient * rise, normal)
    return unit_or(normal + (raised - normal) * maximum(strength, 0.0), normal)


@defines("ShaderNodeBump")
def bump(node: NodeInputs):
    """Heights as normals."""
    normal = node.normal("Normal")
    if not node.varies("Height"):
        return {"Normal": normal if node.varies("Normal") else NORMAL}
    distance = -node.number("Distance") if node.setting("invert") else node.number("Distance")
    steps = maximum(node.number("Filter Width"), 1e-3) * 10.0 if node.has("Filter Width") else 1.0
    return {"Normal": bumped(normal, node.number("Height"), distance, node.number("Strength"), steps)}


def _bumped_before(height: Formula, place: Formula) -> Vector:
    """``bumped`` by a height on the surface before displacement; ``place`` is the index of the attribute with the
    original position.

    As in Cycles, normals and lengths are in object space, and heights in world space.
    """

    def at(u: Formula, v: Formula) -> Vector:
        return as_vector(call(ATTRIBUTE, place, u, v))

    zero, one = constant(0.0), constant(1.0)
    first = at(zero, zero)
    edges = [end - first for end in (at(one, zero), at(zero, one))]
    placed = [from_object(edge, "VECTOR") for edge in edges]
    known: dict[Formula, Formula] = dict(zip(POSITION, from_object(at(*BARYCENTRIC))))
    for variables, edge in zip(EDGES, placed):
        known |= dict(zip(variables, edge))
    slopes = rewritten(
        [(shifted(height, edge.normalized()) - height) / BUMP_STEP for edge in EDGES], known, lambda node: node
    )
    slopes = [slope * length(*there) / maximum(length(*own), 1e-30) for slope, there, own in zip(slopes, placed, edges)]
    tilted = _tilted(to_object(NORMAL, "NORMAL"), [edge.normalized() for edge in edges], slopes, one, one)
    return from_object(tilted, "NORMAL")


@defines("ShaderNodeDisplacement")
def displacement(node: NodeInputs):
    """Heights along the normal, in object and world space: of the mesh, as bump, or both."""
    normal = unit_or(node.normal("Normal"), NORMAL)
    height = (node.number("Height") - node.number("Midlevel")) * node.number("Scale")
    if node.setting("space") == "OBJECT":
        return {"Displacement": from_object(to_object(normal, "NORMAL") * height, "VECTOR")}
    return {"Displacement": normal * height}


@defines("ShaderNodeVectorDisplacement")
def vector_displacement(node: NodeInputs):
    """In tangent, object and world space: of the mesh, as bump by the component along the normal, or both."""
    moved = (node.color("Vector") - node.number("Midlevel")) * node.number("Scale")
    space = node.setting("space")
    if space == "WORLD":
        return {"Displacement": moved}
    if space == "OBJECT":
        return {"Displacement": from_object(moved, "VECTOR")}
    tx, ty, tz, sign, _ = call(ATTRIBUTE_HERE, node.parameter(Attribute("tangent")))
    tangent, normal = Vector(tx, ty, tz), to_object(NORMAL, "NORMAL")
    local = tangent * moved.x + normal * moved.y + normal.cross(tangent) * sign * moved.z
    return {"Displacement": from_object(local, "VECTOR")}


def displaced_as_bump(surface: Node, moved: Vector, undisplaced: Formula | None = None) -> tuple[Node, Vector]:
    """The normal that the surface would have if ``moved`` displaced its points, as in Cycles' bump from displacement;
    and the closures with it as their shading normal.

    ``undisplaced``: index of the attribute with the original positions, if the points have already moved but the
    normals have not.
    """
    height, one = moved.dot(NORMAL), constant(1.0)
    normal = bumped(NORMAL, height, one, one) if undisplaced is None else _bumped_before(height, undisplaced)
    known = dict(zip(NORMAL, normal))
    written: dict[int, Node] = {}

    def rewrite(value):
        if isinstance(value, Node):
            if id(value) not in written:
                inputs = {name: rewrite(entry) for name, entry in value.inputs.items()}
                written[id(value)] = Node(value.kind, inputs, value.settings)
            return written[id(value)]
        if isinstance(value, Vector):
            return Vector(*rewritten(value, known, lambda node: node))
        return rewritten((value,), known, lambda node: node)[0] if isinstance(value, Formula) else value

    return rewrite(surface), normal
