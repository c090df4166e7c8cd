# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What presets of lamps are made of beside their expressions: curves, meshes and pictures, made where they are needed.

A row of ``MAKERS`` for each kind. In the expression of a preset they have the names of its ``sources``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import bmesh
import bpy
import numpy as np

from ..sdf.expression import evaluate
from .presets import Preset

PICTURE = 256  # pixels along each side


def _curve(name: str, about: Mapping) -> bpy.types.Object:
    """A curve through, or with the control points, ``points``, of the spline type ``spline``."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", about.get("bevel", 0.0)
    if about.get("filled", False):
        curve.dimensions, curve.fill_mode = "2D", "BOTH"
    spline = curve.splines.new(about.get("spline", "POLY"))
    spline.points.add(len(about["points"]) - 1)
    for point, place in zip(spline.points, about["points"]):
        point.co = (*place, *(0.0,) * (3 - len(place)), 1.0)
    spline.use_cyclic_u = about.get("closed", False)
    if spline.type == "NURBS":
        spline.use_endpoint_u, spline.order_u = True, 4
    return bpy.data.objects.new(name, curve)


def _monkey(name: str, about: Mapping) -> bpy.types.Object:
    """Blender's monkey, of which half has the size ``size``."""
    mesh, edited = bpy.data.meshes.new(name), bmesh.new()
    bmesh.ops.create_monkey(edited)
    bmesh.ops.scale(edited, verts=edited.verts, vec=(about["size"],) * 3)
    edited.to_mesh(mesh)
    edited.free()
    return bpy.data.objects.new(name, mesh)


def _picture(name: str, about: Mapping) -> bpy.types.Image:
    """A picture of what is inside of shapes in the xy plane, from −1 to 1: ``layers`` of an expression and a colour."""
    image = bpy.data.images.new(name, PICTURE, PICTURE, alpha=True)
    place = (np.arange(PICTURE) + 0.5) * 2.0 / PICTURE - 1.0
    points = np.stack([*np.meshgrid(place, place), np.zeros((PICTURE, PICTURE))], axis=-1)
    pixels = np.zeros((PICTURE, PICTURE, 4), np.float32)
    for expression, color in about["layers"]:
        cover = np.clip(0.5 - evaluate(expression).distance(points) * PICTURE / 2.0, 0.0, 1.0)[..., None]
        alpha = cover + pixels[..., 3:] * (1.0 - cover)
        over = cover * np.array(color) + pixels[..., 3:] * pixels[..., :3] * (1.0 - cover)
        pixels[..., :3], pixels[..., 3:] = np.where(alpha > 0.0, over / np.maximum(alpha, 1e-6), color), alpha
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


MAKERS: dict[str, Callable[[str, Mapping], bpy.types.ID]] = {"curve": _curve, "monkey": _monkey, "picture": _picture}


def with_sources(preset: Preset) -> Preset:
    """The preset with what it needs, made anew, in its texts under the names that this has in the file."""
    expression, emission = preset.expression, preset.emission
    for name, about in preset.sources.items():
        thing = MAKERS[about["kind"]](name, about)
        expression, emission = (text.replace(f'"{name}"', f'"{thing.name}"') for text in (expression, emission))
    return preset._replace(expression=expression, emission=emission, sources={})


def place(things: set[bpy.types.ID], lamp: bpy.types.Object) -> None:
    """Put objects that are nowhere yet beside their lamp, whose children they become: shown as wires and not
    rendered."""
    for thing in things:
        if isinstance(thing, bpy.types.Object) and not thing.users_collection:
            for collection in lamp.users_collection:
                collection.objects.link(thing)
            thing.parent, thing.hide_render, thing.display_type = lamp, True, "WIRE"


def remove(things: set[bpy.types.ID]) -> None:
    """Remove things that are nowhere."""
    for thing in things:
        if isinstance(thing, bpy.types.Image):
            bpy.data.images.remove(thing)
        elif not thing.users_collection:
            blocks = bpy.data.curves if thing.type == "CURVE" else bpy.data.meshes
            data = thing.data
            bpy.data.objects.remove(thing)
            blocks.remove(data)
