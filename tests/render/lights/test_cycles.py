# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A white diffuse plane under each of Blender's lights is as bright as in Cycles: means within 0.5 %."""

import math

import numpy as np
import pytest

from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from tests.render.lights.harness import UP, Packed, irradiance, scene_of

bpy = pytest.importorskip("bpy")
pytestmark = pytest.mark.slow

SIDE, WIDTH = 32, 4.0

# Blender's type, settings of the light, rotation and scale of the object.
CASES = {
    "point": ("POINT", dict(shadow_soft_size=0.0), (0, 0, 0), (1, 1, 1)),
    "soft falloff": ("POINT", dict(shadow_soft_size=0.7, use_soft_falloff=True), (0, 0, 0), (1, 1, 1)),
    "sphere": ("POINT", dict(shadow_soft_size=0.7, use_soft_falloff=False), (0, 0, 0), (1, 1, 1)),
    "scaled sphere": ("POINT", dict(shadow_soft_size=0.7, use_soft_falloff=False), (0, 0, 0), (2, 2, 2)),
    "spot": ("SPOT", dict(shadow_soft_size=0.0, spot_size=1.0, spot_blend=0.4), (0, 0, 0), (1, 1, 1)),
    "elliptic spot": ("SPOT", dict(shadow_soft_size=0.3, spot_size=1.0, spot_blend=0.4), (0.2, 0, 0), (2, 1, 1)),
    "wide spot": (
        "SPOT",
        dict(shadow_soft_size=0.6, spot_size=0.8, spot_blend=0.1, use_soft_falloff=False),
        (0, 0, 0),
        (1, 1, 1),
    ),
    "rectangle": ("AREA", dict(shape="RECTANGLE", size=2.0, size_y=1.0), (0, 0, 0), (1, 1, 1)),
    "scaled square": ("AREA", dict(shape="SQUARE", size=1.0), (0.3, 0.2, 0.5), (2, 0.5, 3)),
    "ellipse": ("AREA", dict(shape="ELLIPSE", size=2.0, size_y=1.0), (0, 0, 0), (1, 1, 1)),
    "disk, spread": ("AREA", dict(shape="DISK", size=1.0, spread=1.0), (0, 0, 0), (1, 1, 1)),
    "rectangle, spread": ("AREA", dict(shape="RECTANGLE", size=2.0, size_y=1.0, spread=2.0), (0, 0, 0), (1, 1, 1)),
    "parallel beam": ("AREA", dict(shape="SQUARE", size=1.0, spread=0.0), (0, 0, 0), (1, 1, 1)),
    "sun": ("SUN", dict(energy=3.0, angle=0.0), (0.5, 0, 0), (1, 1, 1)),
    "wide sun": ("SUN", dict(energy=3.0, angle=1.0), (0.5, 0, 0), (1, 1, 1)),
}


def cycles(kind, settings, rotation, scale, path):
    """Picture of the plane z = 0 by an orthographic camera above it, and the light's matrix."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.max_bounces, scene.cycles.seed = 256, 0, 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.light_sampling_threshold = 0.0
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(path)

    bpy.ops.mesh.primitive_plane_add(size=20.0)
    material = bpy.data.materials.new("white")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    material.node_tree.links.new(diffuse.outputs[0], output.inputs[0])
    bpy.context.object.data.materials.append(material)

    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.data.clip_start = "ORTHO", WIDTH, 0.01
    camera.location = (0.0, 0.0, 1.0)
    light = bpy.data.objects.new("light", bpy.data.lights.new("light", kind))
    for name, value in {"energy": 100.0, **settings}.items():
        setattr(light.data, name, value)
    light.location, light.rotation_euler, light.scale = (0.0, 0.0, 2.0), rotation, scale
    for member in (camera, light):
        scene.collection.objects.link(member)
    scene.camera = camera
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.array(image.pixels[:]).reshape(SIDE, SIDE, image.channels)
    return pixels[..., 0], np.array(light.matrix_world)


def ours(kind, settings, matrix):
    settings = {"energy": 100.0, **settings}
    power = settings["energy"]
    if kind == "SUN":
        return SunLight("", matrix, power, angle=settings["angle"])
    if kind == "AREA":
        size = settings["size"]
        return AreaLight(
            "",
            matrix,
            power,
            ellipse=settings["shape"] in ("DISK", "ELLIPSE"),
            size=(size, settings.get("size_y", size)),
            spread=settings.get("spread", math.pi),
        )
    round_ = dict(radius=settings["shadow_soft_size"], soft_falloff=settings.get("use_soft_falloff", True))
    if kind == "SPOT":
        return SpotLight("", matrix, power, angle=settings["spot_size"], blend=settings["spot_blend"], **round_)
    return PointLight("", matrix, power, **round_)


@pytest.mark.parametrize("name", CASES)
def test_as_bright_as_in_cycles(name, tmp_path):
    kind, settings, rotation, scale = CASES[name]
    theirs, matrix = cycles(kind, settings, rotation, scale, tmp_path / "plane.exr")
    packed = Packed(scene_of(ours(kind, settings, matrix)))
    # Four points a pixel stand for the pixel filter.
    at = (np.arange(2 * SIDE) + 0.5) / (2 * SIDE) * WIDTH - WIDTH / 2.0
    mine = np.array([[irradiance(packed, 0, (x, y, 0.0), UP, 24) for x in at] for y in at]) / math.pi
    mine = mine.reshape(SIDE, 2, SIDE, 2).mean(axis=(1, 3))
    assert mine.mean() == pytest.approx(theirs.mean(), rel=5e-3)
    # The shape too: the difference of the pictures is small against the picture.
    assert np.abs(mine - theirs).mean() < 0.02 * theirs.mean()
