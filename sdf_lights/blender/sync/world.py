# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a colour, or an equirectangular picture that may be turned."""

from __future__ import annotations

import bpy
import mathutils
import numpy as np

from ...render.scene import Ray, World
from .common import Warnings, node_tree_of, rgb
from .images import Images
from .nodes import Reader

_RAYS = {
    "camera": Ray.CAMERA, "diffuse": Ray.DIFFUSE, "glossy": Ray.GLOSSY, "transmission": Ray.TRANSMISSION}


def world_of(world: bpy.types.World | None, images: Images, warn: Warnings) -> World:
    """The world; black where the scene has none.

    Understood are a Background (or Emission) node linked to the output, with constants, or with an Environment Texture
    whose Vector is direct or turned by a Mapping node. Whatever else is linked gives way to the socket's own value.
    """
    if world is None:
        return World()
    visibility = Ray.ALL
    for name, ray in _RAYS.items():  # present only while the Cycles add-on is enabled
        if not getattr(getattr(world, "cycles_visibility", None), name, True):
            visibility &= ~ray
    tree = node_tree_of(world)
    if tree is None:
        return World(rgb(world.color), visibility=visibility)
    owner = f"World '{world.name}'"
    reader = Reader(tree, owner, images, warn)
    output = reader.output()
    node, _, stack = (None, None, ()) if output is None else reader.resolve(output.inputs["Surface"])
    if node is None:
        return World(visibility=visibility)
    if node.bl_idname not in {"ShaderNodeBackground", "ShaderNodeEmission"}:
        warn(f"{owner}: only a Background node linked to its output is supported: the world's viewport colour is used.")
        return World(rgb(world.color), visibility=visibility)
    strength = reader.read(node.inputs["Strength"], 1.0, stack)
    if not isinstance(strength, float):
        warn(f"{owner}: a texture on the strength of the background is not supported: the strength is taken as "
             f"{node.inputs['Strength'].default_value:g}.")
        strength = node.inputs["Strength"].default_value
    texture, _, inner = reader.resolve(node.inputs["Color"], stack)
    if texture is not None and texture.bl_idname == "ShaderNodeTexEnvironment" and texture.image is not None:
        if texture.projection == "EQUIRECTANGULAR":
            return World((1.0, 1.0, 1.0), strength, images.index(texture.image),
                         _rotation(reader, texture.inputs["Vector"], inner), visibility)
        reader.report(texture, "mirror ball projection is not supported, so the background has its own colour")
        return World(rgb(node.inputs["Color"].default_value), strength, visibility=visibility)
    color = reader.read(node.inputs["Color"], (0.0, 0.0, 0.0), stack)
    if not isinstance(color, tuple):
        warn(f"{owner}: only an Environment Texture is supported as a picture of the world: "
             "the background has its own colour.")
        color = rgb(node.inputs["Color"].default_value)
    return World(color, strength, visibility=visibility)


def _rotation(reader: Reader, socket, stack) -> np.ndarray:
    """Rotation from world directions to the picture's, (3, 3), that the nodes at a Vector socket make."""
    node, output, inner = reader.resolve(socket, stack)
    if node is None:
        return np.eye(3)
    if node.bl_idname == "ShaderNodeMapping":
        angles, scale, location = (
            reader.read(node.inputs[name], (0.0, 0.0, 0.0), inner) for name in ("Rotation", "Scale", "Location"))
        if not isinstance(angles, tuple):
            reader.report(node, "a texture as rotation is not supported, so nothing is turned")
            angles = (0.0, 0.0, 0.0)
        if scale != (1.0, 1.0, 1.0) or location != (0.0, 0.0, 0.0) and node.vector_type in {"POINT", "TEXTURE"}:
            reader.report(node, "only its rotation is supported")
        rotation = np.array(mathutils.Euler(angles, "XYZ").to_matrix(), np.float64)
        if node.vector_type == "TEXTURE":
            rotation = rotation.T
        return rotation @ _rotation(reader, node.inputs["Vector"], inner)
    is_direction = node.bl_idname == "ShaderNodeTexCoord" and output.identifier in {"Generated", "Object"}
    if not is_direction or node.object is not None:
        reader.report(node, "not supported here, so the picture is not turned by it")
    return np.eye(3)
