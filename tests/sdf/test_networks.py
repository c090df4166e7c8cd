# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Networks of sines: values, bounds, crossings, files that are none."""

import functools
import io
import pickle
import zipfile

import numpy as np
import pytest

from sdf_lights.emitter.intersection.fields import compile_terms
from sdf_lights.emitter.tree import interior
from sdf_lights.graph import codegen_glsl, codegen_native
from sdf_lights.graph.functions import evaluate
from sdf_lights.sdf.data.network import EXAMPLE, NETWORK, WIDTH, NetworkError, Siren, read
from sdf_lights.sdf.shapes import SHAPES, Difference, Sphere
from support import glsl, grids
from support.lamps.crossings import wrong_crossings
from support.lamps.rays import Traced

BOX = np.array([[-1.0, -0.8, -1.2], [1.1, 0.9, 1.0]])


def _siren(width, layers, omega, seed=1, steeper=1.0):
    """A network as the paper starts to fit one."""
    rng, weights, biases, inputs = np.random.default_rng(seed), [], [], 3
    for index in range(layers + 1):
        outputs = width if index < layers else 1
        spread = steeper * (1.0 / inputs if index == 0 else np.sqrt(6.0 / inputs) / omega)
        weights.append(rng.uniform(-spread, spread, (outputs, inputs)))
        biases.append(rng.uniform(-spread, spread, outputs))
        inputs = outputs
    return Siren(weights, biases, omega, BOX)


NETWORKS = {
    "small": _siren(5, 1, 30.0),
    "deep": _siren(13, 4, 8.0, 2, 1.3),
    "wide": _siren(64, 2, 20.0, 3),
    "example": read(EXAMPLE),
}


@functools.cache
def _shape(name):
    """Its bound takes seconds."""
    return NETWORKS[name].shape()


@pytest.fixture(params=[pytest.param(name, marks=[pytest.mark.slow] * (name in ("wide", "deep"))) for name in NETWORKS])
def network(request):
    return NETWORKS[request.param], _shape(request.param)


@pytest.fixture
def rabbit():
    return _shape("example")


def _points(shape, count, seed=1, beyond=0.0):
    low, high = shape.bounds()
    return np.random.default_rng(seed).uniform(low - beyond, high + beyond, (count, 3))


def test_machine_code_and_numpy_have_the_same_values(network):
    siren, shape = network
    points = _points(shape, 3000, beyond=0.3)
    low, high = siren.box
    outside = SHAPES["box"](tuple(0.5 * (high - low))).distance(points - 0.5 * (low + high))
    expected = np.maximum(siren.values(np.clip(points, low, high)), outside)
    np.testing.assert_allclose(
        codegen_native.evaluate(shape.formula(), points, shape.parameters()), expected, atol=1e-12
    )
    np.testing.assert_allclose(shape.distance(points), expected, atol=1e-12)


def test_glsl_has_the_same_values(rabbit):
    points = _points(rabbit, 500, 3, 0.3).astype(np.float32)
    numbers = np.concatenate([[0.0], rabbit.parameters()[1:], rabbit.data.array])
    source = f"#define table_number(i) k[{len(rabbit.parameters())} + (i)]\n"
    # The address is the parameter of the slot that the call reads; the test gives its table the place 0.
    slots = [slot for slot, value in enumerate(rabbit.parameters()) if value == float(rabbit.data.address)]
    numbers[: len(rabbit.parameters())] = rabbit.parameters()
    numbers[slots] = 0.0
    source += codegen_glsl.function(rabbit.formula(), "read", written=set())
    np.testing.assert_allclose(
        glsl.evaluate(source, "read", points, numbers), rabbit.distance(points.astype(float)), atol=2e-5
    )


