# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Data that nodes need in addition to numbers: pictures, curves, ramps, names of attributes.

A function ``prepare(node, variant)`` gives it to a node; see ``node_recipes``.
"""

from __future__ import annotations

import math
import pathlib

import bpy
import host
import numpy as np

# Datablocks and attributes that ``node_scenes`` makes for these nodes.
TARGET = "Object with coordinates"
SECOND_UV = "Second"
COLOR_OF_POINTS, COLOR_OF_CORNERS = "Color of points", "Color of corners"

# Variants of the Image Texture: how the picture is stored.
IMAGES = (
    "of numbers",
    "of floats",
    "with straight alpha",
    "with premultiplied alpha",
    "with packed channels",
    "without its alpha",
    "of tiles",
    "of none",
    "of a missing file",
)

_OTHERS = "OBJECT", "INSTANCER", "VIEW_LAYER"
# Variants of the Attribute node: name, type.
ATTRIBUTES = {
    "of a number": ("Number", "GEOMETRY"),
    "of an integer": ("Integer", "GEOMETRY"),
    "of a switch": ("Switch", "GEOMETRY"),
    "of a vector": ("Vector", "GEOMETRY"),
    "of a 2D vector": ("Vector 2D", "GEOMETRY"),
    "of faces": ("Number of faces", "GEOMETRY"),
    "of corners": (COLOR_OF_CORNERS, "GEOMETRY"),
    "of points": (COLOR_OF_POINTS, "GEOMETRY"),
    "of the UV map": (SECOND_UV, "GEOMETRY"),
    "of nothing": ("There is none", "GEOMETRY"),
    "of the object": ("number", "OBJECT"),
    "of its color": ("tint", "OBJECT"),
    "of its data": ("data_number", "OBJECT"),
    "of a setting": ("pass_index", "OBJECT"),
    "of the scene": ("scene_number", "VIEW_LAYER"),
    "of the instancer": ("number", "INSTANCER"),
    "without a name": ("", "GEOMETRY"),
    **{f"of nothing of the {kind.lower().replace('_', ' ')}": ("There is none", kind) for kind in _OTHERS},
}


def value(node, variant: str) -> None:
    node.outputs[0].default_value = -1.37


def color(node, variant: str) -> None:
    node.outputs[0].default_value = (0.2, 0.7, 1.3, 0.5)


def normal(node, variant: str) -> None:
    node.outputs["Normal"].default_value = (0.36, -0.48, 0.8)


def curves(node, variant: str) -> None:
    """Curves with handles of all kinds that go beyond [0, 1]; a different one for each component."""
    mapping = node.mapping
    mapping.use_clip = False
    for index, curve in enumerate(mapping.curves):
        low, high = curve.points[0], curve.points[-1]
        low.location, high.location = (low.location[0], 0.1 + 0.05 * index), (high.location[0], 0.9 - 0.07 * index)
        start, width = low.location[0], high.location[0] - low.location[0]
        del low, high  # a new point moves all of them in memory
        for place, (at, to) in enumerate(((0.3, 0.65 - 0.1 * index), (0.6, 0.2 + 0.12 * index), (0.8, 0.7))):
            point = curve.points.new(start + at * width, to)
            point.handle_type = ("AUTO", "VECTOR", "AUTO_CLAMPED")[place]
    if hasattr(mapping, "black_level") and len(mapping.curves) == 4:
        mapping.black_level, mapping.white_level = (0.05, 0.0, 0.02), (0.9, 1.0, 1.1)
    mapping.update()


def ramp(node, variant: str) -> None:
    elements = node.color_ramp.elements
    if variant == "of one stop":
        elements.remove(elements[1])
        elements[0].color, elements[0].position = (0.3, 0.8, 0.1, 0.6), 0.4
        return
    elements[0].color, elements[0].position = (0.9, 0.15, 0.1, 1.0), 0.07
    elements[1].color, elements[1].position = (0.2, 0.3, 0.95, 0.3), 0.93
    places = (0.5, 0.5) if variant == "of two stops at one place" else (0.31, 0.62)
    for place, shade in zip(places, ((0.1, 0.8, 0.3, 0.8), (0.85, 0.8, 0.2, 0.5))):
        elements.new(place).color = shade


def image(node, variant: str) -> None:
    if variant not in ("of none", "clipped, of none"):
        node.image = _picture(variant)
    if variant == "of tiles":
        node.extension = "REPEAT"


def environment(node, variant: str) -> None:
    node.image = panorama()


def sky(node, variant: str) -> None:
    node.sun_disc, node.sun_elevation, node.sun_rotation = False, math.radians(24.0), math.radians(50.0)
    node.sun_direction = (0.5, -0.4, 0.6)


def photometry(node, variant: str) -> None:
    """An IES profile with two planes: candela by the angle from below."""
    text = bpy.data.texts.get("Profile.ies") or bpy.data.texts.new("Profile.ies")
    angles = np.arange(0, 181, 10)
    planes = (0.0, 45.0, 90.0)
    candela = [
        [900.0 * max(math.cos(math.radians(a)), 0.05) ** (1.5 + plane / 45.0) + 30.0 for a in angles]
        for plane in planes
    ]
    lines = [
        "IESNA:LM-63-1995",
        "[TEST] made by script",
        "TILT=NONE",
        f"1 1000 1.0 {len(angles)} {len(planes)} 1 2 0 0 0",
        "1.0 1.0 0.0",
        " ".join(f"{a:g}" for a in angles),
        " ".join(f"{p:g}" for p in planes),
    ]
    lines += [" ".join(f"{c:.3f}" for c in row) for row in candela]
    text.from_string("\n".join(lines) + "\n")
    node.mode, node.ies = "INTERNAL", text


def coordinates(node, variant: str) -> None:
    if variant == "of another object":
        node.object = bpy.data.objects.get(TARGET)


def attribute(node, variant: str) -> None:
    node.attribute_name, node.attribute_type = ATTRIBUTES.get(variant, (COLOR_OF_POINTS, node.attribute_type))


def color_attribute(node, variant: str) -> None:
    node.layer_name = {
        "of corners": COLOR_OF_CORNERS,
        "of the active one": "",
        "of a missing one": "There is none",
    }.get(variant, COLOR_OF_POINTS)


def uv_map(node, variant: str) -> None:
    node.uv_map = {"by name": SECOND_UV, "of a missing one": "There is none"}.get(variant, "")


def tangent(node, variant: str) -> None:
    if variant == "by name":
        node.direction_type, node.uv_map = "UV_MAP", SECOND_UV


def raycast(node, variant: str) -> None:
    pass


# -- pictures ----------------------------------------------------------------------------------------------------------


def _pattern(size: int = 16) -> np.ndarray:
    """(size, size, RGBA) of values that differ from their neighbours', and of which none equals its mirror image."""
    v, u = np.mgrid[0:size, 0:size] / (size - 1.0)
    red = 0.5 + 0.45 * np.sin(9.0 * u + 4.0 * v)
    green = np.where((u > 0.3) ^ (v > 0.6), 0.85, 0.15) * (0.6 + 0.4 * u)
    blue = 0.2 + 0.7 * v * v
    alpha = np.clip(0.25 + 0.9 * (u - 0.4 * v), 0.0, 1.0)
    return np.stack([red, green, blue, alpha], axis=-1).astype(np.float32)


