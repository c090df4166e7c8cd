# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of node cases: a grid of tiles in one picture, each an object with its own material.

Values are the light of emissive tiles, in a world without any other light. Every ray goes through the centre of its
pixel, so one sample is enough. Closures are balls, each in an open cell with black walls, so that they do not light
each other, under a wide sun and a grey world. Rays find these lights by any sampling, so few samples are enough to
compare pictures, even of glass. Each world and each light has its own scene.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import dataclass

import bmesh
import bpy
import host
import numpy as np
from mathutils import Euler, Matrix
from scenery.materials import Graph
from scenery.modelling import add, plane

from . import node_data, simple_scenes
from .node_cases import CLOSURE, DISPLACEMENT, LIGHT, RAYS, SCATTERED, VALUE, VOLUME, WORLD, Case
from .node_recipes import BACK, BALL, BOX, PLANE
from .node_specials import SPECIALS
from .node_structures import BARE

# The camera's position, so that axes of world, camera and objects are different.
FRAME = Matrix.Translation((1.3, -2.1, 0.7)) @ Euler((0.5, -0.3, 0.8)).to_matrix().to_4x4()
DEPTH = 9.0  # of the tiles before the camera
# An object's own transform within its tile.
POSE = Euler((0.3, -0.4, 0.35)).to_matrix().to_4x4() @ Matrix.Diagonal((0.8, 1.1, 0.95, 1.0))
SUN = 1.6  # its angle, like a window: few rays through glass would find a small one
BUMPS = 0.05  # of an emissive ball, relative to its radius: its shape is then visible


