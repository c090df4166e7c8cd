# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The interpreter of value instructions: what the nodes of a material compute at one point of a surface."""

import math

import numpy as np

from ....jit import kernel, table
from ....vec import (
    add, average, cross, dot, length, lerp, luminance, negate, normalize, scale, sub, to_world, transform_normal,
    vec)
from ..textures import image_lookup
from .program import (
    FLAT, INSTRUCTION, NONE, NORMAL_VECTOR, OBJECT, OP_ADD, OP_AVERAGE, OP_BROADCAST, OP_BUMP, OP_CLAMP, OP_COMPLEMENT,
    OP_IMAGE, OP_LUMINANCE, OP_MAPPING, OP_MATRIX, OP_MULTIPLY, OP_NORMAL_MAP, OP_UV, POINT, SPHERE, TANGENT, TEXTURE)
from .records import surface_table

_constants = table("constants", np.float64)
_instructions = table("instructions", INSTRUCTION)
_registers = table("registers", np.float64)

# Bump mapping takes differences over this part of a pixel (Blender's filter width), or over this distance in metres
# where the pixel's width is not known. Bilinear texels make the result all but independent of it.
_BUMP_FILTER = 0.1
_BUMP_DISTANCE = 1e-4


@kernel
def number(block, workspace, operand):
    return _registers(workspace)[operand] if operand >= 0 else _constants(block)[~operand]


@kernel
def vector(block, workspace, operand):
    if operand >= 0:
        registers = _registers(workspace)
        return (registers[operand], registers[operand + 1], registers[operand + 2])
    constants, i = _constants(block), ~operand
    return (constants[i], constants[i + 1], constants[i + 2])


@kernel
def normal(block, workspace, operand):
    """The unit normal of an input; the shading normal where there is none or it vanishes."""
    n = vec(surface_table(workspace)[0].n)
    if operand == NONE:
        return n
    given = normalize(vector(block, workspace, operand))
    square = dot(given, given)
    return given if 0.5 < square < 2.0 else n


@kernel
def _store(workspace, out, v):
    registers = _registers(workspace)
    registers[out] = v[0]
    registers[out + 1] = v[1]
    registers[out + 2] = v[2]


@kernel
def bump_step(surface):
    """Distance over which bump mapping takes differences."""
    return _BUMP_FILTER * surface.footprint if surface.footprint > 0.0 else _BUMP_DISTANCE


@kernel
def _uv(surface, layer, shift):
    u, v = surface.uv[layer, 0], surface.uv[layer, 1]
    if shift == 1:
        step = bump_step(surface) / max(length(vec(surface.dpdu)), 1e-30)
        return (u + step * surface.uv_du[layer, 0], v + step * surface.uv_du[layer, 1], 0.0)
    if shift == 2:
        step = bump_step(surface) / max(length(vec(surface.dpdv)), 1e-30)
        return (u + step * surface.uv_dv[layer, 0], v + step * surface.uv_dv[layer, 1], 0.0)
    return (u, v, 0.0)


@kernel
def _matrix(block, operand, v):
    m, i = _constants(block), ~operand
    return (
        m[i] * v[0] + m[i + 1] * v[1] + m[i + 2] * v[2] + m[i + 3],
        m[i + 4] * v[0] + m[i + 5] * v[1] + m[i + 6] * v[2] + m[i + 7],
        m[i + 8] * v[0] + m[i + 9] * v[1] + m[i + 10] * v[2] + m[i + 11],
    )


@kernel
def _turn(v, angles):
    """Rotation about x, then y, then z."""
    c, s = math.cos(angles[0]), math.sin(angles[0])
    v = (v[0], c * v[1] - s * v[2], s * v[1] + c * v[2])
    c, s = math.cos(angles[1]), math.sin(angles[1])
    v = (c * v[0] + s * v[2], v[1], c * v[2] - s * v[0])
    c, s = math.cos(angles[2]), math.sin(angles[2])
    return (c * v[0] - s * v[1], s * v[0] + c * v[1], v[2])


@kernel
def _turn_back(v, angles):
    c, s = math.cos(angles[2]), math.sin(angles[2])
    v = (c * v[0] + s * v[1], c * v[1] - s * v[0], v[2])
    c, s = math.cos(angles[1]), math.sin(angles[1])
    v = (c * v[0] - s * v[2], v[1], c * v[2] + s * v[0])
    c, s = math.cos(angles[0]), math.sin(angles[0])
    return (v[0], c * v[1] + s * v[2], c * v[2] - s * v[1])


@kernel
def _divide(a, b):
    """a / b of each component, 0 where b is 0."""
    return (
        a[0] / b[0] if b[0] != 0.0 else 0.0, a[1] / b[1] if b[1] != 0.0 else 0.0, a[2] / b[2] if b[2] != 0.0 else 0.0)


@kernel
def _mapping(v, location, rotation, size, kind):
    if kind == TEXTURE:
        return _divide(_turn_back(sub(v, location), rotation), size)
    if kind == NORMAL_VECTOR:
        return normalize(_turn(_divide(v, size), rotation))
    v = _turn((v[0] * size[0], v[1] * size[1], v[2] * size[2]), rotation)
    return add(v, location) if kind == POINT else v


