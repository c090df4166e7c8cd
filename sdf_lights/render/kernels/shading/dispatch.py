# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls of the kernels in ``special/``: closures that few scenes have. Each kernel there is compiled separately, if a
scene has its closure. The path tracer calls it by address, so it is neither larger nor slower to compile because of it.

All arguments and results are numbers, not tuples of them.
"""

import numpy as np

from ....jit import call_part, kernel, table
from ....replaced import replaced_on_gpu
from .records import STRAIGHT
from .special_lobes import END, FIRST

# Indices of the addresses, which are 0 for closures that the scene lacks.
REFINE, THIN_WALL, TRANSPARENCY, SUBSURFACE, ADD = range(5)
EVALUATE = ADD + END - FIRST
SAMPLE = EVALUATE + STRAIGHT
PLACES = SAMPLE + STRAIGHT

TABLES = {"special_code": np.dtype(np.int64)}
_code = table("special_code", np.int64)


@replaced_on_gpu
@kernel
def add(block, workspace, kind, lobe, weight):
    """Add the closures of lobe number ``lobe``, of ``kind``."""
    call_part(_code(block)[ADD + kind - FIRST], block, workspace, (lobe, weight), 1)


@replaced_on_gpu
@kernel
def refine(block, workspace, lobe, closure, roughness):
    """Make microfacets of Principled, closure number ``closure``, anisotropic, and cover them with a film, as lobe
    number ``lobe`` says.

    Returns the roughness for the look-up of their albedo; and, with a film, the reflectance (RGB) that replaces this
    look-up, negative without a film.
    """
    return call_part(_code(block)[REFINE], block, workspace, (lobe, closure, roughness), 4)


@replaced_on_gpu
@kernel
def thin_wall(block, workspace, lobe, r, g, b):
    """Add the transmission of a thin wall with this weight, as lobe number ``lobe`` of Principled says."""
    call_part(_code(block)[THIN_WALL], block, workspace, (lobe, r, g, b), 1)


@replaced_on_gpu
@kernel
def transparency(block, workspace):
    """RGB that passes straight through the surface, which is shaded for it."""
    return call_part(_code(block)[TRANSPARENCY], block, workspace, (0.0,), 3)


@replaced_on_gpu
@kernel
def subsurface(block, workspace, lobe, r, g, b, ior):
    """Add subsurface scattering with this weight, as lobe number ``lobe`` of Principled says; ``ior`` is that of its
    specular layer."""
    call_part(_code(block)[SUBSURFACE], block, workspace, (lobe, r, g, b, ior), 1)


@replaced_on_gpu
@kernel
def evaluate(block, workspace, kind, closure, x, y, z):
    """f · |cos| (r, g, b) without its weight, and pdf, of closure number ``closure``, of ``kind``, for wi."""
    return call_part(_code(block)[EVALUATE + kind], block, workspace, (closure, x, y, z), 4)


@replaced_on_gpu
@kernel
def sample(block, workspace, kind, closure, u1, u2, u3):
    """A sampled direction: wi, f · |cos| (r, g, b) without its weight, pdf and kind of scattering."""
    return call_part(_code(block)[SAMPLE + kind], block, workspace, (closure, u1, u2, u3), 8)
