# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of compiled materials: kinds of lobes, their inputs, tables."""

from __future__ import annotations

import numpy as np

NONE = -(1 << 31)


# Lobes, with their arguments (operands).
(
    LOBE_DIFFUSE,  # color, roughness, normal
    LOBE_GLOSSY,  # color, roughness, normal
    LOBE_GLASS,  # color, roughness, ior, normal
    LOBE_REFRACTION,  # color, roughness, ior, normal
    LOBE_TRANSLUCENT,  # color, normal
    LOBE_TRANSPARENT,  # color
    LOBE_EMISSION,  # color, strength
    LOBE_HOLDOUT,
    LOBE_PRINCIPLED,  # PRINCIPLED, in that order
    LOBE_ALPHA,  # alpha: transparent as far as it is below 1; only in lists for shadow rays
) = range(10)


PRINCIPLED = (
    "base_color",
    "metallic",
    "roughness",
    "ior",
    "alpha",
    "normal",
    "diffuse_roughness",
    "specular_ior_level",
    "specular_tint",
    "transmission_weight",
    "coat_weight",
    "coat_roughness",
    "coat_ior",
    "coat_tint",
    "coat_normal",
    "sheen_weight",
    "sheen_roughness",
    "sheen_tint",
    "emission_color",
    "emission_strength",
    "anisotropic",
    "anisotropic_rotation",
    "tangent",
    "thin_film_thickness",
    "thin_film_ior",
    "thin_wall",
    "subsurface_weight",
    "subsurface_radius",
    "subsurface_scale",
    "subsurface_ior",
    "subsurface_anisotropy",
)


(
    BASE_COLOR,
    METALLIC,
    ROUGHNESS,
    IOR,
    ALPHA,
    NORMAL,
    DIFFUSE_ROUGHNESS,
    SPECULAR_IOR_LEVEL,
    SPECULAR_TINT,
    TRANSMISSION_WEIGHT,
    COAT_WEIGHT,
    COAT_ROUGHNESS,
    COAT_IOR,
    COAT_TINT,
    COAT_NORMAL,
    SHEEN_WEIGHT,
    SHEEN_ROUGHNESS,
    SHEEN_TINT,
    EMISSION_COLOR,
    EMISSION_STRENGTH,
    ANISOTROPIC,
    ANISOTROPIC_ROTATION,
    TANGENT_INPUT,
    THIN_FILM_THICKNESS,
    THIN_FILM_IOR,
    THIN_WALL,
    SUBSURFACE_WEIGHT,
    SUBSURFACE_RADIUS,
    SUBSURFACE_SCALE,
    SUBSURFACE_IOR,
    SUBSURFACE_ANISOTROPY,
) = range(len(PRINCIPLED))


# Features of a lobe: the optional parts of Principled, and energy compensation of GGX.
WITH_ALPHA, WITH_SHEEN, WITH_COAT, WITH_EMISSION, WITH_METAL, WITH_TRANSMISSION, WITH_BASE, MULTISCATTER = (
    1 << bit for bit in range(8)
)


LOBE = np.dtype([("kind", "i4"), ("features", "i4"), ("weight", "i4"), ("args", "i4", len(PRINCIPLED))], align=True)


MATERIAL = np.dtype(
    [
        ("flags", "i4"),
        ("sample_emission", "i4"),
        ("emission", "f8", 3),  # estimate of emitted radiance, for the importance of emissive meshes
        ("graph", "i4"),  # of the code that fills the registers; NO_GRAPH: there is none
        ("slots", "i4"),  # index of its parameters among the constants
        ("lobes", "i4", 2),  # first and end of the range
        ("normal", "i4"),  # operand of the shading normal that replaces the surface's; NONE: that stays
        ("shadow_graph", "i4"),  # for transparency() alone
        ("shadow_slots", "i4"),
        ("shadow_lobes", "i4", 2),
        ("index", "i4"),
        ("aovs", "i4", 2),  # first and end of the range
    ],
    align=True,
)


# The value of a material for shader AOV number ``aov`` of the scene: one number, or three.
AOV = np.dtype([("aov", "i4"), ("width", "i4"), ("operand", "i4")], align=True)


# The factor of the nodes of the world (row 0) and of the lights (row 1 on) on their radiance: a graph of RGB. Of the
# world also the graph of its shader AOVs, with the first and the end of their range.
EMISSION = np.dtype(
    [
        ("graph", "i4"),
        ("slots", "i4"),
        ("mean", "f8", 3),
        ("aov_graph", "i4"),
        ("aov_slots", "i4"),
        ("aovs", "i4", 2),
    ],
    align=True,
)


# The graph of a medium that varies in space (``medium.Varying.roots``); NO_GRAPH: it does not.
VOLUME = np.dtype([("graph", "i4"), ("slots", "i4")], align=True)


NO_GRAPH = -1


TABLES = {
    "emissions": EMISSION,
    "volumes": VOLUME,  # of the world, then of each material
    "materials": MATERIAL,
    "lobes": LOBE,
    "aovs": AOV,
    "constants": np.dtype("f8"),
    "graph_addresses": np.dtype(np.int64),
}
