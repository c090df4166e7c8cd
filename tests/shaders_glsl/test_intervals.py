# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stretches of rays inside shapes, found on the GPU, against a fine march in NumPy."""

import pathlib

import numpy as np
import pytest

from sdf_lights.graph import codegen_glsl, numpy_evaluation
from sdf_lights.graph import formula as f
from support import glsl
from support.shapes import samples

SOURCE = (pathlib.Path(__file__).resolve().parents[2] / "shaders_glsl" / "intervals.glsl").read_text()
ROOM = 16
LEAST = 1e-4
SAMPLES = 3000

_SHADER = (
    glsl.VERSION
    + """
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Rays { vec4 rays[]; };
layout(std430, binding = 1) readonly buffer Parameters { float k[]; };
layout(std430, binding = 2) writeonly buffer Values { vec2 values[]; };
uniform int count;
uniform vec2 bounds;
uniform float lipschitz;
uniform float least;
uniform int steps;
#define INTERVALS %d
%s
%s
void main()
{
    int index = int(gl_GlobalInvocationID.x);
    if (index >= count) {
        return;
    }
    vec3 o = rays[2 * index].xyz;
    vec3 d = rays[2 * index + 1].xyz;
    Intervals found = intervals(o, d, bounds.x, bounds.y, lipschitz, least, steps);
    int first = index * (INTERVALS + 2);
    values[first] = vec2(float(found.count), found.unresolved);
    values[first + 1] = vec2(found.dropped, float(found.evaluations));
    for (int i = 0; i < INTERVALS; i++) {
        values[first + 2 + i] = i < found.count ? found.spans[i] : vec2(0.0);
    }
}
"""
)


