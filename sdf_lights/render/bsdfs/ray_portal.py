# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ray Portal: the ray continues at another position."""

from .description import Bsdf, Group, Lobe

BSDF = Bsdf(
    kind="ray_portal",
    blender="ShaderNodeBsdfRayPortal",
    inputs=dict(color=(1.0, 1.0, 1.0), position=None, direction=None),
    lobes=(Lobe("portal", {"portal": Group.OTHER}),),
)
