# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Sky Texture."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...graph.formula import Vector, call
from ...graph.functions import Function
from ...jit import kernel, table
from ..sky import Sky, kernels, numbers
from .definition import NodeInputs, defines

_constants = table("constants", np.float64)


@kernel
def _sky(block, workspace, kind, with_sun, place, x, y, z):
    return kernels.sky_radiance(kind, with_sun != 0, _constants(block), int(place), (x, y, z))


def sky_function(kind: int, with_sun: bool) -> Function:
    """(place, x, y, z) → RGB; ``place`` is a parameter that is a ``Table`` of ``sky.numbers``.

    ``with_sun`` is compiled in: an importance map of the world is made from the same graph with it off.
    """
    return Function("sky", _sky, (kind, int(with_sun)), 3, scene=True)


def sky_of(setting: Callable[[str], object]) -> Sky:
    """The sky of a node; ``setting`` returns its properties by Blender's names."""
    model = setting("sky_type")
    if model in ("PREETHAM", "HOSEK_WILKIE"):
        return Sky(
            model,
            sun_direction=tuple(setting("sun_direction")),
            turbidity=setting("turbidity"),
            ground_albedo=setting("ground_albedo"),
        )
    names = (
        "sun_disc",
        "sun_size",
        "sun_intensity",
        "sun_elevation",
        "sun_rotation",
        "altitude",
        "air_density",
        "ozone_density",
    )
    aerosol = setting("dust_density" if model == "NISHITA" else "aerosol_density")
    return Sky(model, aerosol_density=aerosol, **{name: setting(name) for name in names})


@defines("ShaderNodeTexSky")
def sky_texture(node: NodeInputs):
    """All models."""
    sky = sky_of(node.setting)
    place = node.table(numbers(sky)[:, None])
    return {"Color": Vector(*call(sky_function(sky.kind, sky.has_disc), place, *node.vector("Vector")))}
