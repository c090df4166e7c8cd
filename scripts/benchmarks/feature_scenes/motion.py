# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur of everything that can move while the shutter is open."""

from __future__ import annotations

import bpy
from scenery.modelling import add

from .geometry import fur
from .stage import FRAME, feature, lamp


def keyed(owner, path: str, *values) -> None:
    """Give a property these values at frames one after the other, of which the middle one is rendered."""
    for frame, value in enumerate(values, FRAME - len(values) // 2):
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)
    bpy.context.scene.frame_set(FRAME)


def _open(scene, shutter: float = 1.0) -> None:
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, shutter


@feature("Motion blur")
def moving_camera(scene):
    """A camera that turns and rises."""
    _open(scene)
    location = scene.camera.location.copy()
    keyed(scene.camera, "location", location, location + type(location)((0.05, 0.0, 0.1)), location)


@feature("Motion blur")
def zooming_camera(scene):
    """A focal length that changes."""
    _open(scene)
    keyed(scene.camera.data, "lens", 42.0, 52.0, 62.0)


@feature("Motion blur")
def moving_objects(scene):
    """A glass ball that flies, a block that turns, and a glowing lamp that falls."""
    _open(scene)
    keyed(bpy.data.objects["Glass"], "location", (0.6, -0.4, 0.35), (0.9, -0.2, 0.45), (1.2, 0.2, 0.35))
    keyed(bpy.data.objects["Block"], "rotation_euler", (0.0, 0.0, 0.0), (0.0, 0.0, 0.5), (0.0, 0.0, 1.2))
    keyed(lamp(), "location", (0.3, -0.9, 1.2), (0.4, -0.9, 0.9), (0.5, -0.9, 0.3))


@feature("Motion blur")
def deformation(scene):
    """A mesh that leans by a shape key."""
    _open(scene)
    block = bpy.data.objects["Block"]
    block.shape_key_add(name="Basis")
    key = block.shape_key_add(name="Lean")
    for point in key.data:
        point.co.x += 0.6 * max(point.co.z, 0.0)
    keyed(key, "value", 0.0, 0.5, 1.0)


@feature("Motion blur")
def moving_hair(scene):
    """Particle hair on a ball that moves."""
    _open(scene)
    keyed(fur(), "location", (-0.5, -0.5, 0.3), (-0.2, -0.5, 0.35), (0.1, -0.4, 0.3))


@feature("Motion blur")
def moving_instances(scene):
    """Instances of a collection whose empties move."""
    _open(scene)
    group = bpy.data.collections.new("Group")
    part = bpy.data.objects["Plastic"]
    group.objects.link(part)
    scene.collection.objects.unlink(part)
    for x in (-0.5, 0.4):
        holder = add(f"Holder {x}", None, location=(x, 0.0, 0.0))
        holder.instance_type, holder.instance_collection = "COLLECTION", group
        keyed(holder, "location", (x, -0.2, 0.0), (x, -0.1, 0.1), (x + 0.2, 0.1, 0.3))


@feature("Motion blur")
def shutter_curve(scene):
    """A shutter that opens fast and closes slowly, after the frame."""
    _open(scene)
    scene.render.motion_blur_position = "START"
    points = scene.render.motion_blur_shutter_curve.curves[0].points
    points[0].location, points[-1].location = (0.0, 1.0), (1.0, 0.0)
    scene.render.motion_blur_shutter_curve.update()
    keyed(bpy.data.objects["Plastic"], "location", (-0.9, -0.5, 0.3), (-0.2, -0.5, 0.3), (0.5, -0.5, 0.3))


@feature("Motion blur")
def rolling_shutter(scene):
    """A rolling shutter of a camera that moves."""
    _open(scene)
    scene.cycles.rolling_shutter_type, scene.cycles.rolling_shutter_duration = "TOP", 0.2
    location = scene.camera.location.copy()
    step = type(location)((0.5, 0.0, 0.0))
    keyed(scene.camera, "location", location - step, location, location + step)