@pytest.mark.parametrize("side", [1.0, 0.2, 0.03, 1e-3, 0.0])
def test_bounds_over_boxes_hold_for_values_and_slopes(network, side):
    _, shape = network
    rng = np.random.default_rng(4)
    low = _points(shape, 1500, 2)
    high = low + side * rng.uniform(0.01, 1.0, (1500, 3))
    address = float(shape.data.address)
    bounds = evaluate(NETWORK.bounds, [address, *(end for k in range(3) for end in (low[:, k], high[:, k]))])
    points = np.moveaxis(low + rng.random((20, 1500, 3)) * (high - low), -1, 0)
    values = evaluate(NETWORK, [address, *points])[0]
    assert (bounds[0] <= values).all() and (values <= bounds[1]).all()
    for k, slopes in enumerate(evaluate(NETWORK.derivatives, [address, *points])):
        assert (bounds[2 + 2 * k] <= slopes + 1e-12).all() and (slopes <= bounds[3 + 2 * k] + 1e-12).all()


def test_bounds_of_small_boxes_are_close(rabbit):
    low = _points(rabbit, 2000)
    high = low + 0.01
    bounds = evaluate(NETWORK.bounds, [float(rabbit.data.address), *np.stack([low, high], axis=2).reshape(-1, 6).T])
    widths = np.mean([bounds[3 + 2 * k] - bounds[2 + 2 * k] for k in range(3)])
    values = evaluate(NETWORK, [float(rabbit.data.address), *low.T])[0]
    assert widths < 0.2 and np.mean(bounds[1] - bounds[0]) < 0.03 and (values >= bounds[0]).all()


def test_derivatives_are_limits_of_differences(network):
    siren, shape = network
    points, step = _points(shape, 500), 1e-6
    found = evaluate(NETWORK.derivatives, [float(shape.data.address), *points.T])
    for axis, slopes in enumerate(found):
        way = step * np.eye(3)[axis]
        expected = (siren.values(points + way) - siren.values(points - way)) / (2.0 * step)
        np.testing.assert_allclose(slopes, expected, atol=1e-6)


def test_no_two_points_differ_by_more_than_the_bound(network):
    _, shape = network
    a = _points(shape, 20_000, 5, 0.2)
    b = a + np.random.default_rng(6).normal(size=a.shape) * 10.0 ** np.random.default_rng(7).uniform(
        -6, -0.5, (len(a), 1)
    )
    difference = np.abs(shape.distance(a) - shape.distance(b))
    assert (difference <= shape.lipschitz * np.linalg.norm(a - b, axis=1) + 1e-12).all()


def test_the_example_has_a_bound_near_its_slope_and_is_certified(rabbit):
    assert rabbit.lipschitz < 2.5 and interior.tree(rabbit).certified
    cut = Difference(rabbit, Sphere(0.4))
    points = _points(rabbit, 1000)
    expected = np.maximum(rabbit.distance(points), -Sphere(0.4).distance(points))
    np.testing.assert_allclose(cut.distance(points), expected, atol=1e-12)
    assert interior.tree(cut).certified
    assert pickle.loads(pickle.dumps(rabbit)) == rabbit


def test_rays_find_all_crossings_of_a_network(rabbit):
    assert wrong_crossings(rabbit, 300) == 0.0


def test_a_ray_asks_a_network_for_few_points(rabbit):
    """The kinds benchmark measures the time, which depends on the machine."""
    evaluations = Traced(rabbit).trace(*grids.rays_around(rabbit, 2000, 6))[:, 3]
    assert evaluations.mean() < 9.0


@pytest.mark.parametrize("width, boxes", [(48, 8), (128, 1)])
def test_trees_of_large_networks_have_no_more_boxes(width, boxes):
    shape = _siren(width, 2, 5.0).shape()
    assert compile_terms(shape.terms(np.eye(4), 1.0)).boxes == boxes


@pytest.mark.slow
def test_rays_find_all_crossings_of_rough_networks():
    for name, count in (("example", 10_000), ("deep", 1000), ("wide", 1000)):
        assert wrong_crossings(NETWORKS[name].shape(), count) == 0.0


def _saved(path, change=lambda arrays: arrays):
    siren = _siren(4, 2, 10.0)
    arrays = {"omega": np.float32(10.0)}
    for index, (weight, bias) in enumerate(zip(siren.weights, siren.biases)):
        arrays |= {f"weight_{index}": weight, f"bias_{index}": bias}
    np.savez(path, **change(arrays))
    return path


