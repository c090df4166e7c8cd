# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps whose shape is the outline of a picture, extruded."""

from __future__ import annotations

from collections import OrderedDict

import bpy
import numpy as np

from ..graph.tables import Table
from ..render.errors import RenderError
from ..sdf.emission import Emission, in_colours
from ..sdf.shapes import SHAPES, Shape

_KEPT = 16
_PARTS = {"ALPHA": "opaque", "BRIGHT": "bright", "DARK": "dark"}

_outlines: OrderedDict[tuple, object] = OrderedDict()
_colours: OrderedDict[tuple, Table] = OrderedDict()
_shapes: OrderedDict[tuple, Shape] = OrderedDict()  # by that, the width and the thickness


def shape_of(lamp) -> Shape:
    """The shape of a ``Light.sdf_lamp`` that is made from a picture. Raises RenderError with a sentence."""
    image = lamp.image
    if image is None:
        raise RenderError("It has no image: choose one in Shape > Image.")
    image = image.original
    width, height = _size(image)
    key = image.session_uid, image.filepath, width, height, lamp.image_part, lamp.image_threshold
    outline = _outlines.get(key)
    if outline is None:
        outline = _outlines[key] = _outline(image, lamp.image_part, lamp.image_threshold)
        while len(_outlines) > _KEPT:
            _outlines.popitem(last=False)
    _outlines.move_to_end(key)
    if isinstance(outline, str):
        raise RenderError(outline)
    whole = *key, lamp.image_size, lamp.thickness
    if whole not in _shapes:
        _shapes[whole] = _placed(outline, lamp.image_size, lamp.thickness)
        while len(_shapes) > _KEPT:
            _shapes.popitem(last=False)
    _shapes.move_to_end(whole)
    return _shapes[whole]


def _outline(image: bpy.types.Image, part: str, threshold: float):
    """Segments (n, 4) in widths of the picture, around its middle, or a sentence on why there are none."""
    from ..sdf.data.picture import MOST_PIXELS, PictureError, outline_of

    width, height = image.size
    try:
        if width * height > MOST_PIXELS:
            pixels = np.broadcast_to(np.float32(0.0), (height, width, 1))  # refused for its size
        else:
            pixels = _pixels(image)
        return outline_of(pixels, _PARTS[part], threshold)
    except RenderError as error:
        return str(error)
    except PictureError as error:
        return f"Image '{image.name}' {error}."


def _size(image: bpy.types.Image) -> tuple[int, int]:
    width, height = image.size
    if not (width and height):
        raise RenderError(f"Image '{image.name}' has no pixels: its file is missing or cannot be read; find it again.")
    return width, height


def _pixels(image: bpy.types.Image) -> np.ndarray:
    """(height, width, channels) float32, the lowest row first."""
    width, height = image.size
    try:
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
    except (MemoryError, RuntimeError, TypeError):
        raise RenderError(f"Image '{image.name}' cannot be read: find its file again.") from None
    return pixels.reshape(height, width, image.channels)


def colours_of(image: bpy.types.Image) -> Table:
    """The table of the linear colours of an image (``data.texture``). Raises RenderError with a sentence."""
    from ..sdf.data.texture import texture_table
    from .sync import colorspaces

    image = image.original
    width, height = _size(image)
    settings = image.colorspace_settings
    key = image.session_uid, image.filepath, width, height, settings.name
    if key not in _colours:
        pixels = _pixels(image)
        if not image.is_float and pixels.shape[2] > 2 and colorspaces.kind_of(settings) != colorspaces.UNKNOWN:
            colours = np.ascontiguousarray(pixels[..., :3].reshape(-1, 3))
            linear = colorspaces.conversion(settings)(colours)
            pixels[..., :3] = (colours if linear is None else linear).reshape(height, width, 3)
        _colours[key] = texture_table(pixels)
        while len(_colours) > _KEPT:
            _colours.popitem(last=False)
    _colours.move_to_end(key)
    return _colours[key]


def in_own_colours(lamp, pattern: Emission) -> Emission:
    """A pattern in the colours of the picture of a ``Light.sdf_lamp``. Raises RenderError with a sentence."""
    if lamp.image is None:
        return pattern
    table = colours_of(lamp.image)
    width, height = lamp.image.original.size
    return in_colours(pattern, table, lamp.image_size, lamp.image_size * height / width)


def _placed(segments: np.ndarray, size: float, thickness: float) -> Shape:
    from ..sdf.data.outline import Outline, outline_table

    return SHAPES["extrusion"](Outline(outline_table(segments * size)), thickness, 0.0)  # type: ignore[call-arg]


def forget(images: set[int]) -> None:
    """Images, by their identities, have changed."""
    for kept in (_outlines, _colours, _shapes):
        for key in [key for key in kept if key[0] in images]:
            del kept[key]
