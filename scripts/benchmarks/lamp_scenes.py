# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes lit only by SDF lamps, each written once: as lamps for SDF Lights, as emission volumes in meshes for Cycles.

A lamp's radiance per metre is the same number for both. Scenes named S… are a stage of boxes and a glossy sphere, with
a lamp of 8 W/sr. Each of the others stresses one property, which its line names.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import host
import numpy as np
from mathutils import Euler, Matrix
from scenery.materials import Graph
from scenery.modelling import add, box, plane

from sdf_lights.blender.lamp import shape_of
from sdf_lights.sdf.expression import Expression

from . import lamp_meshes, simple_scenes
from .lamp_meshes import Solid

INTENSITY = 8.0  # W/sr of a lamp of the S scenes
LAMPS, VOLUMES, SURFACES = "SDF Lamps", "Emission Volumes", "Mesh Lights"  # collections; an engine renders one
THE_FIVE = ("S1", "S2", "S3", "S4", "S5")


@dataclass(frozen=True)
class LampScene:
    """``build`` makes the scene, with so many pixels per side, in place of the open file.

    ``volumes``: whether there are volumes for Cycles, too.
    """

    name: str
    about: str
    build: Callable[[int], None]
    volumes: bool = True


SCENES: dict[str, LampScene] = {}


def _scene(name: str, about: str, volumes: bool = True):
    def register(build):
        SCENES[name] = LampScene(name, about, build, volumes)
        return build

    return register


def show(volumes: bool = False, surfaces: bool = False) -> None:
    """Render the lamps as emission volumes, as meshes with an emissive surface, or as lamps."""
    if surfaces and not _collection(SURFACES).objects:
        _add_surfaces()
    _collection(LAMPS).hide_render = volumes or surfaces
    _collection(VOLUMES).hide_render = not volumes
    _collection(SURFACES).hide_render = not surfaces


def _add_surfaces() -> None:
    """For each volume, a mesh light of the same power, 4π ρ V = π L A; its inner sides are not sampled."""
    simple_scenes.enable_cycles()
    for volume in _collection(VOLUMES).objects:
        node = volume.data.materials[0].node_tree.nodes["Emission"]
        color, density = (node.inputs[name].default_value for name in ("Color", "Strength"))
        mesh = volume.data.copy()
        inside, area = lamp_meshes.measures(mesh)
        graph = Graph(mesh.name)
        emission = graph.node("ShaderNodeEmission", Color=color, Strength=4.0 * density * inside / area)
        material = graph.finish(emission)
        material.cycles.emission_sampling = "FRONT"
        mesh.materials[0] = material
        add(f"{volume.name} Surface", mesh, collection=_collection(SURFACES))


def _collection(name: str):
    if name not in bpy.data.collections:
        bpy.context.scene.collection.children.link(bpy.data.collections.new(name))
    return bpy.data.collections[name]


def turned(x: float = 0.0, y: float = 0.0, z: float = 0.0, at=(0.0, 0.0, 0.0), scale=(1.0, 1.0, 1.0)) -> Matrix:
    """Rz(z) Ry(y) Rx(x) diag(scale), angles in degrees, moved to ``at``."""
    angles = Euler([math.radians(angle) for angle in (x, y, z)], "XYZ")
    return Matrix.Translation(at) @ angles.to_matrix().to_4x4() @ Matrix.Diagonal((*scale, 1.0))


def add_lamp(
    name: str,
    expression: str,
    solid: Solid | None,
    matrix: Matrix,
    density: float,
    color=(1.0, 1.0, 1.0),
    emission: str = "UNIFORM",
) -> None:
    """A lamp of ``density`` W/(sr m³), and the same ``solid`` as a volume, unless it is None.

    ``emission`` is the name of a preset; only uniform ones have a volume.
    """
    light = bpy.data.lights.new(name, "POINT")
    host.set_lamp(light, expression)
    light.sdf_lamp.normalize, light.sdf_lamp.density, light.color = False, density, color
    light.sdf_lamp.emission.source = emission
    thing = add(name, light, collection=_collection(LAMPS))
    thing.matrix_world = matrix
    if solid is not None:
        # The matrix is applied to the mesh, so that the scale of the object has no effect.
        _add_volume(name, lamp_meshes.mesh(name, lamp_meshes.moved(solid, np.array(matrix))), density, color)


