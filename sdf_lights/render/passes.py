# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The render passes: one table for registration with Blender, sampling, storage and output."""

from __future__ import annotations

import enum
from collections.abc import Iterable

from ..frozen import frozen


class Kind(enum.Enum):
    """Blender's kind of a pass, which tells its viewers how to show it."""

    COLOR = "COLOR"
    VECTOR = "VECTOR"
    VALUE = "VALUE"


class Rule(enum.Enum):
    """How the samples of a pixel become its value."""

    MEAN = "MEAN"  # over all samples
    FIRST = "FIRST"  # of the first sample that hit a surface: distances must not be averaged
    NUMBER = "NUMBER"  # of the first sample, 0 if that hit no surface: object numbers must not be averaged
    COMPLEMENT = "COMPLEMENT"  # 1 less the mean over all samples
    COUNT = "COUNT"  # the number of samples
    RATIO = "RATIO"  # of a shadow catcher: its light, over its light without other objects
    WEIGHTED = "WEIGHTED"  # over the samples that have a value: the last column is their number
    MATTE = "MATTE"  # of Cryptomatte: the objects that cover most of the pixel, and their coverage, two per pass


# Sums of the light of parts of Combined, RGB each: light first scattered by such a lobe or by a medium, once or more
# often.
LIGHT_SUMS = (
    "diffuse_direct",
    "diffuse_indirect",
    "glossy_direct",
    "glossy_indirect",
    "transmission_direct",
    "transmission_indirect",
    "volume_direct",
    "volume_indirect",
)
# Sums of the properties of surfaces that the camera sees, and the number of columns of each.
DATA_SUMS = {
    "mist": 1,
    "uv": 3,
    "vector": 5,  # and how many samples have one
    "object_index": 1,
    "material_index": 1,
    "glossy_albedo": 3,
    "transmission_albedo": 3,
    "occlusion": 3,
    # Of shadow catchers: their light without other objects, whether there is one, the light behind it, and the coverage
    # of the rest.
    "bare": 3,
    "caught": 1,
    "backdrop": 3,
    "uncaught": 1,
}
CATCHER_SUMS = ("bare", "caught", "backdrop", "uncaught")


class Owner(enum.Enum):
    """The owner of a pass's switch, in a view layer."""

    BLENDER = "BLENDER"  # Blender itself
    CYCLES = "CYCLES"  # the settings of Cycles
    OWN = "OWN"  # those of this engine


@frozen
class Pass:
    """One pass.

    ``source`` names the sums of the film for the pass (``film.CHANNELS``, ``LIGHT_SUMS``, ``DATA_SUMS``). ``switch``
    names the property of ``owner`` that switches it on; None: always on. ``light``: the exposure of the film applies.
    ``per``: sums of a colour whose mean divides it. ``level``: for a matte, the number of passes before it.
    """

    name: str
    channels: str
    kind: Kind
    rule: Rule
    source: str | None
    switch: str | None
    description: str
    owner: Owner = Owner.BLENDER
    light: bool = False
    per: str | None = None
    level: int = 0


def _lobe(name: str, adjective: str, color: str) -> tuple[Pass, Pass]:
    """Passes of the light first scattered by lobes of a kind."""
    low = name.lower()
    return (
        Pass(
            f"{name} Direct",
            "RGB",
            Kind.COLOR,
            Rule.MEAN,
            f"{low}_direct",
            f"use_pass_{low}_direct",
            f"Light scattered once, by {adjective}, divided by {name} Color",
            light=True,
            per=color,
        ),
        Pass(
            f"{name} Indirect",
            "RGB",
            Kind.COLOR,
            Rule.MEAN,
            f"{low}_indirect",
            f"use_pass_{low}_indirect",
            f"Light scattered several times, the last time before the camera by {adjective}, divided by {name} Color",
            light=True,
            per=color,
        ),
    )


