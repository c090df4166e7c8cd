# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions uniform in a cone and on the sphere."""

import math

from ....jit import kernel
from ....vec import frame, to_world

FULL_SPHERE = 1.0 / (4.0 * math.pi)


@kernel
def one_minus_cos(sine_squared):
    """1 − cos θ from sin² θ for θ up to a right angle, without cancellation."""
    return sine_squared / (1.0 + math.sqrt(max(1.0 - sine_squared, 0.0)))


@kernel
def polar_direction(one_minus_z, phi):
    """Unit vector at angle φ around z with z = 1 − one_minus_z."""
    sine = math.sqrt(max(one_minus_z * (2.0 - one_minus_z), 0.0))
    return sine * math.cos(phi), sine * math.sin(phi), 1.0 - one_minus_z


@kernel
def sample_cone(axis, width, u1, u2):
    """Uniform direction within the cone 1 − cos θ ≤ width around the unit vector ``axis``."""
    t, b = frame(axis)
    return to_world(polar_direction(u2 * width, 2.0 * math.pi * u1), t, b, axis)


@kernel
def cone_pdf(width):
    """Density per solid angle of ``sample_cone``; ``width`` is 1 − the cosine of the half angle."""
    return 1.0 / (2.0 * math.pi * width)


@kernel
def sample_sphere(u1, u2):
    """Uniform direction on the sphere."""
    return polar_direction(2.0 * u2, 2.0 * math.pi * u1)
