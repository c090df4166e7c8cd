# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles renders texture nodes at coordinates that are known: ``python render_textures.py CASES.json RESULT.npy``.

A case is a dictionary: "node" (bl_idname), "settings" (properties), "inputs" (socket: value), "output" (socket),
"origin" and "step" (x, y, z, w). Each is a tile of ``SIZE`` by ``SIZE`` pixels of one picture. At column i and row j,
the coordinates are origin + step · (i, j, i − j, i + j): whole numbers from ``floor``, then arithmetic that single
precision does without rounding if origin and step have few digits. The result is (cases, SIZE, SIZE, 3), row 0 at the
bottom.
"""

import json
import pathlib
import sys
import tempfile

import bpy
import numpy as np

SIZE = 24


def prepare(columns, rows):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", 1, False, False
    cycles.pixel_filter_type, cycles.max_bounces = "BOX", 0
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x, scene.render.resolution_y = columns * SIZE, rows * SIZE
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", max(columns, rows)
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (columns / 2, rows / 2, 1.0)
    scene.collection.objects.link(scene.camera)
    return scene


class Tree:
    def __init__(self, material):
        material.use_nodes = True
        self.nodes, self.links = material.node_tree.nodes, material.node_tree.links
        self.nodes.clear()

    def add(self, kind, inputs=(), **settings):
        node = self.nodes.new(kind)
        for name, value in settings.items():
            setattr(node, name, value)
        for index, value in enumerate(inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.links.new(value, node.inputs[index])
            else:
                node.inputs[index].default_value = value
        return node

    def maths(self, operation, *values):
        return self.add("ShaderNodeMath", values, operation=operation).outputs[0]

    def coordinates(self, origin, step):
        place = self.add("ShaderNodeTexCoord").outputs["Object"]
        x, y, _ = self.add("ShaderNodeSeparateXYZ", [place]).outputs
        i, j = (self.maths("FLOOR", self.maths("MULTIPLY", value, float(SIZE))) for value in (x, y))
        found = [
            self.maths("MULTIPLY_ADD", value, width, start)
            for value, width, start in zip((i, j, self.maths("SUBTRACT", i, j), self.maths("ADD", i, j)), step, origin)
        ]
        return self.add("ShaderNodeCombineXYZ", found[:3]).outputs[0], found[3]


def tile(scene, case, column, row):
    mesh = bpy.data.meshes.new("tile")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new("tile")
    mesh.materials.append(material)
    tree = Tree(material)
    vector, w = tree.coordinates(case["origin"], case["step"])
    node = tree.nodes.new(case["node"])
    for name, value in case["settings"].items():
        setattr(node, name, value)
    inputs = {socket.identifier: socket for socket in node.inputs}
    for name, value in case["inputs"].items():
        inputs[name].default_value = (*value, 1.0) if inputs[name].type == "RGBA" else value
    tree.links.new(vector, inputs["Vector"])
    if "W" in inputs:
        tree.links.new(w, inputs["W"])
    emission = tree.add("ShaderNodeEmission")
    output = next(socket for socket in node.outputs if socket.identifier == case["output"])
    tree.links.new(output, emission.inputs["Color"])
    tree.links.new(emission.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    item = bpy.data.objects.new("tile", mesh)
    item.location = (column, row, 0.0)
    scene.collection.objects.link(item)


def main(cases, result):
    cases = json.loads(cases.read_text())
    columns = int(np.ceil(np.sqrt(len(cases))))
    rows = -(-len(cases) // columns)
    scene = prepare(columns, rows)
    for index, case in enumerate(cases):
        tile(scene, case, index % columns, index // columns)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(pathlib.Path(folder) / "tiles.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(image.size[0] * image.size[1] * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(rows, SIZE, columns, SIZE, -1)[..., :3].swapaxes(1, 2)
    np.save(result, pixels.reshape(-1, SIZE, SIZE, 3)[: len(cases)])


if __name__ == "__main__":
    main(*map(pathlib.Path, sys.argv[-2:]))