PASSES = (
    Pass("Combined", "RGBA", Kind.COLOR, Rule.MEAN, "combined", None, "The picture", light=True),
    Pass("Depth", "Z", Kind.VALUE, Rule.FIRST, "depth", "use_pass_z", "Distance along the viewing axis, in metres"),
    Pass(
        "Mist",
        "Z",
        Kind.VALUE,
        Rule.COMPLEMENT,
        "mist",
        "use_pass_mist",
        "0 near the camera to 1 far away, by the Mist Pass settings of the world",
    ),
    Pass(
        "Position", "XYZ", Kind.VECTOR, Rule.FIRST, "position", "use_pass_position", "Position in the world, in metres"
    ),
    Pass("Normal", "XYZ", Kind.VECTOR, Rule.MEAN, "normal", "use_pass_normal", "Shading normal in the world"),
    Pass(
        "Vector",
        "XYZW",
        Kind.VECTOR,
        Rule.WEIGHTED,
        "vector",
        "use_pass_vector",
        "Motion in pixels: from here to the previous frame, then from the next frame to here. Zero with Motion Blur",
    ),
    Pass(
        "UV",
        "UVA",
        Kind.VECTOR,
        Rule.MEAN,
        "uv",
        "use_pass_uv",
        "UV map that is active for rendering, and its coverage",
    ),
    Pass(
        "Object Index",
        "X",
        Kind.VALUE,
        Rule.NUMBER,
        "object_index",
        "use_pass_object_index",
        "Pass Index of the object",
    ),
    Pass(
        "Material Index",
        "X",
        Kind.VALUE,
        Rule.NUMBER,
        "material_index",
        "use_pass_material_index",
        "Pass Index of the material",
    ),
    *_lobe("Diffuse", "diffuse, translucent and sheen scattering", "diffuse_albedo"),
    Pass(
        "Diffuse Color",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "diffuse_albedo",
        "use_pass_diffuse_color",
        "Albedo of diffuse, translucent and sheen scattering",
    ),
    *_lobe("Glossy", "reflection", "glossy_albedo"),
    Pass(
        "Glossy Color",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "glossy_albedo",
        "use_pass_glossy_color",
        "Albedo of reflection",
    ),
    *_lobe("Transmission", "refraction", "transmission_albedo"),
    Pass(
        "Transmission Color",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "transmission_albedo",
        "use_pass_transmission_color",
        "Albedo of refraction",
    ),
    Pass(
        "Volume Direct",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "volume_direct",
        "use_pass_volume_direct",
        "Light scattered once, by a volume",
        owner=Owner.CYCLES,
        light=True,
    ),
    Pass(
        "Volume Indirect",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "volume_indirect",
        "use_pass_volume_indirect",
        "Light scattered several times, the last time before the camera by a volume",
        owner=Owner.CYCLES,
        light=True,
    ),
    Pass(
        "Emission",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "emission",
        "use_pass_emit",
        "Light of emissive surfaces, lights and SDF lamps that the camera sees directly",
        light=True,
    ),
    Pass(
        "Environment",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "environment",
        "use_pass_environment",
        "Light of the world that the camera sees directly",
        light=True,
    ),
    Pass(
        "Ambient Occlusion",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "occlusion",
        "use_pass_ambient_occlusion",
        "Fraction of the sky that nearby objects leave visible, within the distance in the world's Ambient Occlusion",
    ),
    Pass(
        "Shadow Catcher",
        "RGB",
        Kind.COLOR,
        Rule.RATIO,
        "bare",
        "use_pass_shadow_catcher",
        "Factor on the light of shadow catchers from the shadows and the light of other objects",
        owner=Owner.CYCLES,
    ),
    Pass(
        "SDF Lamps",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "lamps",
        "use_pass_sdf_lamps",
        "Light of SDF lamps in Combined: seen directly, reflected or refracted",
        owner=Owner.OWN,
        light=True,
    ),
    Pass(
        "Sample Count",
        "X",
        Kind.VALUE,
        Rule.COUNT,
        None,
        "use_pass_sample_count",
        "Samples of the pixel",
        owner=Owner.OWN,
    ),
    Pass(
        "Denoising Normal",
        "XYZ",
        Kind.VECTOR,
        Rule.MEAN,
        "normal",
        "use_pass_denoising_data",
        "Normal, for the denoiser",
        owner=Owner.OWN,
    ),
    Pass(
        "Denoising Albedo",
        "RGB",
        Kind.COLOR,
        Rule.MEAN,
        "albedo",
        "use_pass_denoising_data",
        "Albedo, for the denoiser",
        owner=Owner.OWN,
    ),
    Pass(
        "Noisy Image",
        "RGBA",
        Kind.COLOR,
        Rule.MEAN,
        "combined",
        "use_pass_noisy_image",
        "The picture before denoising",
        owner=Owner.OWN,
        light=True,
    ),
)

