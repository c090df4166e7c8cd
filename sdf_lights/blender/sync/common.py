# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared parts of sync: matrices, warnings, sockets."""

from __future__ import annotations

import math

import numpy as np

from ...render.scene import Ray

# Blender's Ray Visibility.
_VISIBILITY = {
    "visible_camera": Ray.CAMERA.value,
    "visible_diffuse": Ray.DIFFUSE.value,
    "visible_glossy": Ray.GLOSSY.value,
    "visible_transmission": Ray.TRANSMISSION.value,
    "visible_shadow": Ray.SHADOW.value,
    "visible_volume_scatter": Ray.VOLUME.value,
}

# A scale below this fraction of the largest counts as zero.
FLAT = 1e-9


class Warnings:
    """Collects sentences for the user, each once, in order; ignores empty ones."""

    def __init__(self, sentences: list[str]):
        self._sentences = sentences
        self._known = set(sentences)

    def __call__(self, sentence: str) -> None:
        if sentence and sentence not in self._known:
            self._known.add(sentence)
            self._sentences.append(sentence)


def matrix_of(value) -> np.ndarray:
    """A mathutils matrix as a (4, 4) float64 array."""
    return np.array([tuple(row) for row in value], np.float64)


def is_finite(matrix: np.ndarray) -> bool:
    """Whether all entries of a matrix (4 × 4) are finite."""
    # In plain Python: there may be many thousands of objects, and NumPy takes longer for 16 numbers.
    return all(map(math.isfinite, matrix.ravel().tolist()))


def is_flat(matrix: np.ndarray) -> bool:
    """Whether the matrix (4 × 4) flattens space to a plane, a line or a point."""
    scales = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    return scales[2] <= FLAT * scales[0]


def visibility_of(item) -> Ray:
    """The kinds of rays that see an object."""
    # Plain integers: enumerations take ten times as long.
    return Ray(sum(bit for name, bit in _VISIBILITY.items() if getattr(item, name)))


def rgb(value) -> tuple[float, float, float]:
    """The first three components as floats."""
    red, green, blue = value[:3]
    return float(red), float(green), float(blue)
