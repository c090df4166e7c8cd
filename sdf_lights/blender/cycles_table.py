# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table that maps settings of Cycles to settings of this engine.

Sync reads it for scenes from Cycles, and docs/cycles.md prints it. This module imports no bpy.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

from ..frozen import frozen
from ..render.settings import Settings

_LIMITS = {field.name: (field.metadata["minimum"], field.metadata["maximum"]) for field in dataclasses.fields(Settings)}

# From Cycles' source: the difference of halves is compared with 5 times the threshold, the sum of RGB with 3 times the
# clamp.
_THRESHOLD, _CLAMP = 5.0, 3.0
UNLIMITED = _LIMITS["samples"][1]


@frozen
class Row:
    """One setting.

    ``cycles``: names in ``scene.cycles``. ``ours``: the path in ``scene.sdf_lights``, empty if there is none. ``read``
    returns our value from a scene; None copies nothing. ``before_5`` is added to the value before Blender 5.0, where
    Cycles counts differently.
    """

    ours: str
    cycles: tuple[str, ...]
    note: str
    read: Callable[[Any], Any] | None = None
    before_5: int = 0


def _same(name: str) -> Callable:
    return lambda scene: getattr(scene.cycles, name)


def _automatic_threshold(use: bool, threshold: float, samples: int) -> float:
    """Cycles' threshold, or its replacement for 0; 0 if adaptive sampling is off."""
    if not use:
        return 0.0
    return threshold if threshold > 0.0 or samples == 0 else max(0.001, 1.0 / samples)


def _threshold(prefix: str) -> Callable:
    def read(scene):
        cycles = scene.cycles
        return _automatic_threshold(
            getattr(cycles, f"use_{prefix}adaptive_sampling"),
            getattr(cycles, f"{prefix}adaptive_threshold"),
            getattr(cycles, f"{prefix}samples"),
        )

    return read


def _noise_threshold(prefix: str) -> Callable:
    threshold = _threshold(prefix)
    return lambda scene: _THRESHOLD * threshold(scene)


def _min_samples(prefix: str) -> Callable:
    threshold = _threshold(prefix)

    def read(scene):
        given, limit = getattr(scene.cycles, f"{prefix}adaptive_min_samples"), threshold(scene)
        if given == 0 and limit > 0.0:
            given = math.ceil(16.0 / limit**0.3)
        return max(given, 4)

    return read


def _samples(scene) -> int:
    given = scene.cycles.samples
    if not scene.cycles.use_sample_subset:
        return given
    return max(min(given - scene.cycles.sample_offset, scene.cycles.sample_subset_length), 1)


def _sample_offset(scene) -> int:
    return scene.cycles.sample_offset if scene.cycles.use_sample_subset else 0


