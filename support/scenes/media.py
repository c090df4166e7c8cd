# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes with participating media, like those of ``SCENES``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sdf_lights.graph.formula import Formula, Vector, call, constant, exp, minimum, parameter, sin
from sdf_lights.render.lights.area import AreaLight
from sdf_lights.render.lights.point import PointLight, SpotLight
from sdf_lights.render.lights.sun import SunLight
from sdf_lights.render.material import Attribute, Material, Node
from sdf_lights.render.medium import Medium, Scattering, Varying
from sdf_lights.render.nodes.lookups import GRID
from sdf_lights.render.nodes.variables import POSITION
from sdf_lights.render.scene import AttributeValues, Domain, Instance, Lamp, Scene, World
from sdf_lights.render.voxels import packed
from sdf_lights.sdf import shapes
from sdf_lights.sdf.emission import EmissionExpression

from .matrices import look_at, rotation, scaling, translation
from .meshes import box, sphere
from .room import GREY, HEIGHT, WIDTH, add, camera, diffuse, material, room, settings, torus_lamp

ONE = minimum(exp(abs(POSITION.x)), 1.0)  # everywhere, but no program can know
WAVES = 1.0 + sin(7.0 * POSITION.x) * sin(6.0 * POSITION.y) * sin(5.0 * POSITION.z)
THINNING = exp(-1.5 * POSITION.z)  # with height
CLEAR = Node("transparent", {"color": (1.0, 1.0, 1.0)})


def varying(medium: Medium | None, factor: Formula = ONE) -> Medium | None:
    """The same medium, whose coefficients are formulas: times a ``factor``."""
    if medium is None:
        return None
    scaled = [
        Vector(*(constant(channel) * factor for channel in color))
        for color in (medium.absorption, *(part.coefficient for part in medium.scattering), medium.emission)
    ]
    return replace(medium, varying=Varying(scaled[0], tuple(scaled[1:-1]), scaled[-1], []))


def with_varying_media(scene: Scene, factor: Formula = ONE) -> Scene:
    """The same scene with all its media ``varying``."""
    scene.world = replace(scene.world, medium=varying(scene.world.medium, factor))
    scene.materials = [replace(each, medium=varying(each.medium, factor)) for each in scene.materials]
    return scene


