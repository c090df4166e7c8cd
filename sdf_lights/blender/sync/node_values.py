# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of sockets: their own, converted between kinds of sockets, and as plain numbers."""

from __future__ import annotations

import bpy

from ...graph.folding import Folding
from ...graph.formula import CONSTANT, Formula, Vector, constant, floor, select
from ...render.material import Node
from ...render.nodes.definition import mean
from ...render.nodes.maths import where_zero
from ...render.nodes.working_space import luminance_weights
from .common import rgb
from .links import INLINED

BLACK = (0.0, 0.0, 0.0)


class _Missing:
    """Result of an unsupported node: the socket that it is linked to uses its own value."""


MISSING = _Missing()


def replaces_default(end, receiver) -> bool:
    """Whether the socket value at the end of a walk replaces the default coordinates or normal of an unlinked input: it
    does if it is the visible value of a group's input."""
    return INLINED and end is not receiver and not end.hide_value


def working_space() -> str | None:
    """Name of the linear colour space of the file, which users can choose since Blender 5.0."""
    return getattr(getattr(bpy.data, "colorspace", None), "working_space", None)


def constant_of(socket):
    """A socket's own value: a float, a 3-tuple, or None for a shader. Vectors of two numbers get a zero."""
    value = getattr(socket, "default_value", None)
    if value is None or isinstance(value, (str, bpy.types.ID)):
        return None
    return rgb((*value, 0.0)) if hasattr(value, "__len__") else float(value)


EXAMPLES = {"VALUE": 0.0, "VECTOR": BLACK, "RGBA": BLACK}  # type of a socket -> an example of its values
# Nodes that Blender computes itself since 5.0 if all their inputs are constants.
FOLDED = {
    f"ShaderNode{name}"
    for name in (
        *(
            "Blackbody",
            "Clamp",
            "CombineColor",
            "CombineXYZ",
            "FloatCurve",
            "Gamma",
            "MapRange",
            "Math",
            "Mix",
            "MixRGB",
        ),
        *("RGBCurve", "RadialTiling", "SeparateXYZ", "TexBrick", "TexChecker", "TexGabor", "TexGradient", "TexMagic"),
        *("TexNoise", "TexVoronoi", "TexWave", "TexWhiteNoise", "ValToRGB", "Value", "VectorCurve", "VectorMath"),
        "VectorRotate",
    )
}
WHOLE = {"INT", "BOOLEAN"}  # types of sockets with whole numbers


def converted(value, socket_type: str, like):
    """A value converted between sockets as in Blender: colours to numbers by luminance, vectors by mean."""
    if isinstance(value, Vector) and isinstance(like, float):
        if socket_type == "RGBA":
            return value.dot(luminance_weights(working_space()))
        return mean(value)
    if isinstance(value, Formula) and isinstance(like, tuple):
        return Vector(value, value, value)
    return value


def whole(value: Formula | Vector, socket_type: str, wanted: str) -> Formula:
    """A value of a socket of that type at a socket of whole numbers (``WHOLE``): without its fraction, or 1 for true.
    Cycles, which converts before Blender 5.0, knows no truth."""
    if not INLINED:
        wanted = "INT"
    if wanted == "BOOLEAN" and isinstance(value, Vector) and socket_type != "RGBA":
        return where_zero(abs(value.x) + abs(value.y) + abs(value.z), 0.0, constant(1.0))
    number = converted(value, socket_type, 0.0)
    if wanted == "BOOLEAN":
        return select(number <= 0.0, 0.0, 1.0)
    return select(number < 0.0, -floor(-number), floor(number))


def numbers_of(parameters, value):
    """A value of formulas as a float or a 3-tuple, for these ``parameters``; None if it varies."""
    if value is None or isinstance(value, Node):
        return None
    if isinstance(value, (float, tuple)) and not isinstance(value, Vector):
        return value
    folding = Folding([entry if isinstance(entry, float) else 0.0 for entry in parameters])
    folded = [folding.fold(formula) for formula in (value if isinstance(value, Vector) else (value,))]
    if any(formula.kind != CONSTANT for formula in folded):
        return None
    return tuple(formula.value for formula in folded) if len(folded) == 3 else folded[0].value
