# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that compute with numbers and vectors.

Undefined operations have the values of Cycles: 0 for a division by 0, for a root or a power that is not real, for a
logarithm of a number that is not positive.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable

from ...graph.formula import (
    Formula,
    Vector,
    apply,
    atan2,
    clamp,
    constant,
    cos,
    exp,
    floor,
    log,
    maximum,
    minimum,
    power,
    select,
    sin,
    sqrt,
    tan,
)
from ...graph.formula import acos as raw_acos
from ...graph.formula import asin as raw_asin
from .definition import NodeInputs, defines

ZERO = Vector(*[constant(0.0)] * 3)

FLOAT_EPSILON = 2.0**-23  # of float32, with which Cycles compares


def where_zero(a: Formula, then: Formula | float, otherwise: Formula | float) -> Formula:
    """``then`` where a is 0, else ``otherwise``."""
    return select(abs(a) <= 0.0, then, otherwise)


def where_equal(a: Formula, b: Formula, then: Formula | float, otherwise: Formula | float) -> Formula:
    """By comparison: a difference of products may not vanish, because one of them may be added without rounding."""
    return select(a < b, otherwise, select(b < a, otherwise, then))


def each(operation: Callable[..., Formula], *vectors: Vector) -> Vector:
    """The operation on the components of vectors; a number applies to each component."""
    spread = [v if isinstance(v, tuple) else (v, v, v) for v in vectors]
    return Vector(*(operation(*components) for components in zip(*spread)))


def saturate(a: Formula) -> Formula:
    """a limited to [0, 1]."""
    return clamp(a, 0.0, 1.0)


def ceil(a: Formula) -> Formula:
    """The least integer that is not below a."""
    return -floor(-a)


def fraction(a: Formula) -> Formula:
    """a − ⌊a⌋, in [0, 1)."""
    return a - floor(a)


def truncate(a: Formula) -> Formula:
    """a without its fraction: rounded towards 0."""
    return select(a < 0.0, ceil(a), floor(a))


def sign(a: Formula) -> Formula:
    """−1, 0 or 1."""
    return select(a < 0.0, -1.0, select(0.0 < a, 1.0, 0.0))


def divide(a: Formula, b: Formula) -> Formula:
    """a / b; 0 if b is 0, as in Cycles."""
    return where_zero(b, 0.0, a / b)


def modulo(a: Formula, b: Formula) -> Formula:
    """The remainder with the sign of a."""
    return where_zero(b, 0.0, a - truncate(a / b) * b)


def floored_modulo(a: Formula, b: Formula) -> Formula:
    """The remainder with the sign of b."""
    return where_zero(b, 0.0, a - floor(a / b) * b)


def wrap(a: Formula, high: Formula, low: Formula) -> Formula:
    """a moved into [low, high) by whole ranges; ``low`` if the range is empty."""
    range_, above = high - low, a - low
    return low + where_equal(high, low, 0.0, above - floor(above / range_) * range_)


def snap(a: Formula, step: Formula) -> Formula:
    """The greatest multiple of ``step`` that is not above a; 0 if the step is 0."""
    return floor(divide(a, step)) * step


def ping_pong(a: Formula, scale: Formula) -> Formula:
    """Distance of a to the nearest even multiple of ``scale``; 0 if the scale is 0."""
    return where_zero(scale, 0.0, abs(fraction((a - scale) / (scale * 2.0)) * scale * 2.0 - scale))


def real_power(a: Formula, b: Formula) -> Formula:
    """a to the power b; 0 if a is 0 and b is not, and if a is negative and b is not whole."""
    raised = where_zero(a, 0.0, power(a, b))
    return where_zero(b, 1.0, select(a < 0.0, select(b <= floor(b), raised, 0.0), raised))


def logarithm(a: Formula, base: Formula) -> Formula:
    """Logarithm of a to a base; 0 if either is not positive."""
    return select(minimum(a, base) <= 0.0, 0.0, divide(log(a), log(base)))


def smooth_minimum(a: Formula, b: Formula, distance: Formula) -> Formula:
    """The cubic polynomial of I. Quilez, "smooth minimum"."""
    h = maximum(distance - abs(a - b), 0.0) / distance
    return minimum(a, b) - where_zero(distance, 0.0, h * h * h * distance * (1.0 / 6.0))


def compare(a: Formula, b: Formula, epsilon: Formula) -> Formula:
    """1 if a and b differ by at most ``epsilon``, else 0."""
    return select(abs(a - b) <= maximum(epsilon, FLOAT_EPSILON), 1.0, 0.0)


def angle(y: Formula, x: Formula) -> Formula:
    """Angle of (x, y) to the x axis; 0 for (0, 0), for any signs of these zeros."""
    return where_zero(maximum(abs(x), abs(y)), 0.0, atan2(y, x))