@kernel
def _project(v, projection):
    """Image coordinates of a point of the unit cube, about whose middle a sphere or a tube stands."""
    if projection == FLAT:
        return v[0], v[1]
    x, y, z = 2.0 * v[0] - 1.0, 2.0 * v[1] - 1.0, 2.0 * v[2] - 1.0
    u = 0.5 - math.atan2(x, y) / (2.0 * math.pi) if x != 0.0 or y != 0.0 else 0.0
    if projection == SPHERE:
        distance = math.sqrt(x * x + y * y + z * z)
        return u, 1.0 - math.acos(min(max(z / distance, -1.0), 1.0)) / math.pi if distance > 0.0 else 0.0
    return u, 0.5 * (z + 1.0)


@kernel
def _normal_map(surface, color, strength, layer, space):
    n = vec(surface.n)
    x, y, z = 2.0 * color[0] - 1.0, 2.0 * color[1] - 1.0, 2.0 * color[2] - 1.0
    strength = max(strength, 0.0)
    if space == TANGENT:
        tangent, sign = vec(surface.tangent[layer]), surface.tangent[layer, 3]
        base = vec(surface.object_normal)
        if sign == 0.0:
            return n
        # MikkTSpace: interpolated vectors enter unnormalised, in the space in which the map was baked.
        mapped = to_world(
            (x * strength, y * strength, 1.0 + (z - 1.0) * min(strength, 1.0)), tangent,
            scale(cross(base, tangent), sign), base)
        mapped = normalize(transform_normal(surface.world_to_object, mapped))
        strength = 1.0
    elif space == OBJECT:
        mapped = normalize(transform_normal(surface.world_to_object, (x, y, z)))
    else:
        mapped = normalize((x, y, z))
    if dot(mapped, mapped) < 0.5:
        return n
    if surface.backfacing:
        mapped = negate(mapped)
    return normalize(lerp(n, mapped, strength)) if strength != 1.0 else mapped


@kernel
def _bump(surface, n, height, height_u, height_v, strength, distance):
    """Normal of the surface raised by ``distance`` × height (Mikkelsen 2010, "Bump mapping unparametrized surfaces on
    the GPU"); the heights are one step apart along the triangle's edges."""
    if strength <= 0.0:
        return n
    step = bump_step(surface)
    du, dv = normalize(vec(surface.dpdu)), normalize(vec(surface.dpdv))
    ru, rv = cross(dv, n), cross(n, du)
    determinant = dot(du, ru)
    gradient = add(scale(ru, (height_u - height) / step), scale(rv, (height_v - height) / step))
    rise = distance if determinant >= 0.0 else -distance
    bumped = normalize(sub(scale(n, abs(determinant)), scale(gradient, rise)))
    return normalize(lerp(n, bumped, strength)) if dot(bumped, bumped) > 0.5 else n


@kernel
def run(block, workspace, first, end):
    """Execute the instructions [first, end)."""
    surface = surface_table(workspace)[0]
    instructions = _instructions(block)
    registers = _registers(workspace)
    for i in range(first, end):
        instruction = instructions[i]
        op, out, args = instruction.op, instruction.out, instruction.args
        if op == OP_UV:
            _store(workspace, out, _uv(surface, args[0], args[1]))
        elif op == OP_IMAGE:
            u, v = _project(vector(block, workspace, args[0]), args[4])
            r, g, b, a = image_lookup(block, args[1], u, v, args[2], args[3], args[5])
            _store(workspace, out, (r, g, b))
            registers[out + 3] = a
        elif op == OP_MATRIX:
            v3 = _matrix(block, args[1], vector(block, workspace, args[0]))
            _store(workspace, out, normalize(v3) if args[2] else v3)
        elif op == OP_MAPPING:
            _store(workspace, out, _mapping(
                vector(block, workspace, args[0]), vector(block, workspace, args[1]), vector(block, workspace, args[2]),
                vector(block, workspace, args[3]), args[4]))
        elif op == OP_NORMAL_MAP:
            _store(workspace, out, _normal_map(
                surface, vector(block, workspace, args[0]), number(block, workspace, args[1]), args[2], args[3]))
        elif op == OP_BUMP:
            distance = number(block, workspace, args[4])
            _store(workspace, out, _bump(
                surface, normal(block, workspace, args[5]), number(block, workspace, args[0]),
                number(block, workspace, args[1]), number(block, workspace, args[2]),
                number(block, workspace, args[3]), -distance if args[6] else distance))
        elif op == OP_BROADCAST:
            value = number(block, workspace, args[0])
            _store(workspace, out, (value, value, value))
        elif op == OP_LUMINANCE:
            registers[out] = luminance(vector(block, workspace, args[0]))
        elif op == OP_AVERAGE:
            registers[out] = average(vector(block, workspace, args[0]))
        elif op == OP_MULTIPLY:
            registers[out] = number(block, workspace, args[0]) * number(block, workspace, args[1])
        elif op == OP_ADD:
            registers[out] = number(block, workspace, args[0]) + number(block, workspace, args[1])
        elif op == OP_CLAMP:
            registers[out] = min(max(number(block, workspace, args[0]), 0.0), 1.0)
        elif op == OP_COMPLEMENT:
            registers[out] = 1.0 - min(max(number(block, workspace, args[0]), 0.0), 1.0)
