# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images as scene-linear pixels."""

from __future__ import annotations

import functools
import os

import bpy
import mathutils
import numpy as np

from ...render.scene import Image, Scene
from .common import Warnings

# What an image without pixels looks like: nobody overlooks it, and Cycles shows the same.
MISSING = (1.0, 0.0, 1.0, 1.0)

CHUNK = 1 << 15  # numbers that are decoded at a time: few enough for the cache, and a multiple of four

_LINEAR = {"Linear Rec.709", "Linear", "Linear BT.709", "Working Space", "scene_linear"}


class Images:
    """Puts each image into the scene once, or twice where it is wanted with and without its alpha."""

    def __init__(self, scene: Scene, warn: Warnings):
        self._scene, self._warn = scene, warn
        self._known: dict[tuple[int, bool], int] = {}

    def index(self, image: bpy.types.Image, associated: bool = False) -> int:
        """Index of the image in the scene; ``associated``: its colour is multiplied by its alpha, as ``pixels_of``."""
        # The original has the pixels that were painted or generated last; evaluated copies share them or have none.
        image = image.original or image
        key = image.as_pointer(), associated
        if key not in self._known:
            self._scene.images.append(Image(image.name, pixels_of(image, associated, self._warn)))
            self._known[key] = len(self._scene.images) - 1
        return self._known[key]


def has_alpha(image: bpy.types.Image) -> bool:
    """Whether Blender understands the image's alpha as how much of the colour is there."""
    return (image.alpha_mode in {"STRAIGHT", "PREMUL"} and not image.colorspace_settings.is_data
            and (not image.has_data or image.depth in {16, 32, 64, 128}))


def pixels_of(image: bpy.types.Image, associated: bool, warn: Warnings) -> np.ndarray:
    """(height, width, 4) float32, scene-linear, row 0 at the bottom.

    Alpha is straight, or, with ``associated``, multiplied into colour: before sRGB is decoded, as in Cycles.
    """
    if image.source == "TILED":
        warn(f"Image '{image.name}' is made of UDIM tiles, which are not supported: its first tile is used everywhere.")
    elif image.source in {"MOVIE", "SEQUENCE"}:
        warn(f"Image '{image.name}' is a movie or a sequence, which is not supported: "
             "one frame of it is used throughout.")
    count, (width, height) = len(image.pixels), image.size  # asking for pixels loads the file, and so sets the size
    if not count or not width or not height:
        warn(f"Image '{image.name}' has no pixels ({image.filepath or 'no file'}): it is shown in magenta; "
             "find the file with File > External Data > Find Missing Files.")
        return np.array(MISSING, np.float32).reshape(1, 1, 4)
    pixels = _read(image, height, width)
    alpha = pixels[..., 3:]
    if image.is_float:
        # Blender has brought floats to scene-linear already, with colour multiplied by alpha.
        if image.alpha_mode != "CHANNEL_PACKED" and not associated:
            np.divide(pixels[..., :3], alpha, out=pixels[..., :3], where=(alpha > 0.0) & (alpha < 1.0))
    else:
        _linearize(pixels, image, associated, warn)
    if not np.isfinite(pixels).all():
        warn(f"Image '{image.name}' has pixels that are not finite numbers: they are taken as 0.")
        pixels[~np.isfinite(pixels)] = 0.0
    return pixels


def _read(image: bpy.types.Image, height: int, width: int) -> np.ndarray:
    """(height, width, 4) pixels as Blender has them, in the image's encoding if they are bytes."""
    raw = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(raw)
    pixels = raw = raw.reshape(height, width, -1)
    channels = raw.shape[2]
    if channels != 4:
        pixels = np.ones((height, width, 4), np.float32)
        if channels < 3:  # grey, or grey and alpha
            pixels[..., :3] = raw[..., :1]
            pixels[..., 4 - (channels - 1):] = raw[..., 1:]
        else:
            pixels[..., :3] = raw
    if image.alpha_mode == "NONE":
        pixels[..., 3] = 1.0
    return pixels


def _linearize(pixels: np.ndarray, image: bpy.types.Image, associated: bool, warn: Warnings) -> None:
    """From the encoding of an image of bytes to scene-linear, in place."""
    space = image.colorspace_settings
    is_linear = space.is_data or space.name in _LINEAR
    if is_linear or space.name != "sRGB" and _convert(pixels, space.name):
        if associated:
            _associate(pixels)
        return
    if space.name != "sRGB":
        warn(f"Image '{image.name}' is in the colour space {space.name}, which cannot be converted here: "
             "it is taken as sRGB.")
    if associated:
        _associate(pixels)
    _decode_srgb(pixels)


def _associate(pixels: np.ndarray) -> None:
    """Multiply colour by alpha, in place."""
    alpha = pixels[..., 3:]
    if (alpha != 1.0).any():
        pixels[..., :3] *= alpha


def _decode_srgb(pixels: np.ndarray) -> None:
    """Decode the colour of pixels made of bytes, in place."""
    table, flat = _srgb_table(), pixels.reshape(-1)
    for first in range(0, len(flat), CHUNK):
        chunk = flat[first:first + CHUNK]
        alpha = chunk[3::4].copy()
        # Bytes have 256 values, so a table is exact. Alpha goes along because that is faster than leaving it out.
        scaled = chunk * np.float32(255.0)
        scaled += np.float32(0.5)
        np.take(table, scaled.astype(np.uint8), out=chunk, mode="clip")
        chunk[3::4] = alpha


@functools.lru_cache(maxsize=1)
def _srgb_table() -> np.ndarray:
    return np.array([mathutils.Color([i / 255.0] * 3).from_srgb_to_scene_linear().r for i in range(256)], np.float32)


def _convert(pixels: np.ndarray, space: str) -> bool:
    """Convert by OpenColorIO with Blender's configuration; False where OpenImageIO or the colour space is missing."""
    try:
        import OpenImageIO
    except ImportError:
        return False
    config = os.environ.get("OCIO") or os.path.join(
        bpy.utils.resource_path("LOCAL"), "datafiles", "colormanagement", "config.ocio")
    color = np.ascontiguousarray(pixels[..., :3])
    source = OpenImageIO.ImageBuf(color)
    result = OpenImageIO.ImageBufAlgo.colorconvert(source, space, "scene_linear", unpremult=False, colorconfig=config)
    if result.has_error:
        return False
    pixels[..., :3] = result.get_pixels(OpenImageIO.FLOAT)
    return True
