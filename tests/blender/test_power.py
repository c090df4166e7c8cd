# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Watts: far away an SDF lamp is a point light of the same power, as Cycles renders it."""

import bpy
import numpy as np
import pytest

POWER, COLOR = 1e5, (1.0, 0.5, 0.25)

# Seventy metres from the floor. What the extent of a lamp of a metre changes there is of the order of its square, 2e-4.
PLACE = (30.0, -20.0, 60.0)
BALL = "sphere(0.4)"
RING = "torus(0.4, 0.15)"
CUT = f"difference(union(box((0.4, 0.3, 0.2)), {RING}), {BALL})"


@pytest.fixture
def floor(file, add, quad, material):
    """A grey floor that fills the picture, seen from above."""
    pytest.importorskip("_cycles")
    bpy.ops.preferences.addon_enable(module="cycles")
    made, tree, output = material()
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], output)
    mesh = quad()
    mesh.materials.append(made)
    add("Floor", mesh, scale=(5.0, 5.0, 1.0))
    file.camera.location, file.camera.rotation_euler = (0.0, 0.0, 5.0), (0.0, 0.0, 0.0)
    file.camera.data.type, file.camera.data.ortho_scale = "ORTHO", 1.0
    file.scene.cycles.samples, file.scene.cycles.seed, file.scene.cycles.use_denoising = 16, 1, False
    file.scene.sdf_lights.samples = 16


def mean(pictures) -> np.ndarray:
    """Mean RGB of the picture, whose standard error is below a thousandth."""
    picture = pictures()["ViewLayer"]["Combined"][..., :3].reshape(-1, 3).astype(float)
    mean = picture.mean(axis=0)
    assert (picture.std(axis=0) / len(picture) ** 0.5 < 1e-3 * mean).all()
    return mean


@pytest.mark.parametrize("device", ["CPU", "REFERENCE"])
@pytest.mark.parametrize(
    ("shape", "rotation", "scale"),
    [
        (BALL, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
        (RING, (0.5, 1.0, -2.0), (2.0, 1.0, 0.25)),
        (CUT, (1.0, -0.3, 0.7), (-1.0, 2.0, 0.5)),
    ],
    ids=["sphere", "torus", "CSG"],
)
def test_far_away_a_lamp_is_a_point_light_of_cycles(file, floor, add, lamp, pictures, device, shape, rotation, scale):
    """Within half of a per cent."""
    data = lamp(power=POWER)
    data.color, data.sdf_lamp.source, data.sdf_lamp.expression = COLOR, "EXPRESSION", shape
    obj = add("Lamp", data, PLACE, rotation, scale)
    file.scene.sdf_lights.device = device
    found = mean(pictures)

    bpy.data.objects.remove(obj)
    point = bpy.data.lights.new("Point", "POINT")
    point.energy, point.color, point.shadow_soft_size = POWER, COLOR, 0.0
    add("Point", point, PLACE)
    file.scene.render.engine = "CYCLES"
    np.testing.assert_allclose(found, mean(pictures), rtol=0.005)
