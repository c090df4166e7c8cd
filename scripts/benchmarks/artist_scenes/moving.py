# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A frame of an animation with motion blur."""

from __future__ import annotations

import math

from scenery.materials import Graph, principled
from scenery.modelling import add, box, plane, smooth_profile, turned
from scenery.staging import camera, light, world

from .stage import scene


def _keyed(thing, frames: dict[int, dict[str, tuple]]) -> None:
    for frame, values in frames.items():
        for name, value in values.items():
            setattr(thing, name, value)
            thing.keyframe_insert(name, frame=frame)


@scene("a frame of an animation: a propeller, a ball, a moving lamp and camera, with motion blur")
def animation(opened) -> None:
    checks = Graph("Checks")
    tone = checks.node(
        "ShaderNodeTexChecker",
        Vector=checks.node("ShaderNodeTexCoord", "UV"),
        Color1=(0.6, 0.58, 0.5),
        Color2=(0.15, 0.16, 0.2),
    )
    checks.finish(checks.node("ShaderNodeBsdfPrincipled", Base_Color=tone, Roughness=0.4))
    add("Floor", plane("Floor", (14.0, 14.0)), checks.material)
    add("Wall", plane("Wall", (14.0, 6.0)), principled("Wall", (0.5, 0.55, 0.6, 1.0), 0.8), location=(0.0, 4.0, 3.0))
    wall = opened.objects["Wall"]
    wall.rotation_euler = (math.pi / 2.0, 0.0, 0.0)
    red = principled("Red", (0.7, 0.05, 0.03, 1.0), 0.25, Coat_Weight=1.0)
    hub = add(
        "Hub", turned("Hub", [(0.0, -0.1), (0.12, -0.1), (0.12, 0.1), (0.0, 0.15)]), red, location=(-1.2, 1.0, 1.5)
    )
    for blade in range(3):
        turn = 120.0 * blade
        arm = add("Blade", box("Blade", (0.14, 1.0, 0.03), bevel=0.01), red, rotation=(0, 0, turn))
        arm.location = (-0.55 * math.sin(math.radians(turn)), 0.55 * math.cos(math.radians(turn)), 0.0)
        arm.parent = hub
    upright = math.pi / 2.0
    _keyed(hub, {1: dict(rotation_euler=(upright, 0.0, 0.0)), 21: dict(rotation_euler=(upright, 0.0, 10.0))})
    profile = smooth_profile([(0.0, -0.35), (0.25, -0.25), (0.35, 0.0), (0.25, 0.25), (0.0, 0.35)])
    chrome = principled("Chrome", (0.85, 0.85, 0.87, 1.0), 0.08, Metallic=1.0)
    ball = add("Ball", turned("Ball", profile, 48), chrome)
    _keyed(ball, {1: dict(location=(-2.5, -0.5, 0.36)), 21: dict(location=(5.5, -0.5, 1.2))})
    lamp = light("Lamp", "AREA", 150.0, (0.0, 0.0, 3.2), (0.0, 0.0, 0.0), (1.0, 0.9, 0.7), shape="DISK", size=0.6)
    _keyed(lamp, {1: dict(location=(-4.0, -1.0, 3.2)), 21: dict(location=(4.0, -1.0, 3.2))})
    world((0.3, 0.38, 0.5), 0.4)
    eye = camera((0.0, -5.5, 2.0), (0.0, 0.5, 1.0), 45.0)
    _keyed(eye, {1: dict(location=(-0.6, -5.5, 1.9)), 21: dict(location=(0.6, -5.5, 2.1))})
    # A straight motion: any of its frames can be compared.
    for thing in (hub, ball, lamp, eye):
        for curve in _curves(thing):
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
    opened.frame_set(11)
    opened.render.use_motion_blur, opened.render.motion_blur_shutter = True, 0.6


def _curves(thing):
    """F-curves of an object's action, in the layers of actions since Blender 4.4."""
    action = thing.animation_data.action
    return [
        curve for layer in action.layers for strip in layer.strips for bag in strip.channelbags for curve in bag.fcurves
    ]