def tanh(a: Formula) -> Formula:
    """Hyperbolic tangent."""
    return 1.0 - 2.0 / (exp(a + a) + 1.0)


OPERATIONS: dict[str, Callable[..., Formula]] = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": divide,
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": real_power,
    "LOGARITHM": logarithm,
    "SQRT": lambda a: sqrt(maximum(a, 0.0)),
    "INVERSE_SQRT": lambda a: select(a <= 0.0, 0.0, 1.0 / sqrt(a)),
    "ABSOLUTE": abs,
    "EXPONENT": exp,
    "MINIMUM": lambda a, b: minimum(a, b),
    "MAXIMUM": lambda a, b: maximum(a, b),
    "LESS_THAN": lambda a, b: select(a < b, 1.0, 0.0),
    "GREATER_THAN": lambda a, b: select(b < a, 1.0, 0.0),
    "SIGN": sign,
    "COMPARE": compare,
    "SMOOTH_MIN": smooth_minimum,
    "SMOOTH_MAX": lambda a, b, c: -smooth_minimum(-a, -b, c),
    "ROUND": lambda a: floor(a + 0.5),
    "FLOOR": floor,
    "CEIL": ceil,
    "TRUNC": truncate,
    "FRACT": fraction,
    "MODULO": modulo,
    "FLOORED_MODULO": floored_modulo,
    "WRAP": wrap,
    "SNAP": snap,
    "PINGPONG": ping_pong,
    "SINE": sin,
    "COSINE": cos,
    "TANGENT": tan,
    "ARCSINE": lambda a: raw_asin(clamp(a, -1.0, 1.0)),
    "ARCCOSINE": lambda a: raw_acos(clamp(a, -1.0, 1.0)),
    "ARCTANGENT": lambda a: apply("atan", a),
    "ARCTAN2": angle,
    "SINH": lambda a: 0.5 * (exp(a) - exp(-a)),
    "COSH": lambda a: 0.5 * (exp(a) + exp(-a)),
    "TANH": tanh,
    "RADIANS": lambda a: a * (math.pi / 180.0),
    "DEGREES": lambda a: a * (180.0 / math.pi),
}


def operand_count(operation: Callable) -> int:
    """Number of operands of an operation of ``OPERATIONS``."""
    return 1 if operation is abs else len(inspect.signature(operation).parameters)


@defines("ShaderNodeMath", modes=OPERATIONS)
def math_node(node: NodeInputs):
    """All operations, with *Clamp*."""
    operation = OPERATIONS.get(node.setting("operation"))
    if operation is None:
        node.report(f"the operation {node.setting('operation')} is not known, so it gives 0")
        return {"Value": constant(0.0)}
    sockets = ("Value", "Value_001", "Value_002")[: operand_count(operation)]
    value = operation(*(node.number(socket) for socket in sockets))
    return {"Value": saturate(value) if node.setting("use_clamp") else value}


def project(a: Vector, b: Vector) -> Vector:
    """Projection of a onto the line of b; zero if b is zero."""
    return b * divide(a.dot(b), b.dot(b))


def refract(incident: Vector, normal: Vector, eta: Formula) -> Vector:
    """Direction of refraction by Snell's law; 0 for total reflection. ``eta``: the index in front over that behind."""
    unit = normal.normalized()
    cosine = unit.dot(incident)
    squared = 1.0 - eta * eta * (1.0 - cosine * cosine)
    refracted = incident * eta - unit * (eta * cosine + sqrt(maximum(squared, 0.0)))
    return each(lambda axis: select(squared < 0.0, 0.0, axis), refracted)


def face_forward(vector: Vector, incident: Vector, reference: Vector) -> Vector:
    """The vector, reversed if ``reference`` and ``incident`` are on the same side."""
    against = reference.dot(incident)
    return each(lambda axis: select(against < 0.0, axis, -axis), vector)


# Operations whose components are those of Math.
COMPONENTWISE = {
    name: OPERATIONS[name]
    for name in (
        "ADD",
        "SUBTRACT",
        "MULTIPLY",
        "DIVIDE",
        "MULTIPLY_ADD",
        "ABSOLUTE",
        "POWER",
        "SIGN",
        "MINIMUM",
        "MAXIMUM",
        "ROUND",
        "FLOOR",
        "CEIL",
        "MODULO",
        "WRAP",
        "SNAP",
        "SINE",
        "COSINE",
        "TANGENT",
    )
} | {"FRACTION": OPERATIONS["FRACT"]}

VECTOR_OPERATIONS: dict[str, Callable[..., Vector]] = {
    "CROSS_PRODUCT": lambda a, b: a.cross(b),
    "PROJECT": project,
    "REFLECT": lambda a, b: a.reflected(b.normalized()),
    "FACEFORWARD": face_forward,
    "NORMALIZE": lambda a: a.normalized(),
}