def _add_volume(name: str, mesh: bpy.types.Mesh, density: float, color=(1.0, 1.0, 1.0)) -> None:
    graph = Graph(name)
    material = graph.finish(graph.node("ShaderNodeEmission", Color=color, Strength=density), "Volume")
    add(f"{name} Volume", mesh, material, collection=_collection(VOLUMES))


@functools.cache
def marched(expression: str, cells: int = 96) -> Solid:
    """The solid of an expression, which has to be smooth."""
    shape = Expression(expression).shape()
    return lamp_meshes.isosurface(shape.distance, *shape.bounds(), cells)


# --- the stage --------------------------------------------------------------------------------------------------------


def _stage_lamp(expression: str, solid: Solid, matrix: Matrix, volume: float) -> None:
    add_lamp("Lamp", expression, solid, matrix, INTENSITY / volume)


def _torus(size: int, major: float, minor: float, matrix: Matrix) -> None:
    simple_scenes.boxes_and_sphere(size)
    volume = 2.0 * math.pi**2 * major * minor**2 * abs(matrix.to_3x3().determinant())
    _stage_lamp(f"torus({major}, {minor})", lamp_meshes.torus(major, minor), matrix, volume)


@_scene("S1", "torus above the stage")
def _(size: int) -> None:
    _torus(size, 1.0, 0.35, turned(x=30.0, z=20.0, at=(0.0, 0.0, 1.7)))


@_scene("S2", "the same torus half sunk in the floor, round a box")
def _(size: int) -> None:
    _torus(size, 1.0, 0.35, Matrix())


@_scene("S3", "cube without a ball: a thin frame")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    half, radius = 0.8, 1.08
    cap = radius - half
    ball = 4.0 / 3.0 * math.pi * radius**3 - 2.0 * math.pi * cap**2 * (3.0 * radius - cap)
    solid = lamp_meshes.difference(lamp_meshes.box((half,) * 3), lamp_meshes.sphere(radius))
    _stage_lamp(
        f"box({half}) - sphere({radius})", solid, turned(x=15.0, z=25.0, at=(0.0, 0.0, 1.9)), 8.0 * half**3 - ball
    )


@_scene("S4", "Menger's sponge, three levels")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    _stage_lamp(
        "menger_sponge(0.75, 3)",
        lamp_meshes.sponge(0.75, 3),
        turned(x=20.0, z=30.0, at=(0.0, 0.0, 1.9)),
        1.5**3 * (20.0 / 27.0) ** 3,
    )


@_scene("S5", "stretched torus")
def _(size: int) -> None:
    _torus(size, 0.7, 0.245, turned(x=55.0, z=25.0, at=(0.0, 0.0, 1.7)) @ turned(y=15.0, scale=(2.0, 1.0, 0.5)))


# --- what else lamps do -----------------------------------------------------------------------------------------------


@_scene("crowd", "forty small lamps of three shapes all over the stage")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    kinds = (
        ("torus(0.12, 0.04)", lamp_meshes.torus(0.12, 0.04, 64, 32), 2.0 * math.pi**2 * 0.12 * 0.04**2),
        ("sphere(0.07)", lamp_meshes.sphere(0.07, 64, 32), 4.0 / 3.0 * math.pi * 0.07**3),
        ("box(0.05, 0.05, 0.12)", lamp_meshes.box((0.05, 0.05, 0.12)), 8.0 * 0.05 * 0.05 * 0.12),
    )
    random = np.random.default_rng(7)
    for index in range(40):
        expression, solid, volume = kinds[index % len(kinds)]
        at = random.uniform((-3.0, -2.5, 0.15), (3.0, 2.7, 3.2))
        angles = random.uniform(0.0, 360.0, 3)
        color = 0.3 + 0.7 * random.random(3)
        add_lamp(f"Lamp {index}", expression, solid, turned(*angles, at=at), INTENSITY / 40 / volume, color)


