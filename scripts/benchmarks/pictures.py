# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the open scene with its engine, and measures the time."""

from __future__ import annotations

import os
import tempfile
import time
from dataclasses import dataclass

import bpy
import numpy as np


@dataclass(frozen=True)
class Picture:
    """``pixels`` are (height, width, RGB) float64, scene-linear, row 0 at the bottom.

    ``seconds`` are wall-clock time, ``work`` is the processor time of all threads.
    """

    pixels: np.ndarray
    seconds: float
    work: float


def render() -> Picture:
    """Render the open scene like F12; the time covers everything from Blender's data to Blender's picture."""
    scene = bpy.context.scene
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # since 5.0, where it limits the formats
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    started, work = time.perf_counter(), time.process_time()
    bpy.ops.render.render()
    work, seconds = time.process_time() - work, time.perf_counter() - started
    handle, path = tempfile.mkstemp(suffix=".exr")
    os.close(handle)
    try:
        result = next(image for image in bpy.data.images if image.type == "RENDER_RESULT")
        result.save_render(path, scene=scene)
        image = bpy.data.images.load(path)
        width, height = image.size
        pixels = np.empty(4 * width * height, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    finally:
        os.remove(path)
    return Picture(pixels.reshape(height, width, 4)[..., :3].astype(float), seconds, work)
