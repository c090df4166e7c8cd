# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes with curves and spheres, like those of ``SCENES``."""

from __future__ import annotations

import numpy as np

from sdf_lights.graph.formula import Vector, call
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes.lookups import POINT_INFO, STRAND_INFO
from sdf_lights.render.scene import Instance, Mesh, Primitive, Scene, Shutter, World

from .matrices import look_at, rotation, scaling, translation
from .room import HEIGHT, WIDTH, room, torus_lamp


def tuft(primitive: Primitive, curves: int = 24, points: int = 6, radius: float = 0.03) -> Mesh:
    """Wavy curves that stand on the square from −0.5 to 0.5, thinner towards their tips; or as many spheres."""
    random = np.random.default_rng(int(primitive))
    t = np.linspace(0.0, 1.0, points)[None, :, None]
    root = np.concatenate([random.uniform(-0.5, 0.5, (curves, 2)), np.zeros((curves, 1))], 1)[:, None]
    wave = 0.08 * np.sin(5.0 * t + random.uniform(0.0, 6.0, (curves, 1, 3)))
    places = (root + t * (0.0, 0.0, 1.0) + random.normal(0.0, 0.15, (curves, 1, 3)) * t * t + wave).reshape(-1, 3)
    radii = np.broadcast_to(radius * (1.0 - 0.7 * t[..., 0]), (curves, points)).ravel()
    if primitive == Primitive.SPHERES:
        rows = np.arange(0, len(places), 3)
        places, radii = places[rows], radii[rows] * 2.0
        triangles = np.repeat(np.arange(len(rows))[:, None], 3, 1)
    else:
        first = (points * np.arange(curves)[:, None] + np.arange(points - 1)).ravel()
        triangles = np.stack([first, first + 1, first], 1)
    return Mesh(
        primitive.name.lower(),
        places.astype(np.float32),
        triangles.astype(np.int32),
        primitive=primitive,
        radii=radii.astype(np.float32),
        subdivisions=2,
    )


def fur(width: int = WIDTH, height: int = HEIGHT, kinds: tuple[Primitive, ...] = tuple(Primitive)[1:]) -> Scene:
    """Tufts of all kinds, each placed once, and the same once more, scaled unevenly; some are half clear."""
    scene = room(width, height, max_bounces=2, transparent_bounces=8)
    scene.world = World((0.3, 0.4, 0.6), 0.3)
    half = Node("transparent", {"color": (0.9, 0.7, 0.5)})
    brown = Node("diffuse", {"color": (0.5, 0.3, 0.2)})
    fiber = Node(
        "hair", {"color": (0.7, 0.4, 0.3), "roughness_u": 0.3, "roughness_v": 0.6}, {"component": "REFLECTION"}
    )
    surfaces = (brown, fiber, Node("mix_closure", {"factor": 0.4, "a": brown, "b": half}), brown)
    for place, (kind, surface) in enumerate(zip(kinds, surfaces)):
        scene.materials.append(Material(f"of {kind.name.lower()}", surface))
        material = (len(scene.materials) - 1,)
        scene.meshes.append(tuft(kind))
        turned = translation(0.9 * place - 1.35, 0.0, 0.0) @ rotation("z", 40 * place)
        scene.instances.append(Instance(len(scene.meshes) - 1, turned @ scaling(0.8, 0.8, 1.2), material, "one"))
        scene.meshes.append(tuft(kind))
        above = translation(0.9 * place - 1.35, 0.0, 1.6) @ rotation("y", 30) @ scaling(0.6, 0.6, 0.6)
        for step in (0, 1):
            matrix = translation(0.0, 0.7 * step, 0.3 * step) @ above @ scaling(1.0, 1.0 - 0.3 * step, 1.0)
            scene.instances.append(Instance(len(scene.meshes) - 1, matrix, material, f"two {step}"))
    scene.lamps.append(torus_lamp(-0.3, -0.6, 2.3, 60.0, 0.6))
    scene.lights.append(AreaLight("panel", look_at((1.2, -0.8, 2.6), (0.4, 0.2, 1.0)), 30.0, size=(0.5, 0.3)))
    return scene


def many_fibers(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Every kind of curve with a BSDF of hair, flattened fibers among them, and nodes that know strands and points."""
    scene = fur(width, height, (Primitive.STRANDS, Primitive.RIBBONS, Primitive.CONES, Primitive.SPHERES))
    tangent = {"offset": 0.1, "roughness_u": 0.3, "roughness_v": 0.7, "color": (0.8, 0.6, 0.4)}
    hair = {"parametrization": "ABSORPTION"}
    absorption = {"absorption_coefficient": (0.3, 0.6, 1.0), "roughness": 0.4, "offset": 0.05}
    chiang = Node("principled_hair", {**absorption, "radial_roughness": 0.5}, {"model": "CHIANG", **hair})
    huang = Node("principled_hair", {**absorption, "aspect_ratio": 0.6}, {"model": "HUANG", **hair})
    through = Node("hair", tangent, {"component": "TRANSMISSION"})
    _, thickness, *across = call(STRAND_INFO)
    shown = Node("diffuse", {"color": Vector(15.0 * thickness, across[1] * across[1], across[2] * across[2])})
    *center, radius = call(POINT_INFO)
    points = Node("diffuse", {"color": Vector(10.0 * radius, 0.5 + 0.0 * center[0], 0.3 * center[2])})
    surfaces = chiang, huang, Node("mix_closure", {"factor": 0.5, "a": shown, "b": through}), points
    for material, surface in zip(scene.materials[-4:], surfaces):
        material.surface = surface
    return scene


def moving_strands(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Tufts of all kinds that bend and grow thicker, while every second one falls."""
    scene = fur(width, height)
    scene.shutter = Shutter()
    for mesh in scene.meshes:
        if mesh.primitive != Primitive.TRIANGLES:
            bent = mesh.positions + 0.3 * mesh.positions[:, 2:] * (1.0, 0.0, 0.0)
            mesh.motion = np.stack([mesh.positions, bent]).astype(np.float32)
            mesh.motion_radii = np.stack([mesh.radii, 1.5 * mesh.radii]).astype(np.float32)
    for instance in scene.instances[-1::-2]:
        if scene.meshes[instance.mesh].primitive != Primitive.TRIANGLES:
            instance.motion = np.stack([instance.matrix, translation(0.0, 0.0, -0.3) @ instance.matrix])
    return scene


STRAND_SCENES = {"fur": fur, "many_fibers": many_fibers, "moving_strands": moving_strands}
