# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A room without light, and what stands in it: materials, a camera, settings, a lamp."""

from __future__ import annotations

import numpy as np

from sdf_lights.render.material import Material, Node
from sdf_lights.render.scene import Camera, Instance, Lamp, Scene
from sdf_lights.render.settings import Filter, Settings
from sdf_lights.sdf import shapes

from .matrices import look_at, rotation, scaling, translation
from .meshes import box, quad, sphere

WIDTH, HEIGHT = 48, 36
WHITE, RED, GREEN, GREY = (0.75, 0.73, 0.70), (0.65, 0.12, 0.08), (0.15, 0.5, 0.12), (0.5, 0.5, 0.5)


def diffuse(color, name: str = "diffuse") -> Material:
    return Material(name, Node("diffuse", {"color": color}))


def material(kind: str, name: str = "", **inputs) -> Material:
    return Material(name or kind, Node(kind, inputs))


def settings(**changes) -> Settings:
    values = dict(
        samples=64,
        noise_threshold=0.0,
        max_bounces=3,
        diffuse_bounces=3,
        glossy_bounces=3,
        transmission_bounces=3,
        transparent_bounces=4,
        filter=Filter.BOX,
        filter_width=1.0,
    )
    values.update(changes)
    return Settings(**values)


def camera(eye, target, width: int, height: int, half_width: float = 0.5, **changes) -> Camera:
    """Perspective camera; ``half_width`` is the tangent of half the horizontal field of view."""
    half_height = half_width * height / width
    return Camera(look_at(eye, target), window=(-half_width, half_width, -half_height, half_height), **changes)


def room(width: int, height: int, **changes) -> Scene:
    """A room of 4 × 4 × 3 metres on the floor z = 0, open towards the camera at −y, without light.

    Materials 0, 1 and 2 are white, red and green; meshes 0, 1 and 2 are ``quad``, ``box`` and ``sphere``.
    """
    walls = [
        (scaling(2, 2, 1), 0),
        (translation(0, 0, 3) @ rotation("x", 180) @ scaling(2, 2, 1), 0),
        (translation(0, 2, 1.5) @ rotation("x", 90) @ scaling(2, 1.5, 1), 0),
        (translation(-2, 0, 1.5) @ rotation("y", 90) @ scaling(1.5, 2, 1), 1),
        (translation(2, 0, 1.5) @ rotation("y", -90) @ scaling(1.5, 2, 1), 2),
    ]
    return Scene(
        camera((0, -5.5, 1.5), (0, 0, 1.4), width, height, 0.42),
        width,
        height,
        meshes=[quad(), box(), sphere()],
        instances=[Instance(0, matrix, (color,), f"wall {i}") for i, (matrix, color) in enumerate(walls)],
        materials=[diffuse(WHITE, "white"), diffuse(RED, "red"), diffuse(GREEN, "green")],
        settings=settings(**changes),
    )


def add(scene: Scene, mesh: int, matrix: np.ndarray, surface: Material, name: str = "") -> None:
    """Place ``mesh`` with a separate material in every slot."""
    scene.materials.append(surface)
    slots = scene.meshes[mesh].slots
    count = 1 if slots is None else int(slots.max()) + 1
    scene.instances.append(Instance(mesh, matrix, (len(scene.materials) - 1,) * count, name or surface.name))


def torus_lamp(x=0.0, y=0.0, z=1.8, power=60.0, size=1.0, **changes) -> Lamp:
    matrix = translation(x, y, z) @ rotation("z", 20) @ rotation("x", 35) @ scaling(size, size, size)
    return Lamp("torus", shapes.Torus(major_radius=0.6, minor_radius=0.2), matrix, power=power, **changes)
