# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that move about frame 5, for tests of what motion looks like."""

import math

import bpy


def animate(owner, path: str, *values) -> None:
    """Give a property these values at frames one after the other, of which the middle one is rendered."""
    first = 5 - len(values) // 2
    holder, _, name = path.rpartition(".")
    for frame, value in enumerate(values, first):
        setattr(owner.path_resolve(holder) if holder else owner, name, value)
        owner.keyframe_insert(path, frame=frame)
    action = owner.animation_data.action
    curves = (
        action.fcurves if hasattr(action, "fcurves") else action.layers[0].strips[0].channelbag(action.slots[0]).fcurves
    )
    for curve in curves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def glowing_square(file, add, quad, material, size, samples: int):
    """A glowing square before the camera, which Cycles renders with the same filter; its object."""
    bpy.ops.preferences.addon_enable(module="cycles")
    made, tree, output = material("Glow")
    node = tree.nodes.new("ShaderNodeEmission")
    node.inputs["Strength"].default_value = 3.0
    tree.links.new(node.outputs[0], output)
    mesh = quad()
    mesh.materials.append(made)
    file.camera.data.lens = 35.0
    cycles = file.scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.samples, cycles.pixel_filter_type, cycles.max_bounces = samples, "BOX", 1
    return add("Square", mesh, (0.0, 0.0, 1.0), (math.pi / 2, 0.0, 0.0), size)


def lens(camera, **_):
    """A camera that comes near by its focal length."""
    animate(camera.data, "lens", 25.0, 35.0, 70.0)


def form(shot, **_):
    """A mesh that leans more and more."""
    shot.shape_key_add(name="Basis")
    key = shot.shape_key_add(name="Lean")
    for point in key.data:
        point.co.x += 1.5 * point.co.y
    for frame, value in ((4, 0.0), (5, 0.3), (6, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)


def instances(shot, add, file, **_):
    """Two of a collection that has ``shot``."""
    group = bpy.data.collections.new("Group")
    group.objects.link(shot)
    file.scene.collection.objects.unlink(shot)
    for x in (-1.0, 1.0):
        holder = add(f"Holder {x}", None, (x, 0.0, 0.0))
        holder.instance_type, holder.instance_collection = "COLLECTION", group
        animate(holder, "location", (x, 0.0, 0.0), (x, 0.0, 0.3), (x + 0.5, 0.0, 0.0))
