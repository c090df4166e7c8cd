# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Toon: uniform inside a cone about the normal or the mirror direction."""

from .description import Bsdf, Group, Lobe

BSDF = Bsdf(
    kind="toon",
    blender="ShaderNodeBsdfToon",
    inputs=dict(color=(0.8, 0.8, 0.8), size=0.5, smooth=0.0, normal=None),
    lobes=(Lobe("toon", {"diffuse_toon": Group.DIFFUSE, "glossy_toon": Group.GLOSSY}),),
    settings=("component",),  # "DIFFUSE" | "GLOSSY"
    options=(("component", "GLOSSY"),),
)
