# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's value nodes as formulas: one small function per node. See README.md."""

from . import (
    colors,
    constants,
    curves,
    environment,
    fresnel,
    geometry,
    ies,
    images,
    light,
    maths,
    mixing,
    normals,
    sky,
    spectra,
    textures,
    tiling,
    tracing,
    vectors,
)
from .definition import DEFINITIONS, NodeInputs, node_outputs

__all__ = ["DEFINITIONS", "NodeInputs", "node_outputs"]
