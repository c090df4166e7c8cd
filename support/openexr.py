# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes as Blender writes them into one OpenEXR file."""

from __future__ import annotations

import pathlib

import numpy as np
import OpenImageIO

ORDER = "XYZWUVRGBArgba"  # of the components of a pass
LOBES = (("Direct", "Color"), ("Indirect", "Color"), ("Dir", "Col"), ("Ind", "Col"))  # names of light and of colour


def read_passes(path: pathlib.Path) -> dict[str, dict[str, np.ndarray]]:
    """{layer: {pass: (height, width, channels)}} of a multilayer file, row 0 at the bottom."""
    found: dict = {}
    image = OpenImageIO.ImageInput.open(str(path))
    part = 0
    while image.seek_subimage(part, 0):
        spec, pixels = image.spec(), image.read_image(OpenImageIO.FLOAT)
        window = np.zeros((spec.full_height, spec.full_width, spec.nchannels), np.float32)
        window[spec.y : spec.y + spec.height, spec.x : spec.x + spec.width] = pixels
        for i, channel in enumerate(spec.channelnames):
            layer, name, component = channel.split(".")[-3:]
            found.setdefault(layer, {}).setdefault(name, []).append((component, window[::-1, :, i]))
        part += 1
    image.close()
    return {
        layer: {
            name: np.stack([values for _, values in sorted(channels, key=lambda item: ORDER.index(item[0]))], -1)
            for name, channels in passes.items()
        }
        for layer, passes in found.items()
    }


def lit(passes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same passes, with the light of each lobe times its colour, as it is in the picture."""
    found = dict(passes)
    for name in passes:
        for light, color in LOBES:
            if name.endswith(light) and name.removesuffix(light) + color in passes:
                found[name] = passes[name] * passes[name.removesuffix(light) + color]
    return found
