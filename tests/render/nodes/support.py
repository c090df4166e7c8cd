# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One node at a time, with known inputs, in Cycles and as formulas.

A picture has a row for each case and a column for each set of inputs: every pixel is a square of its own, whose inputs
are attributes of that face.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import mathutils
import numpy as np
import OpenImageIO

from sdf_lights.blender.sync.nodes import Reader
from sdf_lights.graph.folding import Folding
from sdf_lights.graph.functions import Function
from sdf_lights.graph.numpy_evaluation import Inputs, evaluate_inputs
from sdf_lights.render.material import Attribute, Table
from sdf_lights.render.scene import Ray

COUNT = 64  # sets of inputs of a case

# Where camera and object stand: anywhere but on the axes of the world, for the nodes that tell.
WORLD = np.array(mathutils.Matrix.LocRotScale((3.0, -2.0, 5.0), mathutils.Euler((0.7, -0.4, 1.9)), None))
OBJECT = WORLD @ np.array(
    mathutils.Matrix.LocRotScale((1.5, 0.5, 0.0), mathutils.Euler((0.3, 0.2, 0.8)), (1.5, 0.75, 2.0))
)
CAMERA_DISTANCE, CLIP_START = 10.0, 0.5  # Cycles' rays begin where the camera clips


@dataclass
class Case:
    """A node with these settings, and the output that is looked at.

    ``inputs`` are by the socket's identifier: a constant, or an array (COUNT,) or (COUNT, 3) to be linked to it, as a
    vector, or as a colour where ``as_colors`` holds. ``prepare(node)`` does what a setting cannot say.
    """

    node: str
    output: str
    inputs: dict = field(default_factory=dict)
    settings: dict = field(default_factory=dict)
    prepare: object = None
    label: str = ""
    as_colors: bool = False

    def __str__(self):
        settings = (f"{name}={value}" for name, value in self.settings.items())
        return " ".join([self.node, *settings, self.output, self.label])


def _linked(case: Case) -> dict[str, tuple[str, np.ndarray]]:
    """Attribute and values of each socket that is linked. Cases share attributes: each has its rows of the mesh."""
    arrays = {socket: value for socket, value in case.inputs.items() if isinstance(value, np.ndarray)}
    return {
        socket: (f"{'number' if value.ndim == 1 else 'vector'} {index}", value)
        for index, (socket, value) in enumerate(arrays.items())
    }


def _by_identifier(sockets, identifier: str):
    return next(socket for socket in sockets if socket.identifier == identifier)


def _material(row: int, case: Case):
    material = bpy.data.materials.new(f"{row}")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(case.node)
    for name, value in case.settings.items():
        setattr(node, name, value)
    if case.prepare:
        case.prepare(node)
    links = _linked(case)
    for identifier, value in case.inputs.items():
        socket = _by_identifier(node.inputs, identifier)
        if identifier in links:
            source = tree.nodes.new("ShaderNodeAttribute")
            source.attribute_name = links[identifier][0]
            output = "Fac" if value.ndim == 1 else "Color" if case.as_colors else "Vector"
            tree.links.new(source.outputs[output], socket)
        elif socket.type == "RGBA":
            socket.default_value = (*value, 1.0)
        else:
            socket.default_value = value
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(_by_identifier(node.outputs, case.output), emission.inputs["Color"])
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material, emission.inputs["Color"]