@_scene("nested", "a bright ring inside a large dim ball, which boxes and floor reach into")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    add_lamp("Ball", "sphere(1.3)", lamp_meshes.sphere(1.3), turned(at=(0.0, 0.0, 1.0)), 0.25, (0.4, 0.6, 1.0))
    ring = turned(x=40.0, at=(0.1, 0.2, 1.5))
    add_lamp("Ring", "torus(0.5, 0.06)", lamp_meshes.torus(0.5, 0.06), ring, 80.0, (1.0, 0.7, 0.4))


@_scene("haze", "camera and half of the stage inside one large dim lamp")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    matrix = turned(z=10.0, at=(-0.5, -4.0, 1.5), scale=(3.0, 4.5, 2.5))
    add_lamp("Haze", "sphere(1)", lamp_meshes.sphere(1.0), matrix, 0.12)


@_scene("wall", "a beam of light through a wall, with a shelf inside it")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    shelf = simple_scenes.material("Shelf", "ShaderNodeBsdfDiffuse", (0.6, 0.55, 0.5))
    add("Shelf", box("Shelf", (1.6, 0.9, 0.04)), shelf, location=(-0.8, 2.4, 2.0))
    matrix = turned(z=15.0, at=(-0.4, 2.7, 2.1))
    add_lamp("Beam", "box(0.3, 1.2, 0.35)", lamp_meshes.box((0.3, 1.2, 0.35)), matrix, INTENSITY)


@_scene("gloss", "a thin ring over a glossy floor")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    bpy.data.objects["Floor"].data.materials[0] = simple_scenes.material(
        "Polished", "ShaderNodeBsdfAnisotropic", (0.6, 0.6, 0.62), roughness=0.35, distribution="GGX"
    )
    volume = 2.0 * math.pi**2 * 0.9 * 0.015**2
    _stage_lamp(
        "torus(0.9, 0.015)", lamp_meshes.torus(0.9, 0.015, 512, 32), turned(x=60.0, z=20.0, at=(0.0, 0.5, 1.4)), volume
    )


