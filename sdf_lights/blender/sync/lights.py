# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: SDF lamps, and Blender's Point, Sun, Spot and Area."""

from __future__ import annotations

import math

import bpy
import numpy as np

from ...affine import inverse
from ...render.errors import RenderError
from ...render.material import Material
from ...render.scene import MANY_BOUNCES, RGB, AreaLight, Lamp, Light, PointLight, Portal, Ray, SpotLight, SunLight
from ..lamp import pattern_of, shape_of
from ..passes import own_pass_name
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

    ``owner`` is the matrix of the object itself, from which a lamp's nodes see other objects, where it is an instance.
    ``random`` is the number that Object Info gives.

    Without ``normalize``, Blender's power is that of one square metre of the light's surface (found by renders of
    Cycles: a test repeats them). Raises RenderError, with a sentence that names the object, where it cannot be used.
    """
    data, name = obj.data, obj.name
    color, emission = _color(obj, data, matrix, depsgraph, images, warn, random)
    power = data.energy * 2.0**data.exposure
    if not all(map(math.isfinite, (*color, power))):
        raise RenderError(
            f"Light '{name}' has a power or colour that is not a finite number: it is left out; set it again."
        )
    if data.sdf_lamp.use:
        return _lamp(name, data, matrix, matrix if owner is None else owner, power, color, visibility)
    if getattr(getattr(data, "cycles", None), "is_portal", False) and data.type == "AREA":
        return Portal(name, matrix, data.shape in {"DISK", "ELLIPSE"}, tuple(_sides(data).tolist()))
    common = dict(color=color, visibility=visibility, cast_shadow=data.use_shadow, emission=emission)
    if data.type == "SUN":
        solid = math.pi * math.sin(0.5 * data.angle) ** 2  # ∫ cosine over the sun's disk
        return SunLight(
            name, matrix, power * solid if solid > 0.0 and not data.normalize else power, angle=data.angle, **common
        )
    if data.type == "AREA":
        return _area(name, data, matrix, power, common)
    radius = data.shadow_soft_size
    if not data.normalize:
        power *= 4.0 * math.pi * radius**2 if radius > 0.0 else 4.0
    common |= dict(radius=radius, soft_falloff=data.use_soft_falloff)
    if data.type == "SPOT":
        return SpotLight(name, matrix, power, angle=data.spot_size, blend=data.spot_blend, **common)
    return PointLight(name, matrix, power, **common)


def control(light: Lamp | Light, obj: bpy.types.Object, linking: dict[str, int]) -> None:
    """Give a lamp or light what its object says of what it lights and of its passes, and Cycles' settings of the light."""
    for name, value in linking.items():
        setattr(light, name, value)
    data = obj.data
    light.light_group = obj.original.lightgroup
    light.own_pass = own_pass_name(obj.original) if data.sdf_lamp.use_pass else ""
    cycles = getattr(data, "cycles", None)  # present only while the Cycles add-on is enabled
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
    """Colour of the light, times its temperature's, times what its nodes emit, and these nodes where that varies."""
    color = np.array(rgb(data.color))
    if data.use_temperature:
        color *= rgb(data.temperature_color)
    emission = None
    if data.use_nodes and data.node_tree is not None and not data.sdf_lamp.use:
        settings = _settings(obj, data, matrix, random)
        reader = Reader(data.node_tree, f"Light '{data.name}'", depsgraph, images, warn, "LIGHT", light=settings)
        factor, emission = emission_of(reader, f"Light '{data.name}'")
        color *= factor
    return rgb(color), emission


def _settings(obj: bpy.types.Object, data: bpy.types.Light, matrix: np.ndarray, random: float) -> dict[str, object]:
    """What its nodes ask of a light: see ``Reader``."""
    scale = np.maximum(np.linalg.norm(matrix[:3, :3], axis=0), 1e-30)
    unscaled = matrix.copy()
    unscaled[:3, :3] /= scale
    if abs(np.linalg.det(unscaled)) < FLAT:  # it has no space of its own to look things up in
        unscaled = np.eye(4)
    shape: tuple = ("POINT",)
    if data.type == "SPOT":
        shape = "SPOT", data.spot_size
    elif data.type == "SUN":
        shape = "SUN", data.angle
    elif data.type == "AREA":
        shape = "AREA", *np.maximum(_sides(data) * scale[:2], 1e-30)
    info = (*matrix[:3, 3], *obj.color, obj.original.pass_index, random)
    return dict(
        light_matrix=inverse(unscaled)[:3],
        light_normals=matrix[:3, :3].T,
        light_shape=shape,
        object_info=info,
        owners=(obj, data),
    )


def _sides(data: bpy.types.AreaLight) -> np.ndarray:
    return np.array((data.size, data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size))


def _lamp(
    name: str, data: bpy.types.Light, matrix: np.ndarray, owner: np.ndarray, power: float, color: RGB, visibility: Ray
) -> Lamp:
    if is_flat(matrix):
        raise RenderError(
            f"Lamp '{name}' is scaled to zero, so it has no volume to glow: it is left out; set its scale."
        )
    lamp = data.sdf_lamp
    try:
        shape, emission = shape_of(lamp, owner), pattern_of(lamp, owner)
    except RenderError as error:
        raise RenderError(f"Lamp '{name}' is left out. {error}") from error
    visibility = visibility | Ray.CAMERA if lamp.visible_camera else visibility & ~Ray.CAMERA
    density = None if lamp.normalize else lamp.density * 2.0**data.exposure
    return Lamp(name, shape, matrix, power, density, color, visibility, emission)


def _area(name: str, data: bpy.types.AreaLight, matrix: np.ndarray, power: float, common: dict) -> AreaLight:
    ellipse = data.shape in {"DISK", "ELLIPSE"}
    size = tuple(_sides(data).tolist())
    # Stretched by the object as Blender does it: each axis by its own length.
    stretch = float(np.prod(np.linalg.norm(matrix[:3, :2], axis=0)))
    area = size[0] * size[1] * stretch * (math.pi / 4 if ellipse else 1.0)
    if area <= 0.0:
        raise RenderError(f"Area light '{name}' has no area: it is left out; set its size and its scale.")
    return AreaLight(
        name,
        matrix,
        power if data.normalize else power * area,
        ellipse=ellipse,
        size=size,
        spread=data.spread,
        **common,
    )
