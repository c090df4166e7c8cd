# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Means over blocks of pixels, which compare pictures of several seeds."""

import numpy as np

BLOCK = 4


def means(values: np.ndarray) -> list[np.ndarray]:
    """Means of blocks and of the whole picture, (seeds, …), of ``values`` (seeds, height, width, channels)."""
    seeds, height, width, channels = values.shape
    blocks = values.reshape(seeds, height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels).mean((2, 4))
    return [blocks.reshape(seeds, -1), values.mean((1, 2))]
