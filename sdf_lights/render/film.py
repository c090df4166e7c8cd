# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The film: what the samples of every pixel add up to, how noisy that still is, and the passes read from it."""

from __future__ import annotations

import numpy as np

from .passes import BY_NAME, Rule
from .scene import Scene

# Values that a pixel sums up for each pass; "half" holds the samples of odd index, for the estimate of the noise.
CHANNELS = {
    "combined": 4, "half": 3, "lamps": 3, "emission": 3, "normal": 3, "albedo": 3, "position": 3, "depth": 1}

_SOURCE = {
    "Combined": "combined", "Noisy Image": "combined", "SDF Lamps": "lamps", "Emission": "emission", "Normal": "normal",
    "Denoising Normal": "normal", "Diffuse Color": "albedo", "Denoising Albedo": "albedo", "Position": "position",
    "Depth": "depth"}

# Depth of a pixel that sees nothing, as Cycles gives it.
NO_DEPTH = 1e10
# The noise estimate stands on two halves of the samples.
LEAST_SAMPLES = 4


class Film:
    """Sums of samples for the pixels of ``window`` = (x0, y0, x1, y1), the border or the whole frame.

    Arrays are flat, row 0 at the bottom, float64: a million samples add up without drift. Kernels write to them by address.
    ``samples`` is how many samples every active pixel has received.
    """

    def __init__(self, scene: Scene, passes: tuple[str, ...] = ()):
        self.window = scene.border or (0, 0, scene.width, scene.height)
        self.width, self.height = self.window[2] - self.window[0], self.window[3] - self.window[1]
        self.exposure = scene.settings.exposure
        self.samples = 0
        names = {"Combined", *passes}
        if scene.settings.denoise:
            names |= {"Denoising Albedo", "Denoising Normal"}
        self.passes = tuple(name for name in BY_NAME if name in names)
        used = {_SOURCE[name] for name in self.passes if name in _SOURCE} | {"half"}
        pixels = self.width * self.height
        self.sums = {name: np.zeros(pixels * count if name in used else 0) for name, count in CHANNELS.items()}
        self.count = np.zeros(pixels, np.int32)
        self.surfaces = np.zeros(pixels, np.int32)  # samples that met a surface
        self.active = np.ones(pixels, np.uint8)
        self.discarded = np.zeros(1, np.int64)  # samples that were not finite
        self._denoised: np.ndarray | None = None

    def read(self, name: str) -> np.ndarray:
        """(height, width, channels) float32 of the pass ``name``, of the samples so far."""
        item = BY_NAME[name]
        if name == "Combined" and self._denoised is not None:
            return self._denoised
        if item.rule is Rule.COUNT:
            return self.count.reshape(self.height, self.width, 1).astype(np.float32)
        sums = self.sums[_SOURCE[name]].reshape(self.height, self.width, -1)
        weight = self.count
        if item.rule is Rule.SURFACE_MEAN:
            weight = self.surfaces
        elif item.rule is Rule.FIRST:
            weight = np.ones_like(self.count)
        weight = 1.0 / np.maximum(weight, 1).reshape(self.height, self.width, 1)
        value = sums * weight
        if item.light:
            value[..., :3] *= self.exposure
        if name == "Depth":
            value = np.where(self.surfaces.reshape(value.shape) > 0, value, NO_DEPTH)
        return value.astype(np.float32)

    def replace_combined(self, color: np.ndarray) -> None:
        """Show ``color`` (height, width, RGB), exposed, as the Combined pass: the denoised picture."""
        picture = self.read("Noisy Image")
        picture[..., :3] = color
        self._denoised = picture

    def _errors(self) -> tuple[np.ndarray, np.ndarray]:
        """Of each pixel (height, width): brightness I, and |I − A| with A the mean of the odd samples alone.

        Where the two halves are independent, I − A has the variance of I itself.
        """
        count = np.maximum(self.count, 1)[:, None]
        mean = self.sums["combined"].reshape(-1, 4)[:, :3] / count
        half = self.sums["half"].reshape(-1, 3) / np.maximum(count // 2, 1)
        shape = (self.height, self.width)
        return mean.sum(axis=1).reshape(shape), np.abs(mean - half).sum(axis=1).reshape(shape)

    def noise(self) -> float | None:
        """Estimated relative error of the picture: Σ |error| / Σ brightness over its pixels. None: too few samples."""
        if not self.count.size or self.count.max() < LEAST_SAMPLES:
            return None
        brightness, error = self._errors()
        known = self.count.reshape(brightness.shape) >= LEAST_SAMPLES
        total = brightness[known].sum()
        return float(error[known].sum() / total) if total > 0.0 else 0.0

    def update_active(self, threshold: float) -> bool:
        """Stop sampling pixels whose error is below ``threshold``; False when none are left.

        The error is |I − A| / √I, between absolute and relative, as Cycles has it, and the largest of the 3 × 3
        neighbourhood, so that one lucky pixel does not stop early.
        """
        brightness, error = self._errors()
        error = error * self.exposure**0.5 / np.sqrt(np.maximum(brightness, 1e-8))
        padded = np.pad(error, 1, mode="edge")
        rows = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
        largest = np.maximum(np.maximum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])
        self.active[:] = (largest > threshold).ravel()
        return bool(self.active.any())
