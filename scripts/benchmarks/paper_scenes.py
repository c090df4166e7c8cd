# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of the four kinds of Huang et al. 2026, rebuilt: theirs are not published.

They stress the same properties: a lamp close above a mesh of many triangles, several lamps in a closed room, a lamp of
fine parts in a furnished room, and a flat lamp at a grazing angle to long walls.
"""

from __future__ import annotations

from mathutils import Matrix
from scenery.modelling import add, plane

from sdf_lights.emitter.tree import interior, volume
from sdf_lights.sdf.expression import Expression

from . import lamp_meshes, simple_scenes
from .lamp_scenes import LampScene, add_lamp, marched, turned

SCENES: dict[str, LampScene] = {}

CELLS = 96  # of the detailed mesh to its longest side


def _scene(name: str, about: str):
    def register(build):
        SCENES[name] = LampScene(name, about, build, volumes=False)
        return build

    return register


def _lamp(name: str, expression: str, matrix: Matrix, intensity: float, color=(1.0, 1.0, 1.0)) -> None:
    """A lamp of ``intensity`` W/sr."""
    shape = Expression(expression).shape()
    exact = shape.volume()
    inside = volume.measure(interior.tree(shape)).value if exact is None else exact
    add_lamp(name, expression, None, matrix, intensity / (inside * abs(matrix.to_3x3().determinant())), color)


@_scene("dragon", "a torus over a mesh of many triangles")
def _(size: int) -> None:
    simple_scenes.empty(size, (0.0, -4.2, 2.0), (0.0, 0.0, 0.75), 40.0)
    grey = simple_scenes.diffuse("Grey", (0.7, 0.7, 0.7))
    add("Floor", plane("Floor", (10.0, 10.0)), grey)
    add("Wall", plane("Wall", (10.0, 6.0)), grey, location=(0.0, 2.0, 3.0), rotation=(90, 0, 0))
    # A lattice in a ball has handles, cavities and edges at all angles.
    solid = marched("sphere(0.6) & gyroid(vec3(0.6, 0.6, 0.6), 0.4, 0.1)", CELLS)
    add(
        "Statue",
        lamp_meshes.mesh("Statue", solid),
        simple_scenes.diffuse("Jade", (0.35, 0.6, 0.4)),
        location=(0.0, 0.0, 0.6),
    )
    _lamp("Torus", "torus(0.5, 0.12)", turned(x=25.0, at=(0.0, 0.0, 1.55)), 4.0)


@_scene("room", "a closed room with five lamps of simple shapes")
def _(size: int) -> None:
    simple_scenes.empty(size, (0.0, -2.8, 1.5), (0.0, 0.6, 1.1), 60.0)
    simple_scenes.room((-2.5, -3.0, 0.0), (2.5, 2.5, 2.7), (0.75, 0.73, 0.7))
    wood = simple_scenes.diffuse("Wood", (0.45, 0.3, 0.18))
    simple_scenes.boxes(
        wood,
        ((0.0, 0.6, 0.72), (1.6, 0.8, 0.05)),
        ((-0.75, 0.6, 0.35), (0.06, 0.7, 0.7)),
        ((0.75, 0.6, 0.35), (0.06, 0.7, 0.7)),
        ((-2.2, 1.6, 0.9), (0.5, 1.2, 1.8)),
    )
    simple_scenes.boxes(
        simple_scenes.diffuse("Cloth", (0.2, 0.3, 0.55)),
        ((1.7, 1.6, 0.25), (1.3, 0.9, 0.5)),
        ((1.7, 2.1, 0.65), (1.3, 0.2, 0.5)),
    )
    _lamp("Ball", "sphere(0.16)", turned(at=(-0.4, 0.6, 0.95)), 1.2, (1.0, 0.85, 0.6))
    _lamp("Ring", "torus(0.4, 0.04)", turned(at=(0.0, 0.6, 2.2)), 2.0)
    _lamp("Tube", "capsule(0.05, 0.9)", turned(y=90.0, at=(1.4, 2.3, 2.2)), 1.2, (0.6, 0.8, 1.0))
    _lamp("Frame", "box_frame(vec3(0.18, 0.18, 0.18), 0.025)", turned(z=30.0, at=(0.45, 0.5, 0.95)), 1.0)
    _lamp("Cone", "cone(0.2, 0.4)", turned(at=(-1.4, 1.6, 0.25)), 1.0, (1.0, 0.6, 0.4))


@_scene("kitchen", "a furnished room with a fractal lamp over the worktop")
def _(size: int) -> None:
    simple_scenes.empty(size, (1.2, -2.7, 1.7), (-0.1, 0.6, 1.05), 60.0)
    simple_scenes.room((-2.5, -3.0, 0.0), (2.5, 2.5, 2.6), (0.78, 0.77, 0.74))
    simple_scenes.boxes(
        simple_scenes.diffuse("Cupboards", (0.3, 0.42, 0.38)),
        ((0.0, 2.2, 0.44), (4.4, 0.6, 0.88)),
        ((-1.3, 2.32, 1.9), (1.8, 0.36, 0.7)),
        ((1.3, 2.32, 1.9), (1.8, 0.36, 0.7)),
        ((0.0, 0.3, 0.43), (1.6, 0.8, 0.86)),
    )
    simple_scenes.boxes(
        simple_scenes.diffuse("Stone", (0.8, 0.78, 0.75)),
        ((0.0, 2.18, 0.9), (4.45, 0.66, 0.04)),
        ((0.0, 0.3, 0.88), (1.7, 0.9, 0.04)),
    )
    pot = simple_scenes.diffuse("Pots", (0.65, 0.3, 0.15))
    simple_scenes.boxes(
        pot, *(((x, y, 0.97), (0.14, 0.14, 0.14)) for x, y in ((-0.5, 0.2), (0.45, 0.5), (-1.2, 2.15), (0.9, 2.2)))
    )
    for index, x in enumerate((-0.9, 0.9)):
        add(f"Stool {index}", lamp_meshes.mesh("Stool", lamp_meshes.sphere(0.2, 64, 32)), pot, location=(x, -0.7, 0.4))
    _lamp("Sponge", "menger_sponge(0.2, 4)", turned(x=20.0, z=30.0, at=(0.0, 0.3, 1.55)), 3.0)


@_scene("corridor", "a corridor with an extruded sign")
def _(size: int) -> None:
    simple_scenes.corridor(size)
    _lamp(
        "Sign",
        "union(extrusion(ring(0.42, 0.05), 0.06), extrusion(star(5, 0.3, 0.13), 0.06))",
        turned(x=90.0, z=25.0, at=(0.2, 3.4, 1.85)),
        3.0,
        (1.0, 0.75, 0.5),
    )
