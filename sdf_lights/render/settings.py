# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of a render. The UI properties of ``scene.sdf_lights`` are generated from these fields."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

# That a path divides into: at most, and until it is known how noisy pixels are.
MOST_BRANCHES, START_BRANCHES = 16, 10


class Device(enum.Enum):
    AUTOMATIC = "AUTOMATIC"
    CPU = "CPU"
    REFERENCE = "REFERENCE"
    GPU = "GPU"


class LampSampling(enum.Enum):
    """How light rays towards SDF lamps are drawn. All but ``CUT`` are there to be compared with."""

    CUT = "CUT"  # in proportion to what the parts of the lamp give the point that is lit (emitter/cut.py)
    MIS = "MIS"  # points of the interior, joined with rays of the BSDF by the balance heuristic (Huang et al. 2026)
    PROJECTION = "PROJECTION"  # points of the interior; rays of the BSDF count only where it is glossy
    BOUNDING = "BOUNDING"  # points of the bounding box; else as PROJECTION. On the CPU
    SURFACE = "SURFACE"  # points of the surface, by area; else as PROJECTION. On the CPU
    BSDF = "BSDF"  # no light rays


class Filter(enum.Enum):
    BOX = "BOX"
    GAUSSIAN = "GAUSSIAN"
    BLACKMAN_HARRIS = "BLACKMAN_HARRIS"


def _setting(default, description: str, minimum=None, maximum=None, unit: str = "", label: str = ""):
    return field(default=default, metadata=dict(
        description=description, minimum=minimum, maximum=maximum, unit=unit, label=label))


@dataclass
class Settings:
    device: Device = _setting(
        Device.AUTOMATIC, "What computes the picture: Automatic takes the CPU, which has the better sampling of lamps")
    lamp_sampling: LampSampling = _setting(
        LampSampling.CUT, "How light from SDF lamps is sampled. Cut is the default; the others serve to compare")
    samples: int = _setting(128, "Most samples per pixel; their mean where they are guided", 1, 1 << 24)
    noise_threshold: float = _setting(
        0.01, "Relative error at which a pixel gets no more samples; 0: none stops early", 0.0, 1.0)
    min_samples: int = _setting(16, "Samples per pixel before the noise threshold is looked at", 1, 4096)
    time_limit: float = _setting(0.0, "Seconds after which the render stops; 0 means no limit", 0.0, None, "TIME")
    seed: int = _setting(
        0, "Seed of the sampling pattern: the same seed gives the same picture, bit for bit", 0, (1 << 31) - 1)
    animate_seed: bool = _setting(True, "Another seed for every frame", label="Animate Seed")
    max_bounces: int = _setting(12, "Most bounces of light of all kinds together", 0, 1024)
    diffuse_bounces: int = _setting(4, "Most diffuse bounces", 0, 1024)
    glossy_bounces: int = _setting(4, "Most glossy bounces", 0, 1024)
    transmission_bounces: int = _setting(12, "Most bounces through glass", 0, 1024)
    transparent_bounces: int = _setting(8, "Most transparent surfaces a path goes straight through", 0, 1024)
    indirect_paths: int = _setting(
        0, "Paths that go on from the first surface of each sample, on the CPU; 0 finds out, place by place, how many pay", 0,
        MOST_BRANCHES)
    guided_samples: bool = _setting(
        True, "Without a noise threshold, noisy pixels take up to 8 times as many samples as set and clean ones half as "
        "many or fewer, all of them powers of two: less noise in the same time. On the CPU")
    clamp_direct: float = _setting(
        0.0, "Largest value one sample of direct light may add; 0 means no clamp, and no bias", 0.0, None)
    clamp_indirect: float = _setting(
        0.0, "Largest value one sample of indirect light may add; 0 means no clamp, and no bias", 0.0, None)
    caustics: bool = _setting(True, "Light that reaches a diffuse surface by way of a glossy one")
    filter: Filter = _setting(Filter.BLACKMAN_HARRIS, "Pixel filter")
    filter_width: float = _setting(1.5, "Width of the pixel filter in pixels", 0.01, 10.0)
    exposure: float = _setting(1.0, "Factor on the light that reaches the film", 0.0, 10.0)
    transparent_film: bool = _setting(False, "World is left out of the picture: alpha 0 where nothing is hit")
    denoise: bool = _setting(False, "Remove noise with OpenImageDenoise when the render has finished")
    threads: int = _setting(0, "Threads; 0 means one for each core", 0, 1024)
