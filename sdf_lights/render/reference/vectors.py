# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of vectors, (N, 3): the few functions that NumPy lacks."""

from __future__ import annotations

import numpy as np


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar products (…) of vectors (…, 3)."""
    return np.einsum("...i,...i->...", a, b)


def normalize(a: np.ndarray) -> np.ndarray:
    """a / |a| of vectors (…, 3); zero vectors stay as they are."""
    length = np.sqrt(dot(a, a))[..., None]
    return a / np.where(length == 0.0, 1.0, length)


def reflect(wo: np.ndarray, n: np.ndarray) -> np.ndarray:
    """``wo`` (N, 3) mirrored at the unit normals ``n`` (N, 3)."""
    return 2.0 * dot(wo, n)[..., None] * n - wo


def frame(n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors (N, 3) perpendicular to each of the unit vectors ``n`` (N, 3) and to each other."""
    smallest = np.eye(3)[np.argmin(np.abs(n), axis=-1)]
    t = normalize(np.cross(smallest, n))
    return t, np.cross(n, t)


def to_world(local: np.ndarray, n: np.ndarray) -> np.ndarray:
    """Vectors (N, 3) with components ``local`` (N, 3) in the frame of ``n`` (N, 3)."""
    t, b = frame(n)
    return local[..., :1] * t + local[..., 1:2] * b + local[..., 2:3] * n


def luminance(rgb: np.ndarray) -> np.ndarray:
    """Luminance (N,) of RGB colours (N, 3), by Rec. 709."""
    return rgb @ np.array([0.2126, 0.7152, 0.0722])


def disk(rng: np.random.Generator, count: int) -> np.ndarray:
    """Uniform points of the unit disk, (count, 2)."""
    radius, angle = np.sqrt(rng.random(count)), 2.0 * np.pi * rng.random(count)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], -1)


def cosine_hemisphere(rng: np.random.Generator, n: np.ndarray) -> np.ndarray:
    """Directions (N, 3) about ``n`` (N, 3) with density cos θ / π."""
    xy = disk(rng, len(n))
    z = np.sqrt(np.maximum(0.0, 1.0 - np.sum(xy * xy, -1, keepdims=True)))
    return to_world(np.concatenate([xy, z], -1), n)


def uniform_sphere(rng: np.random.Generator, count: int) -> np.ndarray:
    """Uniform directions, (count, 3)."""
    z, angle = 1.0 - 2.0 * rng.random(count), 2.0 * np.pi * rng.random(count)
    s = np.sqrt(np.maximum(0.0, 1.0 - z * z))
    return np.stack([s * np.cos(angle), s * np.sin(angle), z], -1)


def uniform_cone(rng: np.random.Generator, axis: np.ndarray, one_minus_cos: np.ndarray) -> np.ndarray:
    """Directions (N, 3), uniform in solid angle within a cone about the unit vectors ``axis`` (N, 3)."""
    height, angle = one_minus_cos * rng.random(len(axis)), 2.0 * np.pi * rng.random(len(axis))
    s = np.sqrt(height * (2.0 - height))
    return to_world(np.stack([s * np.cos(angle), s * np.sin(angle), 1.0 - height], -1), axis)
