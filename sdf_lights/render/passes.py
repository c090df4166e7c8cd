# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The render passes: one table for what is registered with Blender, sampled, stored and written."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Kind(enum.Enum):
    """Blender's kind of a pass, which decides how its viewers show it."""

    COLOR = "COLOR"
    VECTOR = "VECTOR"
    VALUE = "VALUE"


class Rule(enum.Enum):
    """How the samples of a pixel become its value."""

    MEAN = "MEAN"  # over all samples
    SURFACE_MEAN = "SURFACE_MEAN"  # over the samples that met a surface, so edges do not blend with nothing
    FIRST = "FIRST"  # of the first sample that met a surface: distances must not be averaged
    COUNT = "COUNT"  # the number of samples


@dataclass(frozen=True)
class Pass:
    """One pass.

    ``source`` names the sums of the film that it is read from (``film.CHANNELS``). ``switch`` names the property that
    switches it on: of Blender's view layer, or, where ``own`` is true, of the view layer's settings of this engine;
    None: always on. ``light``: the exposure of the film applies.
    """

    name: str
    channels: str
    kind: Kind
    rule: Rule
    source: str | None
    switch: str | None
    description: str
    own: bool = False
    light: bool = False


PASSES = (
    Pass("Combined", "RGBA", Kind.COLOR, Rule.MEAN, "combined", None, "The picture", light=True),
    Pass("Depth", "Z", Kind.VALUE, Rule.FIRST, "depth", "use_pass_z", "Distance along the viewing axis, in metres"),
    Pass(
        "Position", "XYZ", Kind.VECTOR, Rule.FIRST, "position", "use_pass_position", "Position in the world, in metres"
    ),
    Pass("Normal", "XYZ", Kind.VECTOR, Rule.SURFACE_MEAN, "normal", "use_pass_normal", "Shading normal in the world"),
    Pass(
        "Diffuse Color",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "diffuse_albedo",
        "use_pass_diffuse_color",
        "Albedo of diffuse, translucent and sheen scattering",
    ),
    Pass(
        "Emission",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "emission",
        "use_pass_emit",
        "Light of emissive surfaces, SDF lamps and the world that the camera sees directly",
        light=True,
    ),
    Pass(
        "SDF Lamps",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "lamps",
        "use_pass_sdf_lamps",
        "Light of SDF lamps in Combined: seen directly, reflected or refracted",
        own=True,
        light=True,
    ),
    Pass("Sample Count", "X", Kind.VALUE, Rule.COUNT, None, "use_pass_sample_count", "Samples of the pixel", own=True),
    Pass(
        "Denoising Normal",
        "XYZ",
        Kind.VECTOR,
        Rule.MEAN,
        "normal",
        "use_pass_denoising_data",
        "Normal, for the denoiser",
        own=True,
    ),
    Pass(
        "Denoising Albedo",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "albedo",
        "use_pass_denoising_data",
        "Albedo, for the denoiser",
        own=True,
    ),
    Pass(
        "Noisy Image",
        "RGBA",
        Kind.COLOR,
        Rule.MEAN,
        "combined",
        "use_pass_noisy_image",
        "The picture before denoising",
        own=True,
        light=True,
    ),
)

BY_NAME = {item.name: item for item in PASSES}
