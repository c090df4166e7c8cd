# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of a picture at a place in it, joined linearly between pixels; beyond its edges they go on as they are there.

Pixels count by their alpha, so what is transparent lends no colour to what is beside it.
"""

from __future__ import annotations

import math

import numpy as np

from ...graph.formula import Formula, call, constant
from ...graph.functions import Function, TableFunction
from ...graph.tables import Table, table
from ...jit import floats_at, kernel

_HEAD = 4  # numbers before the pixels: width, height, and the least and greatest of all colours
MOST_PIXELS = 1 << 20  # a larger picture is scaled down: its light comes from a volume, so nobody sees as much


@kernel
def texture_value(address, channel, u, v):
    """Channel 0, 1 or 2 at a place from (0, 0), the lower left corner of the picture, to (1, 1)."""
    numbers = floats_at(address)
    width, height = int(numbers[0]), int(numbers[1])
    if not (abs(u) < 1e100 and abs(v) < 1e100):
        return math.nan
    x = min(max(u * width - 0.5, 0.0), width - 1.0)
    y = min(max(v * height - 0.5, 0.0), height - 1.0)
    i, j = int(x), int(y)
    s, t = x - i, y - j
    value = weight = mean = 0.0
    for corner in range(4):
        a, b = corner & 1, corner >> 1
        at = 4 + 4 * (min(i + a, width - 1) + width * min(j + b, height - 1))
        share = (s if a else 1.0 - s) * (t if b else 1.0 - t)
        colour, alpha = np.float64(numbers[at + int(channel)]), np.float64(numbers[at + 3])
        mean += share * colour
        value += share * alpha * colour
        weight += share * alpha
    return value / weight if weight > 1e-6 else mean


@kernel
def texture_bounds(address, c_low, c_high, u_low, u_high, v_low, v_high):
    """Bounds of the colours, and none of how fast they change."""
    numbers = floats_at(address)
    low, high = np.float64(numbers[2]), np.float64(numbers[3])
    return low, high, -math.inf, math.inf, -math.inf, math.inf, -math.inf, math.inf


_GLSL = """\
float texture_value(int table, float channel, float u, float v)
{
    int width = int(table_number(table));
    int height = int(table_number(table + 1));
    float x = clamp(u * float(width) - 0.5, 0.0, float(width) - 1.0);
    float y = clamp(v * float(height) - 0.5, 0.0, float(height) - 1.0);
    int i = int(x);
    int j = int(y);
    float s = x - float(i);
    float t = y - float(j);
    float value = 0.0;
    float weight = 0.0;
    float mean = 0.0;
    for (int corner = 0; corner < 4; corner++) {
        int a = corner & 1;
        int b = corner >> 1;
        int at = table + 4 + 4 * (min(i + a, width - 1) + width * min(j + b, height - 1));
        float share = (a == 1 ? s : 1.0 - s) * (b == 1 ? t : 1.0 - t);
        float colour = table_number(at + int(channel));
        float alpha = table_number(at + 3);
        mean += share * colour;
        value += share * alpha * colour;
        weight += share * alpha;
    }
    return weight > 1e-6 ? value / weight : mean;
}
"""

TEXTURE = TableFunction(
    "texture_value",
    texture_value,
    bounds=Function("texture_bounds", texture_bounds, results=8),
    glsl=_GLSL,
    operations=60.0,
)


def texture_table(pixels: np.ndarray) -> Table:
    """Table of linear colours (height, width, channels), the lowest row first; a fourth channel is alpha."""
    height, width, channels = pixels.shape
    step = 1
    while max(height // step, 1) * max(width // step, 1) > MOST_PIXELS:
        step += 1
    colours = np.ones((height, width, 4), np.float32)
    colours[..., :3] = pixels[..., :3] if channels > 2 else pixels[..., :1]
    if channels == 4:
        colours[..., 3] = pixels[..., 3]
    colours = np.nan_to_num(colours, posinf=0.0, neginf=0.0)
    if step > 1:
        colours = _scaled_down(colours, step)
    height, width, _ = colours.shape
    head = [width, height, colours[..., :3].min(), colours[..., :3].max()]
    return table(np.concatenate([np.array(head, np.float32), colours.ravel()]))


def _scaled_down(colours: np.ndarray, step: int) -> np.ndarray:
    """Means of ``step`` × ``step`` pixels, by their alpha."""
    height, width = (max(size // step, 1) for size in colours.shape[:2])
    parts = colours[: height * step, : width * step]
    parts = parts.reshape(height, parts.shape[0] // height, width, parts.shape[1] // width, 4)
    alpha = parts[..., 3:].mean(axis=(1, 3))
    weighted = (parts[..., :3] * parts[..., 3:]).mean(axis=(1, 3))
    plain = parts[..., :3].mean(axis=(1, 3))
    with np.errstate(all="ignore"):
        found = np.where(alpha > 1e-6, weighted / alpha, plain)
    return np.concatenate([found, alpha], axis=2).astype(np.float32)


def colour(address: Formula, u: Formula | float, v: Formula | float) -> tuple[Formula, Formula, Formula]:
    """Red, green and blue at a place, of the picture whose table is at the address."""
    red, green, blue = (call(TEXTURE, address, constant(float(channel)), u, v)[0] for channel in range(3))
    return red, green, blue