def smoke(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """Closed meshes, some of which overlap: coloured smoke around a lamp, a pane in it, absorbing glass, glowing gas,
    and smoke behind a surface that also scatters."""
    scene = room(width, height, max_bounces=2, transparent_bounces=8)
    scene.meshes.append(box("plain box"))
    scene.meshes[3].slots = None
    puff = Medium((0.1, 0.3, 0.5), (Scattering((1.2, 0.9, 0.7), 0.5), Scattering((0.2, 0.2, 0.4), 0.0, 1.0)))
    add(scene, 2, translation(-0.7, 0.2, 1.7) @ scaling(0.9, 0.9, 0.9), Material("smoke", CLEAR, medium=puff))
    add(scene, 0, translation(-0.5, 0.0, 1.2) @ rotation("x", 70) @ scaling(0.3, 0.3, 1), diffuse(GREY))
    amber = Node("glass", {"color": (1.0, 1.0, 1.0), "roughness": 0.0, "ior": 1.3})
    add(
        scene,
        3,
        translation(0.9, -0.2, 0.5) @ rotation("z", 30) @ scaling(0.4, 0.4, 0.5),
        Material("amber", amber, medium=Medium((0.2, 0.8, 2.0), (Scattering((0.5, 0.3, 0.1)),))),
    )
    add(
        scene,
        3,
        translation(0.1, 0.2, 2.0) @ rotation("y", 20) @ scaling(0.5, -0.4, 0.4),
        Material("gas", CLEAR, medium=Medium((0.4, 0.2, 0.1), (), (0.1, 0.2, 0.5))),
    )
    veil = Node("mix_closure", {"factor": 0.3, "a": CLEAR, "b": Node("diffuse", {"color": (0.2, 0.7, 0.3)})})
    add(
        scene,
        2,
        translation(-0.9, -0.3, 0.4) @ scaling(0.4, 0.4, 0.4),
        Material("murk", veil, medium=Medium((0.0, 0.5, 0.5), (Scattering((2.0, 2.0, 2.0), -0.4),))),
    )
    scene.lamps.append(torus_lamp(-0.6, 0.0, 2.0, 40.0, 0.6))
    scene.lights.append(AreaLight("panel", look_at((1.2, -0.8, 2.6), (0.4, 0.2, 1.0)), 30.0, size=(0.5, 0.3)))
    return scene


def haze(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The world is full of haze, under lamps, one of which varies, a spot light, a sun and a sky."""
    scene = room(width, height, max_bounces=2)
    scene.world = World((0.3, 0.4, 0.6), 0.3)
    scene.world.medium = Medium((0.01, 0.02, 0.04), (Scattering((0.12, 0.1, 0.08), 0.6), Scattering((0.02,) * 3)))
    add(
        scene,
        1,
        translation(0.7, 0.3, 0.5) @ rotation("z", 25) @ scaling(0.4, 0.4, 0.5),
        material("glossy", roughness=0.2),
    )
    scene.lamps += [
        torus_lamp(-0.6, 0.3, 1.9, 40.0, 0.7),
        Lamp(
            "ember",
            shapes.Sphere(radius=0.4),
            translation(0.9, 0.4, 1.9),
            power=20.0,
            emission=EmissionExpression("blackbody(mix(1500, 6000, height)) * (0.2 + height ** 2)").emission(),
        ),
    ]
    scene.lights += [
        SpotLight("spot", look_at((-1.5, -1.5, 2.8), (0.5, 0.5, 0.5)), 120.0, angle=0.6),
        SunLight("sun", rotation("x", 50.0), 0.5, angle=0.1),
    ]
    return scene


def fog_lamp(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """One lamp in fog, without surfaces."""
    scene = Scene(camera((0, -5, 1.5), (0, 0, 1.6), width, height, 0.4), width, height)
    scene.world = World((0.0, 0.0, 0.0), 0.0)
    scene.world.medium = Medium((0.02, 0.02, 0.05), (Scattering((0.3, 0.25, 0.2), 0.3),))
    scene.settings = settings(max_bounces=1)
    scene.lamps.append(torus_lamp())
    return scene


def submerged(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """The camera is inside a mesh that bounds a medium; the mesh is used twice, and mirrored. Balls with less
    absorption are cut out like air."""
    scene = room(width, height, max_bounces=2)
    scene.meshes.append(sphere("pool", 24, 12, smooth=False))
    scene.materials.append(
        Material("water", CLEAR, medium=Medium((0.15, 0.05, 0.02), (Scattering((0.05, 0.06, 0.08), 0.7),)))
    )
    water = len(scene.materials) - 1
    scene.instances += [
        Instance(3, translation(0.0, -3.0, 1.5) @ scaling(4.5, -4.5, 4.5), (water,), "pool"),
        Instance(3, translation(0.8, 0.3, 1.0) @ rotation("x", 30) @ scaling(0.5, 0.7, 0.5), (water,), "drop"),
    ]
    scene.lamps.append(torus_lamp(-0.4, 0.3, 1.9, 60.0, 0.7))
    scene.lights.append(PointLight("bulb", translation(1.0, -0.5, 2.4), 30.0, radius=0.1))
    return scene


def linked_media(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A ball of smoke in a larger one, in fog; each of three lights lights only one of these media."""
    scene = room(width, height, max_bounces=2)
    scene.world.medium = Medium((0.0, 0.0, 0.0), (Scattering((0.05, 0.05, 0.05), 0.3),))
    scene.meshes.append(sphere("ball", 16, 8, smooth=False))
    mesh = len(scene.meshes) - 1
    for name, size, scattering in (("core", 0.4, (0.9, 0.5, 0.3)), ("cloud", 0.9, (0.2, 0.4, 0.6))):
        scene.materials.append(Material(name, CLEAR, medium=Medium((0.1, 0.1, 0.1), (Scattering(scattering, 0.0),))))
        placed = translation(0.0, 0.0, 1.2) @ scaling(size, size, size)
        scene.instances.append(Instance(mesh, placed, (len(scene.materials) - 1,), name))
    scene.instances[-2].light_set, scene.instances[-1].light_set = 1, 2
    lamp = torus_lamp(-0.4, 0.3, 2.4, 60.0, 0.7)
    lamp.receivers = 2
    scene.lamps.append(lamp)
    scene.lights.append(PointLight("cloud's", translation(1.0, -0.5, 2.4), 60.0, radius=0.1, receivers=4))
    scene.lights.append(PointLight("fog's", translation(-1.2, -0.8, 1.0), 20.0, radius=0.1, receivers=1))
    return scene


def varying_smoke(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """One lamp in front of a ball of smoke that comes in waves, in a room."""
    scene = room(width, height, max_bounces=1)
    puff = Medium(
        (0.1, 0.3, 0.5), (Scattering((1.2, 0.9, 0.7), 0.5), Scattering((0.2, 0.2, 0.4), 0.0, 1.0)), (0.1,) * 3
    )
    smoke = Material("smoke", CLEAR, medium=varying(puff, WAVES))
    scene.meshes.append(sphere("ball", 16, 8, smooth=False))
    add(scene, 3, translation(0.3, 0.2, 1.2) @ scaling(0.8, 0.8, 0.8), smoke)
    scene.lamps.append(torus_lamp(-0.6, 0.0, 2.0, 40.0, 0.6))
    return scene


def thinning_fog(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """One lamp in fog that is thinner with height, and has no end below."""
    return with_varying_media(fog_lamp(width, height), THINNING)


def voxel_cloud(width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """One lamp over a turned box of smoke, whose density and colour are grids of voxels."""
    scene = room(width, height, max_bounces=1)
    generator = np.random.default_rng(3)
    density, color = generator.random((11, 9, 10, 1)) ** 4, 0.5 + 0.5 * generator.random((11, 9, 10, 3))
    matrix, last = translation(-1.0, -1.0, -1.0) @ scaling(0.2, 0.2, 0.2), np.array(density.shape[:3]) - 1
    numbers = [
        packed(_parts_of(values), (0, 0, 0), last, np.zeros(values.shape[3]), matrix) for values in (density, color)
    ]
    grids = [Attribute("grid", name) for name in ("density", "color")]
    (amount, *_), (red, green, blue, *_) = (
        call(GRID["LINEAR"], parameter(index), *POSITION) for index in range(len(grids))
    )
    amount, zero = 4.0 * amount, Vector(*(constant(0.0),) * 3)
    tint = Vector(red * amount, green * amount, blue * amount)
    formulas = Varying(Vector(amount, amount, amount) - tint, (tint,), zero, grids)
    smoke = Material("smoke", CLEAR, medium=Medium((0.1,) * 3, (Scattering((0.1,) * 3, 0.3),), varying=formulas))
    scene.meshes.append(box())
    scene.meshes[-1].slots = None
    placed = translation(0.2, 0.2, 1.1) @ rotation("z", 20) @ scaling(0.9, 0.7, 0.8)
    add(scene, len(scene.meshes) - 1, placed, smoke)
    scene.instances[-1].attributes.update(
        {grid: AttributeValues(Domain.WHOLE, values) for grid, values in zip(grids, numbers)}
    )
    scene.lamps.append(torus_lamp(-0.6, 0.0, 2.4, 40.0, 0.6))
    return scene


def _parts_of(values: np.ndarray):
    """What gives parts of voxels (x, y, z, channels); zeros around them."""

    def read(start, counts):
        found = np.zeros((*counts, values.shape[3]), np.float32)
        first, last = np.clip(start, 0, values.shape[:3]), np.clip(start + counts, 0, values.shape[:3])
        found[tuple(map(slice, first - start, last - start))] = values[tuple(map(slice, first, last))]
        return found

    return read


VARYING_SCENES = {builder.__name__: builder for builder in (varying_smoke, thinning_fog, voxel_cloud)}
MEDIA_SCENES = {builder.__name__: builder for builder in (smoke, haze, fog_lamp, submerged, linked_media)}
