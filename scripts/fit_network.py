# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits a network of sines to a shape, for lamps with Source: Network. With NumPy alone, where a seed gives one network,
or by PyTorch.

python fit_network.py SOURCE OUT.npz [--object NAME] [--width 32] [--layers 2] [--omega 10] [--steps 4000] [--seed 0]
[--torch]

SOURCE is a mesh (.obj, .ply, .stl), a .blend with --object, or a text file with an expression (.txt).
"""

from __future__ import annotations

import argparse
import pathlib
import sys

import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(REPOSITORY))

from sdf_lights.sdf.data.network import Siren  # noqa: E402
from sdf_lights.sdf.expression import Expression  # noqa: E402
from sdf_lights.sdf.shapes import Shape  # noqa: E402

IMPORTERS = {".obj": "obj_import", ".ply": "ply_import", ".stl": "stl_import"}
POOL = 1 << 18  # points
NEAR = 0.1  # half sides from the surface at which points are a third as frequent
RATES = 3e-3, 3e-5  # of learning, at the beginning and at the end
MOMENTS = 0.9, 0.99
# of weights, times the rate (Loshchilov and Hutter 2019): small weights have close bounds, so rays take fewer steps
DECAY = 0.15
MARGIN = 0.1  # around the shape, of half its longest side


def shape_of(source: pathlib.Path, name: str = "") -> Shape:
    """The shape of a file: of an expression, or what a mesh encloses."""
    if source.suffix == ".txt":
        return Expression(source.read_text(encoding="utf-8")).shape()
    import bpy

    from sdf_lights.sdf.data.voxels import mesh_grid

    if source.suffix == ".blend":
        bpy.ops.wm.open_mainfile(filepath=str(source))
        found = bpy.data.objects.get(name)
        if found is None:
            raise SystemExit(f"{source} has no object '{name}': name one with --object.")
        chosen = [found]
    elif source.suffix in IMPORTERS:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        getattr(bpy.ops.wm, IMPORTERS[source.suffix])(filepath=str(source))
        chosen = [obj for obj in bpy.data.objects if obj.type == "MESH"]
    else:
        raise SystemExit(f"{source} is no .obj, .ply, .stl, .blend or .txt file.")
    graph, vertices, faces = bpy.context.evaluated_depsgraph_get(), [np.zeros((0, 3))], [np.zeros((0, 3), int)]
    for obj in chosen:
        mesh = obj.evaluated_get(graph).to_mesh()
        mesh.calc_loop_triangles()
        corners = np.array([vertex.co for vertex in mesh.vertices]).reshape(-1, 3)
        triangles = np.array([tuple(triangle.vertices) for triangle in mesh.loop_triangles], int).reshape(-1, 3)
        matrix = np.array(obj.matrix_world)
        faces.append(triangles + sum(map(len, vertices)))
        vertices.append(corners @ matrix[:3, :3].T + matrix[:3, 3])
    return mesh_grid(np.concatenate(vertices), np.concatenate(faces))


def fit(
    shape: Shape,
    width: int,
    layers: int,
    omega: float,
    steps: int,
    batch: int,
    seed: int,
    say=lambda text: None,
    with_torch: bool = False,
) -> Siren:
    """A network whose field is near that of the shape: least squares by Adam (Kingma and Ba 2015), near its surface
    above all."""
    rng = np.random.default_rng(seed)
    low, high = shape.bounds()
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    size = float(half.max())
    half = half / size + MARGIN
    points = rng.uniform(-half, half, (4 * POOL, 3))
    distances = shape.distance(middle + size * points) / size
    near = rng.random(len(points)) < 0.1 + 0.9 * np.exp(-np.abs(distances) / NEAR)
    points, distances = points[near][:POOL].astype(np.float32), distances[near][:POOL].astype(np.float32)
    weights, biases, inputs = [], [], 3
    for index in range(layers + 1):
        outputs = width if index < layers else 1
        # As the paper starts: the sums of all layers have the same spread.
        spread = 1.0 / inputs if index == 0 else np.sqrt(6.0 / inputs) / omega
        weights.append(rng.uniform(-spread, spread, (outputs, inputs)).astype(np.float32))
        biases.append(rng.uniform(-spread, spread, outputs).astype(np.float32))
        inputs = outputs
    train = _train_with_torch if with_torch else _train
    batches = (rng.integers(len(points), size=batch) for _ in range(steps))
    weights, biases = train(
        points,
        distances,
        weights,
        biases,
        omega,
        steps,
        batches,
        lambda step, error: say(f"{step}: {size * error:.5f} m"),
    )
    # From a box of half side 1 to metres.
    scaled = [weights[0].astype(np.float64) / size, *weights[1:-1], size * weights[-1]]
    moved = [biases[0] - scaled[0] @ middle, *biases[1:-1], size * biases[-1]]
    return Siren(scaled, moved, omega, (middle - size * half, middle + size * half))


def _rate(step: int, steps: int) -> float:
    return RATES[0] * (RATES[1] / RATES[0]) ** (step / steps)


def _train(points, distances, weights, biases, omega, steps, batches, told):
    """Weights and biases after ``steps`` steps, each with the points that are next in ``batches``."""
    parameters = weights + biases
    first, second = ([np.zeros_like(part) for part in parameters] for _ in range(2))
    for step, chosen in enumerate(batches):
        error, slopes = _slopes(points[chosen], distances[chosen], weights, biases, np.float32(omega))
        if step % 500 == 0:
            told(step, error)
        rate = _rate(step, steps)
        for part in weights:
            part *= np.float32(1.0 - DECAY * rate)
        for part, slope, mean, square in zip(parameters, slopes, first, second):
            mean += (1.0 - MOMENTS[0]) * (slope - mean)
            square += (1.0 - MOMENTS[1]) * (slope**2 - square)
            unbiased = mean / (1.0 - MOMENTS[0] ** (step + 1))
            part -= np.float32(rate) * unbiased / (np.sqrt(square / (1.0 - MOMENTS[1] ** (step + 1))) + 1e-8)
    return weights, biases


def _train_with_torch(points, distances, weights, biases, omega, steps, batches, told):
    """The same by PyTorch, on its graphics card if there is one."""
    try:
        import torch
    except ImportError:
        raise SystemExit("PyTorch is not installed: install it, or leave out --torch.") from None
    device = "cuda" if torch.cuda.is_available() else "cpu"
    points, distances = (torch.from_numpy(array).to(device) for array in (points, distances))
    weights, biases = (
        [torch.from_numpy(part).to(device).requires_grad_() for part in parts] for parts in (weights, biases)
    )
    groups = [dict(params=weights, weight_decay=DECAY), dict(params=biases, weight_decay=0.0)]
    optimizer = torch.optim.AdamW(groups, betas=MOMENTS)
    for step, chosen in enumerate(batches):
        chosen = torch.from_numpy(chosen).to(device)
        values = points[chosen]
        for weight, bias in zip(weights[:-1], biases):
            values = torch.sin(omega * torch.nn.functional.linear(values, weight, bias))
        values = torch.nn.functional.linear(values, weights[-1], biases[-1])[:, 0]
        square = torch.mean((values - distances[chosen]) ** 2)
        if step % 500 == 0:
            told(step, square.item() ** 0.5)
        for group in optimizer.param_groups:
            group["lr"] = _rate(step, steps)
        optimizer.zero_grad()
        (0.5 * square).backward()
        optimizer.step()
    return tuple([part.detach().cpu().numpy() for part in parts] for parts in (weights, biases))


def _slopes(points, wanted, weights, biases, omega):
    """Root of the mean square error, and the slopes of half of that square by all weights and biases."""
    values, cosines = [points], []
    for weight, bias in zip(weights[:-1], biases):
        sums = omega * (values[-1] @ weight.T + bias)
        values.append(np.sin(sums))
        cosines.append(np.cos(sums))
    errors = (values[-1] @ weights[-1].T + biases[-1])[:, 0] - wanted
    back = (errors / len(points))[:, None]
    of_weights, of_biases = [], []
    for index in range(len(weights) - 1, -1, -1):
        of_weights.insert(0, back.T @ values[index])
        of_biases.insert(0, back.sum(axis=0))
        if index:
            back = omega * cosines[index - 1] * (back @ weights[index])
    return float(np.sqrt(np.mean(errors**2))), of_weights + of_biases


def main(arguments: list[str]) -> None:
    """Write a network."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "source", type=pathlib.Path, help="a mesh (.obj, .ply, .stl), a .blend, or an expression (.txt)"
    )
    parser.add_argument("out", type=pathlib.Path, help="the .npz file to write")
    parser.add_argument("--object", default="", help="the object of a .blend")
    parser.add_argument("--width", type=int, default=32, help="neurons of a layer")
    parser.add_argument("--layers", type=int, default=2, help="hidden layers")
    parser.add_argument("--omega", type=float, default=10.0, help="factor of the sums in sines: more for finer details")
    parser.add_argument("--steps", type=int, default=4000)
    parser.add_argument("--batch", type=int, default=4096, help="points of a step")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--torch", action="store_true", help="fit with PyTorch, which you have to install")
    options = parser.parse_args(arguments)
    shape = shape_of(options.source, options.object)
    sizes = options.width, options.layers, options.omega, options.steps, options.batch, options.seed
    found = fit(shape, *sizes, say=print, with_torch=options.torch)
    found.save(options.out)
    print(f"{options.out}: Lipschitz constant {found.shape().lipschitz:.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
