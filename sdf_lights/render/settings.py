# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of a render. The UI properties of ``scene.sdf_lights`` are generated from these fields."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

# Number of branches of a path: the maximum, and the number until the noise of pixels is known.
MOST_BRANCHES, START_BRANCHES = 16, 4
LARGEST_BATCH = 32  # samples between two decisions


class Device(enum.Enum):
    """The device: ``AUTOMATIC`` is the CPU if Numba is available, else the NumPy reference."""

    AUTOMATIC = "AUTOMATIC"
    CPU = "CPU"
    REFERENCE = "REFERENCE"
    GPU = "GPU"


class LampSampling(enum.Enum):
    """Sampling of light rays towards SDF lamps. All except ``CUT`` are for comparison; no panel shows them."""

    CUT = "CUT"  # in proportion to the light that parts of the lamp give the point (emitter/sampling/cut.py)
    MIS = "MIS"  # points of the interior, combined with BSDF rays by the balance heuristic (Huang et al. 2026)
    PROJECTION = "PROJECTION"  # points of the interior; BSDF rays count only if the BSDF is glossy
    # the sampler registered with emitter/sampling/external.py; else as PROJECTION. Only on the CPU
    EXTERNAL = "EXTERNAL"
    BSDF = "BSDF"  # no light rays


class LampPaths(enum.Enum):
    """Whether paths from SDF lamps help those from the camera (docs/sampling.md)."""

    AUTOMATIC = "AUTOMATIC"  # in final renders, where the first samples show that it pays
    ALWAYS = "ALWAYS"  # where the scene can have it
    NEVER = "NEVER"


class PathReuse(enum.Enum):
    """Whether paths of neighbouring pixels share their branches (docs/sampling.md)."""

    AUTOMATIC = "AUTOMATIC"  # in final renders without denoising, where the first samples show that it pays
    ALWAYS = "ALWAYS"  # where the scene can have it
    NEVER = "NEVER"


class CausticPaths(enum.Enum):
    """Whether paths from SDF lamps by way of mirrors and glass are connected to the camera (docs/sampling.md)."""

    AUTOMATIC = "AUTOMATIC"  # in final renders, where the first paths show that it pays
    ALWAYS = "ALWAYS"  # in final renders, where the scene can have it
    NEVER = "NEVER"


class Filter(enum.Enum):
    """Pixel filters, as in Cycles."""

    BOX = "BOX"
    GAUSSIAN = "GAUSSIAN"
    BLACKMAN_HARRIS = "BLACKMAN_HARRIS"


def _setting(
    default, description: str, minimum=None, maximum=None, unit: str = "", label: str = "", developer: bool = False
):
    """A field of ``Settings``. A ``developer`` field is in no panel and no document for artists."""
    return field(
        default=default,
        metadata=dict(
            description=description, minimum=minimum, maximum=maximum, unit=unit, label=label, developer=developer
        ),
    )