ROWS = (
    Row(
        "samples",
        ("samples", "use_sample_subset", "sample_subset_length"),
        "With a sample subset, the number of its samples",
        _samples,
    ),
    Row("sample_offset", ("sample_offset",), "0 without a sample subset", _sample_offset),
    Row(
        "noise_threshold",
        ("use_adaptive_sampling", "adaptive_threshold"),
        "5 times as large. Cycles' threshold is a fifth of the same error |I − A| / √I, where A is the mean of half "
        "of the samples (|I − A| / I if the sum of RGB is above 1). 0 if adaptive sampling is off. Cycles' threshold "
        "0 means 1 / samples, at least 0.001",
        _noise_threshold(""),
    ),
    Row(
        "min_samples",
        ("adaptive_min_samples",),
        "0 becomes 16 / threshold^0.3, at least 4, as in Cycles. No pixel here stops before 16 samples",
        _min_samples(""),
    ),
    Row("time_limit", ("time_limit",), "", _same("time_limit")),
    Row("seed", ("seed",), "The patterns differ, so the same seed gives different noise", _same("seed")),
    Row("animate_seed", ("use_animated_seed",), "", _same("use_animated_seed")),
    Row("max_bounces", ("max_bounces",), "", _same("max_bounces")),
    Row("diffuse_bounces", ("diffuse_bounces",), "", _same("diffuse_bounces")),
    Row("glossy_bounces", ("glossy_bounces",), "", _same("glossy_bounces")),
    Row("transmission_bounces", ("transmission_bounces",), "", _same("transmission_bounces")),
    Row("volume_bounces", ("volume_bounces",), "", _same("volume_bounces")),
    Row(
        "transparent_bounces",
        ("transparent_max_bounces",),
        "One more before Blender 5.0, where Cycles passes one more surface",
        _same("transparent_max_bounces"),
        before_5=1,
    ),
    Row(
        "clamp_direct",
        ("sample_clamp_direct",),
        "3 times as large: Cycles clamps the mean of RGB, this engine clamps the sum. 0 is no clamp in both",
        lambda scene: _CLAMP * scene.cycles.sample_clamp_direct,
    ),
    Row(
        "clamp_indirect",
        ("sample_clamp_indirect",),
        "3 times as large, as above. Cycles' default, 10, darkens bright caustics; the default here is 0",
        lambda scene: _CLAMP * scene.cycles.sample_clamp_indirect,
    ),
    Row("caustics_reflective", ("caustics_reflective",), "", _same("caustics_reflective")),
    Row("caustics_refractive", ("caustics_refractive",), "", _same("caustics_refractive")),
    Row(
        "filter_glossy",
        ("blur_glossy",),
        "Cycles' default, 1, blurs glossy reflections in rough surfaces; the default here is 0",
        _same("blur_glossy"),
    ),
    Row("filter", ("pixel_filter_type",), "", _same("pixel_filter_type")),
    Row("filter_width", ("filter_width",), "", _same("filter_width")),
    Row(
        "exposure",
        ("film_exposure",),
        "Exposure and gamma of colour management are Blender's own and apply to both",
        _same("film_exposure"),
    ),
    Row(
        "denoise",
        ("use_denoising",),
        "OpenImageDenoise with albedo and normal. The switch of Cycles in a view layer also counts",
        _same("use_denoising"),
    ),
    Row(
        "layer_samples",
        ("use_layer_samples",),
        "How Blender's `view_layer.samples` overrides the samples of the scene",
        _same("use_layer_samples"),
    ),
    Row(
        "viewport.samples",
        ("preview_samples",),
        f"0 means unlimited and becomes {UNLIMITED}",
        lambda scene: scene.cycles.preview_samples or UNLIMITED,
    ),
    Row(
        "viewport.noise_threshold",
        ("use_preview_adaptive_sampling", "preview_adaptive_threshold"),
        "5 times as large, as above",
        _noise_threshold("preview_"),
    ),
    Row("viewport.min_samples", ("preview_adaptive_min_samples",), "As above", _min_samples("preview_")),
    Row("viewport.denoise", ("use_preview_denoising",), "", _same("use_preview_denoising")),
    Row("", ("light_sampling_threshold",), "Weak light rays are always traced: the mean is the same"),
    Row(
        "",
        ("use_light_tree", "direct_light_sampling_type"),
        "Lights are always chosen by a light tree, and MIS always combines both samplings",
    ),
    Row(
        "",
        (
            "use_guiding",
            "use_deterministic_guiding",
            "use_guiding_direct_light",
            "use_guiding_mis_weights",
            "use_surface_guiding",
            "use_volume_guiding",
            "guiding_directional_sampling_type",
            "guiding_distribution_type",
            "guiding_roughness_threshold",
            "guiding_training_samples",
            "surface_guiding_probability",
            "volume_guiding_probability",
        ),
        "Paths are not guided: the same picture with different noise",
    ),
    Row(
        "",
        (
            "sampling_pattern",
            "scrambling_distance",
            "auto_scrambling_distance",
            "preview_scrambling_distance",
            "use_pixel_jitter",
        ),
        "There is one pattern: the same picture with different noise",
    ),
    Row(
        "",
        ("min_light_bounces", "min_transparent_bounces"),
        "Russian roulette begins at the third bounce: the same picture with different noise",
    ),
    Row(
        "",
        ("use_fast_gi", "fast_gi_method", "ao_bounces", "ao_bounces_render"),
        "Fast GI: light is always traced in full; listed in the scene's report",
    ),
    Row(
        "",
        ("film_transparent_glass", "film_transparent_roughness"),
        "Glass is opaque on a transparent film; listed in the scene's report",
    ),
    Row(
        "",
        ("volume_step_rate", "volume_preview_step_rate", "volume_max_steps", "volume_biased"),
        "No ray marching in volumes",
    ),
    Row(
        "",
        (
            "denoiser",
            "denoising_prefilter",
            "denoising_quality",
            "denoising_input_passes",
            "denoising_use_gpu",
            "preview_denoiser",
            "preview_denoising_prefilter",
            "preview_denoising_quality",
            "preview_denoising_input_passes",
            "preview_denoising_start_sample",
            "preview_denoising_use_gpu",
        ),
        "Always OpenImageDenoise on the processor, in high quality, with albedo and normal",
    ),
    Row(
        "",
        ("dicing_rate", "preview_dicing_rate", "max_subdivisions", "dicing_camera", "offscreen_dicing_scale"),
        "Adaptive subdivision: listed in the scene's report",
    ),
    Row(
        "",
        (
            "use_camera_cull",
            "camera_cull_margin",
            "use_distance_cull",
            "distance_cull_margin",
            "texture_limit",
            "texture_limit_render",
            "texture_resolution",
            "texture_resolution_render",
        ),
        "Read directly, like the rest of Simplify; a viewport culls no objects",
    ),
    Row("", ("rolling_shutter_type", "rolling_shutter_duration"), "Read directly, like the rest of motion blur"),
    Row(
        "",
        ("device", "feature_set", "shading_system", "use_auto_tile", "tile_size", "preview_pause"),
        "This engine has a separate setting of the device",
    ),
)

