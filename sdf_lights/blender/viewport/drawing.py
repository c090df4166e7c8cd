# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rectangles on the screen, filled from textures."""

from __future__ import annotations

import gpu
from gpu_extras.batch import batch_for_shader

from . import shaders

Place = tuple[float, float, float, float]  # x0, y0, x1, y1 as fractions of the frame buffer: 0 to 1


def draw_rectangle(shader: gpu.types.GPUShader, place: Place, blend: str, textures: dict, **values) -> None:
    """Fill a rectangle with a shader of ``shaders`` that takes these textures and values."""
    x0, y0, x1, y1 = (2.0 * edge - 1.0 for edge in place)
    batch = batch_for_shader(
        shader,
        "TRIS",
        {
            "position": [(x0, y0), (x1, y0), (x0, y1), (x1, y1)],
            "texcoord": [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)],
        },
        indices=[(0, 1, 2), (1, 3, 2)],
    )
    gpu.state.blend_set(blend)
    gpu.state.depth_test_set("NONE")
    try:
        shader.bind()
        for name, texture in textures.items():
            shader.uniform_sampler(name, texture)
        for name, value in values.items():
            shader.uniform_float(name, value)
        batch.draw(shader)
    finally:
        gpu.state.blend_set("NONE")


def draw_texture(texture: gpu.types.GPUTexture, place: Place) -> None:
    """Draw a premultiplied picture over the present picture."""
    draw_rectangle(shaders.picture_shader(), place, "ALPHA_PREMULT", {"picture": texture})
