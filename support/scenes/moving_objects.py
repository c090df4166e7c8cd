# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that move during the exposure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sdf_lights.render import motion
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.scene import Lamp, Scene, Shutter
from sdf_lights.sdf import shapes
from sdf_lights.sdf.emission import EmissionExpression

from .lamps import torus_room
from .matrices import rotation, scaling, translation
from .meshes import box, quad, sphere
from .room import HEIGHT, RED, WIDTH, add, diffuse, material, room, torus_lamp


def _over_time(thing, count: int, **ends):
    """``thing`` with ``motion`` from itself to itself with the matrix and the other fields of ``ends``."""
    start = np.asarray(thing.matrix, float)
    end = ends.pop("matrix", np.eye(4)) @ start
    part = np.linspace(0.0, 1.0, count)
    steps = [
        replace(
            thing,
            matrix=start + t * (end - start),
            **{name: getattr(thing, name) + t * (value - getattr(thing, name)) for name, value in ends.items()},
        )
        for t in part
    ]
    return replace(thing, motion=motion.resampled(tuple(steps)))


def moving(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Everything that can move: a camera that turns, a box that spins through distant poses, a ball that becomes an egg
    while two instances of it fall, a lamp that flies and one that fades, lights of all kinds, and a glowing quad."""
    scene = room(width, height)
    scene.shutter = Shutter(motion.exposure(np.array([0.2, 1.0, 1.0, 0.5, 0.0])))
    scene.camera = _over_time(scene.camera, 3, matrix=translation(0.1, 0.0, 0.05), focus=scene.camera.focus + 1.0)
    scene.meshes += [box(), sphere(columns=10, rows=5), quad()]
    egg = scene.meshes[-2]
    forms = [egg.positions * (1.0, 1.0, 1.0 + 0.4 * t) for t in (0.0, 1.0, 0.5)]
    egg.motion = np.stack(forms).astype(np.float32)
    normals = [form / (1.0, 1.0, (1.0 + 0.4 * t) ** 2) for form, t in zip(forms, (0.0, 1.0, 0.5))]
    normals = [n / np.linalg.norm(n, axis=1, keepdims=True) for n in normals]
    egg.motion_normals = np.stack([n[egg.triangles] for n in normals]).astype(np.float32)
    first = len(scene.meshes) - 3
    add(scene, first, translation(-0.8, 0.3, 0.5) @ scaling(0.4, 0.4, 0.4), diffuse(RED))
    turned = [scene.instances[-1].matrix @ rotation("z", angle) for angle in (0.0, 50.0, 100.0)]
    scene.instances[-1].motion = motion.poses(np.stack(turned))
    for x in (0.5, 1.2):
        add(scene, first + 1, translation(x, 0.2, 1.0) @ scaling(0.3, 0.3, 0.3), material("glossy", roughness=0.3))
        scene.instances[-1].motion = np.stack(
            [translation(0.0, 0.0, -t) @ scene.instances[-1].matrix for t in (0, 0.2, 0.6)]
        )
    glow = material("emission", strength=6.0, color=(0.4, 0.6, 1.0))
    add(scene, first + 2, translation(0.3, -0.5, 2.4) @ rotation("x", 160.0) @ scaling(0.3, 0.3, 0.3), glow)
    glowing = [scene.instances[-1].matrix, translation(0.5, 0.0, 0.2) @ scene.instances[-1].matrix]
    scene.instances[-1].motion = np.stack(glowing)
    turn = translation(0.0, 0.3, 0.0) @ rotation("z", 30.0)
    scene.lamps += [
        _over_time(torus_lamp(-0.6, 0.0, 1.6, 30.0, 0.6), 2, matrix=translation(0.9, 0.0, 0.3)),
        _over_time(torus_lamp(0.8, 0.6, 1.9, 10.0, 0.4), 3, power=30.0),
    ]
    scene.lights += [
        _over_time(PointLight("point", translation(-1.0, -1.0, 1.5), 10.0, radius=0.1), 2, matrix=turn),
        _over_time(SpotLight("spot", translation(1.0, -1.0, 2.0), 40.0, angle=1.0), 3, matrix=turn, power=10.0),
        _over_time(AreaLight("area", translation(0.0, 1.0, 2.2), 15.0, size=(0.4, 0.2)), 2, matrix=turn),
        _over_time(SunLight("sun", rotation("x", 30.0), 0.4, angle=0.2), 2, matrix=rotation("y", 20.0)),
    ]
    return scene


def changing_lamps(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Lamps whose shapes and emissions change: a torus that swells as it flies, a blend of two balls, and a ball
    whose glow moves inwards."""
    scene = room(width, height)
    scene.shutter = Shutter(motion.exposure(np.array([0.5, 1.0, 0.2])))
    torus = torus_lamp(-0.9, 0.0, 1.6, 30.0, 0.5)
    balls = [
        shapes.SHAPES["smooth_union"](
            shapes.Sphere(0.2), shapes.Transformed(shapes.Sphere(0.15), translation(x, 0.0, 0.0))
        )
        for x in (0.1, 0.4)
    ]
    glow = EmissionExpression("width = slider(0.05, 0.01, 1)\nexp(-depth / width)")
    ball = Lamp("ball", shapes.Sphere(0.25), translation(0.0, -0.6, 0.6), 10.0, emission=glow.emission())
    scene.lamps += [
        _over_time(torus, 3, matrix=translation(0.5, 0.0, 0.2)),
        Lamp("balls", balls[0], translation(0.7, 0.4, 1.9) @ rotation("y", 20.0), 20.0, color=(1.0, 0.6, 0.3)),
        ball,
    ]
    changes = (
        {"shape": shapes.Torus(0.5, 0.05)},
        {"shape": balls[1]},
        {"emission": glow.emission({"width": 0.5})},
    )
    for lamp, change in zip(scene.lamps, changes):
        ends = (lamp.motion[0], lamp.motion[-1]) if lamp.motion else (lamp, lamp)
        lamp.motion = motion.resampled((ends[0], replace(ends[1], **change)))
    return scene


def rolling(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The torus room while the camera turns, line by line."""
    scene = torus_room(width, height)
    scene.camera = _over_time(scene.camera, 2, matrix=translation(0.4, 0.0, 0.0))
    scene.shutter = Shutter(rolling=0.3)
    return scene
