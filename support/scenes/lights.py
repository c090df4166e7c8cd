# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes lit by Blender's lights, worlds, and meshes that emit; light linking."""

from __future__ import annotations

import numpy as np

from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes.variables import BACKFACING, POSITION
from sdf_lights.render.scene import Image, Ray, Scene, World
from support.graphs import Graph

from .matrices import look_at, rotation, scaling, translation
from .meshes import sphere
from .room import GREEN, GREY, HEIGHT, RED, WIDTH, add, diffuse, material, room, torus_lamp


def blender_lights(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Point lights with and without radius, spot, sun with and without angle, rectangle and ellipse."""
    scene = room(width, height, max_bounces=2)
    add(scene, 1, translation(0.2, 0.3, 0.4) @ rotation("z", 30) @ scaling(0.4, 0.4, 0.4), diffuse(GREY))
    down = look_at((0, 0, 0), (0, 0, -1), (0, 1, 0))
    front = look_at((0, -3, 4), (0.3, 0, 0.5))
    scene.lights += [
        PointLight("point", translation(-1.3, 0.5, 2.2), 12.0, (1.0, 0.8, 0.6)),
        PointLight("ball", translation(1.3, 1.2, 2.4), 20.0, (0.6, 0.8, 1.0), radius=0.2),
        SpotLight("spot", look_at((-1.5, -1.5, 2.5), (0.5, 1.0, 0.0)), 60.0, radius=0.05, angle=0.8, blend=0.3),
        SpotLight("sharp spot", look_at((1.5, -1.5, 1.0), (1.0, 2.0, 1.5)), 40.0, angle=0.5, blend=0.0),
        SunLight("sun", front, 0.5, (1.0, 0.9, 0.7), angle=0.1),
        SunLight("thin sun", rotation("z", 50) @ front, 0.3),
        AreaLight("rectangle", translation(0.8, -0.6, 2.9) @ down, 15.0, (0.9, 1.0, 0.8), size=(0.8, 0.4)),
        AreaLight(
            "ellipse", look_at((-1.8, -0.8, 0.8), (0, 0.5, 0.5)), 10.0, (1.0, 0.5, 0.9), ellipse=True, size=(0.6, 0.9)
        ),
    ]
    return scene


def world_color(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Spheres on a floor under a sky of one colour."""
    scene = room(width, height)
    del scene.instances[1:]
    scene.world = World((0.6, 0.8, 1.0), 1.2)
    add(scene, 2, translation(-0.8, 0.2, 0.6) @ scaling(0.6, 0.6, 0.6), diffuse(RED))
    add(scene, 2, translation(0.7, 0.0, 0.5) @ scaling(0.5, 0.5, 0.5), material("principled", base_color=GREEN))
    return scene


def sky_image() -> Image:
    """An equirectangular sky with a small bright patch and a dark ground: (32, 64, 4)."""
    v, u = np.mgrid[0:32, 0:64]
    pixels = np.ones((32, 64, 4), np.float32)
    pixels[..., :3] = np.where((v >= 16)[..., None], (0.3, 0.5, 0.9), (0.12, 0.10, 0.08))
    pixels[..., 1] += 0.2 * np.sin(u / 64 * 2 * np.pi)
    pixels[24:27, 40:44, :3] = (60.0, 50.0, 40.0)
    return Image("sky", pixels)


def environment(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The same under an environment image, rotated about two axes."""
    scene = world_color(width, height)
    scene.images.append(sky_image())
    turn = (rotation("z", 70) @ rotation("x", 15))[:3, :3]
    scene.world = World((1.0, 1.0, 1.0), 0.8, image=0, rotation=turn)
    return scene


def skylight(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The same under a sky with a large sun."""
    scene = world_color(width, height)
    graph = Graph()
    sky = graph.node(
        "ShaderNodeTexSky",
        {"Vector": POSITION},
        dict(
            sky_type="MULTIPLE_SCATTERING",
            sun_disc=True,
            sun_size=0.3,
            sun_intensity=0.5,
            sun_elevation=0.6,
            sun_rotation=2.4,
            altitude=200.0,
            air_density=1.0,
            aerosol_density=1.0,
            ozone_density=1.0,
        ),
    )["Color"]
    emission = Node("emission", {"color": sky, "strength": 0.1})
    scene.world = World((1.0, 1.0, 1.0), emission=graph.material("sky", emission))
    return scene


def emissive_mesh(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Glowing ball and glowing squares, the only light."""
    scene = room(width, height)
    scene.meshes.append(sphere("ball", 12, 6, smooth=False))
    add(
        scene,
        3,
        translation(0.5, 0.2, 0.6) @ scaling(0.4, 0.4, 0.5),
        material("emission", color=(1.0, 0.7, 0.4), strength=4.0),
    )
    lit = Node("add_closure", {"a": Node("diffuse", {"color": GREY}), "b": Node("emission", {"strength": 5.0})})
    add(scene, 0, translation(-0.6, 0.2, 2.8) @ rotation("x", 180) @ scaling(0.6, 0.4, 1), Material("panel", lit))
    return scene


def glowing_bubble(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A clear ball, the only light, that emits more on its inside: light rays hit its outside first."""
    scene = room(width, height)
    shine = Node("emission", {"color": (0.4, 0.7, 1.0), "strength": 0.2 + 8.0 * BACKFACING})
    clear = Node("mix_closure", {"a": Node("transparent", {}), "b": shine, "factor": 0.4})
    scene.meshes.append(sphere("bubble", 6, 4, smooth=False))
    add(scene, 3, translation(-0.4, 0.0, 1.2) @ scaling(0.9, 0.7, 0.9), Material("bubble", clear))
    return scene


def light_control(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Light and shadow linking, visibility to some lobes and limits of bounces, each for a lamp, a light and a mesh;
    and a lamp that the camera sees darker."""
    scene = room(width, height, max_bounces=2)
    floor, back = scene.instances[0], scene.instances[2]
    floor.light_set, back.light_set = 1, 2
    add(scene, 1, translation(-0.9, 0.4, 0.5) @ rotation("z", 25) @ scaling(0.4, 0.4, 0.5), diffuse(GREY), "block")
    coated = Node("add_closure", {"a": Node("diffuse", {"color": GREY}), "b": Node("glossy", {"roughness": 0.3})})
    add(scene, 2, translation(0.9, 0.5, 0.6) @ scaling(0.6, 0.6, 0.6), Material("coated", coated), "ball")
    add(scene, 0, translation(0.2, -0.6, 0.9) @ scaling(0.3, 0.3, 1.0), material("transparent", color=(0.2, 0.9, 0.5)))
    block, ball, pane = scene.instances[-3:]
    block.shadow_set, ball.light_set, pane.shadow_set = 1, 1, 2
    add(scene, 2, translation(0.0, 1.2, 2.4) @ scaling(0.2, 0.2, 0.2), material("emission", strength=12.0), "bulb")
    scene.instances[-1].receivers, scene.instances[-1].blockers = ~2, ~2
    scene.instances[-1].visibility &= ~Ray.GLOSSY
    down = look_at((0, 0, 0), (0, 0, -1), (0, 1, 0))
    scene.lamps += [
        torus_lamp(-0.8, 0.0, 2.2, 30.0, 0.4, color=(1.0, 0.2, 0.1), receivers=~4, camera_brightness=0.3),
        torus_lamp(0.8, -0.4, 2.0, 30.0, 0.4, color=(0.1, 0.2, 1.0), blockers=1 | 4, max_bounces=1),
    ]
    scene.lights += [
        AreaLight("shadows", translation(0.2, -0.3, 2.5) @ down, 20.0, (1.0, 0.9, 0.2), size=(0.5, 0.5), blockers=3),
        PointLight("once", translation(1.2, -1.2, 1.5), 8.0, (0.2, 1.0, 0.4), 0.2, max_bounces=0, receivers=1 | 2),
        PointLight(
            "hidden", translation(-1.2, -1.2, 1.5), 8.0, (1.0, 0.4, 1.0), 0.2, visibility=Ray.ALL & ~Ray.DIFFUSE
        ),
        PointLight("sampled", translation(0.0, 1.0, 1.5), 8.0, (0.4, 1.0, 1.0), 0.3, sampled_only=True),
        SunLight("sun", look_at((0, -3, 4), (0.3, 0, 0.5)), 0.3, angle=0.1, receivers=2 | 4, blockers=~2),
    ]
    scene.world = World((0.1, 0.1, 0.15), max_bounces=1)
    return scene


def shadow_catcher(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Metal and a glowing box on a floor that catches their light and shadows, seen through a clear sheet, under an SDF
    lamp. Another lamp and a light do not count for catchers."""
    scene = emissive_mesh(width, height)
    scene.instances[0].catcher = True
    scene.lamps += [torus_lamp(), torus_lamp(-1.2, 0.2, 1.0, 6.0)]
    scene.lamps[1].lights_catchers = False
    beside = translation(1.4, -0.8, 1.6)
    scene.lights.append(PointLight("beside", beside, 15.0, (0.4, 1.0, 0.6), 0.2, lights_catchers=False))
    return scene