class Found:
    """Of n rays: ``count``, ``unresolved``, ``dropped`` and ``evaluations`` (n,); ``spans`` (n, room, 2)."""

    def __init__(
        self, formula, parameters, origins, directions, bounds, *, lipschitz=1.0, room=ROOM, steps=2000, least=LEAST
    ):
        gl, n = glsl.context(), len(origins)
        shader = gl.compute_shader(_SHADER % (room, codegen_glsl.function(formula, "field"), SOURCE))
        rays = np.zeros((n, 2, 4), np.float32)
        rays[:, 0, :3], rays[:, 1, :3] = origins, directions
        numbers = np.zeros(max(len(parameters), 1), np.float32)
        numbers[: len(parameters)] = parameters
        buffers = gl.buffer(rays), gl.buffer(numbers), gl.buffer(reserve=n * (room + 2) * 8)
        for binding, buffer in enumerate(buffers):
            buffer.bind_to_storage_buffer(binding)
        for name, value in dict(count=n, bounds=bounds, lipschitz=lipschitz, least=least, steps=steps).items():
            shader[name] = value
        shader.run(group_x=-(-n // 64))
        values = np.frombuffer(buffers[2].read(), np.float32).reshape(n, room + 2, 2).astype(np.float64)
        for resource in (shader, *buffers):
            resource.release()
        self.count, self.unresolved = values[:, 0, 0].astype(int), values[:, 0, 1]
        self.dropped, self.evaluations = values[:, 1, 0], values[:, 1, 1]
        self.spans = values[:, 2:]

    @property
    def shortest(self) -> np.ndarray:
        """Length of the shortest stretch or gap of each ray (n,)."""
        ends = self.spans.reshape(len(self.spans), -1)
        last = 2 * self.count[:, None] - 1
        return np.where(np.arange(1, ends.shape[1]) <= last, np.diff(ends), np.inf).min(axis=1)

    @property
    def length(self) -> np.ndarray:
        return (self.spans[..., 1] - self.spans[..., 0]).sum(axis=1)


def _rays(shape, count: int = 100):
    """Rays (n, 3), (n, 3) from around a shape to points in it; some start in it, some run along an axis."""
    rng = np.random.default_rng(1)
    low, high = samples.window(shape)
    center, radius = (low + high) / 2, np.linalg.norm(high - low)
    origins = rng.normal(size=(count, 3))
    origins = center + radius * origins / np.linalg.norm(origins, axis=1, keepdims=True)
    origins[::6] = center + (high - low) * rng.uniform(-0.5, 0.5, (len(origins[::6]), 3))
    directions = center + (high - low) * rng.uniform(-0.5, 0.5, (count, 3)) - origins
    along = np.eye(3)[rng.integers(0, 3, len(directions[1::5]))] * rng.choice([-1, 1], (len(directions[1::5]), 1))
    aside = 0.3 * (origins[1::5] - center)
    directions[1::5], origins[1::5] = along, center + np.where(along == 0.0, aside, -radius * along)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return (array.astype(np.float32).astype(np.float64) for array in (origins, directions)), 2.2 * radius


def _marched(formula, parameters, origins, directions, end: float):
    """Length inside, number of stretches, and the shortest stretch or gap in samples, of each ray: (n,), (n,), (n,)."""
    t = np.linspace(0.0, end, SAMPLES)
    values = numpy_evaluation.evaluate(formula, origins[:, None] + t[:, None] * directions[:, None], parameters)
    inside = values <= 0.0
    a, b = values[:, :-1], values[:, 1:]
    with np.errstate(all="ignore"):
        part = np.where(
            inside[:, :-1] == inside[:, 1:],
            inside[:, 1:],
            np.where(inside[:, 1:], b, a) / np.where(inside[:, 1:], b - a, a - b),
        )
    count = inside[:, 0] + (inside[:, 1:] & ~inside[:, :-1]).sum(axis=1)
    changes = [np.flatnonzero(row) for row in inside[:, 1:] != inside[:, :-1]]
    shortest = np.array([np.diff(change).min(initial=SAMPLES) for change in changes])
    return part.sum(axis=1) * t[1], count, shortest


NAMES = [
    "sphere",
    "torus",
    "box",
    "capsule",
    "link",
    "hollow box",
    "three",
    "nested",
    "box_frame",
    "menger_sponge",
    "smooth union",
    "exponential union",
    "xor",
    "octahedron",
    "gyroid",
]


@pytest.mark.parametrize("name", NAMES)
def test_every_stretch_is_found(name):
    shape = samples.SHAPES_TO_TRY[name]
    (origins, directions), end = _rays(shape)
    formula, parameters = shape.formula(), shape.parameters()
    found = Found(formula, parameters, origins, directions, (0.0, end), lipschitz=shape.lipschitz)
    length, count, shortest = _marched(formula, parameters, origins, directions, end)
    step = end / SAMPLES
    # The march itself is blind to what is shorter than its steps.
    clear = (shortest > 3) & (found.shortest > 3.0 * step)
    assert clear.mean() > 0.6 and count.sum() > 20
    assert (found.dropped == 0.0).all()
    off = clear & (found.count != count)
    # What float32 and the least step leave open is told.
    assert (found.unresolved[off] > 0.0).all() and off.mean() <= 0.01
    assert (np.abs(found.length - length) <= 2.0 * step + found.unresolved).all()
    exact = clear & ~off
    assert np.abs(found.length - length)[exact].max() <= 2.0 * step
    assert np.median(found.unresolved) <= 20.0 * LEAST


def _slabs():
    """Three slabs, one of them thin, with a field that is three times the distance."""

    def slab(center, half):
        return f.maximum(abs(x - center) - half, abs(y) - 2.0, abs(z) - 2.0)

    x, y, z = f.POINT
    return 3.0 * f.minimum(slab(-1.0, 0.03), slab(-0.45, 0.4), slab(0.45, 0.4))


def _rays_through_slabs(count: int):
    rng = np.random.default_rng(2)
    origins = np.stack([rng.uniform(-1.55, -1.30, count), *rng.uniform(-0.5, 0.5, (2, count))], axis=-1)
    directions = np.stack([np.ones(count), *rng.uniform(-0.1, 0.1, (2, count))], axis=-1)
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def test_no_thin_slab_is_missed():
    origins, directions = _rays_through_slabs(4000)
    found = Found(_slabs(), (), origins, directions, (0.0, 4.0), lipschitz=3.0)
    assert (found.count == 3).all()
    expected = (0.06 + 0.8 + 0.8) / directions[:, 0]
    np.testing.assert_allclose(found.length, expected, atol=1e-5)


def test_directions_need_not_be_unit_vectors():
    """Then the parameter is not a length, and the slope along the ray is another."""
    origins, directions = _rays_through_slabs(200)
    once = Found(_slabs(), (), origins, directions, (0.0, 4.0), lipschitz=3.0)
    twice = Found(_slabs(), (), origins, 2.0 * directions, (0.0, 2.0), lipschitz=6.0, least=LEAST / 2.0)
    np.testing.assert_allclose(twice.spans, 0.5 * once.spans, atol=1e-5)


def test_what_has_no_room_is_told():
    origins, directions = _rays_through_slabs(100)
    found = Found(_slabs(), (), origins, directions, (0.0, 4.0), lipschitz=3.0, room=2)
    assert (found.count == 2).all()
    np.testing.assert_allclose(found.dropped, 0.8 / directions[:, 0], atol=1e-5)


def test_rays_that_run_out_of_steps_say_so():
    origins, directions = _rays_through_slabs(100)
    found = Found(_slabs(), (), origins, directions, (0.0, 4.0), lipschitz=3.0, steps=5)
    assert (found.unresolved > 1.0).all()


def test_rays_along_a_face():
    """Nothing but steps of the least length: what they may have missed is told."""
    x, y, z = f.POINT
    grazing = Found(abs(y) - 0.5, (), np.array([(-1.0, 0.5, 0.0)]), np.array([(1.0, 0.0, 0.0)]), (0.0, 2.0), least=1e-2)
    assert grazing.count == 1 and grazing.length == pytest.approx(2.0)
    assert grazing.unresolved == pytest.approx(2.0, rel=0.02)


def test_fewer_evaluations_than_plain_sphere_tracing():
    shape = samples.SHAPES_TO_TRY["torus"]
    (origins, directions), end = _rays(shape, 400)
    formula, parameters = shape.formula(), shape.parameters()
    found = Found(formula, parameters, origins, directions, (0.0, end))
    t, evaluations, running = np.zeros(len(origins)), np.zeros(len(origins)), np.ones(len(origins), bool)
    while running.any():
        distance = np.abs(numpy_evaluation.evaluate(formula, origins + t[:, None] * directions, parameters))
        evaluations += running
        t = np.where(running, t + np.maximum(distance, LEAST), t)
        running &= t < end
    assert found.evaluations.mean() < 0.9 * evaluations.mean()