def test_a_file_keeps_a_network(tmp_path):
    siren = _siren(9, 2, 12.0)
    siren.save(tmp_path / "network.npz")
    again = read(tmp_path / "network.npz")
    points = _points(siren.shape(), 1000)
    np.testing.assert_allclose(again.values(points), siren.values(points), atol=1e-4)
    np.testing.assert_allclose(again.box, siren.box, rtol=1e-6)
    assert read(_saved(tmp_path / "plain.npz")).box.tolist() == [[-1.0] * 3, [1.0] * 3]


class _Command:
    """What would run if it were unpickled."""

    def __reduce__(self):
        return open, ("unpickled", "w")


@pytest.mark.parametrize(
    "name, value, sentence",
    [
        ("weight_1", None, "has no array 'weight_1'|is of shape"),
        ("weight_1", np.zeros((4, 5)), r"'weight_1' of shape \(4, 5\)"),
        ("weight_0", np.zeros((4, 2)), r"'weight_0' of shape \(4, 2\)"),
        ("weight_2", np.zeros((2, 4)), r"'weight_2' of shape"),
        ("bias_0", np.zeros((4, 1)), "'bias_0' of shape"),
        ("bias_0", np.zeros(0), "layer of 0 neurons"),
        ("bias_0", np.full(4, np.nan), "'bias_0' that is not finite"),
        ("weight_0", np.full((4, 3), 1e30), "too large"),
        ("weight_0", np.array(["a"] * 12).reshape(4, 3), "no array of numbers"),
        ("weight_0", np.full((4, 3), 1j), "no array of numbers"),
        ("omega", np.zeros(2), "'omega' of 2 numbers"),
        ("omega", np.inf, "'omega' that is not finite"),
        ("low", np.full(3, 2.0), "box 'low' to 'high' that is empty"),
        ("weight_0", np.array([_Command()] * 12).reshape(4, 3), "damaged"),
    ],
)
def test_files_that_are_no_networks_say_so_in_a_sentence(tmp_path, monkeypatch, name, value, sentence):
    monkeypatch.chdir(tmp_path)
    path = _saved(
        tmp_path / "a.npz", lambda arrays: {k: v for k, v in (arrays | {name: value}).items() if v is not None}
    )
    with pytest.raises(NetworkError, match=sentence):
        read(path)
    assert not (tmp_path / "unpickled").exists()


def test_too_wide_and_too_deep_networks_are_refused(tmp_path):
    for siren, sentence in ((_siren(WIDTH + 1, 1, 10.0), "neurons"), (_siren(3, 9, 10.0), "hidden layers")):
        siren.save(tmp_path / "a.npz")
        with pytest.raises(NetworkError, match=sentence):
            read(tmp_path / "a.npz")


def test_truncated_and_foreign_files_say_so_in_a_sentence(tmp_path):
    whole = EXAMPLE.read_bytes()
    bomb = io.BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("weight_0.npy", bytes(1 << 25))
    array = io.BytesIO()
    np.save(array, np.zeros(3))
    damaged = [whole[:cut] for cut in range(0, len(whole), 997)] + [whole[:-1]]
    rng = np.random.default_rng(1)
    for _ in range(100):
        changed = bytearray(whole)
        for place in rng.integers(len(whole), size=3):
            changed[place] ^= int(rng.integers(1, 256))
        damaged.append(bytes(changed))
    damaged += [b"", b"text", pickle.dumps([1]), array.getvalue(), bomb.getvalue()]
    path, refused = tmp_path / "a.npz", 0
    for content in damaged:
        path.write_bytes(content)
        try:
            read(path)  # a changed time of a file in the archive harms nothing
        except NetworkError:
            refused += 1
    assert refused > len(damaged) - 60
    with pytest.raises(NetworkError, match="is missing"):
        read(tmp_path / "none.npz")
    with pytest.raises(NetworkError, match="cannot be read|damaged"):
        read(tmp_path)