def folder() -> pathlib.Path:
    """Folder of pictures that must be files."""
    path = host.REPOSITORY / "build" / "node_cases"
    path.mkdir(parents=True, exist_ok=True)
    return path


def _picture(variant: str) -> bpy.types.Image:
    name = f"Picture {variant}"
    made = bpy.data.images.get(name)
    if made is not None:
        return made
    if variant == "of tiles":
        return _tiles(name)
    pixels = _pattern()
    floats = variant == "of floats"
    made = bpy.data.images.new(name, 16, 16, alpha=True, float_buffer=floats)
    made.alpha_mode = {
        "with premultiplied alpha": "PREMUL",
        "with packed channels": "CHANNEL_PACKED",
        "without its alpha": "NONE",
    }.get(variant, "STRAIGHT")
    made.colorspace_settings.name = {"of numbers": "Non-Color", "of floats": "Linear Rec.709"}.get(variant, "sRGB")
    if "alpha" not in variant and "packed" not in variant:
        pixels[..., 3] = 1.0
    if floats:
        pixels[..., :3] = 6.0 * pixels[..., :3] - 1.0
    made.pixels.foreach_set(pixels.ravel())
    if variant == "of a missing file":
        made.source, made.filepath = "FILE", str(folder() / "there is no such file.png")
    else:
        made.pack()
    return made


def _tiles(name: str) -> bpy.types.Image:
    """Two adjacent tiles, 1001 and 1002, and one above, as files."""
    whole = folder() / "tiles.<UDIM>.png"
    for number, turn in ((1001, 0), (1002, 1), (1011, 2)):
        part = bpy.data.images.new("Part", 16, 16)
        pixels = np.rot90(_pattern(), turn).copy()
        pixels[..., 3] = 1.0
        part.pixels.foreach_set(pixels.ravel())
        part.filepath_raw, part.file_format = str(whole).replace("<UDIM>", str(number)), "PNG"
        part.save()
        bpy.data.images.remove(part)
    made = bpy.data.images.load(str(whole).replace("<UDIM>", "1001"))
    made.name, made.source = name, "TILED"
    known = {tile.number for tile in made.tiles}
    for number in {1001, 1002, 1011} - known:
        made.tiles.new(tile_number=number)
    return made


def panorama() -> bpy.types.Image:
    """A picture of a sky with a bright sun, and of the ground, with twice as many columns as rows."""
    name = "Panorama"
    if name in bpy.data.images:
        return bpy.data.images[name]
    height, width = 64, 128
    v, u = np.mgrid[0:height, 0:width]
    up = np.sin(np.pi * ((v + 0.5) / height - 0.5))
    around = 2.0 * np.pi * (u + 0.5) / width
    pixels = np.ones((height, width, 4), np.float32)
    sky_shade = np.stack([0.35 + 0.25 * (1.0 - up), 0.5 + 0.2 * (1.0 - up), 0.9 - 0.1 * up], axis=-1)
    ground = np.stack(
        [0.28 + 0.08 * np.sin(5.0 * around), 0.24 + 0.05 * np.cos(3.0 * around), 0.2 + 0.0 * around], axis=-1
    )
    pixels[..., :3] = np.where(up[..., None] > 0.0, sky_shade, ground)
    towards_sun = up * math.sin(0.7) + np.sqrt(1.0 - up * up) * math.cos(0.7) * np.cos(around - 1.1)
    pixels[..., :3] += (12.0 * np.exp((towards_sun - 1.0) / 0.01))[..., None] * np.array([1.0, 0.9, 0.7], np.float32)
    made = bpy.data.images.new(name, width, height, float_buffer=True)
    made.colorspace_settings.name = "Linear Rec.709"
    made.pixels.foreach_set(pixels.ravel())
    made.pack()
    return made
