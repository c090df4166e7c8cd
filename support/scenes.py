# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes on which all back ends must agree.

``SCENES`` maps a name to a function ``(width=48, height=36) -> Scene``. Each scene tests one feature, has at most 2,000
triangles, and converges in few samples. It uses a box filter one pixel wide and no adaptive sampling, so pixel values
are plain means. World space is z up.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sdf_lights.graph.formula import Vector, constant
from sdf_lights.render import motion
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.material import Material, Node
from sdf_lights.render.nodes.normals import displaced_as_bump
from sdf_lights.render.nodes.variables import BACKFACING, NORMAL, POSITION, RAY_LENGTH
from sdf_lights.render.scene import Camera, Image, Instance, Lamp, Mesh, Projection, Ray, Scene, Shutter, World
from sdf_lights.render.settings import Filter, LampPaths, Settings
from sdf_lights.sdf import shapes
from sdf_lights.sdf.emission import Emission, EmissionExpression
from support.graphs import Graph

WIDTH, HEIGHT = 48, 36


# --- matrices ---------------------------------------------------------------------------------------------------------


def translation(x: float, y: float, z: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def scaling(x: float, y: float, z: float) -> np.ndarray:
    return np.diag([x, y, z, 1.0])


def rotation(axis: str, degrees: float) -> np.ndarray:
    """Right-handed rotation about "x", "y" or "z"."""
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(4)
    matrix[j, j], matrix[j, k], matrix[k, j], matrix[k, k] = c, -s, s, c
    return matrix


def look_at(eye, target, up=(0.0, 0.0, 1.0)) -> np.ndarray:
    """Matrix of an object at ``eye`` whose local −z points at ``target``."""
    eye = np.asarray(eye, float)
    back = eye - np.asarray(target, float)
    back /= np.linalg.norm(back)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = right, np.cross(back, right), back, eye
    return matrix


# --- meshes -----------------------------------------------------------------------------------------------------------


def quad(name: str = "quad") -> Mesh:
    """Square of side 2 in the plane z = 0, facing +z, with UVs from 0 to 1."""
    positions = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    uv = (positions[:, :2] * 0.5 + 0.5)[triangles]
    tangents = np.tile(np.array([1, 0, 0, 1], np.float32), (2, 3, 1))
    return Mesh(name, positions, triangles, uvs={"": uv}, tangents={"": tangents})


def box(name: str = "box", inside_out: bool = False) -> Mesh:
    """Cube from −1 to 1. Its material slots are x, y and z for the faces normal to those axes."""
    positions, triangles, slots = [], [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            corners = np.zeros((4, 3), np.float32)
            corners[:, axis] = sign
            corners[:, (axis + 1) % 3] = np.array([-1, 1, 1, -1]) * sign
            corners[:, (axis + 2) % 3] = [-1, -1, 1, 1]
            first = len(positions)
            positions.extend(corners)
            faces = np.array([[0, 1, 2], [0, 2, 3]])
            triangles.extend((faces[:, ::-1] if inside_out else faces) + first)
            slots += [axis, axis]
    return Mesh(name, np.array(positions, np.float32), np.array(triangles, np.int32), slots=np.array(slots, np.int32))


def sphere(name: str = "sphere", columns: int = 20, rows: int = 10, smooth: bool = True) -> Mesh:
    """Unit sphere of 2 · columns · (rows − 1) triangles about the z axis."""
    theta = np.linspace(0, np.pi, rows + 1)[1:-1, None]
    phi = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
    rings = np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1)
    positions = np.concatenate([[[0, 0, 1.0]], rings.reshape(-1, 3), [[0, 0, -1.0]]]).astype(np.float32)
    triangles = []
    last = len(positions) - 1
    for i in range(columns):
        j = (i + 1) % columns
        triangles.append((0, 1 + i, 1 + j))
        for row in range(rows - 2):
            a, b = 1 + row * columns + i, 1 + row * columns + j
            triangles += [(a, a + columns, b + columns), (a, b + columns, b)]
        triangles.append((last, last - columns + j, last - columns + i))
    triangles = np.array(triangles, np.int32)
    return Mesh(name, positions, triangles, normals=positions[triangles] if smooth else None)


# --- materials --------------------------------------------------------------------------------------------------------


def diffuse(color, name: str = "diffuse") -> Material:
    return Material(name, Node("diffuse", {"color": color}))


def material(kind: str, name: str = "", **inputs) -> Material:
    return Material(name or kind, Node(kind, inputs))


# --- a room -----------------------------------------------------------------------------------------------------------

WHITE, RED, GREEN, GREY = (0.75, 0.73, 0.70), (0.65, 0.12, 0.08), (0.15, 0.5, 0.12), (0.5, 0.5, 0.5)


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


# --- the scenes -------------------------------------------------------------------------------------------------------


def torus_room(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Diffuse room and a box, lit by one torus lamp."""
    scene = room(width, height)
    add(scene, 1, translation(-0.7, 0.5, 0.5) @ rotation("z", 25) @ scaling(0.4, 0.4, 0.5), diffuse(GREY))
    scene.lamps.append(torus_lamp())
    return scene


def cove(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A lamp above a shelf, which hides it from most of the room: light comes by way of the ceiling, and light paths are used.

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


def shadow_catcher(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Metal and a glowing box on a floor that catches their light and shadows, seen through a clear sheet, under an SDF lamp."""
    scene = emissive_mesh(width, height)
    scene.instances[0].catcher = True
    scene.lamps.append(torus_lamp())
    return scene


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
    scene = room(width, height)
    add(scene, 1, translation(0.9, 0.6, 0.4) @ rotation("z", 15) @ scaling(0.4, 0.4, 0.4), diffuse(GREY))
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


def data_lamps(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Lamps made of data: an outline, a tube, a mesh."""
    from sdf_lights.sdf.data.simplest import simplest

    scene = room(width, height)
    add(scene, 1, translation(0.9, 0.6, 0.4) @ rotation("z", 15) @ scaling(0.4, 0.4, 0.4), diffuse(GREY))
    outline, rod, mesh, _ = simplest()
    turn = rotation("x", 60) @ rotation("y", 20)
    scene.lamps += [
        Lamp("outline", outline, translation(-0.8, 0.3, 1.8) @ turn, power=20.0, color=(1.0, 0.8, 0.5)),
        Lamp("rod", rod, translation(0.8, 0.0, 1.5) @ turn, power=20.0, color=(0.5, 0.7, 1.0)),
        Lamp("mesh", mesh, translation(-0.3, -0.3, 0.6) @ turn @ scaling(0.4, 0.4, 0.6), power=10.0),
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


def depth_of_field(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A lens with five rotated, scaled blades, in focus on the middle of three balls; a lamp far out of focus."""
    scene = room(width, height)
    for i, color in enumerate((RED, WHITE, GREEN)):
        add(scene, 2, translation(i - 1.0, 1.2 * (i - 1), 0.5) @ scaling(0.4, 0.4, 0.4), diffuse(color))
    scene.camera.aperture, scene.camera.focus = 0.15, 5.5
    scene.camera.blades, scene.camera.blade_rotation, scene.camera.blade_ratio = 5, 0.3, 1.5
    scene.lamps.append(torus_lamp(0.0, 1.0, 2.2))
    return scene


def panorama(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Part of the room around an equirectangular camera between two lamps."""
    scene = room(width, height, max_bounces=2)
    scene.camera = Camera(
        look_at((0.2, 0.1, 1.3), (0, 2, 1.2)),
        Projection.EQUIRECTANGULAR,
        clip=(0.01, 100.0),
        window=(-3.0, 2.8, -1.2, 1.3),
    )
    scene.lamps += [torus_lamp(-0.9, 0.6, 1.6, 30.0, 0.6), torus_lamp(1.0, -0.8, 1.2, 20.0, 0.4)]
    return scene


def fisheye(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The room through a fisheye whose picture does not fill the frame."""
    scene = panorama(width, height)
    scene.camera = Camera(scene.camera.matrix, Projection.FISHEYE_EQUISOLID, (-0.9, 0.9, -0.7, 0.7), (0.01, 100.0), 3.0)
    return scene


def orthographic(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The torus room through an orthographic camera, clipped in depth."""
    scene = torus_room(width, height)
    half = 2.2 * height / width
    scene.camera = Camera(
        look_at((1.0, -5.0, 2.5), (0, 0, 1.4)),
        Projection.ORTHOGRAPHIC,
        window=(-2.2, 2.2, -half, half),
        clip=(0.1, 6.8),
    )
    return scene


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


def rolling(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The torus room while the camera turns, line by line."""
    scene = torus_room(width, height)
    scene.camera = _over_time(scene.camera, 2, matrix=translation(0.4, 0.0, 0.0))
    scene.shutter = Shutter(rolling=0.3)
    return scene


SCENES = {
    builder.__name__: builder
    for builder in (
        torus_room,
        cove,
        blender_lights,
        world_color,
        environment,
        skylight,
        emissive_mesh,
        glowing_bubble,
        light_control,
        glossy_metal,
        facets,
        rare,
        glass,
        subsurface,
        subsurface_profile,
        only_reflective_caustics,
        only_refractive_caustics,
        filtered_glossy,
        shadow_catcher,
        textured,
        probed,
        instances,
        frame_lamp,
        field_lamps,
        data_lamps,
        varying_lamps,
        inside_lamp,
        veiled,
        transparent,
        depth_of_field,
        panorama,
        fisheye,
        orthographic,
        moving,
        rolling,
    )
}
