# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of image files in the form that renderers use. OpenImageIO reads them in bands, and each band is converted at
once. So an image never takes more memory than its final form. Nothing here calls Blender, so threads can read in
parallel.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator

import numpy as np

from ...frozen import frozen
from ...render.errors import reason_of
from ...render.images import LARGEST

Conversion = Callable[[np.ndarray], np.ndarray]  # converts colours (n, 3) float32

BAND = 1 << 20  # bytes read at a time
CONVERTED_BAND = 1 << 21  # pixels, if colours are converted: the set-up takes as long as a million pixels

_LARGEST_HALF = 65504.0


@frozen
class Form:
    """The conversion of a file's pixels.

    ``drops_alpha``: leave alpha out. ``multiplies``: how often colours are multiplied by alpha. ``conversion``: to
    scene-linear, for colours that are not multiplied by alpha; ``associated``: they are already multiplied by it once.
    """

    drops_alpha: bool = False
    multiplies: int = 0
    associated: bool = False
    conversion: Conversion | None = None

    def dtype(self, source: np.dtype) -> np.dtype:
        """Type of the pixels. Converted integers become halves, which also hold values above 1."""
        return np.dtype("f2") if self.conversion is not None and source.kind == "u" else source

    def channels(self, source: int) -> int:
        """Number of channels kept of a file with ``source`` channels: 1, 3 or 4."""
        if source == 1:
            return 1
        return 3 if source == 3 or self.drops_alpha else 4

    def apply(self, band: np.ndarray) -> np.ndarray:
        """(rows, columns, 1 to 4 channels as stored) as pixels of an ``Image``."""
        dtype = self.dtype(band.dtype)
        if band.shape[2] == 2:  # grey and alpha
            band = band[..., (0, 0, 0, 1)]
        band = band[..., : self.channels(band.shape[2])]
        if self.conversion is not None:
            band = self._converted(band)
        elif band.shape[2] == 4:
            for _ in range(self.multiplies):
                band = _multiplied(band)
        if dtype.kind != "f":
            return band
        finite = np.isfinite(band).all(axis=2)
        if not finite.all():
            band = np.where(finite[..., None], band, band.dtype.type(0.0))
        if band.dtype != dtype:
            band = np.clip(band, -_LARGEST_HALF, _LARGEST_HALF)
        return band.astype(dtype, copy=False)

    def _converted(self, band: np.ndarray) -> np.ndarray:
        values = band.astype(np.float32)
        if band.dtype.kind == "u":
            values /= np.float32(LARGEST[band.dtype])
        colors = np.repeat(values, 3, axis=2) if values.shape[2] == 1 else values[..., :3]
        alpha = values[..., 3:] if values.shape[2] == 4 else np.ones_like(values[..., :1])
        weight = (
            np.where((alpha > 0.0) & (alpha != 1.0), alpha, np.float32(1.0)) if self.associated else np.float32(1.0)
        )
        colors = self.conversion(np.ascontiguousarray(colors / weight).reshape(-1, 3)).reshape(colors.shape)
        if values.shape[2] == 1:
            return colors.mean(axis=2, keepdims=True)
        colors = colors * (weight * alpha**self.multiplies)
        return np.concatenate([colors, alpha], axis=2) if values.shape[2] == 4 else colors


def _multiplied(band: np.ndarray) -> np.ndarray:
    """Colours times alpha. Integers are rounded down, as in Cycles."""
    alpha = band[..., 3:]
    largest = LARGEST[band.dtype]
    if (alpha == largest).all():
        return band
    if band.dtype.kind == "u":
        wide = np.dtype(f"u{2 * band.dtype.itemsize}")
        colors = (band[..., :3].astype(wide) * alpha // wide.type(largest)).astype(band.dtype)
    else:
        colors = (band[..., :3].astype(np.float32) * alpha).astype(band.dtype)
    return np.concatenate([colors, alpha], axis=2)


class File:
    """An image file that OpenImageIO can read. Raises OSError, with its reason, for any other."""

    def __init__(self, path: str):
        import OpenImageIO

        self.path, self._library = path, OpenImageIO
        self._input = self._opened()
        spec = self._input.spec()
        if spec.depth > 1:
            raise OSError("it is a volume")
        self.width, self.height, self.stored_channels = spec.width, spec.height, spec.nchannels
        self.dtype = _dtype(spec)
        self.alpha_is_straight = _alpha_is_straight(spec, self._input.format_name())

    def _opened(self):
        # Otherwise OpenImageIO would multiply by alpha itself, before colours are converted.
        wish = self._library.ImageSpec()
        wish.attribute("oiio:UnassociatedAlpha", 1)
        opened = self._library.ImageInput.open(self.path, wish)
        if opened is None:
            raise OSError(reason_of(self._library, "its format is not known"))
        return opened

    @property
    def channels(self) -> int:
        """Number of channels read from the file, at most 4."""
        return min(self.stored_channels, 4)

    def read(self, form: Form) -> np.ndarray:
        """(height, width, channels) of an ``Image``, row 0 at the bottom. Raises OSError if the file is damaged."""
        result = np.empty((self.height, self.width, form.channels(self.channels)), form.dtype(self.dtype))
        pixels = BAND // (self.channels * self.dtype.itemsize) if form.conversion is None else CONVERTED_BAND
        for first, band in self._bands(max(pixels // self.width, 1)):
            end = first + len(band)
            result[self.height - end : self.height - first] = form.apply(band)[::-1]
        self._input.close()
        return result

    def _bands(self, rows: int) -> Iterator[tuple[int, np.ndarray]]:
        """Rows from the top, with the number of the first."""
        spec, kind = self._input.spec(), self._types()[self.dtype]
        if spec.tile_height:
            rows = max(rows // spec.tile_height, 1) * spec.tile_height
        for first in range(0, self.height, rows):
            top, end = spec.y + first, spec.y + min(first + rows, self.height)
            if spec.tile_width:
                band = self._input.read_tiles(
                    spec.x, spec.x + spec.width, top, end, spec.z, spec.z + 1, 0, self.channels, kind
                )
            else:
                band = self._input.read_scanlines(top, end, spec.z, 0, self.channels, kind)
            if band is None:
                raise OSError(reason_of(self._input, "it ends too early"))
            yield first, np.asarray(band).reshape(end - top, self.width, self.channels)

    def _types(self) -> dict:
        library = self._library
        return {
            np.dtype("u1"): library.UINT8,
            np.dtype("u2"): library.UINT16,
            np.dtype("f2"): library.HALF,
            np.dtype("f4"): library.FLOAT,
        }


def _dtype(spec) -> np.dtype:
    """Type in which an image is stored, by the rule of Cycles."""
    base = str(spec.format)
    if base == "half":
        return np.dtype("f2")
    if base in ("float", "double") or any(str(kind) in ("half", "float", "double") for kind in spec.channelformats):
        return np.dtype("f4")
    return np.dtype("u2") if base == "uint16" else np.dtype("u1")


def _alpha_is_straight(spec, format_name: str) -> bool:
    """Whether colours in a file are not multiplied by alpha."""
    if spec.get_int_attribute("oiio:UnassociatedAlpha", 0):
        return True
    if spec.alpha_channel < 0:
        return False
    # Formats for which OpenImageIO does not report it.
    if format_name == "targa":
        return spec.get_int_attribute("targa:alpha_type", -1) != 4
    return format_name in ("dds", "psd")


def exists(path: str) -> bool:
    """Whether the path is a regular file."""
    return bool(path) and os.path.isfile(path)
