# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes with closures of each kind, and with the settings for caustics."""

from __future__ import annotations

from dataclasses import replace

from sdf_lights.graph.formula import Vector, constant
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes.variables import POSITION, RAY_LENGTH
from sdf_lights.render.scene import Scene, World
from support.graphs import Graph

from .matrices import look_at, rotation, scaling, translation
from .room import HEIGHT, RED, WIDTH, add, material, room, torus_lamp
from .textured_surfaces import checker_image


def glossy_metal(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Glossy, metallic, coated and sheen spheres beside each other."""
    scene = room(width, height)
    spheres = [
        material("glossy", color=(0.8, 0.75, 0.65), roughness=0.35),
        material("principled", "metal", base_color=(0.95, 0.6, 0.3), metallic=1.0, roughness=0.4),
        material("principled", "plastic", base_color=(0.1, 0.3, 0.7), roughness=0.3),
        material(
            "principled",
            "coat",
            base_color=(0.6, 0.1, 0.1),
            roughness=0.6,
            coat_weight=1.0,
            coat_roughness=0.3,
            coat_tint=(0.9, 0.8, 0.7),
        ),
        material(
            "principled",
            "sheen",
            base_color=(0.2, 0.2, 0.25),
            roughness=0.8,
            sheen_weight=1.0,
            sheen_tint=(1.0, 0.8, 0.9),
        ),
    ]
    for i, surface in enumerate(spheres):
        x, z = (i - 1) * 1.2 if i < 3 else (i - 3.5) * 1.4, 0.5 if i < 3 else 1.6
        add(scene, 2, translation(x, 0.3, z) @ scaling(0.5, 0.5, 0.5), surface)
    scene.lamps.append(torus_lamp(0.0, -0.6, 2.4, 70.0))
    return scene


def facets(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Anisotropic microfacets, Beckmann's distribution, and thin films."""
    scene = room(width, height)
    spheres = [
        material("glossy", color=(0.8, 0.75, 0.65), roughness=0.5, anisotropy=0.6, rotation=0.1),
        Material(
            "beckmann", Node("glossy", {"color": (0.9, 0.6, 0.3), "roughness": 0.4}, {"distribution": "BECKMANN"})
        ),
        Material(
            "stretched",
            Node(
                "glossy",
                {"roughness": 0.5, "anisotropy": -0.5, "tangent": (0.3, 0.2, 1.0)},
                {"distribution": "BECKMANN"},
            ),
        ),
        material(
            "principled",
            "brushed",
            base_color=(0.9, 0.5, 0.2),
            metallic=0.7,
            roughness=0.4,
            anisotropic=0.8,
            anisotropic_rotation=0.3,
        ),
    ]
    for i, surface in enumerate(spheres):
        x, z = (i - 1) * 1.2 if i < 3 else (i - 3.5) * 1.4, 0.5 if i < 3 else 1.6
        add(scene, 2, translation(x, 0.3, z) @ rotation("x", 30) @ scaling(0.5, 0.4, 0.5), surface)
    scene.lamps.append(torus_lamp(0.0, -0.6, 2.4, 70.0))
    return scene


def rare(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Closures that few scenes have, a portal, a thin pane before a lamp, and lights with nodes."""
    scene = room(width, height)
    absorbing = {"model": "CHIANG", "parametrization": "ABSORPTION"}
    balls = [
        Material("conductor", Node("metallic", {"roughness": 0.4}, {"fresnel_type": "PHYSICAL_CONDUCTOR"})),
        Material(
            "shirley",
            Node(
                "glossy",
                {"roughness": 0.5, "anisotropy": 0.5, "color": (0.9, 0.7, 0.5)},
                {"distribution": "ASHIKHMIN_SHIRLEY"},
            ),
        ),
        Material("velvet", Node("sheen", {"color": (0.5, 0.6, 0.9), "roughness": 0.5}, {"distribution": "ASHIKHMIN"})),
        Material(
            "toon", Node("toon", {"color": (0.9, 0.4, 0.3), "size": 0.6, "smooth": 0.2}, {"component": "DIFFUSE"})
        ),
        Material("fiber", Node("principled_hair", {"absorption_coefficient": (0.2, 0.5, 1.0)}, absorbing)),
    ]
    for i, surface in enumerate(balls):
        x, z = (i - 1) * 1.2 if i < 3 else (i - 3.5) * 1.4, 0.5 if i < 3 else 1.5
        add(scene, 2, translation(x, 0.3, z) @ rotation("x", 30) @ scaling(0.45, 0.4, 0.45), surface)
    pane = material(
        "principled", "pane", base_color=(0.6, 0.8, 0.9), roughness=0.3, transmission_weight=1.0, thin_wall=1.0
    )
    add(scene, 0, translation(1.2, -0.8, 0.9) @ rotation("x", 80) @ scaling(0.35, 0.3, 1.0), pane)
    up = Vector(POSITION.x * 0.5, POSITION.y, constant(2.6))
    portal = Material(
        "portal", Node("ray_portal", {"color": (0.8, 0.9, 0.7), "position": up, "direction": (0.2, 0.3, -1.0)})
    )
    add(scene, 0, translation(-1.2, -0.8, 0.9) @ rotation("x", 80) @ scaling(0.35, 0.3, 1.0), portal)
    near = Node("emission", {"color": Vector(constant(1.0), RAY_LENGTH * 0.4, constant(0.5)), "strength": 0.7})
    scene.lights.append(
        PointLight("nodes", translation(0.4, -1.0, 2.6), 60.0, radius=0.1, emission=Material("nodes", near))
    )
    scene.lights.append(
        AreaLight(
            "area",
            look_at((-0.8, -1.2, 2.7), (0.0, 0.3, 0.5)),
            40.0,
            size=(0.4, 0.4),
            emission=Material("pattern", near),
        )
    )
    return scene


def glass(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Rough and smooth glass, refraction and principled transmission, lit through glass by a lamp and a sky."""
    scene = room(width, height, max_bounces=6, transmission_bounces=6, glossy_bounces=6)
    del scene.instances[1]
    scene.world = World((0.8, 0.9, 1.0), 0.6)
    add(scene, 2, translation(-1.1, 0.2, 0.6) @ scaling(0.55, 0.55, 0.55), material("glass", color=(0.95, 1.0, 0.95)))
    add(
        scene,
        2,
        translation(0.1, 0.2, 0.6) @ scaling(0.55, 0.55, 0.55),
        material("glass", "frosted", roughness=0.5, ior=1.4),
    )
    add(
        scene,
        1,
        translation(1.2, 0.3, 0.62) @ rotation("z", 30) @ scaling(0.35, 0.35, 0.6),
        material("principled", "block", base_color=(0.7, 0.9, 1.0), roughness=0.3, transmission_weight=1.0, ior=1.33),
    )
    add(
        scene,
        0,
        translation(0.3, 0.5, 1.9) @ rotation("x", 70) @ scaling(0.7, 0.4, 1.0),
        material("refraction", roughness=0.3, ior=1.2),
    )
    scene.lamps.append(torus_lamp(0.0, 0.6, 2.2, 40.0))
    return scene


def only_reflective_caustics(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Glass without refraction after diffuse bounces, and metal that reflects."""
    scene = glass(width, height)
    scene.settings.caustics_refractive = False
    scene.materials[-1] = material("glossy", "mirror", color=(0.9, 0.8, 0.6), roughness=0.2)
    return scene


def only_refractive_caustics(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Glass and metal without reflection after diffuse bounces."""
    scene = only_reflective_caustics(width, height)
    scene.settings.caustics_refractive, scene.settings.caustics_reflective = True, False
    return scene


def principled_without_caustics(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Coats, metal and glass in parts, all black after diffuse bounces."""
    scene = glass(width, height)
    scene.settings.caustics_reflective = scene.settings.caustics_refractive = False
    for index, inputs in enumerate((dict(coat_weight=1.0), dict(metallic=0.5), dict(transmission_weight=0.5))):
        scene.materials.append(material("principled", "half", base_color=(0.8, 0.6, 0.4), roughness=0.3, **inputs))
        scene.instances[index].materials = (len(scene.materials) - 1,)
    return scene


def filtered_glossy(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A mirror, glass and facets that Filter Glossy blurs behind diffuse bounces."""
    scene = glass(width, height)
    scene.settings.filter_glossy = 1.0
    for index, surface in enumerate(
        (
            material("glossy", "mirror", color=(0.9, 0.8, 0.6), roughness=0.0),
            material("glossy", "brushed", color=(0.9, 0.8, 0.6), roughness=0.2, anisotropy=0.8),
        )
    ):
        scene.materials.append(surface)
        scene.instances[1 + index].materials = (len(scene.materials) - 1,)
    return scene


def transparent(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Cut-out alpha, tinted transparent and translucent sheets, and a transparent film."""
    scene = room(width, height, transparent_film=True)
    del scene.instances[1:3]
    scene.world = World((0.5, 0.6, 0.8), 0.5)
    scene.images.append(checker_image())
    graph = Graph()
    sheet = Node(
        "principled",
        {
            "base_color": graph.image(0, graph.uv(), interpolation="Closest"),
            "alpha": graph.image(0, graph.uv(), "Alpha", "Closest"),
        },
    )
    tint = Node(
        "mix_closure",
        {"factor": 0.6, "a": Node("diffuse", {"color": RED}), "b": Node("transparent", {"color": (0.5, 0.9, 0.6)})},
    )
    upright = rotation("x", 90)
    add(
        scene,
        0,
        translation(-1.0, 0.0, 0.9) @ rotation("z", 20) @ upright @ scaling(0.6, 0.8, 1),
        graph.material("cut-out", sheet),
    )
    add(scene, 0, translation(0.3, 0.2, 0.9) @ upright @ scaling(0.5, 0.8, 1), Material("tinted", tint))
    add(
        scene,
        0,
        translation(1.3, 0.2, 0.9) @ rotation("z", -30) @ upright @ scaling(0.4, 0.8, 1),
        material("translucent", color=(0.7, 0.6, 0.3)),
    )
    scene.lamps.append(torus_lamp(0.0, 1.0, 2.0, 50.0))
    return scene


def stopped_light(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """``transparent`` under a sky and a point, whose light rays stop at the sheets."""
    scene = transparent(width, height)
    scene.materials = [replace(item, transparent_shadows=False) for item in scene.materials]
    scene.lamps.clear()
    scene.lights.append(PointLight("point", translation(-0.5, -0.6, 2.2), 40.0, (1.0, 0.9, 0.7)))
    return scene
