# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour spaces of images: those that renderers know, and the conversion of the others to scene-linear."""

from __future__ import annotations

import functools
import os

import bpy
import numpy as np

from ...render.images import decoded
from .pixels import Conversion

LINEAR, SRGB, OTHER, UNKNOWN = "linear", "sRGB", "other", "unknown"

# Names in Blender's own configuration, whose working space has the primaries of Rec.709 unless a file says otherwise.
_KNOWN = {"Linear Rec.709": LINEAR, "sRGB": SRGB}
_DEFAULT_SPACE = "Linear Rec.709"

STEPS = 256  # codes at which a colour space is compared with the known ones


def kind_of(settings: bpy.types.ColorManagedInputColorspaceSettings) -> str:
    """``LINEAR`` (also data), ``SRGB`` with the primaries of the working space, ``OTHER``, or ``UNKNOWN`` if there is
    no conversion."""
    if settings.is_data:
        return LINEAR
    working = _working_space()
    if working in ("", _DEFAULT_SPACE) and not os.environ.get("OCIO") and settings.name in _KNOWN:
        return _KNOWN[settings.name]
    return _kind(settings.name, *_target())


def conversion(settings: bpy.types.ColorManagedInputColorspaceSettings) -> Conversion:
    """Function from colours (n, 3) float32 to scene-linear ones, usable in any thread; not for ``UNKNOWN``."""
    kind = kind_of(settings)
    if kind == LINEAR:
        return lambda colors: colors
    if kind == SRGB:
        return decoded
    return functools.partial(_converted, settings.name, *_target())


def _working_space() -> str:
    """The working space of the open file; "" before Blender 5.0, which has only one."""
    return getattr(getattr(bpy.data, "colorspace", None), "working_space", "")


def _target() -> tuple[str, str]:
    """The colour space of renders, and its configuration."""
    own = os.path.join(bpy.utils.resource_path("LOCAL"), "datafiles", "colormanagement", "config.ocio")
    return _working_space() or "scene_linear", os.environ.get("OCIO") or own


def _converted(space: str, target: str, config: str, colors: np.ndarray) -> np.ndarray | None:
    """OpenColorIO, from OpenImageIO's module; None if that fails."""
    import OpenImageIO

    source = OpenImageIO.ImageBuf(np.ascontiguousarray(colors, np.float32).reshape(1, -1, 3))
    result = OpenImageIO.ImageBufAlgo.colorconvert(source, space, target, unpremult=False, colorconfig=config)
    if result.has_error:
        result.geterror()
        return None
    return result.get_pixels(OpenImageIO.FLOAT).reshape(-1, 3)


@functools.cache
def _kind(space: str, target: str, config: str) -> str:
    codes = np.arange(STEPS, dtype=np.float32) / np.float32(STEPS - 1)
    ramps = np.stack([np.outer(codes, mask) for mask in ((1, 1, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1))]).astype(
        np.float32
    )
    try:
        found = _converted(space, target, config, ramps.reshape(-1, 3))
    except ImportError:
        found = None
    if found is None:
        return _KNOWN.get(space, UNKNOWN)
    found = found.reshape(ramps.shape)
    if np.allclose(found, ramps, rtol=1e-5, atol=1e-6):
        return LINEAR
    return SRGB if np.allclose(found, decoded(ramps), rtol=1e-4, atol=1e-5) else OTHER