BY_NAME = {item.name: item for item in PASSES}
# Names before Blender 5.0, used by compositor nodes and files of that time.
OLD_NAMES = {
    "Emission": "Emit",
    "Environment": "Env",
    "Ambient Occlusion": "AO",
    "Object Index": "IndexOB",
    "Material Index": "IndexMA",
    "Volume Direct": "VolumeDir",
    "Volume Indirect": "VolumeInd",
    **{
        f"{name} {part}": f"{short}{part[:3]}"
        for name, short in (("Diffuse", "Diff"), ("Glossy", "Gloss"), ("Transmission", "Trans"))
        for part in ("Direct", "Indirect", "Color")
    },
}

# Kinds of Cryptomatte, by the objects that they separate, and the names of their passes.
MATTES = {"object": "CryptoObject", "material": "CryptoMaterial", "asset": "CryptoAsset"}
_GROUP, _OWN, _AOV, _MATTE = "group ", "light ", "aov ", "matte "


def light_group_pass(group: str) -> Pass:
    """The pass of a light group."""
    about = f"Light of the light group {group}"
    return Pass(f"Combined_{group}", "RGB", Kind.COLOR, Rule.MEAN, _GROUP + group, None, about, light=True)


def own_pass(name: str) -> Pass:
    """The pass of lights that ask for a pass of this name."""
    return Pass(name, "RGB", Kind.COLOR, Rule.MEAN, _OWN + name, None, f"Light of {name}", light=True)


def aov_pass(name: str, is_value: bool) -> Pass:
    """The pass of a shader AOV."""
    kind = Kind.VALUE if is_value else Kind.COLOR
    return Pass(
        name,
        "X" if is_value else "RGBA",
        kind,
        Rule.MEAN,
        _AOV + name,
        None,
        (f"Values that AOV Output nodes give to {name}"),
    )


def aov_names(passes: Iterable[Pass]) -> list[str]:
    """Names of the shader AOVs among passes."""
    return [source.removeprefix(_AOV) for source in aov_sources(passes)]


def aov_sources(passes: Iterable[Pass]) -> list[str]:
    """The sources of the shader AOVs among passes."""
    return [item.source for item in passes if item.source and item.source.startswith(_AOV)]


def matte_passes(kind: str, depth: int) -> list[Pass]:
    """Passes of a kind of Cryptomatte, for so many objects in a pixel."""
    return [
        Pass(
            f"{MATTES[kind]}{level:02}",
            "rgba",
            Kind.COLOR,
            Rule.MATTE,
            _MATTE + kind,
            None,
            f"Cryptomatte, by {kind}",
            level=level,
        )
        for level in range((min(depth, 16) + 1) // 2)
    ]


def is_light(item: Pass) -> bool:
    """Whether a pass is read from sums of the light of parts of Combined."""
    return item.source is not None and (item.source in LIGHT_SUMS or item.source.startswith((_GROUP, _OWN)))


def data_width(item: Pass) -> int:
    """Number of columns of surface properties that a pass sums; 0: none."""
    if item.source is None:
        return 0
    return len(item.channels) if item.source.startswith(_AOV) else DATA_SUMS.get(item.source, 0)


def matte_of(item: Pass) -> str | None:
    """Kind of Cryptomatte of a pass."""
    return item.source.removeprefix(_MATTE) if item.rule is Rule.MATTE and item.source else None
