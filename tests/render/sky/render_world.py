# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles renders panoramas of a world that shows one texture node: ``python render_world.py CASES.json RESULT.npz``.

A case is [bl_idname, {property: value}, view]. Of the properties, "ies" is a text, and "image" the shape of a picture:
see ``pixels_of``. A view is (longitudes from, to, latitudes from, to, width, height). The result holds for case i
"radiance i" and "directions i", both (n, 3).
"""

import json
import pathlib
import sys
import tempfile

import bpy
import numpy as np


def pixels_of(shape):
    values = np.random.default_rng(1).random((*shape, 4)).astype(np.float32) ** 2
    values[..., 3] = 1.0  # what alpha does to colour differs between versions
    return values


def prepare():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    # A narrow filter puts every sample at the centre of its pixel.
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    camera = bpy.data.cameras.new("camera")
    camera.type = "PANO"
    (camera if hasattr(camera, "panorama_type") else camera.cycles).panorama_type = "EQUIRECTANGULAR"
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.rotation_euler = (np.pi / 2.0, 0.0, 0.0)
    scene.collection.objects.link(scene.camera)
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    # No importance map: nothing is lit, and Cycles crashes where it makes one of an IES file.
    scene.world.cycles.sampling_method = "NONE"
    return scene, scene.world.node_tree


def picture(scene, view):
    camera = scene.camera.data
    camera = camera if hasattr(camera, "longitude_min") else camera.cycles
    camera.longitude_min, camera.longitude_max, camera.latitude_min, camera.latitude_max = view[:4]
    scene.render.resolution_x, scene.render.resolution_y = view[4:]
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(pathlib.Path(folder) / "world.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.array(image.pixels[:]).reshape(-1, image.channels)
        bpy.data.images.remove(image)
    return pixels[:, :3]


def directions(scene, tree, view):
    """What the world's shader gets as its direction, told by the shader itself."""
    half = tree.nodes.new("ShaderNodeVectorMath")
    half.operation, half.inputs[1].default_value, half.inputs[2].default_value = (
        "MULTIPLY_ADD",
        (0.5, 0.5, 0.5),
        (0.5, 0.5, 0.5),
    )
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], half.inputs[0])
    tree.links.new(half.outputs[0], tree.nodes["Background"].inputs["Color"])
    found = 2.0 * picture(scene, view).astype(np.float64) - 1.0
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def image_of(shape):
    image = bpy.data.images.new("image", shape[1], shape[0], float_buffer=True)
    image.pixels.foreach_set(pixels_of(shape).ravel())
    image.update()
    return image


def text_of(content):
    text = bpy.data.texts.new("ies")
    text.from_string(content)
    return text


def main(cases, result):
    scene, tree = prepare()
    arrays, known = {}, {}
    for index, (kind, settings, view) in enumerate(json.loads(cases.read_text())):
        view = tuple(view)
        if view not in known:
            known[view] = directions(scene, tree, view)
        node = tree.nodes.new(kind)
        for name, value in settings.items():
            setattr(node, name, {"ies": text_of, "image": image_of}.get(name, lambda same: same)(value))
        if "Vector" in node.inputs:  # some models of skies take none
            tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], node.inputs["Vector"])
        tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])
        arrays[f"radiance {index}"], arrays[f"directions {index}"] = picture(scene, view), known[view]
        tree.nodes.remove(node)
    np.savez(result, **arrays)


if __name__ == "__main__":
    main(*map(pathlib.Path, sys.argv[-2:]))
