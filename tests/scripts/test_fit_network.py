# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The script that fits a network to a shape."""

import importlib.util

import fit_network
import numpy as np
import pytest

from sdf_lights.sdf.data.network import read
from support import grids


def test_the_script_fits_a_network_and_a_seed_gives_one(tmp_path):
    source = tmp_path / "ball.txt"
    source.write_text("sphere(0.5)")
    for name in ("a", "b"):
        fit_network.main(
            [str(source), str(tmp_path / f"{name}.npz"), "--width", "16", "--steps", "400", "--batch", "512"]
        )
    first, again = (read(tmp_path / f"{name}.npz") for name in "ab")
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (2000, 3))
    np.testing.assert_array_equal(first.values(points), again.values(points))
    assert np.abs(first.values(points) - (np.linalg.norm(points, axis=1) - 0.5)).mean() < 0.02


def test_pytorch_takes_the_same_steps(tmp_path):
    source = tmp_path / "ball.txt"
    source.write_text("sphere(0.5)")
    options = ["--width", "8", "--steps", "20", "--batch", "256"]
    if importlib.util.find_spec("torch") is None:
        with pytest.raises(SystemExit, match="PyTorch is not installed: install it"):
            fit_network.main([str(source), str(tmp_path / "a.npz"), *options, "--torch"])
        return
    for name, more in (("a", []), ("b", ["--torch"])):
        fit_network.main([str(source), str(tmp_path / f"{name}.npz"), *options, *more])
    first, again = (read(tmp_path / f"{name}.npz") for name in "ab")
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (2000, 3))
    np.testing.assert_allclose(first.values(points), again.values(points), atol=1e-4)


def test_the_script_fits_a_mesh(tmp_path):
    vertices, faces = grids.torus(0.7, 0.25, 32, 16)
    lines = ["v {} {} {}".format(*v) for v in vertices] + ["f {} {} {}".format(*(f + 1)) for f in faces]
    (tmp_path / "ring.obj").write_text("\n".join(lines))
    shape = fit_network.shape_of(tmp_path / "ring.obj")
    found = fit_network.fit(shape, 16, 2, 8.0, 600, 512, 0)
    points = np.random.default_rng(2).uniform(*shape.bounds(), (5000, 3))
    inside = shape.distance(points) < 0.0
    assert ((found.values(points) < 0.0) == inside).mean() > 0.95
