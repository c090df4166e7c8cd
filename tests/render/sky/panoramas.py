# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panoramas by Cycles, in a process of its own, and the Blender that is installed."""

import importlib.metadata
import json
import math
import pathlib
import subprocess
import sys

import numpy as np
import pytest

FULL = (-math.pi, math.pi, -0.5 * math.pi, 0.5 * math.pi, 96, 48)


def blender_version():
    try:
        return tuple(map(int, importlib.metadata.version("bpy").split(".")[:2]))
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("bpy is not installed")


def panoramas(cases, folder):
    """[(directions (n, 3), radiance (n, 3))] of cases as ``render_world.py`` takes them."""
    (folder / "cases.json").write_text(json.dumps(cases))
    script = pathlib.Path(__file__).with_name("render_world.py")
    command = [sys.executable, str(script), str(folder / "cases.json"), str(folder / "result.npz")]
    subprocess.run(command, check=True, capture_output=True, cwd=folder, timeout=1200)
    with np.load(folder / "result.npz") as result:
        return [(result[f"directions {i}"], result[f"radiance {i}"].astype(float)) for i in range(len(cases))]


def errors(ours, theirs, floor=1e-3):
    """Of each direction the largest error of a channel, relative to its brightness and at least to ``floor`` of the
    brightest."""
    least = max(floor * theirs.max(), 1e-12)
    return np.max(np.abs(ours - theirs) / np.maximum(theirs, least), axis=1)