@_scene("sheet", "a twisted bar behind a translucent sheet")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    graph = Graph("Sheet")
    both = graph.node(
        "ShaderNodeMixShader",
        _0=0.4,
        _1=graph.node("ShaderNodeBsdfTranslucent", Color=(0.9, 0.85, 0.7)),
        _2=graph.node("ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8)),
    )
    add("Sheet", plane("Sheet", (2.6, 2.2)), graph.finish(both), location=(0.3, -0.9, 1.4), rotation=(80, 0, 10))
    expression = "box(0.15, 0.15, 0.8)"
    add_lamp(
        "Bar",
        expression,
        lamp_meshes.box((0.15, 0.15, 0.8)),
        turned(y=50.0, z=20.0, at=(0.1, -0.3, 1.4)),
        INTENSITY / (8.0 * 0.15 * 0.15 * 0.8),
    )


@_scene("room", "a closed room lit by a sponge behind a screen: light that has been scattered")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    white = simple_scenes.material("White", "ShaderNodeBsdfDiffuse", (0.78, 0.76, 0.72))
    for name, extent, location, rotation in (
        ("Ceiling", (12.0, 10.5), (0.0, -2.0, 4.0), (180, 0, 0)),
        ("Left", (10.5, 4.2), (-3.5, -2.0, 2.0), (90, 0, 90)),
        ("Right", (10.5, 4.2), (3.5, -2.0, 2.0), (90, 0, -90)),
        ("Back", (12.0, 4.2), (0.0, -7.0, 2.0), (-90, 0, 0)),
    ):
        add(name, plane(name, extent), white, location=location, rotation=rotation)
    add("Screen", box("Screen", (1.6, 0.05, 1.8)), white, location=(-1.2, 1.2, 1.9))
    add_lamp(
        "Sponge",
        "menger_sponge(0.3, 3)",
        lamp_meshes.sponge(0.3, 3),
        turned(x=20.0, z=30.0, at=(-1.4, 2.0, 2.1)),
        2.0 * INTENSITY / (0.6**3 * (20.0 / 27.0) ** 3),
    )


@_scene("spark", "a lamp of a centimetre, metres away, outside the picture")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    add_lamp(
        "Spark",
        "sphere(0.005)",
        lamp_meshes.sphere(0.005, 64, 32),
        turned(at=(-2.8, -4.5, 3.0)),
        3.0 * INTENSITY / (4.0 / 3.0 * math.pi * 0.005**3),
    )


@_scene("moon", "a ball 120 m large, half a kilometre away")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    add_lamp("Moon", "sphere(60)", lamp_meshes.sphere(60.0), turned(at=(-250.0, -350.0, 300.0)), 0.35)


@_scene("blob", "a smooth union of balls, which rays are marched through")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    expression = (
        "smooth_union(translate(sphere(0.5), (-0.45, 0, 0)), translate(sphere(0.4), (0.4, 0.1, 0.2)), "
        "translate(sphere(0.3), (0.1, -0.2, -0.5)), 0.25)"
    )
    add_lamp("Blob", expression, marched(expression), turned(z=20.0, at=(0.0, 0.2, 1.8)), INTENSITY / 1.0)


@_scene("skin", "a torus that glows next to its surface", volumes=False)
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    add_lamp(
        "Skin", "torus(1, 0.35)", None, turned(x=30.0, z=20.0, at=(0.0, 0.0, 1.7)), 0.6 * INTENSITY, emission="SHELL"
    )


@_scene("fire", "a flame on the floor, brighter below", volumes=False)
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    add_lamp(
        "Fire", "sphere(0.5)", None, turned(at=(-0.3, -0.8, 0.85), scale=(0.7, 0.7, 1.5)), INTENSITY, emission="FLAME"
    )


@_scene("bulb", "a Mandelbulb near the floor, of which no mesh is close enough", volumes=False)
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    add_lamp("Bulb", "scale(mandelbulb(), 0.6)", None, turned(x=70.0, z=20.0, at=(-0.2, -0.9, 0.75)), INTENSITY / 0.6)


# --- lamps that data make ---------------------------------------------------------------------------------------------

OF_DATA = ("sign", "spring", "statue", "logo", "rabbit")


def _data_lamp(matrix: Matrix, mesh: bpy.types.Mesh | None, **source) -> None:
    """A lamp of 8 W/sr over the stage, from the ``source`` (properties of ``sdf_lamp``). ``mesh`` is the same for
    Cycles; without it, marching makes one."""
    light = bpy.data.lights.new("Lamp", "POINT")
    light.sdf_lamp.use, light.sdf_lamp.normalize = True, False
    for name, value in source.items():
        setattr(light.sdf_lamp, name, value)
    if mesh is None:
        shape = shape_of(light.sdf_lamp)
        mesh = lamp_meshes.mesh("Lamp", lamp_meshes.isosurface(shape.distance, *shape.bounds(), 160))
    else:
        lamp_meshes.close(mesh)
    mesh.transform(matrix)
    light.sdf_lamp.density = INTENSITY / lamp_meshes.measures(mesh)[0]
    add("Lamp", light, collection=_collection(LAMPS)).matrix_world = matrix
    _add_volume("Lamp", mesh, light.sdf_lamp.density)


def _object_lamp(matrix: Matrix, data: bpy.types.ID, is_exact: bool = True) -> None:
    """``is_exact``: the lamp equals Blender's mesh of the object."""
    obj = bpy.data.objects.new("Source", data)
    bpy.context.scene.collection.objects.link(obj)
    obj.hide_render = True
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(obj.evaluated_get(graph), depsgraph=graph) if is_exact else None
    _data_lamp(matrix, mesh, source="OBJECT", object=obj)


@_scene("sign", "a text with sharp edges")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    _object_lamp(turned(x=75.0, z=15.0, at=(0.0, 0.3, 1.6)), _text("OPEN", size=1.1, extrude=0.08))


@_scene("spring", "a tube along a curve")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    curve = bpy.data.curves.new("Spring", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.09
    spline = curve.splines.new("NURBS")
    turn = np.linspace(0.0, 14.0, 60)
    spline.points.add(len(turn) - 1)
    for point, angle in zip(spline.points, turn):
        point.co = 0.6 * math.cos(angle), 0.6 * math.sin(angle), 0.09 * angle - 0.6, 1.0
    spline.use_endpoint_u, spline.resolution_u = True, 8
    _object_lamp(turned(x=80.0, z=20.0, at=(0.0, 0.2, 1.8)), curve, is_exact=False)  # its ends are round


def _monkey() -> bpy.types.Mesh:
    """Blender's monkey, closed and divided."""
    with bpy.context.temp_override():
        bpy.ops.mesh.primitive_monkey_add()
    monkey = bpy.context.object
    monkey.modifiers.new("Whole", "REMESH").voxel_size = 0.04
    bpy.context.view_layer.update()
    mesh = bpy.data.meshes.new_from_object(monkey.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(monkey)
    return mesh


def _text(body: str, **settings) -> bpy.types.Curve:
    """A text around its middle."""
    curve = bpy.data.curves.new(body, "FONT")
    curve.body, curve.align_x = body, "CENTER"
    for name, value in settings.items():
        setattr(curve, name, value)
    return curve


@_scene("statue", "a mesh: Blender's monkey, closed and divided")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    mesh = _monkey()
    _object_lamp(turned(x=20.0, z=30.0, at=(0.0, 0.3, 1.7), scale=(0.8, 0.8, 0.8)), mesh)


def logo_image() -> bpy.types.Image:
    """A disc with a star cut out, in the alpha of a picture."""
    width = 512
    x, y = (2.0 * (np.arange(width) + 0.5) / width - 1.0 for _ in range(2))
    radius, angle = np.hypot(*np.meshgrid(x, y)), np.arctan2(*np.meshgrid(y, x, indexing="ij"))
    inside = np.clip(0.5 + 0.4 * width * np.minimum(0.9 - radius, radius - 0.45 - 0.2 * np.cos(5.0 * angle)), 0.0, 1.0)
    image = bpy.data.images.new("Logo", width, width, alpha=True)
    pixels = np.ones((width, width, 4), np.float32)
    pixels[..., 3] = inside
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


@_scene("logo", "the outline of a picture: a disc with a star cut out")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    image = logo_image()
    _data_lamp(turned(x=80.0, z=15.0, at=(0.0, 0.3, 1.6)), None, source="IMAGE", image=image, image_size=1.8)


@_scene("rabbit", "a network of sines: the add-on's example")
def _(size: int) -> None:
    simple_scenes.boxes_and_sphere(size)
    _data_lamp(turned(z=-70.0, at=(0.0, 0.3, 1.5)), None, source="NETWORK")


# The lamps of the corridor of Huang et al. 2026: an extruded sign, a network, a field of voxels.
IN_CORRIDOR = ("corridor_sign", "corridor_network", "corridor_voxels")
_UNDER_CEILING = dict(at=(0.2, 3.4, 1.85))


@_scene("corridor_sign", "a corridor with an extruded text")
def _(size: int) -> None:
    simple_scenes.corridor(size)
    _object_lamp(turned(x=90.0, z=25.0, **_UNDER_CEILING), _text("EXIT", size=0.4, extrude=0.04))


@_scene("corridor_network", "the same corridor with a network")
def _(size: int) -> None:
    simple_scenes.corridor(size)
    _data_lamp(turned(z=-70.0, **_UNDER_CEILING, scale=(0.4, 0.4, 0.4)), None, source="NETWORK")


@_scene("corridor_voxels", "the same corridor with a mesh as a field of voxels")
def _(size: int) -> None:
    simple_scenes.corridor(size)
    _object_lamp(turned(z=25.0, **_UNDER_CEILING, scale=(0.35, 0.35, 0.35)), _monkey())
