# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's four kinds of scenes, and its figures beside ours."""

import pytest

bpy = pytest.importorskip("bpy")

import bench  # noqa: E402
from benchmarks import lamp_scenes, paper, paper_scenes  # noqa: E402
from benchmarks.progress import Progress  # noqa: E402
from reporting import results, sampling_sections  # noqa: E402


def test_every_published_scene_is_rebuilt():
    assert set(paper_scenes.SCENES) == set(paper.PUBLISHED)


@pytest.mark.parametrize("name, lamps", [("room", 5), ("kitchen", 1), ("corridor", 1)])
def test_the_camera_is_inside_and_sees_surfaces_from_their_front(name, lamps):
    paper_scenes.SCENES[name].build(16)
    things = bpy.data.collections[lamp_scenes.LAMPS].objects
    assert len(things) == lamps
    seen = paper._seen(8)
    assert len(seen) == 64  # every ray ends at a wall
    eye = bpy.context.scene.camera.matrix_world.translation
    assert all(normal.dot(eye - place) >= 0.0 for place, normal in seen)
    assert len({round(coordinate, 3) for place, _ in seen for coordinate in place}) > 64


@pytest.mark.slow
def test_the_statue_has_many_triangles():
    paper_scenes.SCENES["dragon"].build(16)
    assert max(len(mesh.loop_triangles) for mesh in paper._triangulated()) > 100_000


def test_figures_of_the_paper_stand_beside_ours(tmp_path):
    rows = [
        dict(
            scene="kitchen",
            method=method,
            mape=0.02,
            flip=None,
            rel_mse=1e-3,
            seconds=1.0,
            samples=64,
            seeds=8,
            reference=0.001,
        )
        for method in ("BSDF", "BOUNDING", "SURFACE", "PROJECTION", "MIS", "CUT")
    ]
    rows += [
        dict(scene="kitchen", technique=technique, mape_at_points=0.1)
        for technique in ("cosine", "bounding", "surface", "projection")
    ]
    result = results.Result("paper", "", {}, [*paper.compared(rows), *rows], dict(processor="A", cores=2))
    text = "\n".join(sampling_sections.paper(result, tmp_path, tmp_path / "page.md"))
    assert f"| kitchen |{' 0.02 |' * 6} 0.945 | 0.079 | 0.013 |" in text
    assert f"| kitchen |{' – |' * 6} 0.761 | 0.083 | 0.02 |" in text
    assert f"| kitchen |{' 1 |' * 6}\n" in text  # seconds, of which the paper has none


def test_ratios_are_to_projection_sampling():
    rows = [
        dict(scene="kitchen", method=method, mape=mape, flip=None)
        for method, mape in (
            ("BSDF", 0.8),
            ("BOUNDING", 0.04),
            ("SURFACE", 0.05),
            ("PROJECTION", 0.02),
            ("MIS", 0.03),
            ("CUT", 0.01),
        )
    ]
    rows += [
        dict(scene="kitchen", technique=technique, mape_at_points=mape)
        for technique, mape in (("cosine", 0.6), ("bounding", 0.06), ("surface", 0.02), ("projection", 0.01))
    ]
    (row,) = paper.compared(rows)
    assert row["competitor"] == "bounding volume"
    assert row["paper_mape_bsdf_to_projection"] == pytest.approx(0.945 / 0.013)
    assert row["mape_bsdf_to_projection"] == pytest.approx(40.0) and row["flip_bsdf_to_projection"] is None
    assert row["mape_cut_to_projection"] == pytest.approx(0.5)
    assert row["mape_surface_to_projection"] == pytest.approx(2.5)
    assert row["points_bounding_to_projection"] == pytest.approx(6.0)
    assert row["points_surface_to_projection"] == pytest.approx(2.0)


@pytest.mark.slow
def test_rows_of_a_scene_give_its_ratios(tmp_path, monkeypatch):
    monkeypatch.setenv("SDF_LIGHTS_REFERENCES", str(tmp_path))
    options = bench.parse(["paper", "--quick", "--size", "16", "--reference-seconds", "0"])
    rows = paper.measure("corridor", options, Progress(1))
    (row,) = paper.compared(rows)
    assert row["mape_bsdf_to_projection"] > 5.0
    assert row["points_bounding_to_projection"] > 1.0