class Picture:
    """The cases as a scene."""

    def __init__(self, cases: list[Case], working_space: str | None = None):
        self.warnings: list[str] = []
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.cases = cases
        assert len(cases) >= 4, "Blender renders no picture that is less high"
        made = [_material(row, case) for row, case in enumerate(cases)]
        self._sockets = [socket for _, socket in made]
        width, height = COUNT, len(cases)
        x, y = np.meshgrid(np.arange(width) + 0.5 - 0.5 * width, np.arange(height) + 0.5 - 0.5 * height)
        self.middles = np.stack([x, y, 0.0 * x], -1)
        self.backfacing = (np.arange(width) % 2).astype(float)  # of every second column
        corners = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]) * 0.48
        vertices = self.middles[:, :, None] + np.where(self.backfacing[:, None, None] > 0.0, corners[::-1], corners)
        local = np.linalg.inv(OBJECT) @ WORLD
        mesh = bpy.data.meshes.new("Picture")
        flat = vertices.reshape(-1, 3) @ local[:3, :3].T + local[:3, 3]
        mesh.from_pydata(flat.tolist(), [], np.arange(len(flat)).reshape(-1, 4).tolist())
        for material, _ in made:
            mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", np.repeat(np.arange(height), width).astype(np.int32))
        self._add_attributes(mesh)
        item = bpy.data.objects.new("Picture", mesh)
        item.matrix_world = mathutils.Matrix(OBJECT.tolist())
        bpy.context.scene.collection.objects.link(item)
        self._add_camera(width, height)
        if working_space is not None:
            bpy.ops.wm.set_working_color_space(working_space=working_space, convert_colors=False)

    def _add_attributes(self, mesh) -> None:
        values = {}
        for row, case in enumerate(self.cases):
            for name, value in _linked(case).values():
                values.setdefault(name, np.zeros((len(self.cases), *value.shape), np.float32))[row] = value
        for name, array in values.items():
            kind, field_name = ("FLOAT", "value") if array.ndim == 2 else ("FLOAT_VECTOR", "vector")
            mesh.attributes.new(name, kind, "FACE").data.foreach_set(field_name, array.ravel())

    def _add_camera(self, width: int, height: int) -> None:
        data = bpy.data.cameras.new("Camera")
        data.type, data.ortho_scale, data.clip_start = "ORTHO", float(max(width, height)), CLIP_START
        camera = bpy.data.objects.new("Camera", data)
        self.camera = WORLD @ np.array(mathutils.Matrix.Translation((0.0, 0.0, CAMERA_DISTANCE)))
        camera.matrix_world = mathutils.Matrix(self.camera.tolist())
        scene = bpy.context.scene
        scene.collection.objects.link(camera)
        scene.camera = camera
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
        # The scene's matrices are those of the last evaluation.
        bpy.context.view_layer.update()

    def in_cycles(self, folder) -> np.ndarray:
        """(cases, COUNT, 3) what Cycles of this Blender makes of it."""
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.cycles.device, scene.cycles.samples = "CPU", 1
        scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
        scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
        scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0.0
        scene.render.threads_mode, scene.render.threads = "FIXED", 1
        image = scene.render.image_settings
        image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGB"
        scene.render.filepath = str(folder / "picture.exr")
        bpy.ops.render.render(write_still=True)
        pixels = OpenImageIO.ImageBuf(scene.render.filepath).get_pixels(OpenImageIO.FLOAT)
        return pixels[::-1].astype(float)

    def in_formulas(self, folded: bool) -> np.ndarray:
        """(cases, COUNT, 3) what the formulas give; ``folded``: with constants for what is constant."""
        return np.array([self._row(row, folded) for row in range(len(self.cases))])

    def _row(self, row: int, folded: bool) -> np.ndarray:
        socket = self._sockets[row]
        reader = Reader(
            socket.id_data,
            str(self.cases[row]),
            bpy.context.evaluated_depsgraph_get(),
            None,
            self.warnings.append,
        )
        formulas = reader.read(socket, (0.0, 0.0, 0.0))
        numbers = [value if isinstance(value, float) else float(slot) for slot, value in enumerate(reader.parameters)]
        if folded:
            folding = Folding(numbers)
            formulas = tuple(map(folding.fold, formulas))
        inputs = _Pixels(self, row, reader.parameters)
        values = np.stack([np.broadcast_to(v, COUNT) for v in evaluate_inputs(tuple(formulas), inputs, numbers)], -1)
        return np.where(np.isfinite(values), values, 0.0)  # as Cycles' film takes them