@dataclass
class Settings:
    """Settings of a render. The metadata of a field (tooltip, limits, unit, label) make the UI and docs/settings.md."""

    device: Device = _setting(Device.AUTOMATIC, "Device that renders. Automatic is the CPU, which samples lamps better")
    lamp_sampling: LampSampling = _setting(
        LampSampling.CUT,
        "Sampling of light from SDF lamps. Cut is the default; the others are for comparison",
        developer=True,
    )
    samples: int = _setting(
        128, "Maximum number of samples per pixel. With guided samples, the mean number", 1, 1 << 24
    )
    noise_threshold: float = _setting(
        0.01, "Relative error at which a pixel gets no more samples. 0 gives every pixel all samples", 0.0, 1.0
    )
    min_samples: int = _setting(16, "Number of samples per pixel before the noise threshold is tested", 1, 4096)
    time_limit: float = _setting(0.0, "Time in seconds after which the render stops. 0 is no limit", 0.0, None, "TIME")
    seed: int = _setting(
        0, "Seed of the sampling pattern. The same seed gives the same picture, bit for bit", 0, (1 << 31) - 1
    )
    animate_seed: bool = _setting(True, "Use a different seed for each frame", label="Animate Seed")
    sample_offset: int = _setting(
        0,
        "Number of samples of the same picture to leave out before the first. Several machines can render the same "
        "seed with adjoining ranges; scripts/merge joins their files",
        0,
        1 << 24,
    )
    max_bounces: int = _setting(12, "Maximum number of bounces of all kinds together", 0, 1024)
    diffuse_bounces: int = _setting(4, "Maximum number of diffuse bounces", 0, 1024)
    glossy_bounces: int = _setting(4, "Maximum number of glossy bounces", 0, 1024)
    transmission_bounces: int = _setting(12, "Maximum number of bounces through glass", 0, 1024)
    volume_bounces: int = _setting(
        0, "Maximum number of times that a volume scatters light again, after the first time", 0, 1024
    )
    transparent_bounces: int = _setting(8, "Maximum number of transparent surfaces that a path passes", 0, 1024)
    indirect_paths: int = _setting(
        0,
        "Number of paths that continue from the first surface of each sample, on the CPU. 0 chooses the best number "
        "for each pixel",
        0,
        MOST_BRANCHES,
    )
    guided_samples: bool = _setting(
        True,
        "Give noisy pixels up to 8 times as many samples as set, and clean pixels half as many or fewer. This gives "
        "less noise in the same time. Only on the CPU and without a noise threshold",
    )
    lamp_paths: LampPaths = _setting(
        LampPaths.AUTOMATIC,
        "Trace paths from lamps and lights, too, and connect them to those from the camera. This gives less noise where "
        "walls scatter the light of hidden lamps. Automatic measures whether it pays. Only in final renders",
        label="Paths from Lamps",
    )
    path_reuse: PathReuse = _setting(
        PathReuse.AUTOMATIC,
        "Share the light that a path finds with the paths of neighbouring pixels. This gives much less noise, which is "
        "alike in neighbours. Automatic measures whether it pays, and leaves it out where the picture is denoised. Only "
        "on the CPU and in final renders",
        label="Path Reuse",
    )
    caustic_paths: CausticPaths = _setting(
        CausticPaths.AUTOMATIC,
        "Trace paths from SDF lamps by way of mirrors, glass and polished metal to what the camera sees. This gives "
        "much less noise in caustics. Automatic measures whether it pays. Only on the CPU and in final renders",
        label="Caustics from Lamps",
    )
    clamp_direct: float = _setting(
        0.0, "Maximum value that one sample of direct light adds. 0 is no clamp, and no bias", 0.0, None
    )
    clamp_indirect: float = _setting(
        0.0, "Maximum value that one sample of indirect light adds. 0 is no clamp, and no bias", 0.0, None
    )
    caustics_reflective: bool = _setting(
        True, "Show light that reaches a diffuse surface by reflection", label="Reflective Caustics"
    )
    caustics_refractive: bool = _setting(
        True, "Show light that reaches a diffuse surface by refraction", label="Refractive Caustics"
    )
    filter_glossy: float = _setting(
        0.0,
        "Minimum roughness of reflection and refraction behind rough surfaces, which gives less noise in caustics. 0 is "
        "no blur, and no bias",
        0.0,
        10.0,
    )
    filter: Filter = _setting(Filter.BLACKMAN_HARRIS, "Pixel filter")
    filter_width: float = _setting(1.5, "Width of the pixel filter in pixels", 0.01, 10.0)
    exposure: float = _setting(1.0, "Factor of the light that reaches the film", 0.0, 10.0)
    transparent_film: bool = _setting(False, "Leave the world out of the picture: alpha is 0 where no object is")
    denoise: bool = _setting(False, "Remove noise with OpenImageDenoise after the render")
    threads: int = _setting(0, "Number of threads. 0 is one for each core", 0, 1024)
