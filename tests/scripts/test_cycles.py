# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against time beside Cycles: mesh lights of the same power, and what is read off the curves."""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

import bench  # noqa: E402
from benchmarks import cycles, lamp_meshes, lamp_scenes, pictures, references, simple_scenes  # noqa: E402
from benchmarks.methods import Method  # noqa: E402


@pytest.mark.parametrize("name", ["S1", "S4", "nested"])
def test_mesh_lights_have_the_power_of_the_lamps(name):
    lamp_scenes.SCENES[name].build(16)
    lamp_scenes.show(surfaces=True)
    volumes = bpy.data.collections[lamp_scenes.VOLUMES]
    surfaces = bpy.data.collections[lamp_scenes.SURFACES]
    assert not surfaces.hide_render and volumes.hide_render and len(surfaces.objects) == len(volumes.objects)
    for volume, surface in zip(volumes.objects, surfaces.objects):
        inside, area = lamp_meshes.measures(surface.data)
        density, radiance = (
            thing.data.materials[0].node_tree.nodes["Emission"].inputs["Strength"].default_value
            for thing in (volume, surface)
        )
        assert math.pi * radiance * area == pytest.approx(4.0 * math.pi * density * inside, rel=1e-6)


def test_measures_of_a_torus():
    mesh = lamp_meshes.mesh("Torus", lamp_meshes.torus(1.0, 0.35))
    assert lamp_meshes.measures(mesh) == pytest.approx((2.0 * math.pi**2 * 0.35**2, 4.0 * math.pi**2 * 0.35), rel=2e-3)


def test_a_convex_mesh_light_lights_a_far_wall_like_the_volume():
    """Of a ball, from metres away, nothing but the power matters."""
    scene = simple_scenes.boxes_and_sphere(16)
    solid = lamp_meshes.sphere(1.0, 32, 16)
    lamp_scenes.add_lamp("Ball", "sphere(1)", solid, lamp_scenes.turned(at=(0.0, -5.0, 9.0)), 1.0)
    means = []
    for surfaces in (False, True):
        lamp_scenes.show(volumes=not surfaces, surfaces=surfaces)
        simple_scenes.plain_cycles(scene, 256 if surfaces else 4096, 0)
        means.append(pictures.render().pixels.mean())
    assert means[1] == pytest.approx(means[0], rel=0.03)


def made(seconds: float, error: float) -> pictures.Picture:
    """A picture whose relative error is the same everywhere."""
    return pictures.Picture(np.full((4, 4, 3), 1.0 + error), seconds, seconds)


def test_rows_have_the_band_of_the_seeds(tmp_path, monkeypatch):
    monkeypatch.setenv("SDF_LIGHTS_REFERENCES", str(tmp_path))
    reference = references.Reference("even")
    for _ in range(2):
        reference.add(lambda seed: (np.ones((4, 4, 3)), 0.0))
    method = Method("CUT", "CUT", pictures={4: [made(1.0, 0.1), made(3.0, 0.2), made(2.0, 0.3)]})
    (row,) = method.rows("S1", 0, reference)
    assert (row["seeds"], row["clock"]) == (3, 2.0)
    assert [row[f"rel_mse{end}"] for end in ("_low", "", "_high")] == pytest.approx(
        [error / 1.01 for error in (0.01, 0.14 / 3.0, 0.09)]
    )
    assert [row[f"mape{end}"] for end in ("_low", "", "_high")] == pytest.approx(
        [error / 1.01 for error in (0.1, 0.2, 0.3)]
    )
    assert row["mean_ratio"] == pytest.approx(1.2)


def test_a_method_that_has_not_begun_has_no_error_at_that_time():
    slow = Method("slow", pictures={4: [made(10.4, 0.1)], 16: [made(11.6, 0.1)]})
    each, start = slow.rate()
    assert slow.samples_in(start + 8.0 * each) == pytest.approx(8.0)
    assert slow.samples_in(0.5 * start) < 1.0


def test_summary_is_the_geometric_mean_over_scenes():
    found = [
        {
            "scene": scene,
            "bounces": 0,
            "samples": 64,
            "rel_mse CUT": 1.0,
            "rel_mse Cycles volume": ratio,
            "rel_mse Cycles mesh light": mesh,
        }
        for scene, ratio, mesh in (("S1", 4.0, 3.0), ("S2", 9.0, None))
    ]
    rows = [
        dict(scene=scene, bounces=0, samples=64, method=method, rel_mse=value, mape=None, flip=None)
        for scene, value in (("S1", 2.0), ("S2", 8.0))
        for method, value in (("CUT", 1.0), ("Cycles volume", value))
    ]
    summary = cycles.summary_of(found, rows, "CUT")
    assert summary == pytest.approx(
        {
            "rel_mse_ratio_cycles_volume_direct_equal_time": 6.0,
            "rel_mse_ratio_cycles_volume_direct_equal_samples": 4.0,
            "rel_mse_ratio_cycles_mesh_light_direct_equal_time": 3.0,
        }
    )


@pytest.mark.parametrize("text", ["4", "16,4", "4,four", "0,4"])
def test_a_ladder_goes_from_few_to_many(text, capsys):
    with pytest.raises(SystemExit):
        bench.parse(["cycles", "--ladder", text])
    assert "--ladder" in capsys.readouterr().err