class _Pixels(Inputs):
    """The row of a picture: variables, attributes, tables, transforms."""

    def __init__(self, picture: Picture, row: int, parameters: list):
        self._picture, self._row, self._parameters = picture, row, parameters

    def variable(self, name: str, component: int) -> np.ndarray:
        picture = self._picture
        position = picture.middles[self._row] @ WORLD[:3, :3].T + WORLD[:3, 3]
        towards = np.broadcast_to(WORLD[:3, 2], position.shape)
        distance = np.full((COUNT, 1), CAMERA_DISTANCE - CLIP_START)
        zero = np.zeros((COUNT, 5))
        values = dict(
            position=position,
            normal=towards,
            true_normal=towards,
            incoming=towards,
            barycentric=zero,
            backfacing=picture.backfacing[:, None],
            ray_kind=zero + float(Ray.CAMERA),
            ray_singular=zero,
            ray_length=distance,
            depth=zero,
        )
        return values[name][:, component]

    def call(self, function: Function, operands: list) -> tuple:
        if not function.scene:
            return super().call(function, operands)
        return tuple(getattr(self, "_" + function.name)(function.static, *operands))

    def _attribute(self, static, place, u, v):
        found = self._parameters[int(place)]
        assert isinstance(found, Attribute) and found.kind == "geometry"
        values = dict(_linked(self._picture.cases[self._row]).values())
        value = np.asarray(values[found.name], np.float32).astype(float)
        value = np.repeat(value[:, None], 3, 1) if value.ndim == 1 else value
        factor = value[:, 0] if (value == value[:, :1]).all() else value.mean(1)
        return (*value.T, np.ones(COUNT), factor)

    def _table(self, static, start, rows, position):
        columns, extrapolates = static
        table = self._parameters[int(start)]
        assert isinstance(table, Table) and table.values.shape == (int(rows), columns)
        x = np.broadcast_to(position, COUNT) * (rows - 1)
        row = np.clip(np.floor(x), 0, rows - 2).astype(int)
        share = (x if extrapolates else np.clip(x, 0, rows - 1)) - row
        found = table.values[row] + share[:, None] * (table.values[row + 1] - table.values[row])
        return list(np.concatenate([found, np.ones((COUNT, 4 - columns))], 1).T)

    def _moved(self, matrix, vector, point):
        spread = np.stack([np.broadcast_to(axis, COUNT) for axis in vector], -1)
        return spread @ matrix[:3, :3].T + matrix[:3, 3] * point

    def _normal(self, matrix, vector):
        moved = self._moved(np.linalg.inv(matrix).T, vector, 0.0)
        return (moved / np.linalg.norm(moved, axis=1)[:, None]).T

    def _to_object_point(self, static, *vector):
        return self._moved(np.linalg.inv(OBJECT), vector, 1.0).T

    def _to_object_vector(self, static, *vector):
        return self._moved(np.linalg.inv(OBJECT), vector, 0.0).T

    def _to_object_normal(self, static, *vector):
        return self._normal(np.linalg.inv(OBJECT), vector)

    def _from_object_point(self, static, *vector):
        return self._moved(OBJECT, vector, 1.0).T

    def _from_object_vector(self, static, *vector):
        return self._moved(OBJECT, vector, 0.0).T

    def _from_object_normal(self, static, *vector):
        return self._normal(OBJECT, vector)

    def _camera(self):
        return self._picture.camera @ np.diag([1.0, 1.0, -1.0, 1.0])

    def _to_camera_point(self, static, *vector):
        return self._moved(np.linalg.inv(self._camera()), vector, 1.0).T

    def _to_camera_vector(self, static, *vector):
        return self._moved(np.linalg.inv(self._camera()), vector, 0.0).T

    def _from_camera_point(self, static, *vector):
        return self._moved(self._camera(), vector, 1.0).T

    def _from_camera_vector(self, static, *vector):
        return self._moved(self._camera(), vector, 0.0).T
