# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The linear working space of a file: its matrix from CIE XYZ, and the luminance."""

from __future__ import annotations

import numpy as np

from ...graph.formula import Formula, Vector
from .definition import NodeInputs

# From CIE XYZ with the white of D65 to linear Rec. 709, as in Blender before 5.0. Later matrices are rounded
# differently.
REC709 = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)

# To the linear working spaces of files since then: ITU-R BT.709 and BT.2020, and ACEScg (S-2014-004, adapted to D65 by
# Bradford's method).
WORKING_SPACES = {
    "Linear Rec.709": np.array(
        [[3.2409699, -1.5373832, -0.4986108], [-0.9692436, 1.8759675, 0.0415551], [0.0556301, -0.2039770, 1.0569715]]
    ),
    "Linear Rec.2020": np.array(
        [[1.7166512, -0.3556708, -0.2533663], [-0.6666844, 1.6164812, 0.0157685], [0.0176399, -0.0427706, 0.9421031]]
    ),
    "ACEScg": np.linalg.inv(
        [[0.652238, 0.128237, 0.169983], [0.267672, 0.674340, 0.057988], [-0.005382, 0.001369, 1.093071]]
    ),
}


def xyz_to_rgb(working_space: str | None) -> np.ndarray:
    """(3, 3) matrix from XYZ to the working space of that name; to Rec. 709 if there is none."""
    return REC709 if working_space is None else WORKING_SPACES.get(working_space, REC709)


def luminance_weights(working_space: str | None) -> tuple[float, ...]:
    """Weights of red, green and blue of the working space in the luminance."""
    return tuple(np.linalg.inv(xyz_to_rgb(working_space))[1].tolist())


def luminance(node: NodeInputs, color: Vector) -> Formula:
    """Luminance of a linear colour of the working space."""
    return color.dot(luminance_weights(node.setting("working_space")))


def transformed(matrix: np.ndarray, vector: Vector) -> Vector:
    """A matrix (3, 3) of numbers times a vector."""
    return Vector(*(vector.dot(row) for row in matrix.tolist()))
