# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of a lamp in other engines: a point light with the volume of the lamp as a ball, and the mean colour
of its pattern.

The size is Blender's own radius, which Blender also draws as a circle. The colour is in the light's nodes, which lamps
do not use here. So the tint of the lamp stays the user's. Both follow the lamp while Blender has a window.
"""

from __future__ import annotations

import functools
import math

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ..render.errors import RenderError
from ..sdf.emission import Emission
from ..sdf.shapes import Shape
from .lamp import pattern_of, shape_of
from .shader_trees import node_tree_of, use_nodes

MARK = "sdf_lights_pattern"  # marks a node of the add-on
DARK = "sdf_lights_dark"  # marks the nodes that replace those of a light without light
_FILLED = 0.3  # part of its box, for a shape whose volume has no closed form
_POINTS = 4096
_CHANGE = 0.01  # relative; a smaller change does not justify an update of the scene
_REST = 0.2  # seconds without a change of the scene before lights are updated


def radius_of(shape: Shape) -> float:
    """Radius in metres of a ball with the volume of the shape. Approximate if the volume has no closed form."""
    volume = shape.volume()
    if volume is None:
        low, high = shape.bounds()
        volume = _FILLED * float(np.prod(np.maximum(high - low, 0.0)))
    return (0.75 * volume / math.pi) ** (1.0 / 3.0) if 0.0 < volume < math.inf else 0.0


@functools.lru_cache(maxsize=256)
def mean_color(shape: Shape, pattern: Emission | None) -> tuple[float, float, float]:
    """Mean (RGB) of a pattern over a shape, scaled so that the mean over the channels is 1."""
    from .viewport.bodies import points_of

    white = (1.0, 1.0, 1.0)
    if pattern is None:
        return white
    low, high = shape.bounds()
    points = np.random.default_rng(0).uniform(low, high, (_POINTS, 3)) if np.isfinite([low, high]).all() else []
    points = points[shape.distance(points) <= 0.0] if len(points) else points_of(shape)
    if len(points) < _POINTS // 100:  # the shape is thin
        points = points_of(shape)
    mean = pattern.placed(shape).evaluate(points).mean(axis=0) if len(points) else np.ones(3)
    return tuple((mean / mean.mean()).tolist()) if np.isfinite(mean).all() and mean.mean() > 0.0 else white


def follow(light: bpy.types.Light) -> None:
    """Update the light to what other engines should see of the lamp."""
    lamp = light.sdf_lamp
    if not lamp.use or not light.is_editable or light.library is not None:
        return
    _set_dark(light, any(scene.sdf_lights.beside is not None for scene in bpy.data.scenes))
    try:
        shape, pattern = shape_of(lamp), pattern_of(lamp)
        radius, color = radius_of(shape), mean_color(shape, pattern)
    except (ArithmeticError, RenderError):
        return  # it keeps its last values
    if hasattr(light, "shadow_soft_size") and abs(radius - light.shadow_soft_size) > _CHANGE * radius > 0.0:
        light.shadow_soft_size = radius
    _set_color(light, np.array(color))


def _set_dark(light: bpy.types.Light, dark: bool) -> None:
    """Let the light give no light in Cycles, or restore its light."""
    tree = node_tree_of(light)
    own = [node for node in tree.nodes if DARK in node.keys()] if tree is not None else []
    if dark == bool(own):
        return
    if dark:
        tree = use_nodes(light) if tree is None else tree
        others = [node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputLight"]
        shader, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputLight")
        shader.inputs["Strength"].default_value = 0.0
        shader.label = output.label = "SDF Lights renders it"
        shader.location, output.location = (0.0, -200.0), (200.0, -200.0)
        shader[DARK] = output[DARK] = True
        tree.links.new(shader.outputs[0], output.inputs["Surface"])
        for other in others:
            other.is_active_output = False
        output.is_active_output = True
        return
    for node in own:
        tree.nodes.remove(node)
    for node in tree.nodes:
        if node.bl_idname == "ShaderNodeOutputLight":
            node.is_active_output = True
            break


def _own_node(light: bpy.types.Light) -> bpy.types.Node | None:
    tree = node_tree_of(light)
    return next((node for node in tree.nodes if MARK in node.keys()), None) if tree is not None else None


def _set_color(light: bpy.types.Light, color: np.ndarray) -> None:
    node = _own_node(light)
    if node is None:
        if np.ptp(color) <= _CHANGE:
            return
        if node_tree_of(light) is None:
            use_nodes(light)
        tree = node_tree_of(light)
        plain = (node for node in tree.nodes if node.bl_idname == "ShaderNodeEmission" and DARK not in node.keys())
        node = next(plain, None)
        foreign = [other for other in tree.nodes if DARK not in other.keys()]
        if node is None or len(foreign) > 2 or any(socket.is_linked for socket in node.inputs):
            return  # the user's nodes
        node[MARK] = True
    strength = float(color.max())
    wanted = (*(color / strength).tolist(), 1.0)
    if np.abs(np.array(node.inputs["Color"].default_value) - wanted).max() > _CHANGE:
        node.inputs["Color"].default_value = wanted
    if abs(node.inputs["Strength"].default_value - strength) > _CHANGE:
        node.inputs["Strength"].default_value = strength


def _follow_all() -> None:
    if bpy.app.is_job_running("RENDER"):  # the scene may not be changed
        bpy.app.timers.register(_follow_all, first_interval=1.0)
        return
    for light in bpy.data.lights:
        follow(light)


@persistent
def _changed(scene, depsgraph):
    kinds = (bpy.types.Light, bpy.types.NodeTree)
    if any(isinstance(update.id, kinds) for update in depsgraph.updates):
        if bpy.app.timers.is_registered(_follow_all):
            bpy.app.timers.unregister(_follow_all)
        bpy.app.timers.register(_follow_all, first_interval=_REST)


CLASSES = ()


def register():
    if not bpy.app.background:
        bpy.app.handlers.depsgraph_update_post.append(_changed)


def unregister():
    if _changed in bpy.app.handlers.depsgraph_update_post:
        bpy.app.handlers.depsgraph_update_post.remove(_changed)
    if bpy.app.timers.is_registered(_follow_all):
        bpy.app.timers.unregister(_follow_all)
    mean_color.cache_clear()
