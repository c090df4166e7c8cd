# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: SDF lamps, and Blender's Point, Sun, Spot and Area."""

from __future__ import annotations

import math

import bpy
import numpy as np

from ...affine import inverse
from ...render import lights
from ...render.errors import RenderError
from ...render.lights.area import is_round, sides
from ...render.material import Material
from ...render.scene import MANY_BOUNCES, RGB, Lamp, Light, Portal, Ray
from .. import objects
from ..lamp import LAST_GOOD, keep, last_good, pattern_of, shape_of
from ..passes import own_pass_name
from ..shader_trees import node_tree_of
from .common import FLAT, Warnings, is_flat, rgb
from .images import Images
from .nodes import Reader, emission_of


def light_of(
    obj: bpy.types.Object,
    matrix: np.ndarray,
    visibility: Ray,
    depsgraph: bpy.types.Depsgraph,
    warn: Warnings,
    images: Images,
    owner: np.ndarray | None = None,
    random: float = 0.0,
) -> Lamp | Light | Portal:
    """The lamp, light or portal of a Light object.

    ``matrix`` (4 × 4) is that of the light. ``owner`` is the matrix of the object itself, even for an instance. A
    lamp's nodes use it to find other objects. ``random`` is the random number of Object Info.

    Without ``normalize``, Blender's power is per square metre of the light's surface. Renders of Cycles show this, and
    a test repeats them. Raises RenderError, with a sentence that names the object, if it is unusable.
    """
    data, name = obj.data, obj.name
    color, emission = _color(obj, data, matrix, depsgraph, images, warn, random)
    power = data.energy * 2.0**data.exposure
    if not all(map(math.isfinite, (*color, power))):
        raise RenderError(
            f"Light '{name}' has a power or color that is not a finite number: it is left out; set it again."
        )
    if data.sdf_lamp.use:
        own = matrix if owner is None else owner
        with objects.within(depsgraph):
            return _lamp(name, data, matrix, own, power, color, visibility, depsgraph.mode == "VIEWPORT", warn)
    if getattr(getattr(data, "cycles", None), "is_portal", False) and data.type == "AREA":
        return Portal(name, matrix, is_round(data), tuple(sides(data).tolist()))
    common = dict(color=color, visibility=visibility, cast_shadow=data.use_shadow, emission=emission)
    return lights.KINDS[data.type].read(data, name, matrix, power, common)


def control(light: Lamp | Light, obj: bpy.types.Object, linking: dict[str, int]) -> None:
    """Set the fields of a lamp or light from its object: linking, passes, shadow catchers, and Cycles' settings of
    the light."""
    for name, value in linking.items():
        setattr(light, name, value)
    data = obj.data
    light.light_group = obj.original.lightgroup
    light.lights_catchers = obj.original.is_shadow_catcher
    light.own_pass = own_pass_name(obj.original) if data.sdf_lamp.use_pass else ""
    cycles = getattr(data, "cycles", None)  # exists only while the Cycles add-on is enabled
    light.max_bounces = getattr(cycles, "max_bounces", MANY_BOUNCES)
    if not isinstance(light, Lamp):
        light.sampled_only = not getattr(cycles, "use_multiple_importance_sampling", True)


def _color(
    obj: bpy.types.Object,
    data: bpy.types.Light,
    matrix: np.ndarray,
    depsgraph: bpy.types.Depsgraph,
    images: Images,
    warn: Warnings,
    random: float,
) -> tuple[RGB, Material | None]:
    """Colour of the light, times the colour of its temperature, times the emission of its nodes; and these nodes if
    their emission varies."""
    color = np.array(rgb(data.color))
    if data.use_temperature:
        color *= rgb(data.temperature_color)
    emission = None
    tree = None if data.sdf_lamp.use else node_tree_of(data)
    if tree is not None:
        settings = _settings(obj, data, matrix, random)
        reader = Reader(tree, f"Light '{data.name}'", depsgraph, images, warn, "LIGHT", light=settings)
        factor, emission = emission_of(reader, f"Light '{data.name}'")
        color *= factor
    return rgb(color), emission


def _settings(obj: bpy.types.Object, data: bpy.types.Light, matrix: np.ndarray, random: float) -> dict[str, object]:
    """Data of a light that its nodes read: see ``Reader``."""
    scale = np.maximum(np.linalg.norm(matrix[:3, :3], axis=0), 1e-30)
    unscaled = matrix.copy()
    unscaled[:3, :3] /= scale
    if abs(np.linalg.det(unscaled)) < FLAT:  # it has no object space for look-ups
        unscaled = np.eye(4)
    info = (*matrix[:3, 3], *obj.color, obj.original.pass_index, random)
    return dict(
        light_matrix=inverse(unscaled)[:3],
        light_normals=matrix[:3, :3].T,
        light_shape=lights.KINDS[data.type].nodes_see(data, scale),
        object_info=info,
        owners=(obj, data),
    )


def _lamp(
    name: str,
    data: bpy.types.Light,
    matrix: np.ndarray,
    owner: np.ndarray,
    power: float,
    color: RGB,
    visibility: Ray,
    keeps: bool,
    warn: Warnings,
) -> Lamp:
    """``keeps``: a lamp without a valid shape, for instance while its text is typed, keeps its last good one."""
    if is_flat(matrix):
        raise RenderError(
            f"Lamp '{name}' is scaled to zero, so it has no volume that could glow: it is left out; set its scale."
        )
    lamp = data.sdf_lamp
    try:
        shape, emission = shape_of(lamp, owner), pattern_of(lamp, owner)
        keep(data.original, shape, emission)
    except RenderError as error:
        last = last_good(data.original) if keeps else None
        if last is None:
            raise RenderError(f"Lamp '{name}' is left out. {error}") from error
        shape, emission = last
        warn(f"Lamp '{name}' {LAST_GOOD} {error}")
    visibility = visibility | Ray.CAMERA if lamp.visible_camera else visibility & ~Ray.CAMERA
    density = None if lamp.normalize else lamp.density * 2.0**data.exposure
    return Lamp(
        name, shape, matrix, power, density, color, visibility, emission, camera_brightness=lamp.camera_brightness
    )
