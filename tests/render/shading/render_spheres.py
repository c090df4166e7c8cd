# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles renders a sphere of each material: ``python render_spheres.py CASES.json RESULT.json``.

A case is [shader node type, {input or property: value}, light]; the result of each is the mean RGB of the sphere's
disk. The light is null for a white world, or the direction towards a sun of strength π, whose light is seen after one
reflection.
"""

import json
import math
import pathlib
import sys
import tempfile

import bpy
import mathutils
import numpy as np

SIZE, SAMPLES, BOUNCES = 64, 64, 64


def prepare():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", SAMPLES, False, False
    cycles.sample_clamp_indirect = cycles.sample_clamp_direct = cycles.blur_glossy = 0.0
    cycles.min_light_bounces, cycles.max_bounces, cycles.pixel_filter_type = BOUNCES, BOUNCES, "BOX"
    for kind in ("diffuse", "glossy", "transmission"):
        setattr(cycles, kind + "_bounces", BOUNCES)
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.film_transparent = True
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.world = bpy.data.worlds.new("white")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (1.0, 1.0, 1.0, 1.0), 1.0
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", 2.0
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (0.0, 0.0, 10.0)
    scene.collection.objects.link(scene.camera)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=512, ring_count=256, radius=1.0)
    bpy.ops.object.shade_smooth()
    material = bpy.data.materials.new("material")
    material.use_nodes = True
    bpy.context.object.data.materials.append(material)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle = math.pi, 0.0
    scene.collection.objects.link(sun)
    return scene, material.node_tree, sun, background


def illuminate(scene, sun, background, light):
    """A white world, or where a direction is given a sun and no light that is reflected twice."""
    sun.hide_render = light is None
    background.inputs["Strength"].default_value = 1.0 if light is None else 0.0
    scene.cycles.max_bounces = BOUNCES if light is None else 0
    if light is not None:
        sun.rotation_euler = mathutils.Vector(light).to_track_quat("Z", "Y").to_euler()


def render(scene, tree, kind, inputs, folder):
    tree.nodes.clear()
    output, node = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(kind)
    for name, value in inputs.items():
        if name[0].islower():
            setattr(node, name, value)
        elif name == "Tangent":
            tangent = tree.nodes.new("ShaderNodeTangent")
            tangent.axis = value
            tree.links.new(tangent.outputs[0], node.inputs[name])
        elif isinstance(value, list) and node.inputs[name].type == "RGBA":
            node.inputs[name].default_value = (*value, 1.0)
        else:
            node.inputs[name].default_value = value
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    scene.render.filepath = str(folder / "sphere.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(image.pixels[:]).reshape(SIZE, SIZE, 4)
    bpy.data.images.remove(image)
    return (pixels[..., :3].sum(axis=(0, 1)) / pixels[..., 3].sum()).tolist()


if __name__ == "__main__":
    cases, result = (pathlib.Path(name) for name in sys.argv[-2:])
    scene, tree, sun, background = prepare()
    means = []
    with tempfile.TemporaryDirectory() as folder:
        for kind, inputs, light in json.loads(cases.read_text()):
            illuminate(scene, sun, background, light)
            means.append(render(scene, tree, kind, inputs, pathlib.Path(folder)))
    result.write_text(json.dumps(means))