@dataclass(frozen=True)
class Grid:
    """Position of each case in a picture of tiles of ``size`` pixels per side."""

    cases: tuple[Case, ...]
    columns: int
    size: int

    @property
    def rows(self) -> int:
        return -(-len(self.cases) // self.columns)

    def place(self, index: int) -> tuple[int, int]:
        """Column and row, from the bottom left."""
        return index % self.columns, index // self.columns

    def tile(self, picture: np.ndarray, index: int) -> np.ndarray:
        """Pixels of one case, of a (height, width, …) picture with row 0 at the bottom."""
        column, row = self.place(index)
        return picture[row * self.size : (row + 1) * self.size, column * self.size : (column + 1) * self.size]


def grid_of(cases, size: int) -> Grid:
    return Grid(tuple(cases), max(math.ceil(math.sqrt(len(cases))), 1), size)


def lit(case: Case) -> bool:
    """Whether a case has lights around it, and takes many samples."""
    return case.place in {SCATTERED, CLOSURE, VOLUME, DISPLACEMENT}


def build(grid: Grid) -> tuple[bpy.types.Scene, dict[str, str]]:
    """Open a new file with the cases of a grid, which are all lit, or none is.

    Returns the scene, and the error by the name of each case that cannot be built, which is black.
    """
    case = grid.cases[0]
    if case.place == WORLD:
        return _world(case, grid.size)
    if case.place == LIGHT:
        return _light(case, grid.size)
    scene = _empty(grid)
    meshes = _meshes(smooth=lit(case))
    problems = {}
    for index, case in enumerate(grid.cases):
        try:
            material = material_of(case)
        except Exception as error:  # the others must still be shown
            problems[case.name] = f"{type(error).__name__}: {error}"
            material = bpy.data.materials.new(case.name)
        _place(scene, grid, index, meshes[case.shape], material)
    if lit(case):
        _add_cells(grid)
        _add_lights(grid)
    return scene, problems


def ball(size: int) -> tuple[bpy.types.Scene, bpy.types.Object]:
    """Open a new file with a ball on a floor, as for a closure; the caller supplies the material."""
    case = Case("ShaderNodeBsdfDiffuse", output="BSDF", place=CLOSURE, shape=BALL)
    scene, _ = build(Grid((case,), 1, size))
    return scene, bpy.data.objects["Tile 0"]


@contextlib.contextmanager
def only(grid: Grid, indices: list[int]) -> Iterator[None]:
    """Inside this context, all tiles but these have a plain material."""
    others = (
        [
            bpy.data.objects[f"Tile {index}"].material_slots[0]
            for index in range(len(grid.cases))
            if index not in set(indices)
        ]
        if len(grid.cases) > 1
        else []
    )
    kept = [slot.material for slot in others]
    if others:
        plain = bpy.data.materials.get("Plain") or _diffuse("Plain", 0.5)
    for slot in others:
        slot.material = plain
    try:
        yield
    finally:
        for slot, material in zip(others, kept):
            slot.material = material


@contextlib.contextmanager
def camera_moved(scene, right: float, up: float) -> Iterator[None]:
    """Inside this context, all rays are moved so many pixels to the side."""
    camera, pose = scene.camera.data, scene.camera.matrix_world.copy()
    if camera.type == "PANO":
        step = 2.0 * math.pi / scene.render.resolution_x
        scene.camera.matrix_world = pose @ Euler((up * step, -right * step, 0.0)).to_matrix().to_4x4()
    else:
        step = camera.ortho_scale / scene.render.resolution_x
        scene.camera.matrix_world = pose @ Matrix.Translation((right * step, up * step, 0.0))
    try:
        yield
    finally:
        scene.camera.matrix_world = pose


def settings(scene, engine: str, samples: int, bounces: int, averaged: bool, device: str) -> None:
    """The same settings for both engines. If pixels are not ``averaged``, all rays go through their centres."""
    simple_scenes.plain_cycles(scene, samples, bounces)
    simple_scenes.plain_sdf_lights(scene, samples, bounces, device)
    scene.render.engine = engine
    scene.cycles.use_auto_tile = False
    for owner, name in ((scene.cycles, "volume_bounces"), (scene.sdf_lights, "volume_bounces")):
        if hasattr(owner, name):
            setattr(owner, name, bounces)
    if not averaged:
        scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 0.01
        scene.sdf_lights.filter, scene.sdf_lights.filter_width = "BLACKMAN_HARRIS", 0.01


def _empty(grid: Grid) -> bpy.types.Scene:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    host.register_extension()
    simple_scenes.enable_cycles()
    scene = bpy.context.scene
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.sensor_fit, camera.ortho_scale = "ORTHO", "HORIZONTAL", grid.columns
    camera.clip_start, camera.clip_end = 0.1, 100.0
    thing = add("Camera", camera)
    thing.matrix_world = FRAME
    scene.camera = thing
    scene.render.resolution_x, scene.render.resolution_y = grid.columns * grid.size, grid.rows * grid.size
    scene.render.resolution_percentage = 100
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.frame_set(7)
    scene["scene_number"] = 0.37
    target = add(node_data.TARGET, None)
    target.matrix_world = Matrix.Translation((0.4, 0.2, -0.3)) @ Euler((0.3, 0.2, 0.1)).to_matrix().to_4x4()
    bpy.context.view_layer.update()
    return scene


# -- materials ---------------------------------------------------------------------------------------------------------


def material_of(case: Case) -> bpy.types.Material:
    graph = Graph(case.name)
    material = graph.material
    material.pass_index, material.diffuse_color = 3, (0.0, 0.0, 0.0, 1.0)
    socket = case.build(graph)
    if case.place in {VALUE, RAYS}:
        graph.finish(graph.node("ShaderNodeEmission", Color=socket, Strength=1.0))
        material.cycles.emission_sampling = "NONE"
    elif case.place == SCATTERED:
        glow = graph.node("ShaderNodeEmission", Color=socket, Strength=0.6)
        inside = graph.node(
            "ShaderNodeMixShader",
            _0=0.5,
            _1=graph.node("ShaderNodeBsdfTransparent"),
            _2=graph.node("ShaderNodeBsdfRefraction", IOR=1.1, Roughness=0.1),
        )
        graph.finish(graph.node("ShaderNodeMixShader", _0=0.6, _1=glow, _2=inside))
        material.cycles.emission_sampling = "NONE"
    elif case.place == DISPLACEMENT:
        graph.finish(graph.node("ShaderNodeBsdfDiffuse", Color=(0.7, 0.7, 0.7)))
        output = next(node for node in graph.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
        graph.links.new(socket, output.inputs["Displacement"])
        material.displacement_method = {"of the mesh": "DISPLACEMENT", "of the mesh and bump": "BOTH"}.get(
            case.variant, "BUMP"
        )
    else:
        graph.finish(socket, "Volume" if case.place == VOLUME else "Surface")
    return material


# -- objects -----------------------------------------------------------------------------------------------------------


def _meshes(smooth: bool) -> dict[str, bpy.types.Mesh]:
    """One of each shape, for all tiles: positions in a unit tile, taken back through ``POSE``."""
    ball = _ball(0.42 if smooth else 0.47, 0.0 if smooth else BUMPS)
    bare = ball.copy()
    while bare.uv_layers:
        bare.uv_layers.remove(bare.uv_layers[0])
    return {PLANE: _sheet(False), BACK: _sheet(True), BALL: ball, BARE: bare, BOX: _box()}


def _finished(name: str, work: bmesh.types.BMesh, smooth: bool) -> bpy.types.Mesh:
    """A mesh of positions in a tile, with all attributes of the cases; ``work`` has a UV map."""
    back = POSE.inverted()
    places = np.array([vertex.co for vertex in work.verts])
    for face in work.faces:
        face.smooth = smooth
    work.transform(back)
    mesh = bpy.data.meshes.new(name)
    work.to_mesh(mesh)
    work.free()
    if POSE.determinant() < 0.0:
        mesh.flip_normals()
    _attributes(mesh, places)
    return mesh


def _attributes(mesh: bpy.types.Mesh, places: np.ndarray) -> None:
    def write(name: str, kind: str, domain: str, values, field: str = "value") -> None:
        attribute = mesh.attributes.new(name, kind, domain)
        mesh.attributes[attribute.name].data.foreach_set(field, np.ascontiguousarray(values).ravel())

    x, y, z = places.T
    corners, faces = len(mesh.loops), len(mesh.polygons)
    first = np.empty(2 * corners, np.float32)
    mesh.uv_layers[0].uv.foreach_get("vector", first)
    first = first.reshape(-1, 2)
    second = mesh.uv_layers.new(name=node_data.SECOND_UV)
    second.uv.foreach_set("vector", np.stack([1.7 * first[:, 1], 0.3 - first[:, 0]], axis=1).astype(np.float32).ravel())
    mesh.uv_layers.active = mesh.uv_layers[0]
    mesh.uv_layers[0].active_render = True
    write("Number", "FLOAT", "POINT", (0.4 + x - 0.5 * y).astype(np.float32))
    write("Integer", "INT", "POINT", np.floor(5.0 * (x + y)).astype(np.int32))
    write("Switch", "BOOLEAN", "FACE", np.arange(faces) % 3 == 0)
    write("Number of faces", "FLOAT", "FACE", (0.2 + (np.arange(faces) * 7 % 5) / 5.0).astype(np.float32))
    write(
        "Vector", "FLOAT_VECTOR", "POINT", np.stack([x, y - 0.2, 0.4 + z + x * y], axis=1).astype(np.float32), "vector"
    )
    write("Vector 2D", "FLOAT2", "CORNER", first[:, ::-1].astype(np.float32), "vector")
    shades = np.stack([0.5 + x, 0.5 + y, 0.5 - x * y, 0.6 + 0.4 * x], axis=1).astype(np.float32)
    write(node_data.COLOR_OF_POINTS, "FLOAT_COLOR", "POINT", shades, "color")
    corner = np.clip(np.concatenate([first, 1.0 - first], axis=1), 0.0, 1.0).astype(np.float32)
    write(node_data.COLOR_OF_CORNERS, "BYTE_COLOR", "CORNER", corner, "color")
    colors = mesh.color_attributes
    colors.active_color_index = colors.render_color_index = list(colors.keys()).index(node_data.COLOR_OF_POINTS)
    mesh["data_number"] = 0.83


def _sheet(away: bool) -> bpy.types.Mesh:
    """A square that fills its tile, tilted, of 4 × 5 faces, which face the camera, or face away.

    Because they are not squares, their diagonals go through the centres of few pixels.
    """
    work = bmesh.new()
    bmesh.ops.create_grid(work, x_segments=4, y_segments=5, size=0.5)
    layer = work.loops.layers.uv.new("UVMap")
    for face in work.faces:
        for loop in face.loops:
            loop[layer].uv = loop.vert.co.x + 0.5, loop.vert.co.y + 0.5
    for vertex in work.verts:
        vertex.co.z = 0.21 * vertex.co.x - 0.13 * vertex.co.y
    if away:
        bmesh.ops.reverse_faces(work, faces=work.faces)
    return _finished("Sheet", work, False)


def _ball(radius: float, bumps: float) -> bpy.types.Mesh:
    work = bmesh.new()
    work.loops.layers.uv.new("UVMap")
    bmesh.ops.create_uvsphere(work, u_segments=96, v_segments=48, radius=radius, calc_uvs=True)
    for vertex in work.verts:
        direction = vertex.co.normalized()
        vertex.co *= 1.0 + bumps * math.sin(5.0 * direction.x + 2.0) * math.sin(4.0 * direction.y) * math.cos(
            4.0 * direction.z
        )
    work.transform(Euler((1.1, 0.2, 0.0)).to_matrix().to_4x4())
    return _finished("Ball", work, True)


def _box() -> bpy.types.Mesh:
    """A plate that fills the tile, with a cube on it that shows three of its faces."""
    work = bmesh.new()
    bmesh.ops.create_grid(work, x_segments=1, y_segments=1, size=0.5)
    cube = Matrix.Translation((0.0, 0.0, 0.22)) @ Euler((0.6, 0.5, 0.3)).to_matrix().to_4x4()
    bmesh.ops.create_cube(work, size=0.42, matrix=cube)
    layer = work.loops.layers.uv.new("UVMap")
    for face in work.faces:
        for loop in face.loops:
            loop[layer].uv = loop.vert.co.x + 0.5, loop.vert.co.y + 0.5
    return _finished("Box", work, False)


def _tile_matrix(grid: Grid, index: int) -> Matrix:
    """From a unit tile, with its centre at the origin and +z towards the camera, to the world."""
    column, row = grid.place(index)
    return FRAME @ Matrix.Translation((column + 0.5 - 0.5 * grid.columns, row + 0.5 - 0.5 * grid.rows, -DEPTH))


def _place(scene, grid: Grid, index: int, mesh: bpy.types.Mesh, material: bpy.types.Material) -> None:
    thing = add(f"Tile {index}", mesh)
    if not mesh.materials:
        mesh.materials.append(None)
    thing.material_slots[0].link = "OBJECT"
    thing.material_slots[0].material = material
    lift = Matrix.Translation((0.0, 0.0, 0.46)) if lit(grid.cases[index]) else Matrix()
    thing.matrix_world = _tile_matrix(grid, index) @ lift @ POSE
    thing.color, thing.pass_index = (0.2, 0.5, 0.9, 0.7), 5
    thing["number"], thing["tint"] = 0.71, (0.9, 0.4, 0.2)


# -- what is around objects that are lit -------------------------------------------------------------------------------


def _diffuse(name: str, shade: float) -> bpy.types.Material:
    graph = Graph(name)
    return graph.finish(graph.node("ShaderNodeBsdfDiffuse", Color=(shade, shade, shade)))


def _add_cells(grid: Grid) -> None:
    """A grey floor with black walls between the tiles, as high as tiles are wide."""
    size = (grid.columns, grid.rows)
    flat = add("Floor", plane("Floor", size), _diffuse("Floor", 0.5))
    flat.matrix_world = FRAME @ Matrix.Translation((0.0, 0.0, -DEPTH))
    work = bmesh.new()
    for axis, count in enumerate(size):
        for step in range(count + 1):
            at, half = step - 0.5 * count, 0.5 * size[1 - axis]
            ends = [(at, -half), (at, half)] if axis == 0 else [(-half, at), (half, at)]
            work.faces.new(
                [work.verts.new((*ends[end], height)) for end, height in ((0, 0.0), (1, 0.0), (1, 1.0), (0, 1.0))]
            )
    mesh = bpy.data.meshes.new("Walls")
    work.to_mesh(mesh)
    work.free()
    add("Walls", mesh, _diffuse("Black", 0.0)).matrix_world = flat.matrix_world


def _add_lights(grid: Grid) -> None:
    light = bpy.data.lights.new("Sun", "SUN")
    light.energy, light.angle = 3.0, SUN
    add("Sun", light).matrix_world = FRAME @ Euler((0.3, 0.25, 0.0)).to_matrix().to_4x4()
    world(bpy.context.scene, (0.35, 0.4, 0.45))


def world(scene, shade) -> None:
    scene.world = bpy.data.worlds.new("World")
    graph = Graph(scene.world)
    graph.finish(graph.node("ShaderNodeBackground", Color=shade, Strength=1.0))


def _world(case: Case, size: int) -> tuple[bpy.types.Scene, dict[str, str]]:
    """A camera that sees all directions of a world."""
    scene = _empty(Grid((case,), 2, size))
    camera = scene.camera.data
    camera.type = "PANO"
    owner = camera if hasattr(camera, "panorama_type") else camera.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    scene.render.resolution_x, scene.render.resolution_y = 2 * size, size
    scene.camera.matrix_world = Matrix.Translation((0.3, 0.2, 1.7)) @ Euler((1.4, 0.0, 0.3)).to_matrix().to_4x4()
    scene.world = bpy.data.worlds.new(case.name)
    scene.world.cycles.sampling_method = "NONE"  # nothing is lit by it
    return _alone(scene, scene.world, case)


def _light(case: Case, size: int) -> tuple[bpy.types.Scene, dict[str, str]]:
    """A white floor under a light without a size, whose nodes are examined."""
    scene = _empty(Grid((case,), 1, size))
    floor = add("Floor", plane("Floor", (1.0, 1.0)), _diffuse("White", 0.8))
    floor.matrix_world = FRAME @ Matrix.Translation((0.0, 0.0, -DEPTH))
    special = SPECIALS[case.node]
    light = bpy.data.lights.new(case.name, special.light)
    light.energy, light.color = 2.0, (1.0, 0.8, 0.6)
    if special.light != "SUN":
        light.shadow_soft_size = 0.0
    if special.light == "SPOT":
        light.spot_size = math.radians(120.0)
    pose = Matrix.Translation((0.1, -0.1, 0.35)) @ Euler((0.3, 0.2, 0.5)).to_matrix().to_4x4()
    thing = add("Light", light)
    thing.matrix_world, thing["number"] = floor.matrix_world @ pose, 0.71
    return _alone(scene, light, case)


def _alone(scene, owner, case: Case) -> tuple[bpy.types.Scene, dict[str, str]]:
    try:
        graph = Graph(owner)
        graph.finish(case.build(graph))
    except Exception as error:
        return scene, {case.name: f"{type(error).__name__}: {error}"}
    return scene, {}
