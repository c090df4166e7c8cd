# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets look as their pictures in Blender's own scene under its own view transform, and are not blown out."""

import pathlib
import subprocess
import sys

import numpy as np
import OpenImageIO
import pytest

from sdf_lights import jit

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PICTURES = REPOSITORY / "sdf_lights" / "blender" / "presets"
NAMES = ("campfire", "neon_ring", "sunset", "gyroid")  # three with a pattern, of which the first two were white once
SIZE = 48  # half of the pictures'
WHITE = 0.95  # display value of all channels of what is blown out

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")


def pixels(path) -> np.ndarray:
    return OpenImageIO.ImageBuf(str(path)).get_pixels(OpenImageIO.FLOAT)[..., :3]


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("thumbnails")
    command = [sys.executable, str(REPOSITORY / "scripts" / "preset_thumbnails.py"), *NAMES]
    command += ["--size", str(SIZE), "--samples", "16", "--out", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=500)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_looks_as_its_picture(rendered, name):
    picture = pixels(PICTURES / f"{name}.png")
    assert picture.shape == (2 * SIZE, 2 * SIZE, 3)
    smaller = picture.reshape(SIZE, 2, SIZE, 2, 3).mean((1, 3))
    assert np.abs(smaller - pixels(rendered / f"{name}.png")).mean() < 0.02


@pytest.mark.parametrize("name", sorted(path.stem for path in PICTURES.glob("*.png")))
def test_no_picture_is_blown_out(name):
    picture = pixels(PICTURES / f"{name}.png")
    assert (picture.min(axis=2) > WHITE).mean() < 0.001
    assert picture.max() > 0.6  # yet the lamp is bright
