# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume objects as lamps: level sets of .vdb files by OpenVDB's own module, and what is said where there is none."""

import pathlib
import re
import sys

import bpy
import numpy as np
import pytest

from sdf_lights.blender import vdb_files
from sdf_lights.blender.lamp import shape_of
from sdf_lights.emitter.tree import interior
from sdf_lights.render.errors import RenderError

PYTHON = pathlib.Path(__file__).resolve().parents[2] / "docs" / "python.md"


@pytest.fixture
def vdb(openvdb):
    """OpenVDB's module, as the add-on finds it."""
    assert vdb_files.vdb() is openvdb
    return openvdb


@pytest.fixture
def lamp_of(file, lamp, add):
    """Function: the shape of a lamp of a volume with this file."""

    def make(path):
        volume = bpy.data.volumes.new("Cloud")
        volume.filepath = str(path)
        light = lamp()
        light.sdf_lamp.source, light.sdf_lamp.object = "OBJECT", add("Cloud", volume)
        bpy.context.view_layer.update()
        return shape_of(light.sdf_lamp)

    return make


def _distance_to_ring(points):
    return np.hypot(np.hypot(points[..., 0], points[..., 1]) - 0.7, points[..., 2]) - 0.25


def _ring(vdb, size, band=3):
    """A torus, in voxels around the origin."""
    count = int(1.1 / size)
    axis = size * np.arange(-count, count + 1)
    values = _distance_to_ring(np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)).astype(np.float32)
    grid = vdb.FloatGrid(band * size)
    grid.copyFromArray(np.clip(values, -band * size, band * size), ijk=(-count,) * 3, tolerance=1e-6)
    grid.signedFloodFill()
    grid.gridClass, grid.name = "level set", "surface"
    grid.transform = vdb.createLinearTransform(voxelSize=size)
    return grid


def test_a_level_set_is_a_certified_lamp(vdb, lamp_of, tmp_path):
    vdb.write(str(tmp_path / "ring.vdb"), [_ring(vdb, 0.04)])
    shape = lamp_of(tmp_path / "ring.vdb")
    assert shape.validate() == "" and shape.lipschitz < 1.8 and interior.tree(shape).certified
    points = np.random.default_rng(1).uniform(*shape.bounds(), (50_000, 3))
    exact, found = _distance_to_ring(points), shape.distance(points)
    near = np.abs(exact) < 0.06
    np.testing.assert_allclose(found[near], exact[near], atol=0.01)
    sure = np.abs(exact) > 0.01
    assert ((found < 0.0) == (exact < 0.0))[sure].all()
    assert np.abs(found).max() > 0.3  # far from the surface rays take long steps


def test_a_sphere_of_openvdb_has_its_inside(vdb, lamp_of, tmp_path):
    vdb.write(str(tmp_path / "a.vdb"), [vdb.createLevelSetSphere(radius=1.0, center=(0.5, 0.0, 2.0), voxelSize=0.05)])
    shape = lamp_of(tmp_path / "a.vdb")
    points = np.random.default_rng(2).normal(size=(3000, 3))
    points = (0.5, 0.0, 2.0) + points / np.linalg.norm(points, axis=1, keepdims=True)
    np.testing.assert_allclose(shape.distance(points), 0.0, atol=2e-3)
    assert shape.distance(np.array([0.5, 0.0, 2.0])) < -0.5


def test_a_lamp_that_python_wrote_comes_back(vdb, lamp_of, tmp_path, monkeypatch):
    """The recipe of docs/python.md, and the lamp of a Volume with its file."""
    code = re.search(r"^## 10\..*?^```python\n(.*?)^```", PYTHON.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    monkeypatch.chdir(tmp_path)
    told: dict = {}
    exec(compile(code[1], "docs/python.md", "exec"), told)
    found, exact, voxel = lamp_of(tmp_path / "lamp.vdb"), told["shape"], told["voxel"]
    assert found.validate() == "" and interior.tree(found).certified
    points = np.random.default_rng(4).uniform(*(1.2 * bound for bound in exact.bounds()), (50_000, 3))
    distances = exact.distance(points)
    sure = np.abs(distances) > voxel
    assert ((found.distance(points) < 0.0) == (distances < 0.0))[sure].all()
    assert 0.05 < (distances < 0.0).mean() < 0.15 and told["grid"].activeVoxelCount() > 1000


def test_a_transform_moves_turns_and_stretches_it(vdb, lamp_of, tmp_path):
    grid = _ring(vdb, 0.05)
    matrix = [[0.1, 0.0, 0.0, 0.0], [0.0, 0.0, 0.05, 0.0], [0.0, -0.05, 0.0, 0.0], [1.0, 2.0, 3.0, 1.0]]
    grid.transform = vdb.createLinearTransform(matrix)
    vdb.write(str(tmp_path / "a.vdb"), [grid])
    shape = lamp_of(tmp_path / "a.vdb")
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (2000, 3))
    inside = _distance_to_ring(points)
    rows = np.array(matrix)
    placed = (points / 0.05) @ rows[:3, :3] + rows[3, :3]
    sure = np.abs(inside) > 0.02
    assert ((shape.distance(placed) < 0.0) == (inside < 0.0))[sure].all()


def test_files_that_are_no_level_sets_say_so_in_a_sentence(vdb, lamp_of, tmp_path):
    fog = vdb.FloatGrid(0.0)
    fog.fill((0, 0, 0), (9, 9, 9), 1.0)
    fog.gridClass, fog.name = "fog volume", "density"
    vdb.write(str(tmp_path / "fog.vdb"), [fog])
    with pytest.raises(RenderError, match="Volume 'Cloud' has no level set.*Volume to Mesh"):
        lamp_of(tmp_path / "fog.vdb")
    empty = vdb.FloatGrid(0.1)
    empty.gridClass, empty.name = "level set", "surface"
    vdb.write(str(tmp_path / "empty.vdb"), [empty])
    with pytest.raises(RenderError, match="Volume 'Cloud.*' has an empty level set"):
        lamp_of(tmp_path / "empty.vdb")
    vdb.write(str(tmp_path / "whole.vdb"), [_ring(vdb, 0.1)])
    whole = (tmp_path / "whole.vdb").read_bytes()
    for number, cut in enumerate(range(0, len(whole), len(whole) // 17)):
        (tmp_path / f"cut{number}.vdb").write_bytes(whole[:cut])
        with pytest.raises(RenderError, match="Volume 'Cloud.*' .*(damaged|no level set|empty)") as caught:
            lamp_of(tmp_path / f"cut{number}.vdb")
        assert len(str(caught.value)) < 300


def test_a_volume_without_a_file_says_so(lamp_of, tmp_path):
    with pytest.raises(RenderError, match="Volume 'Cloud' has no file: choose a .vdb"):
        lamp_of("")
    with pytest.raises(RenderError, match="Volume 'Cloud.*' has no file 'gone.vdb': find it again"):
        lamp_of(tmp_path / "gone.vdb")


def test_without_openvdb_a_volume_names_the_cure(lamp_of, tmp_path, monkeypatch):
    (tmp_path / "a.vdb").write_bytes(b"")
    for name in vdb_files.MODULES:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(RenderError, match="Volume 'Cloud' cannot be read.*Blender from blender.org"):
        lamp_of(tmp_path / "a.vdb")
