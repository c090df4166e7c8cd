# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair: one lobe of reflection or of transmission by a thin fiber."""

from .description import Bsdf, Group, Lobe

BSDF = Bsdf(
    kind="hair",
    blender="ShaderNodeBsdfHair",
    inputs=dict(color=(0.8, 0.8, 0.8), offset=0.0, roughness_u=0.1, roughness_v=1.0, tangent=None),
    lobes=(Lobe("hair", {"hair": Group.OTHER}),),
    settings=("component",),  # "REFLECTION" | "TRANSMISSION"
    options=(("component", "TRANSMISSION"),),
    sockets=dict(roughness_u="RoughnessU", roughness_v="RoughnessV"),
    needs_derivatives=True,
)