SCALED_OPERATIONS: dict[str, Callable[..., Vector]] = {"SCALE": lambda a, scale: a * scale, "REFRACT": refract}

MEASURES: dict[str, Callable[..., Formula]] = {
    "DOT_PRODUCT": lambda a, b: a.dot(b),
    "DISTANCE": lambda a, b: (a - b).length(),
    "LENGTH": lambda a: a.length(),
}


@defines("ShaderNodeVectorMath", modes=(*COMPONENTWISE, *VECTOR_OPERATIONS, *SCALED_OPERATIONS, *MEASURES))
def vector_math(node: NodeInputs):
    """All operations."""
    name = node.setting("operation")

    def operands(count: int) -> list[Vector]:
        return [node.vector(socket) for socket in ("Vector", "Vector_001", "Vector_002")[:count]]

    result, number = ZERO, constant(0.0)
    if name in COMPONENTWISE:
        operation = COMPONENTWISE[name]
        result = each(operation, *operands(operand_count(operation)))
    elif name in VECTOR_OPERATIONS:
        operation = VECTOR_OPERATIONS[name]
        result = operation(*operands(operand_count(operation)))
    elif name in SCALED_OPERATIONS:
        operation = SCALED_OPERATIONS[name]
        result = operation(*operands(operand_count(operation) - 1), node.number("Scale"))
    elif name in MEASURES:
        operation = MEASURES[name]
        number = operation(*operands(operand_count(operation)))
    else:
        node.report(f"the operation {name} is not known, so it gives 0")
    return {"Vector": result, "Value": number}


def clamp_between(value: Formula, a: Formula, b: Formula) -> Formula:
    """Clamped between a and b, whichever is less."""
    return clamp(value, minimum(a, b), maximum(a, b))


@defines("ShaderNodeClamp", modes=("MINMAX", "RANGE"))
def clamp_node(node: NodeInputs):
    """Both types: with *Min Max*, the maximum wins if it is less than the minimum."""
    value, low, high = (node.number(name) for name in ("Value", "Min", "Max"))
    return {
        "Result": clamp_between(value, low, high) if node.setting("clamp_type") == "RANGE" else clamp(value, low, high)
    }


def _stepped(share: Formula, steps: Formula) -> Formula:
    return select(steps <= 0.0, 0.0, floor(share * (steps + 1.0)) / steps)


def smoothstep(share: Formula) -> Formula:
    """3t² − 2t³ of the fraction limited to [0, 1]."""
    t = saturate(share)
    return (3.0 - 2.0 * t) * (t * t)


def smootherstep(share: Formula) -> Formula:
    """K. Perlin, "Improving noise", 2002."""
    t = saturate(share)
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


INTERPOLATIONS: dict[str, Callable[..., Formula]] = {
    "LINEAR": lambda share, steps: share,
    "STEPPED": _stepped,
    "SMOOTHSTEP": lambda share, steps: smoothstep(share),
    "SMOOTHERSTEP": lambda share, steps: smootherstep(share),
}


@defines("ShaderNodeMapRange", modes=INTERPOLATIONS)
def map_range(node: NodeInputs):
    """Numbers and vectors, with *Clamp*. An empty range gives *To Min*, except for a number that Cycles computes: 0."""
    interpolation = INTERPOLATIONS.get(node.setting("interpolation_type"))
    if interpolation is None:
        node.report(f"the interpolation {node.setting('interpolation_type')} is not known, so it is linear")
        interpolation = INTERPOLATIONS["LINEAR"]
    held, steps = node.setting("clamp"), node.setting("interpolation_type") == "STEPPED"
    if node.setting("data_type") == "FLOAT_VECTOR":
        value = node.vector("Vector")
        bounds = [node.vector(f"{name}_FLOAT3") for name in ("From_Min", "From_Max", "To_Min", "To_Max")]
        count = node.vector("Steps_FLOAT3") if steps else ZERO

        def mapped(value, from_low, from_high, low, high, count):
            share = where_equal(from_low, from_high, 0.0, (value - from_low) / (from_high - from_low))
            result = low + interpolation(share, count) * (high - low)
            return clamp_between(result, low, high) if held else result

        return {"Vector": each(mapped, value, *bounds, count)}
    value, from_low, from_high, low, high = (
        node.number(name) for name in ("Value", "From Min", "From Max", "To Min", "To Max")
    )
    share = interpolation((value - from_low) / (from_high - from_low), node.number("Steps") if steps else constant(0.0))
    empty = low if node.is_folded() else 0.0
    result = where_equal(from_low, from_high, empty, low + share * (high - low))
    return {"Result": clamp_between(result, low, high) if held else result}


@defines("ShaderNodeSqueeze")
def squeeze(node: NodeInputs):
    """Not known to Cycles: the socket it is linked to uses its own value, as in Cycles."""
    node.report("Cycles does not know it, so the socket it is linked to uses its own value, as in Cycles")
    return {}
