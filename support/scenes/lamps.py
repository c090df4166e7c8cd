# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes lit by SDF lamps of each kind."""

from __future__ import annotations

import numpy as np

from sdf_lights.render.material import Material, Node
from sdf_lights.render.scene import Instance, Lamp, Scene
from sdf_lights.render.settings import LampPaths
from sdf_lights.sdf import shapes
from sdf_lights.sdf.data.simplest import simplest
from sdf_lights.sdf.emission import Emission, EmissionExpression
from sdf_lights.sdf.resolver import Arrays

from .matrices import rotation, scaling, translation
from .room import GREY, HEIGHT, RED, WHITE, WIDTH, add, diffuse, material, room, torus_lamp


def torus_room(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Diffuse room and a box, lit by one torus lamp."""
    scene = room(width, height)
    add(scene, 1, translation(-0.7, 0.5, 0.5) @ rotation("z", 25) @ scaling(0.4, 0.4, 0.5), diffuse(GREY))
    scene.lamps.append(torus_lamp())
    return scene


def cove(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A lamp above a shelf, which hides it from most of the room: light comes by way of the ceiling, and light paths
    are used.

    In the room are a coarse smooth ball that is glossy, too, a box of metal, a tinted pane, and glass before the lamp.
    """
    scene = room(width, height, lamp_paths=LampPaths.ALWAYS)
    add(scene, 1, translation(0.0, 1.2, 2.3) @ scaling(1.6, 0.75, 0.03), diffuse(GREY))
    clear_coat = material("principled", "ball", base_color=RED, roughness=0.4)
    add(scene, 2, translation(-0.7, 0.2, 0.6) @ scaling(0.6, 0.6, 0.6), clear_coat)
    scene.instances[-1].terminator = 0.1
    add(
        scene,
        1,
        translation(0.8, 0.6, 0.5) @ rotation("z", 25) @ scaling(0.4, 0.4, 0.5),
        material("glossy", "metal", color=WHITE, roughness=0.35),
    )
    pane = Node("transparent", {"color": (0.5, 0.9, 0.6)})
    tinted = Node("mix_closure", {"factor": 0.6, "a": Node("diffuse", {"color": GREY}), "b": pane})
    add(scene, 0, translation(0.6, -0.4, 1.2) @ rotation("x", 90) @ scaling(0.6, 0.5, 1.0), Material("tinted", tinted))
    add(scene, 1, translation(-0.5, 0.7, 2.6) @ scaling(0.3, 0.03, 0.15), material("glass", "glass", roughness=0.0))
    scene.lamps.append(torus_lamp(0.0, 1.3, 2.6, 60.0, 0.3))
    return scene


def frame_lamp(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A thin frame, a cube minus a ball, and a small capsule, of two colours."""
    scene = room(width, height)
    add(scene, 1, translation(0.7, 0.4, 0.4) @ rotation("z", 15) @ scaling(0.4, 0.4, 0.4), diffuse(GREY))
    frame = shapes.Difference(shapes.Box(half_size=(0.5, 0.5, 0.5)), shapes.Sphere(radius=0.66))
    scene.lamps += [
        Lamp(
            "frame",
            frame,
            translation(-0.4, 0.3, 1.5) @ rotation("z", 25) @ rotation("x", 15),
            power=50.0,
            color=(1.0, 0.8, 0.5),
        ),
        Lamp(
            "capsule",
            shapes.Capsule(radius=0.08, height=0.25),
            translation(1.2, -0.3, 2.2) @ rotation("x", 50),
            density=4.0,
            color=(0.5, 0.7, 1.0),
        ),
    ]
    return scene


def field_lamps(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Lamps whose intervals have no closed form: a twisted bar, a spring, a sponge."""
    scene = _room_with_box(width, height)
    twisted = shapes.SHAPES["twist"](shapes.Box((0.15, 0.1, 0.4)), 1.5)
    scene.lamps += [
        Lamp(
            "bar",
            twisted,
            translation(-0.8, 0.3, 2.0) @ rotation("x", 40) @ scaling(1.0, 1.3, 0.8),
            power=30.0,
            color=(1.0, 0.8, 0.5),
        ),
        Lamp(
            "spring",
            shapes.SHAPES["helix"](),
            translation(0.8, 0.0, 1.8) @ rotation("y", 70),
            power=20.0,
            color=(0.5, 0.7, 1.0),
        ),
        Lamp(
            "sponge",
            shapes.SHAPES["menger_sponge"](0.3, 2),
            translation(-0.5, -0.3, 0.7) @ rotation("y", 30),
            power=10.0,
        ),
    ]
    return scene


def _room_with_box(width: int, height: int) -> Scene:
    scene = room(width, height)
    add(scene, 1, translation(0.9, 0.6, 0.4) @ rotation("z", 15) @ scaling(0.4, 0.4, 0.4), diffuse(GREY))
    return scene


def data_lamps(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Lamps made of data: an outline, a tube, a mesh."""
    scene = _room_with_box(width, height)
    outline, rod, mesh, _ = simplest()
    turn = rotation("x", 60) @ rotation("y", 20)
    scene.lamps += [
        Lamp("outline", outline, translation(-0.8, 0.3, 1.8) @ turn, power=20.0, color=(1.0, 0.8, 0.5)),
        Lamp("rod", rod, translation(0.8, 0.0, 1.5) @ turn, power=20.0, color=(0.5, 0.7, 1.0)),
        Lamp("mesh", mesh, translation(-0.3, -0.3, 0.6) @ turn @ scaling(0.4, 0.4, 0.6), power=10.0),
    ]
    return scene


def network_lamp(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A network of sines, over a box."""
    scene = _room_with_box(width, height)
    network = simplest()[3]
    scene.lamps.append(Lamp("network", network, translation(-0.2, 0.2, 1.2) @ rotation("z", 40), power=30.0))
    return scene


def colored_lamps(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Colours from place to place: across the box of a mesh, along a tube, of a picture on an outline."""
    scene = _room_with_box(width, height)
    outline, rod, mesh, _ = simplest()
    turn = rotation("x", 60) @ rotation("y", 20)
    stripes = np.zeros((2, 4, 4), np.float32)
    stripes[..., 3] = 1.0
    stripes[:, range(4), (0, 1, 2, 0)] = 1.0
    placed = (
        ("outline", outline, translation(-0.8, 0.3, 1.8) @ turn, 20.0, 'image_color("Stripes", u, v)'),
        ("rod", rod, translation(0.8, 0.0, 1.5) @ turn, 20.0, "ramp(along, 0, (1, 0.1, 0.05), 1, (0.1, 0.4, 1))"),
        ("mesh", mesh, translation(-0.3, -0.3, 0.6) @ turn @ scaling(0.4, 0.4, 0.6), 10.0, "(u, v, 0.2 + height)"),
    )
    files = Arrays(images={"Stripes": stripes})
    scene.lamps += [
        Lamp(name, shape, matrix, power=power, emission=EmissionExpression(text).emission(resolver=files))
        for name, shape, matrix, power, text in placed
    ]
    return scene


def varying_lamps(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Emission by position, depth and height: of a primitive, a closed form, a field, and a fog with a pane in it."""
    scene = room(width, height)
    scene.materials.append(
        Material(
            "tinted",
            Node(
                "mix_closure",
                {
                    "factor": 0.6,
                    "a": Node("diffuse", {"color": RED}),
                    "b": Node("transparent", {"color": (0.5, 0.9, 0.6)}),
                },
            ),
        )
    )
    scene.instances.append(
        Instance(0, translation(0.9, 0.2, 0.9) @ rotation("x", 90) @ scaling(0.5, 0.6, 1), (len(scene.materials) - 1,))
    )
    twisted = shapes.SHAPES["twist"](shapes.Box((0.15, 0.1, 0.4)), 1.5)
    hollow = shapes.Difference(shapes.Box(half_size=(0.4, 0.4, 0.4)), shapes.Sphere(radius=0.5))
    scene.lamps += [
        torus_lamp(
            -0.8,
            0.4,
            1.9,
            40.0,
            emission=_emission("blackbody(mix(1500, 6000, height)) * (0.2 + height ** 2) * exp(-depth / 0.04)"),
        ),
        Lamp(
            "hollow",
            hollow,
            translation(0.2, 0.9, 0.9) @ rotation("z", 25) @ scaling(1.0, -1.2, 0.8),
            power=20.0,
            color=(1.0, 0.7, 0.4),
            emission=_emission("ramp(p.x, -0.4, 0, 0, (1, 0, 0), 0.4, (0, 1, 1))"),
        ),
        Lamp(
            "bar",
            twisted,
            translation(-0.9, -0.2, 0.7) @ rotation("x", 40),
            density=6.0,
            emission=_emission("(0.5 + 0.5 * noise(9 * p)) * ramp(depth, 0, (0, 0, 1), 0.1, 1)"),
        ),
        Lamp(
            "fog",
            shapes.Sphere(radius=0.7),
            translation(0.9, 0.2, 1.0),
            density=0.6,
            emission=_emission("max(0, p.y + 0.1) + 0.2"),
        ),
    ]
    return scene


def _emission(text: str) -> Emission:
    return EmissionExpression(text).emission()


def inside_lamp(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The camera and the furniture stand inside a large glowing ball; a second lamp overlaps it."""
    scene = room(width, height, max_bounces=2)
    add(scene, 2, translation(0.5, 0.0, 0.7) @ scaling(0.6, 0.6, 0.6), diffuse(GREY))
    scene.lamps += [
        Lamp("fog", shapes.Sphere(radius=1.0), translation(0, -2.0, 1.2) @ scaling(5, 5, 3), density=0.02),
        torus_lamp(-0.6, 0.0, 1.0, 20.0, color=(1.0, 0.6, 0.3)),
    ]
    return scene


def veiled(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A sheet that scatters half of the light and lets the rest pass, close under a lamp and close over the floor."""
    scene = room(width, height)
    veil = Node(
        "mix_closure", {"factor": 0.5, "a": Node("diffuse", {"color": (0.8, 0.7, 0.5)}), "b": Node("transparent")}
    )
    add(scene, 0, translation(0.0, 0.0, 0.25) @ scaling(1.5, 1.5, 1.0), Material("veil", veil))
    scene.lamps.append(torus_lamp(z=0.75))
    return scene
