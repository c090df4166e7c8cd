# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Projections of image textures, rendered, against Cycles."""

import bpy
import numpy as np
import pytest

from tests.blender.test_images import COLORS, load, rendered, saved

PIXELS = 32


@pytest.fixture
def pictures_of_both(file, add, material, tmp_path):
    """Function: pictures (height, width, 3) of a scaled and turned object with an image texture that glows, by SDF
    Lights on a device, and by Cycles."""
    pytest.importorskip("_cycles")
    pytest.importorskip("OpenImageIO")
    bpy.ops.preferences.addon_enable(module="cycles")
    scene = file.scene
    image = load(saved(tmp_path / "image.png", COLORS))

    def run(device: str, coordinates: str = "Generated", output: str = "Color", smooth: bool = True, **settings):
        made, tree, surface = material()
        node, emission = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
        node.image = image
        for name, value in settings.items():
            setattr(node, name, value)
        place = tree.nodes.new("ShaderNodeTexCoord").outputs[coordinates]
        tree.links.new(place, node.inputs["Vector"])
        tree.links.new(node.outputs[output], emission.inputs["Color"])
        tree.links.new(emission.outputs[0], surface)
        bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
        ball = bpy.context.object
        ball.rotation_euler, ball.scale = (0.4, 0.3, 0.8), (1.2, 0.8, 1.0)
        for polygon in ball.data.polygons:
            polygon.use_smooth = smooth
        ball.data.materials.append(made)
        scene.render.resolution_x = scene.render.resolution_y = PIXELS
        file.camera.data.type, file.camera.data.ortho_scale = "ORTHO", 2.6
        file.camera.location = (0.0, -5.0, 0.0)
        own = scene.sdf_lights
        own.device, own.samples, own.filter, own.filter_width = device, 1, "BLACKMAN_HARRIS", 0.01
        engine = scene.render.engine
        mine = rendered(scene, engine)
        return mine, rendered(scene)

    return run


def check(mine, theirs, seam: float = 0.005) -> None:
    """The same but for pixels on edges, where a sample lies on one side or the other: no more than a part ``seam``."""
    assert np.ptp(theirs) > 0.1
    different = (np.abs(mine - theirs) > 0.02 + 0.02 * theirs).any(axis=2)
    assert different.mean() <= seam
    assert mine.mean() == pytest.approx(theirs.mean(), rel=0.01)


@pytest.mark.parametrize("projection", ["FLAT", "SPHERE", "TUBE", "BOX"])
@pytest.mark.parametrize("coordinates", ["Generated", "Object"])
def test_projections(pictures_of_both, projection, coordinates):
    check(*pictures_of_both("CPU", coordinates, projection=projection, interpolation="Cubic"))


@pytest.mark.parametrize("blend", [0.2, 0.7, 1.0])
@pytest.mark.parametrize("device", ["CPU", "REFERENCE"])
def test_blend_of_boxes(pictures_of_both, blend, device):
    check(*pictures_of_both(device, projection="BOX", projection_blend=blend))


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_boxes_of_flat_faces(pictures_of_both, smooth, output):
    check(*pictures_of_both("CPU", output=output, smooth=smooth, projection="BOX"))
