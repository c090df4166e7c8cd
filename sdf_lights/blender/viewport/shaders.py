# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders of the viewport: one per formula, for any number of lamps and any parameters.

``GPUShaderCreateInfo`` describes them; Blender translates them for OpenGL, Vulkan and Metal.
"""

from __future__ import annotations

import functools
import pathlib
from typing import NamedTuple

import gpu

from ...graph import codegen_glsl
from ...graph.formula import Formula

FOLDER = pathlib.Path(__file__).resolve().parents[3] / "shaders_glsl"

# Vectors of four before the numbers in the uniform block of a lamp; see `Lamp` below.
HEADER = 12
# Of 16 KiB, the minimum size of uniform blocks in every graphics API.
MOST_NUMBERS = 4 * (1024 - HEADER)
# Along a ray: see README.md of shaders_glsl. 200 are too few for the Mandelbox; no shape changes with more than 400.
STEPS = 400

_LAMP = """
struct Lamp {
    vec4 low;        // corner of the box, in the space of the shape; the least step
    vec4 high;       // the other corner; bound on the slope of the field
    vec4 eye;        // w 1: the place of the eye; w 0: direction of view; in the space of the shape
    vec4 axis;       // depth along the view axis is dot(axis, (p, 1))
    vec4 clip;       // least and greatest depth; pixels of the depth texture for each pixel, 0: none
    vec4 unproject;  // of the projection matrix: [2][2], [2][3], [3][2], [3][3]
    vec4 emission;   // radiance per metre where the relative emission is 1; points of a ray in each unit of length
    vec4 mask;
    vec4 along[3];   // columns of the shape's matrix: directions in metres
    vec4 least;      // least light where the lamp is seen; by how much it is drawn wider, in the space of the shape
    vec4 numbers[%d];
};
"""
_NUMBER = "#define number(i) lamp.numbers[(i) / 4][(i) % 4]\n"
# Tables of a lamp, concatenated: see ``graph.tables``.
TABLE_WIDTH = 2048
_TABLES = f"#define table_number(i) texelFetch(tables, ivec2((i) % {TABLE_WIDTH}, (i) / {TABLE_WIDTH}), 0).r\n"
_FIELD = "float field(vec3 p)\n{\n    return body(p) - lamp.least.w;\n}\n"


class ShaderError(Exception):
    """A sentence on why a lamp cannot be drawn by a shader."""


@functools.cache
def source(name: str) -> str:
    """Text of a hand-written shader in ``shaders_glsl/``."""
    return (FOLDER / name).read_text(encoding="utf-8")


def vectors_of(count: int) -> int:
    """Number of vectors of four for ``count`` numbers; at least one, because arrays cannot be empty."""
    return max(-(-count // 4), 1)


class LampCode(NamedTuple):
    """Source of a shader: the ``field``, whose parameters are the first ``parameters`` of ``numbers``, and the relative
    emission with the rest; None if it is uniform."""

    field: Formula
    parameters: int
    numbers: int
    colour: tuple[Formula, Formula, Formula] | None


def lamp_shader(code: LampCode) -> gpu.types.GPUShader:
    """Shader that adds the light of a lamp. Compiles at once, which may take long. Raises ShaderError."""
    numbers = code.numbers
    if numbers > MOST_NUMBERS:
        raise ShaderError(f"its shape has {numbers:,} numbers, and shaders hold {MOST_NUMBERS:,}: simplify it.")
    info = gpu.types.GPUShaderCreateInfo()
    info.typedef_source(_LAMP % vectors_of(numbers))
    info.uniform_buf(0, "Lamp", "lamp")
    info.push_constant("MAT4", "projection")
    info.push_constant("IVEC2", "depth_origin")
    info.sampler(0, "FLOAT_2D", "scene_depth")
    info.vertex_in(0, "VEC3", "corner")
    info.vertex_out(_interface("lamp_interface", "VEC3", "point"))
    info.fragment_out(0, "VEC4", "glow")
    info.fragment_out(1, "VEC4", "mask")
    info.define("STEPS", str(STEPS))
    # Only the sum over the intervals is used, so they need no memory.
    info.define("INTERVALS", "1")
    info.define("INTERVALS_SUM", "emitted")
    info.define("CROSSING_ERROR", "(0.1 * lamp.low.w)")
    info.vertex_source(source("proxy_vertex.glsl"))
    try:
        written: set[str] = set()
        functions = _NUMBER + _TABLES + codegen_glsl.function(code.field, "body", "number({})", written) + _FIELD
        if code.colour is not None:
            info.define("VARIES", "1")
            functions += codegen_glsl.function(code.colour, "colour", f"number({{}} + {code.parameters})", written)
    except codegen_glsl.UnwrittenError as error:
        raise ShaderError(f"{error}.") from None
    if written:
        info.sampler(1, "FLOAT_2D", "tables")
    info.fragment_source(
        "".join([functions, *map(source, ("proxy_emission.glsl", "intervals.glsl", "proxy_fragment.glsl"))])
    )
    return _created(info)


@functools.cache
def composite_shader() -> gpu.types.GPUShader:
    """Shader that adds the texture ``glow``."""
    info = _on_screen("proxy_composite.glsl")
    info.sampler(0, "FLOAT_2D", "glow")
    return _created(info)


@functools.cache
def depth_shader() -> gpu.types.GPUShader:
    """Shader that writes the depth of triangles; ``transform`` maps from their space to that of the projection."""
    info = gpu.types.GPUShaderCreateInfo()
    info.vertex_in(0, "VEC3", "position")
    info.push_constant("MAT4", "transform")
    info.fragment_out(0, "VEC4", "depth")
    info.vertex_source("void main()\n{\n    gl_Position = transform * vec4(position, 1.0);\n}\n")
    info.fragment_source("void main()\n{\n    depth = vec4(gl_FragCoord.z);\n}\n")
    return _created(info)


@functools.cache
def picture_shader() -> gpu.types.GPUShader:
    """Shader that draws the texture ``picture``."""
    info = _on_screen("viewport_picture.glsl")
    info.sampler(0, "FLOAT_2D", "picture")
    return _created(info)


@functools.cache
def outline_shader() -> gpu.types.GPUShader:
    """Shader that draws lines of ``width``, in fractions of the screen, around the marked pixels of ``mask``."""
    info = _on_screen("proxy_outline.glsl")
    info.sampler(0, "FLOAT_2D", "mask")
    info.push_constant("VEC2", "width")
    info.push_constant("VEC4", "selected_color")
    info.push_constant("VEC4", "active_color")
    return _created(info)


def _on_screen(name: str) -> gpu.types.GPUShaderCreateInfo:
    info = gpu.types.GPUShaderCreateInfo()
    info.vertex_in(0, "VEC2", "position")
    info.vertex_in(1, "VEC2", "texcoord")
    info.vertex_out(_interface("screen_interface", "VEC2", "uv"))
    info.fragment_out(0, "VEC4", "color")
    info.vertex_source("void main()\n{\n    uv = texcoord;\n    gl_Position = vec4(position, 0.0, 1.0);\n}\n")
    info.fragment_source(source(name))
    return info


def _interface(name: str, kind: str, variable: str) -> gpu.types.GPUStageInterfaceInfo:
    interface = gpu.types.GPUStageInterfaceInfo(name)
    interface.smooth(kind, variable)
    return interface


def _created(info: gpu.types.GPUShaderCreateInfo) -> gpu.types.GPUShader:
    try:
        return gpu.shader.create_from_info(info)
    except Exception as error:
        raise ShaderError(
            f"the graphics driver refused its shader ({error}): its shape may be too complex for this graphics card; "
            "simplify it."
        ) from error