# Properties of ``scene.cycles`` about baking and the build of Cycles, not about the picture.
UNRELATED = ("bake_", "debug_")


def comes_from(row: Row, scene) -> bool:
    """Whether this Cycles has all properties that the row reads."""
    return row.read is not None and all(hasattr(scene.cycles, name) for name in row.cycles)


def read(scene, blender: tuple[int, ...]) -> dict[str, Any]:
    """Our settings by path, from the Cycles settings of a scene; empty without Cycles. ``blender``: its version, such
    as (5, 2, 0)."""
    if not hasattr(scene, "cycles"):
        return {}
    found = {}
    for row in filter(lambda row: comes_from(row, scene), ROWS):
        value = row.read(scene)
        if row.before_5 and blender < (5, 0):
            value += row.before_5
        minimum, maximum = _LIMITS.get(row.ours.removeprefix("viewport."), (None, None))
        if minimum is not None:
            value = max(value, minimum)
        if maximum is not None:
            value = min(value, maximum)
        found[row.ours] = value
    return found


# -- docs/cycles.md ----------------------------------------------------------------------------------------------------


def table() -> str:
    """The table of settings that are copied."""
    lines = ["| `scene.cycles.` | `scene.sdf_lights.` | |", "|---|---|---|"]
    lines += [f"| {_names(row)} | `{row.ours}` | {row.note} |" for row in ROWS if row.read is not None]
    lines.append(
        "| `scene.render.film_transparent`, `threads_mode`, `threads` | the same | Blender's own, read by both |"
    )
    return "\n".join(lines)


def rest() -> str:
    """The table of settings that are not copied."""
    lines = ["| `scene.cycles.` | here |", "|---|---|"]
    return "\n".join(lines + [f"| {_names(row)} | {row.note} |" for row in ROWS if row.read is None])


def _names(row: Row) -> str:
    return ", ".join(f"`{name}`" for name in row.cycles)
