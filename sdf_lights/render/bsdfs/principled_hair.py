# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Principled Hair: all orders of light through a fiber, by the models of Chiang and of Huang."""

from .description import Bsdf, Group, Lobe

BSDF = Bsdf(
    kind="principled_hair",
    blender="ShaderNodeBsdfHairPrincipled",
    inputs=dict(
        color=(0.017513, 0.005763, 0.002059),
        melanin=0.8,
        melanin_redness=1.0,
        tint=(1.0, 1.0, 1.0),
        absorption_coefficient=(0.245531, 0.52, 1.365),
        roughness=0.3,
        radial_roughness=0.3,
        coat=0.0,
        ior=1.55,
        offset=0.0349066,
        random_color=0.0,
        random_roughness=0.0,
        random=0.0,
        aspect_ratio=0.85,
        r_lobe=1.0,
        tt_lobe=1.0,
        trt_lobe=1.0,
        axis=None,  # of a strand: the major axis of its cross-section, of any length and inclination; None: any
    ),
    lobes=(Lobe("chiang", {"chiang": Group.OTHER}), Lobe("huang", {"huang": Group.OTHER}, when=("model", "HUANG"))),
    settings=("model", "parametrization"),  # "CHIANG" | "HUANG"; "COLOR" | "MELANIN" | "ABSORPTION"
    # light_rays "ALL": those of a mesh see all directions, as in Blender before 5.0
    options=(("parametrization", "MELANIN"), ("parametrization", "ABSORPTION"), ("light_rays", "ALL")),
    sockets=dict(ior="IOR", r_lobe="R lobe", tt_lobe="TT lobe", trt_lobe="TRT lobe"),
    needs_derivatives=True,
)
