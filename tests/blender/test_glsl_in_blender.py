# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GLSL of formulas in Blender's own shaders, as its ``gpu`` module builds them for every graphics API."""

import pathlib

import bpy
import gpu
import numpy as np
import pytest

from sdf_lights.graph import codegen_glsl, numpy_evaluation
from sdf_lights.graph import formula as f
from sdf_lights.graph.gradient import gradient
from sdf_lights.graph.loops import iterate
from sdf_lights.sdf.shapes import Box, Cone, Difference, Sphere, Torus

pytestmark = pytest.mark.skipif(
    not hasattr(gpu, "init"), reason=f"Blender {bpy.app.version_string} draws in a window alone"
)

x, y, z = f.POINT
_WIDTH = 64


@pytest.fixture(scope="module", autouse=True)
def _graphics():
    gpu.init()


def _evaluate(source: str, call: str, points: np.ndarray, parameters) -> np.ndarray:
    """Values (n, 4) of the GLSL expression ``call`` of the point p, for up to 4,096 points (n, 3)."""
    pixels = np.zeros((_WIDTH * _WIDTH, 4), np.float32)
    pixels[: len(points), :3] = points
    # A member of a uniform array takes the place of four floats, so the number is the first of four.
    numbers = np.zeros((max(len(parameters), 1), 4), np.float32)
    numbers[: len(parameters), 0] = parameters
    info = gpu.types.GPUShaderCreateInfo()
    info.typedef_source(f"struct Lamp {{ vec4 k[{len(numbers)}]; }};")
    info.uniform_buf(0, "Lamp", "lamp")
    info.sampler(0, "FLOAT_2D", "points")
    info.image(0, "RGBA32F", "FLOAT_2D", "values", qualifiers={"WRITE"})
    info.local_group_size(8, 8)
    info.compute_source(
        source
        + f"""
void main()
{{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    vec3 p = texelFetch(points, texel, 0).xyz;
    imageStore(values, texel, {call});
}}
"""
    )
    shader = gpu.shader.create_from_info(info)
    size = (_WIDTH, _WIDTH)
    inputs = gpu.types.GPUTexture(size, format="RGBA32F", data=gpu.types.Buffer("FLOAT", pixels.size, pixels.ravel()))
    outputs = gpu.types.GPUTexture(size, format="RGBA32F")
    lamp = gpu.types.GPUUniformBuf(gpu.types.Buffer("FLOAT", numbers.size, numbers.ravel()))
    shader.bind()
    shader.uniform_block("lamp", lamp)
    shader.uniform_sampler("points", inputs)
    shader.image("values", outputs)
    gpu.compute.dispatch(shader, _WIDTH // 8, _WIDTH // 8, 1)
    values = outputs.read()
    values.dimensions = _WIDTH * _WIDTH * 4
    return np.array(values, np.float32).reshape(-1, 4)[: len(points)]


def _escape(u, v, n):
    return (u * u - v * v + x, 2.0 * u * v + y, n + z), u * u + v * v < 4.0


@pytest.mark.parametrize(
    "formula, parameters",
    [
        pytest.param(shape.formula(), shape.parameters(), id=shape.name())
        for shape in (Torus(), Cone(), Difference(Box(0.8), Sphere(1.08)))
    ]
    + [
        pytest.param(sum(iterate(f.parameter(0), (x, y, z), _escape, 7)), [5.0], id="loop"),
        pytest.param(
            f.apply("power", x, 3.0) + f.apply("atan2", y, z) - f.select(x < y, x, f.apply("acos", y / 4.0)),
            [],
            id="functions",
        ),
    ],
)
def test_shaders_compile_and_agree(formula, parameters):
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (1000, 3)).astype(np.float32)
    source = codegen_glsl.function(formula, "field", "lamp.k[{}].x")
    found = _evaluate(source, "vec4(field(p), 0.0, 0.0, 1.0)", points, parameters)[:, 0]
    expected = numpy_evaluation.evaluate(formula, points, parameters)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-5)


def test_gradients_in_a_shader():
    shape = Torus()
    points = np.random.default_rng(2).uniform(-1.0, 1.0, (500, 3)).astype(np.float32)
    source = codegen_glsl.function((shape.formula(), *gradient(shape.formula())), "field", "lamp.k[{}].x")
    found = _evaluate(source, "field(p)", points, shape.parameters())
    np.testing.assert_allclose(found[:, 0], shape.distance(points), atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(found[:, 1:], axis=1), 1.0, atol=1e-5)


def test_intervals_in_a_shader():
    """Rays along x through the axis of a torus: two stretches, where they meet the tube."""
    shape = Torus(0.5, 0.2)
    source = (
        codegen_glsl.function(shape.formula(), "field", "lamp.k[{}].x")
        + (pathlib.Path(__file__).resolve().parents[2] / "shaders_glsl" / "intervals.glsl").read_text()
        + """
vec4 stretches(vec3 p)
{
    Intervals found = intervals(p, vec3(1.0, 0.0, 0.0), 0.0, 4.0, 1.0, 1e-4, 500);
    return vec4(float(found.count), found.spans[0], found.spans[1].y);
}
"""
    )
    heights = np.linspace(-0.19, 0.19, 50)
    points = np.stack([np.full(50, -2.0), np.zeros(50), heights], axis=-1).astype(np.float32)
    found = _evaluate(source, "stretches(p)", points, shape.parameters())
    half = np.sqrt(0.2**2 - heights**2)
    np.testing.assert_array_equal(found[:, 0], 2)
    np.testing.assert_allclose(found[:, 1:], 2.0 + np.stack([-0.5 - half, -0.5 + half, 0.5 + half], -1), atol=1e-5)
