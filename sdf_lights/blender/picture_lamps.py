# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps whose shape is the outline of a picture, extruded."""

from __future__ import annotations

from collections import OrderedDict

import bpy
import numpy as np

from ..render.errors import RenderError
from ..sdf.shapes import SHAPES, Shape

_KEPT = 16
_PARTS = {"ALPHA": "opaque", "BRIGHT": "bright", "DARK": "dark"}

_outlines: OrderedDict[tuple, object] = OrderedDict()
_shapes: OrderedDict[tuple, Shape] = OrderedDict()  # by that, the width and the thickness


def shape_of(lamp) -> Shape:
    """The shape of a ``Light.sdf_lamp`` that is made from a picture. Raises RenderError with a sentence."""
    image = lamp.image
    if image is None:
        raise RenderError("It has no image: choose one in Shape > Image.")
    image = image.original
    width, height = image.size
    if not (width and height):
        raise RenderError(f"Image '{image.name}' has no pixels: its file is missing or cannot be read; find it again.")
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
            pixels = np.empty(width * height * image.channels, np.float32)
            image.pixels.foreach_get(pixels)
            pixels = pixels.reshape(height, width, image.channels)
        return outline_of(pixels, _PARTS[part], threshold)
    except (MemoryError, RuntimeError, TypeError):
        return f"Image '{image.name}' cannot be read: find its file again."
    except PictureError as error:
        return f"Image '{image.name}' {error}."


def _placed(segments: np.ndarray, size: float, thickness: float) -> Shape:
    from ..sdf.data.outline import Outline, outline_table

    return SHAPES["extrusion"](Outline(outline_table(segments * size)), thickness, 0.0)  # type: ignore[call-arg]


def forget(images: set[int]) -> None:
    """Images, by their identities, have changed."""
    for kept in (_outlines, _shapes):
        for key in [key for key in kept if key[0] in images]:
            del kept[key]
