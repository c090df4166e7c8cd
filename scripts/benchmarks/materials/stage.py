# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene of a material: an object on a floor, under a procedural sky and an area light from the side."""

from __future__ import annotations

import math

import bmesh
import bpy
from mathutils import Vector
from scenery.modelling import add, box, plane, smooth_profile, turned

from .. import node_data, simple_scenes
from .shader import MATERIALS, Shader


def build(name: str, size: int) -> bpy.types.Scene:
    """Open a new file with the scene of one material; a square picture."""
    scene = simple_scenes.empty(size, (0.0, -5.2, 2.3), (0.0, 0.0, 0.92), 30.0)
    _sky(scene)
    _light()
    floor = add("Floor", plane("Floor", (14.0, 14.0)), _floor())
    floor.location = (0.0, 3.0, 0.0)
    entry = MATERIALS[name]
    thing = SHAPES[entry.shape](name)
    thing.data.materials.clear()
    thing.data.materials.append(material_of(name))
    thing.location.z += 0.004  # above the floor, to avoid coincident faces
    bpy.context.view_layer.update()
    return scene


def material_of(name: str) -> bpy.types.Material:
    entry = MATERIALS[name]
    shader = Shader(name.replace("_", " ").capitalize())
    made = entry.build(shader)
    output = shader.nodes.new("ShaderNodeOutputMaterial")
    for socket, place in zip(made if isinstance(made, tuple) else (made,), ("Surface", "Volume", "Displacement")):
        if socket is not None:
            shader.links.new(socket, output.inputs[place])
    return shader.material


def _sky(scene) -> None:
    scene.world = bpy.data.worlds.new("Sky")
    # By default, Cycles uses a map 32 times as wide as the image, for which it needs a second before each render.
    scene.world.cycles.sampling_method, scene.world.cycles.sample_map_resolution = "MANUAL", 256
    shader = Shader(scene.world)
    picture = shader.node("ShaderNodeTexEnvironment")
    picture.node.image = node_data.panorama()
    shader.finish(shader.node("ShaderNodeBackground", Color=picture, Strength=0.6))


def _light() -> None:
    light = bpy.data.lights.new("Window", "AREA")
    light.shape, light.size, light.size_y, light.energy = "RECTANGLE", 1.6, 2.2, 260.0
    thing = add("Window", light, location=(-3.0, -2.4, 3.4))
    thing.rotation_euler = (Vector((0.0, 0.0, 0.8)) - thing.location).to_track_quat("-Z", "Y").to_euler()


def _floor() -> bpy.types.Material:
    shader = Shader("Floor")
    tiles = shader.node(
        "ShaderNodeTexChecker",
        Vector=shader.coordinates("Object"),
        Scale=1.6,
        Color1=(0.42, 0.41, 0.40),
        Color2=(0.30, 0.29, 0.28),
    )
    return shader.finish(shader.node("ShaderNodeBsdfDiffuse", Color=tiles))


def _smooth(thing):
    for face in thing.data.polygons:
        face.use_smooth = True
    return thing


def _ball(name: str):
    work = bmesh.new()
    work.loops.layers.uv.new("UVMap")
    bmesh.ops.create_uvsphere(work, u_segments=96, v_segments=48, radius=1.0, calc_uvs=True)
    return _smooth(_thing(name, work, (0.0, 0.0, 1.0)))


def _thing(name: str, work: bmesh.types.BMesh, location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0)):
    mesh = bpy.data.meshes.new(name)
    work.to_mesh(mesh)
    work.free()
    return add(name, mesh, location=location, rotation=rotation)


def _vase(name: str):
    profile = smooth_profile([(0.0, 0.0), (0.45, 0.0), (0.78, 0.5), (0.62, 1.1), (0.3, 1.5), (0.42, 1.9)], 8)
    return add(name, turned(name, profile, 96))


def _cube(name: str):
    return add(name, box(name, (1.35, 1.35, 1.35), 0.06, 4), location=(0.0, 0.0, 0.68), rotation=(0.0, 0.0, 32.0))


def _wall(name: str):
    """An upright panel that faces the camera a little from the side."""
    return add(name, plane(name, (2.5, 1.9), None), location=(0.0, 0.1, 0.95), rotation=(82.0, 0.0, 18.0))


