# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures of the demo scene, painted with NumPy.

Every painter returns (height, width, 3) float64 in [0, 1], row 0 at the bottom. Those marked seamless repeat without a
seam. Colours are display-referred (sRGB), heights are plain numbers.
"""

from __future__ import annotations

import numpy as np


def noise(size: tuple[int, int], frequency: tuple[float, float], seed: int, octaves: int = 5) -> np.ndarray:
    """Seamless noise with mean 0 and deviation 1: octaves of band-limited Gaussian noise.

    ``size`` is (height, width) in pixels, ``frequency`` the lowest frequency down and across, in waves per image.
    """
    random = np.random.default_rng(seed)
    down, across = np.meshgrid(
        np.fft.fftfreq(size[0], 1.0 / size[0]), np.fft.rfftfreq(size[1], 1.0 / size[1]), indexing="ij"
    )
    radius = np.hypot(down / frequency[0], across / frequency[1])
    # Amplitude falls as 1/f above the lowest frequency, as a sum of octaves of half the amplitude does.
    band = np.where((radius >= 0.5) & (radius < 2.0**octaves), 1.0 / np.maximum(radius, 1.0) ** 2, 0.0)
    spectrum = band * np.exp(2j * np.pi * random.random(band.shape))
    field = np.fft.irfft2(spectrum, s=size)
    return (field - field.mean()) / field.std()


def smoothstep(low: float, high: float, x: np.ndarray) -> np.ndarray:
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def blend(a, b, t: np.ndarray) -> np.ndarray:
    """Colours a and b mixed by t."""
    return np.asarray(a) + (np.asarray(b) - np.asarray(a)) * t[..., None]


def grey(values: np.ndarray) -> np.ndarray:
    return np.repeat(np.clip(values, 0.0, 1.0)[..., None], 3, axis=2)


def wood(size: int = 1024, seed: int = 1, light=(0.66, 0.46, 0.29), dark=(0.33, 0.19, 0.10)) -> np.ndarray:
    """Grain along the image's width; seamless."""
    figure = noise((size, size), (3.0, 1.0), seed, 4)
    rings = 0.5 + 0.5 * np.sin(5.0 * figure)
    pores = noise((size, size), (160.0, 6.0), seed + 1, 2)
    return np.clip(blend(light, dark, np.clip(0.55 * rings + 0.12 * pores, 0.0, 1.0)), 0.0, 1.0)


def parquet(size: int = 1024, boards: int = 8) -> tuple[np.ndarray, np.ndarray]:
    """Boards of two lengths in staggered rows: (colour, height), both seamless."""
    random = np.random.default_rng(7)
    grain = wood(size, 11, (0.60, 0.40, 0.24), (0.40, 0.24, 0.13))
    colour, height = np.empty((size, size, 3)), np.ones((size, size))
    row_height = size // boards
    x = np.arange(size)
    for row in range(boards):
        rows = slice(row * row_height, (row + 1) * row_height)
        shift = int(random.integers(size))
        position = (x + shift) % size
        board = position * 2 // size
        tone = random.uniform(0.72, 1.12, 2)[board]
        source = np.roll(grain, (int(random.integers(size)), int(random.integers(size))), axis=(0, 1))[rows]
        along = np.minimum(position % (size // 2), size // 2 - position % (size // 2))
        across = np.minimum(np.arange(row_height), row_height - 1 - np.arange(row_height))
        groove = smoothstep(0.0, 4.0, np.minimum(along[None, :], across[:, None]).astype(float))
        colour[rows] = source * (tone[None, :] * (0.35 + 0.65 * groove))[..., None]
        height[rows] = groove
    height = 0.9 * height + 0.1 * grain.mean(axis=2)
    return np.clip(colour, 0.0, 1.0), grey(height)


def plaster(size: int = 1024) -> np.ndarray:
    """Height of trowelled plaster; seamless."""
    broad = noise((size, size), (3.0, 5.0), 21, 3)
    fine = noise((size, size), (40.0, 40.0), 22, 3)
    return grey(0.5 + 0.13 * broad + 0.03 * fine)


def weave(size: int = 512, threads: int = 48) -> np.ndarray:
    """Height of a plain weave; seamless."""
    v, u = np.mgrid[0:size, 0:size] * (threads / size)
    over = (np.floor(u) + np.floor(v)) % 2
    warp = np.abs(np.sin(np.pi * u)) * (0.6 + 0.4 * np.cos(np.pi * (v - np.floor(v) - 0.5)))
    weft = np.abs(np.sin(np.pi * v)) * (0.6 + 0.4 * np.cos(np.pi * (u - np.floor(u) - 0.5)))
    return grey(np.where(over > 0, warp, weft))


def rug(size: int = 1024) -> np.ndarray:
    """Rings round the centre, in four muted colours, with the threads showing."""
    v, u = (np.mgrid[0:size, 0:size] + 0.5) / size * 2.0 - 1.0
    wobble = 0.004 * noise((size, size), (4.0, 4.0), 31, 3)
    ring = np.maximum(np.abs(u), np.abs(v)) + wobble
    palette = np.array(
        [(0.71, 0.64, 0.54), (0.20, 0.25, 0.32), (0.71, 0.64, 0.54), (0.55, 0.27, 0.19), (0.16, 0.19, 0.24)]
    )
    colour = palette[np.clip((ring * 5.0).astype(int), 0, len(palette) - 1)]
    threads = 0.86 + 0.14 * weave(size, 128)[..., :1]
    return np.clip(colour * threads * (1.0 + 0.05 * noise((size, size), (60.0, 60.0), 32, 3)[..., None]), 0.0, 1.0)


def marble(size: int = 1024) -> np.ndarray:
    """White marble with grey veins; seamless."""
    veins = np.abs(noise((size, size), (2.0, 2.0), 41, 4))
    cloud = noise((size, size), (3.0, 3.0), 42, 4)
    white = blend((0.90, 0.89, 0.87), (0.78, 0.78, 0.79), smoothstep(-1.0, 2.0, cloud))
    return np.clip(white * (1.0 - 0.45 * (1.0 - smoothstep(0.0, 0.10, veins)))[..., None], 0.0, 1.0)


def contours(width: int = 1024, height: int = 640) -> np.ndarray:
    """The painting on the wall: lines of equal distance from three discs in smooth union."""
    y, x = np.mgrid[0:height, 0:width] / height
    discs = [(0.48, 0.56, 0.20), (0.88, 0.36, 0.13), (1.18, 0.64, 0.16)]
    # A soft minimum, -log Σ exp(-k d) / k.
    distance = -np.log(sum(np.exp(-14.0 * (np.hypot(x - cx, y - cy) - r)) for cx, cy, r in discs)) / 14.0
    paper, ink = (0.90, 0.86, 0.78), (0.14, 0.22, 0.30)
    outside = blend(paper, ink, 0.85 * (1.0 - smoothstep(0.07, 0.16, np.abs(distance * 22.0 % 1.0 - 0.5))))
    inside = blend((0.83, 0.42, 0.19), (0.95, 0.76, 0.42), smoothstep(0.0, 0.16, -distance))
    return np.clip(np.where((distance < 0.0)[..., None], inside, outside), 0.0, 1.0)
