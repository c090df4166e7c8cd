# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes with subsurface scattering."""

from __future__ import annotations

from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes.variables import POSITION
from sdf_lights.render.scene import Instance, Scene
from support.graphs import Graph

from .matrices import look_at, rotation, scaling, translation
from .room import HEIGHT, WIDTH, add, material, room, torus_lamp


def _scattering(name: str, method: str, kind: str = "principled", once: bool = False, **inputs) -> Material:
    return Material(name, Node(kind, inputs, {"subsurface_method": method, "subsurface_once": once}))


def subsurface(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Random walks of all kinds: a ball in a block, another by itself, and a slab with light behind it."""
    scene = room(width, height, max_bounces=2)
    add(
        scene,
        2,
        translation(-0.9, 0.2, 0.6) @ scaling(0.6, 0.6, 0.6),
        _scattering(
            "marble",
            "RANDOM_WALK",
            base_color=(0.8, 0.7, 0.5),
            subsurface_weight=0.7,
            subsurface_radius=(1.0, 0.6, 0.3),
            subsurface_scale=0.15,
            subsurface_anisotropy=-0.3,
            roughness=0.3,
        ),
    )
    add(
        scene,
        1,
        translation(-0.3, 0.1, 0.3) @ rotation("z", 30) @ scaling(0.4, 0.3, 0.3),
        _scattering(
            "wax",
            "RANDOM_WALK_LEGACY",
            "subsurface",
            color=(0.8, 0.5, 0.1),
            scale=1.2,
            radius=(0.9, 0.5, 0.0),
            ior=1.6,
            roughness=0.5,
            anisotropy=0.6,
        ),
    )
    add(
        scene,
        1,
        translation(0.9, 0.0, 0.6) @ rotation("z", -20) @ scaling(0.5, 0.06, 0.6),
        _scattering(
            "skin",
            "RANDOM_WALK_SKIN",
            base_color=(0.8, 0.5, 0.4),
            subsurface_weight=1.0,
            subsurface_scale=0.2,
            subsurface_anisotropy=0.7,
            roughness=0.4,
        ),
    )
    scene.lamps.append(torus_lamp(0.3, -0.4, 2.3, 50.0))
    scene.lights.append(
        AreaLight("behind", look_at((1.1, 1.2, 0.8), (0.9, 0.0, 0.6)), 20.0, (1.0, 0.9, 0.7), size=(0.5, 0.5))
    )
    return scene


def subsurface_profile(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Burley's profile, with a varying weight and with bumps, also in a thin wall, and a walk that ends at diffuse
    bounces."""
    scene = room(width, height, max_bounces=2)
    graph = Graph()
    bump = graph.bump(POSITION.x * POSITION.x * POSITION.z, 0.7)
    scene.materials.append(
        graph.material(
            "bumpy",
            Node(
                "principled",
                {
                    "base_color": (0.9, 0.6, 0.3),
                    "subsurface_weight": POSITION.z,
                    "subsurface_radius": (1.0, 0.5, 0.2),
                    "subsurface_scale": 0.8,
                    "normal": bump,
                },
                {"subsurface_method": "BURLEY", "subsurface_once": True},
            ),
        )
    )
    scene.instances.append(
        Instance(1, translation(-0.8, 0.3, 0.5) @ rotation("z", 20) @ scaling(0.5, 0.4, 0.5), (3, 3, 3))
    )
    add(
        scene,
        2,
        translation(0.5, 0.2, 0.5) @ scaling(0.5, -0.5, 0.5),
        _scattering(
            "jade",
            "RANDOM_WALK_LEGACY",
            "subsurface",
            once=True,
            color=(0.3, 0.8, 0.4),
            scale=1.0,
            radius=(0.5, 0.9, 0.6),
        ),
    )
    add(
        scene,
        0,
        translation(0.2, 0.4, 1.5) @ rotation("x", 80) @ scaling(1.0, 0.4, 1.0),
        material(
            "principled",
            "leaf",
            base_color=(0.2, 0.7, 0.1),
            subsurface_weight=0.8,
            subsurface_anisotropy=0.3,
            thin_wall=1.0,
        ),
    )
    scene.lamps.append(torus_lamp(0.0, -0.3, 2.4, 60.0))
    return scene
