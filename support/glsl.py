# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""GLSL on a GPU, or on Mesa's software renderer: functions of points, compute shaders."""

import functools

import numpy as np
import pytest

from sdf_lights.graph import interval_arithmetic

# The OpenGL Shading Language 4.60, section 4.7.1: + − · are rounded correctly, / is within 2.5 ulps, √ within 4.5, log
# within 3 or 2^-21, exp within 3 + 2 |x|. It does not limit sin and cos. Drivers reduce large angles as well as float32
# can, and are within 2^-20 (NVIDIA: 2^-21). Helpers of ``codegen_glsl`` are within 4 ulps.
ULP = 2.0**-23
PRECISION = interval_arithmetic.Precision(
    np.float32,
    basic=4.5 * ULP,
    library=4.0 * ULP,
    sine=2.0**-20,
    logarithm=2.0**-21,
    exponent=2.0 * ULP,
    tiny=2.0**-126,
)

VERSION = "#version 430 core\n"

_EVALUATE = (
    VERSION
    + """
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Points { vec4 points[]; };
layout(std430, binding = 1) readonly buffer Parameters { float k[]; };
layout(std430, binding = 2) writeonly buffer Values { vec4 values[]; };
uniform int count;
%s
void main()
{
    int index = int(gl_GlobalInvocationID.x);
    if (index < count) {
        values[index] = %s;
    }
}
"""
)

_AS_VECTOR = ["vec4({}, 0.0, 0.0, 0.0)", "vec4({}, 0.0, 0.0)", "vec4({}, 0.0)", "{}"]


@functools.cache
def context():
    """One OpenGL 4.3 context without a window; the test is skipped if there is none."""
    moderngl = pytest.importorskip("moderngl")
    errors = []
    for options in ({"backend": "egl"}, {}):
        try:
            return moderngl.create_context(standalone=True, require=430, **options)
        except Exception as error:  # each platform's driver has errors of its own
            errors.append(str(error))
    pytest.skip(f"no OpenGL 4.3 context: {'; '.join(errors)}")


def evaluate(source: str, name: str, points: np.ndarray, parameters=(), size: int = 1) -> np.ndarray:
    """Values (n,), or (n, size), of the GLSL function ``name(vec3)`` of ``source`` at points (n, 3).

    ``k[i]`` is parameter i; both are rounded to float32.
    """
    gl, n = context(), len(points)
    call = _AS_VECTOR[size - 1].format(f"{name}(points[index].xyz)")
    shader = gl.compute_shader(_EVALUATE % (source, call))
    padded = np.zeros((max(n, 1), 4), np.float32)
    with np.errstate(over="ignore"):
        padded[:n, :3] = points
        numbers = np.zeros(max(len(parameters), 1), np.float32)
        numbers[: len(parameters)] = parameters
    buffers = gl.buffer(padded), gl.buffer(numbers), gl.buffer(reserve=padded.nbytes)
    try:
        for binding, buffer in enumerate(buffers):
            buffer.bind_to_storage_buffer(binding)
        if "count" in shader:
            shader["count"] = n
        shader.run(group_x=-(-max(n, 1) // 64))
        values = np.frombuffer(buffers[2].read(), np.float32).reshape(-1, 4)[:n, :size]
    finally:
        for resource in (shader, *buffers):
            resource.release()
    return values[:, 0].copy() if size == 1 else values.copy()
