# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface and bounding box sampling as external strategies of the path tracer: after ``register``, scenes use it."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Iterator

import numpy as np

from sdf_lights.emitter.sampling import external
from sdf_lights.emitter.sampling.external import External
from sdf_lights.jit import kernel
from sdf_lights.render.kernels.workspace import spans_of
from sdf_lights.render.settings import LampSampling

from . import bounding, surfaces


@kernel
def surface_direction(block, workspace, lamp, x, y, z, u1, u2, u3):
    return surfaces.sample(block, int(lamp), (x, y, z), spans_of(workspace), u1, u2, u3)


@kernel
def surface_density(block, workspace, lamp, x, y, z, dx, dy, dz, count):
    return surfaces.density(block, int(lamp), (x, y, z), (dx, dy, dz), spans_of(workspace), int(count))


@kernel
def bounding_direction(block, workspace, lamp, x, y, z, u1, u2, u3):
    return bounding.sample(block, int(lamp), (x, y, z), u1, u2, u3)


@kernel
def bounding_density(block, workspace, lamp, x, y, z, dx, dy, dz, count):
    return bounding.density(block, int(lamp), (x, y, z), (dx, dy, dz))


EXTERNALS = {
    "SURFACE": External(surface_direction, surface_density, surfaces.pack_surfaces),
    "BOUNDING": External(bounding_direction, bounding_density, lambda built, sources: (np.zeros(0, np.uint8), None)),
}

# Every sampling for comparison, by name, in the order of tables.
SAMPLERS = ("CUT", "MIS", "PROJECTION", "BOUNDING", "SURFACE", "BSDF")


def register(name: str, program: str = "sdf_lights") -> LampSampling:
    """Register the sampling of ``SAMPLERS``. Returns its value of ``lamp_sampling`` for scenes.

    ``program`` is the package that renders: a registered extension has a copy of its own.
    """
    found = EXTERNALS.get(name)
    if found is not None:
        importlib.import_module(f"{program}.emitter.sampling.external").register(found)
    return LampSampling[name] if found is None else LampSampling.EXTERNAL


@contextlib.contextmanager
def registered(name: str) -> Iterator[LampSampling]:
    """As ``register``, and undoes it at the end."""
    try:
        yield register(name)
    finally:
        external.register(None)