def _grid(name: str, steps: int, height, size=(2.6, 2.6), location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0)):
    """A sheet of ``steps`` × ``steps`` faces with UVs, whose points are lifted by ``height(x, y)`` of [−1, 1]²."""
    work = bmesh.new()
    bmesh.ops.create_grid(work, x_segments=steps, y_segments=steps, size=1.0)
    layer = work.loops.layers.uv.new("UVMap")
    for face in work.faces:
        for loop in face.loops:
            loop[layer].uv = 0.5 + 0.5 * loop.vert.co.x, 0.5 + 0.5 * loop.vert.co.y
    for vertex in work.verts:
        x, y, _ = vertex.co
        vertex.co = (0.5 * size[0] * x, 0.5 * size[1] * y, height(x, y))
    return _smooth(_thing(name, work, location, rotation))


def _terrain(name: str):
    def height(x, y):
        hills = sum(
            math.sin(a * x + b * y + c) / d
            for a, b, c, d in (
                (3.1, 1.2, 0.3, 3.0),
                (-2.3, 4.4, 1.1, 4.0),
                (6.2, -5.1, 2.0, 9.0),
                (9.4, 8.3, 0.7, 16.0),
            )
        )
        return 0.42 + 0.85 * max(1.0 - x * x - y * y, 0.0) * abs(hills) + 0.1 * hills

    return _grid(name, 72, height, (3.2, 3.2))


def _cloth(name: str):
    return _grid(
        name,
        64,
        lambda x, y: 0.09 * math.sin(5.0 * x + 1.5 * y) + 0.05 * math.sin(7.0 * y - 2.0 * x),
        (2.4, 2.0),
        (0.0, 0.1, 0.95),
        (72.0, 0.0, 12.0),
    )


def _leaf(name: str):
    """A blade that is lit from behind; its vein runs along v."""

    def height(x, y):
        return 0.12 * abs(x) + 0.1 * math.sin(2.0 * y)

    thing = _grid(name, 40, height, (1.0, 2.1), (0.0, 0.0, 1.0), (75.0, 8.0, -14.0))
    for vertex in thing.data.vertices:
        y = vertex.co.y / 1.05
        vertex.co.x *= max(1.0 - abs(y) ** 2.2, 0.0) ** 0.7 * (1.0 - 0.25 * y)
    return thing


def _tube(name: str):
    """Bent glass tube, like a letter."""
    work = bmesh.new()
    layer = work.loops.layers.uv.new("UVMap")
    steps, around, radius = 96, 16, 0.075
    rings = []
    for step in range(steps + 1):
        t = step / steps
        centre = Vector((1.05 * math.cos(2.0 * math.pi * t), 0.0, 0.95 + 0.62 * math.sin(4.0 * math.pi * t)))
        ahead = Vector((-1.05 * math.sin(2.0 * math.pi * t), 0.0, 1.24 * math.cos(4.0 * math.pi * t))).normalized()
        side = Vector((0.0, 1.0, 0.0))
        up = ahead.cross(side)
        rings.append(
            [
                work.verts.new(centre + radius * (math.cos(a) * side + math.sin(a) * up))
                for a in (2.0 * math.pi * i / around for i in range(around))
            ]
        )
    for step in range(steps):
        for i in range(around):
            j = (i + 1) % around
            face = work.faces.new((rings[step][i], rings[step + 1][i], rings[step + 1][j], rings[step][j]))
            for loop, uv in zip(face.loops, ((step, i), (step + 1, i), (step + 1, i + 1), (step, i + 1))):
                loop[layer].uv = uv[0] / steps, uv[1] / around
    bmesh.ops.recalc_face_normals(work, faces=work.faces)
    return _smooth(_thing(name, work))


def _gem(name: str):
    """A cut stone with flat faces."""
    work = bmesh.new()
    bmesh.ops.create_icosphere(work, subdivisions=2, radius=1.0)
    for vertex in work.verts:
        vertex.co.z *= 0.86
    return _thing(name, work, (0.0, 0.0, 0.83), (12.0, 8.0, 20.0))


def _suzanne(name: str):
    work = bmesh.new()
    bmesh.ops.create_monkey(work)
    bmesh.ops.subdivide_edges(work, edges=work.edges, cuts=2, use_grid_fill=True, smooth=1.0)
    thing = _smooth(_thing(name, work, (0.0, 0.0, 0.95), (-12.0, 0.0, 18.0)))
    thing.data.uv_layers.new(name="UVMap")
    return thing


SHAPES = dict(
    ball=_ball,
    vase=_vase,
    cube=_cube,
    wall=_wall,
    terrain=_terrain,
    cloth=_cloth,
    leaf=_leaf,
    tube=_tube,
    gem=_gem,
    head=_suzanne,
)
