# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a colour, an equirectangular picture that may be rotated, or a node graph of the direction."""

from __future__ import annotations

from dataclasses import replace

import bpy
import mathutils
import numpy as np

from ...render.images import MISSING
from ...render.material import Material
from ...render.passes import Pass
from ...render.scene import MANY_BOUNCES, Mist, Ray, World
from ..shader_trees import node_tree_of
from .aovs import aovs_of
from .common import Warnings, rgb
from .images import Images
from .node_inputs import texture_matrix
from .node_values import numbers_of
from .nodes import Reader, emission_of
from .volumes import medium_of

_RAYS = {
    "camera": Ray.CAMERA,
    "diffuse": Ray.DIFFUSE,
    "glossy": Ray.GLOSSY,
    "transmission": Ray.TRANSMISSION,
    "scatter": Ray.VOLUME,
}


def world_of(
    world: bpy.types.World | None,
    depsgraph: bpy.types.Depsgraph,
    images: Images,
    warn: Warnings,
    passes: list[Pass],
) -> World:
    """The world, with the shader AOVs that are among the ``passes``; black where the scene has none."""
    if world is None:
        return World()
    visibility = Ray.ALL
    for name, ray in _RAYS.items():  # exists only while the Cycles add-on is enabled
        if not getattr(getattr(world, "cycles_visibility", None), name, True):
            visibility &= ~ray
    bounces = getattr(getattr(world, "cycles", None), "max_bounces", MANY_BOUNCES)
    return replace(
        _shaded(world, depsgraph, images, warn, visibility, passes), max_bounces=bounces, light_group=world.lightgroup
    )


def _shaded(
    world: bpy.types.World,
    depsgraph: bpy.types.Depsgraph,
    images: Images,
    warn: Warnings,
    visibility: Ray,
    passes: list[Pass],
) -> World:
    tree = node_tree_of(world)
    if tree is None:
        return World(rgb(world.color), visibility=visibility)
    owner = f"World '{world.name}'"
    reader = Reader(tree, owner, depsgraph, images, warn, "WORLD")
    output = reader.output()
    if output is None:
        return World(visibility=visibility)
    medium = medium_of(reader, output, owner, warn)
    found = _background(reader, output, owner, images, visibility)
    values = aovs_of(tree, reader, passes)
    aovs = Material(owner, None, parameters=reader.parameters, aovs=values) if values else None
    return replace(found, medium=medium, aovs=aovs)


def mist_of(settings: bpy.types.WorldMistSettings) -> Mist:
    """The Mist Pass of a world, as Cycles reads it."""
    power = {"LINEAR": 1.0, "QUADRATIC": 2.0, "INVERSE_QUADRATIC": 0.5}[settings.falloff]
    return Mist(settings.start, settings.depth, power)


def _background(reader: Reader, output, owner: str, images: Images, visibility: Ray) -> World:
    color, emission = emission_of(reader, owner)
    if emission is None:
        return World(rgb(color), visibility=visibility)
    return _picture(reader, output, images, visibility) or World(
        (1.0, 1.0, 1.0), visibility=visibility, emission=emission
    )


def _picture(reader: Reader, output, images: Images, visibility: Ray) -> World | None:
    """A world that is an equirectangular picture, perhaps rotated: sampled by its own pixels. None if it is more than
    that."""
    node, _, stack = reader.resolve(output.inputs["Surface"])
    if node.bl_idname not in {"ShaderNodeBackground", "ShaderNodeEmission"}:
        return None
    strength = numbers_of(reader.parameters, reader.read(node.inputs["Strength"], 1.0, stack))
    texture, _, inner = reader.resolve(node.inputs["Color"], stack)
    if (
        strength is None
        or texture is None
        or texture.bl_idname != "ShaderNodeTexEnvironment"
        or texture.image is None
        or texture.projection != "EQUIRECTANGULAR"
        or texture.interpolation != "Linear"
        or texture_matrix(texture.texture_mapping) is not None
    ):
        return None
    rotation = _rotation(reader, texture.inputs["Vector"], inner)
    if rotation is None:
        return None
    image = images.index(texture.image, texture.image_user)
    return World(MISSING[:3] if image is None else (1.0, 1.0, 1.0), strength, image, rotation, visibility)


def _rotation(reader: Reader, socket, stack) -> np.ndarray | None:
    """Rotation from world directions to the picture's, (3, 3), made by the nodes at a Vector socket; None if they do
    something else."""
    node, output, inner = reader.resolve(socket, stack)
    if node is None:
        return np.eye(3)
    if node.bl_idname == "ShaderNodeMapping":
        angles, scale, location = (
            numbers_of(reader.parameters, reader.read(node.inputs[name], (0.0, 0.0, 0.0), inner))
            for name in ("Rotation", "Scale", "Location")
        )
        before = _rotation(reader, node.inputs["Vector"], inner)
        if (
            angles is None
            or before is None
            or scale != (1.0, 1.0, 1.0)
            or location != (0.0, 0.0, 0.0)
            and node.vector_type in {"POINT", "TEXTURE"}
        ):
            return None
        rotation = np.array(mathutils.Euler(angles, "XYZ").to_matrix(), np.float64)
        return (rotation.T if node.vector_type == "TEXTURE" else rotation) @ before
    is_direction = node.bl_idname == "ShaderNodeTexCoord" and output.identifier in {"Generated", "Object"}
    return np.eye(3) if is_direction and node.object is None else None
