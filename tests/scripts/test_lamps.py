# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of lamps for benchmarks: each has its lamps twice, as bright in SDF Lights as in Cycles."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from benchmarks import lamp_scenes, lamps, pictures, simple_scenes  # noqa: E402
from benchmarks.methods import Method  # noqa: E402

# Seconds of Blender's Boolean, marching of tetrahedra and networks. The slow test below renders them.
COSTLY = "S3", "spring", "rabbit", "corridor_network"


@pytest.mark.slow
def test_each_lamp_has_its_volume():
    for name, about in lamp_scenes.SCENES.items():
        if name in COSTLY:
            continue
        about.build(16)
        lamp_scenes.show(volumes=False)
        lamps = bpy.data.collections[lamp_scenes.LAMPS].objects
        assert lamps and all(lamp.data.sdf_lamp.use for lamp in lamps)
        volumes = bpy.data.collections[lamp_scenes.VOLUMES].objects
        assert len(volumes) == (len(lamps) if about.volumes else 0)


def test_scenes_without_volumes_do_not_count_against_cycles():
    def row(scene: str, ratio: float, **more) -> dict:
        worst = {f"{error} MIS / CUT": 1.5 for error in lamps.WORST}
        return {
            "scene": scene,
            "bounces": 4,
            "MIS / CUT": ratio,
            "MIS guided / CUT": 1.1,
            "slope": -0.6,
            **worst,
            **more,
        }

    cycles = {"cycles": 40.0, "cycles denoised": 4.0, "both denoised": 10.0}
    for rows in ([row("skin", 1.2), row("wall", 3.0, **cycles)], [row("wall", 3.0, **cycles), row("skin", 1.2)]):
        summary = lamps._summary(rows, "CUT")
        assert summary["mse_ratio_cycles_bounces_geomean"] == pytest.approx(40.0)
        assert summary["mse_ratio_both_denoised_bounces_geomean"] == pytest.approx(10.0)
        assert summary["mse_ratio_paper_bounces_geomean"] == pytest.approx(3.6**0.5)
        assert summary["mse_ratio_paper_bounces_min"] == 1.2
    assert "mse_ratio_cycles_bounces_min" not in lamps._summary([row("skin", 1.2)], "CUT")


@pytest.mark.parametrize("sampler", ["BOUNDING", pytest.param("SURFACE", marks=pytest.mark.slow)])
def test_samplers_to_compare_with_render_through_blender(sampler):
    """The extension's copy of the program knows those that are registered: the mean of a picture, within a tenth of
    ours."""
    lamp_scenes.SCENES["S2"].build(16)
    found, ours = (Method(name, name, plain=True).render(64, 0, 0, "CPU").pixels.mean() for name in (sampler, "CUT"))
    assert found == pytest.approx(ours, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [  # the spark is one that Cycles hardly ever finds
        name for name, about in lamp_scenes.SCENES.items() if about.volumes and name != "spark"
    ],
)
def test_as_bright_as_in_cycles(name):
    size, blocks = 48, 6
    lamp_scenes.SCENES[name].build(size)
    scene = bpy.context.scene
    made = {}
    for volumes in (False, True):
        lamp_scenes.show(volumes)
        renders = []
        for seed in range(4):
            if volumes:
                simple_scenes.plain_cycles(scene, 256, 1)
                scene.cycles.seed = seed
            else:
                simple_scenes.plain_sdf_lights(scene, 64, 1, "CPU")
                scene.sdf_lights.seed = seed
            pixels = pictures.render().pixels
            renders.append(pixels.reshape(blocks, size // blocks, blocks, size // blocks, 3).mean(axis=(1, 3)))
        made[volumes] = np.array(renders)
    ours, theirs = (made[volumes].mean(axis=0) for volumes in (False, True))
    error = np.sqrt(sum(made[volumes].var(axis=0, ddof=1) / 4 for volumes in (False, True)))
    means = [made[volumes].mean(axis=(1, 2, 3)) for volumes in (False, True)]
    doubt = np.sqrt(sum(found.var(ddof=1) / 4 for found in means))
    assert abs(ours.mean() - theirs.mean()) < 0.01 * theirs.mean() + 5.0 * doubt
    # Half a per cent for the shape of the meshes.
    assert np.mean(np.abs(ours - theirs) > 5.0 * error + 0.005 * theirs.max()) < 0.05
