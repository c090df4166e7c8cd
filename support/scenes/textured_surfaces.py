# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes with textures, instances, and materials that trace rays."""

from __future__ import annotations

import numpy as np

from sdf_lights.graph.formula import Vector, constant
from sdf_lights.render.material import Node
from sdf_lights.render.nodes.normals import displaced_as_bump
from sdf_lights.render.nodes.variables import NORMAL
from sdf_lights.render.scene import Image, Instance, Scene
from support.graphs import Graph

from .matrices import rotation, scaling, translation
from .room import GREEN, HEIGHT, RED, WHITE, WIDTH, diffuse, material, room, torus_lamp


def checker_image() -> Image:
    """8 × 8 coloured squares; alpha 0 in every third: (8, 8, 4)."""
    v, u = np.mgrid[0:8, 0:8]
    pixels = np.ones((8, 8, 4), np.float32)
    pixels[..., :3] = np.where(((u + v) % 2 == 0)[..., None], (0.8, 0.7, 0.2), (0.1, 0.2, 0.5))
    pixels[..., 3] = (u + 2 * v) % 3 > 0
    return Image("checker", pixels)


def textured(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Image texture with a mapping on the floor, which displacement bumps; bump on the left wall, normal map on the
    right one."""
    scene = room(width, height)
    scene.images.append(checker_image())
    u, v = np.meshgrid((np.arange(16) + 0.5) / 16, (np.arange(16) + 0.5) / 16)
    slope = 0.5 * np.stack([np.sin(2 * np.pi * u), np.cos(2 * np.pi * v), np.ones_like(u) * 2], -1)
    slope /= np.linalg.norm(slope, axis=-1, keepdims=True)
    scene.images.append(Image("normals", np.concatenate([slope * 0.5 + 0.5, np.ones((16, 16, 1))], -1).astype("f4")))
    graph = Graph()
    turned = graph.mapping(graph.uv(), location=(0.1, 0.2, 0.0), rotation=(0.0, 0.0, 0.4), scale=(2.0, 1.5, 1.0))
    bump = graph.bump(graph.image(0, graph.uv()).x, 0.05, 0.5)
    normal = graph.normal_map(graph.image(1, graph.uv()), 0.8)
    scene.materials += [
        graph.material("checkered", Node("diffuse", {"color": graph.image(0, turned)})),
        graph.material("bumpy", Node("principled", {"base_color": RED, "roughness": 0.6, "normal": bump})),
        graph.material(
            "embossed",
            Node("diffuse", {"color": graph.image(0, graph.uv(), interpolation="Closest"), "normal": normal}),
        ),
    ]
    floor = scene.materials[3]
    floor.surface, floor.normal = displaced_as_bump(floor.surface, NORMAL * graph.image(0, turned).x * 0.05)
    for instance, surface in ((0, 3), (3, 4), (4, 5)):
        scene.instances[instance].materials = (surface,)
    scene.lamps.append(torus_lamp())
    return scene


def instances(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """One mesh many times: rotated, scaled, mirrored; and a scaled, sheared, mirrored lamp."""
    scene = room(width, height)
    scene.materials += [diffuse((0.2, 0.3, 0.7), "blue"), material("glossy", color=(0.9, 0.8, 0.6), roughness=0.4)]
    shear = np.eye(4)
    shear[0, 2] = 0.5
    transforms = [
        scaling(0.3, 0.3, 0.5),
        rotation("z", 40) @ scaling(-0.3, 0.3, 0.4),
        rotation("y", 30) @ scaling(0.4, 0.2, -0.3),
        shear @ scaling(0.25, 0.25, 0.4),
        scaling(-0.3, -0.3, -0.3),
    ]
    for i, matrix in enumerate(transforms):
        where = translation(-1.4 + 0.7 * i, 0.6 - 0.5 * (i % 2), 0.5)
        scene.instances.append(Instance(1, where @ matrix, (3, 4, 0), f"box {i}"))
        where = translation(-1.4 + 0.7 * i, 0.8, 1.5)
        scene.instances.append(Instance(2, where @ matrix, (4 if i % 2 else 3,), f"ball {i}"))
    lamp = torus_lamp(0.0, -0.3, 2.2, 60.0)
    lamp.matrix = lamp.matrix @ shear @ scaling(-1.3, 0.9, 0.6)
    scene.lamps.append(lamp)
    return scene


def probed(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Materials that trace rays: occlusion on the floor and in balls, a bevel on a box, the color of the object in
    front of a wall."""
    scene = room(width, height)
    graph = Graph()
    ahead = graph.raycast(NORMAL, 2.5)
    far, near = (Vector(*map(constant, color)) for color in (WHITE, (0.2, 0.3, 0.7)))
    scene.materials += [
        graph.material("open", Node("diffuse", {"color": graph.occlusion(WHITE, 1.5)})),
        graph.material("thick", Node("diffuse", {"color": graph.occlusion(GREEN, 0.6, inside=True, only_local=True)})),
        graph.material("round", Node("principled", {"base_color": RED, "roughness": 0.6, "normal": graph.bevel(0.25)})),
        graph.material("watching", Node("diffuse", {"color": far + (near - far) * ahead["Is Hit"]})),
        # Light sampling traces no rays, so with any here the picture would depend on the weights of MIS.
        graph.material("lamp", Node("emission", {"color": WHITE, "strength": 2.0})),
    ]
    for instance, surface in ((0, 3), (2, 6)):
        scene.instances[instance].materials = (surface,)
    scene.instances.append(
        Instance(1, translation(-0.8, 0.6, 0.5) @ rotation("z", 30) @ scaling(-0.5, 0.5, 0.5), (5,) * 3, "box")
    )
    for i in range(2):
        scene.instances.append(
            Instance(2, translation(0.5 + 0.8 * i, 0.4, 0.6) @ scaling(0.35, 0.35, 0.6), (4,), f"ball {i}")
        )
    scene.instances.append(
        Instance(0, translation(0.0, 0.0, 2.9) @ rotation("x", 180) @ scaling(0.5, 0.5, 1.0), (7,), "lamp")
    )
    return scene
