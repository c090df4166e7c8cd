# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A character with skin and hair."""

from __future__ import annotations

import math

import bpy
import numpy as np
from scenery.materials import Graph, principled
from scenery.modelling import add, plane, smooth_profile, turned
from scenery.staging import camera, light, panorama

from .stage import scene

STRANDS, POINTS = 4000, 6


def _skin():
    graph = Graph("Skin")
    place = graph.node("ShaderNodeTexCoord", "Object")
    blotch = graph.node("ShaderNodeTexNoise", Vector=place, Scale=5.0, Detail=4.0)
    tone = graph.node("ShaderNodeMix", data_type="RGBA", _0=blotch, _1=(0.55, 0.3, 0.22), _2=(0.75, 0.45, 0.35))
    pores = graph.node("ShaderNodeTexVoronoi", Vector=place, Scale=120.0)
    return graph.finish(
        graph.node(
            "ShaderNodeBsdfPrincipled",
            Base_Color=tone,
            Roughness=0.42,
            Subsurface_Weight=1.0,
            Subsurface_Radius=(1.0, 0.35, 0.2),
            Subsurface_Scale=0.05,
            Normal=graph.bump(pores, 0.002, 0.5),
        )
    )


def _hair(center, radius: float) -> bpy.types.Object:
    """Strands that fall from the upper half of a ball."""
    random = np.random.default_rng(3)
    up = random.uniform(0.2, 1.0, STRANDS)
    turn = random.uniform(0.0, 2.0 * math.pi, STRANDS)
    flat = np.sqrt(1.0 - up * up)
    out = np.stack([flat * np.cos(turn), flat * np.sin(turn), up], axis=1)
    out = out[(out[:, 1] > -0.35) | (out[:, 2] > 0.75)]  # the face is free
    step = np.linspace(0.0, 1.0, POINTS)[None, :, None]
    side = out * (1.0, 1.0, 0.0)
    curl = 0.02 * random.standard_normal((len(out), 1, 3)) * step
    strands = radius * (out[:, None] * (1.0 + 0.25 * step) + side[:, None] * 0.1 * step) + curl
    strands[..., 2] -= (1.1 * radius * step**2)[..., 0]
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([POINTS] * len(out))
    data.points.foreach_set("position", (strands + np.asarray(center)).astype(np.float32).ravel())
    widths = np.broadcast_to(0.0025 * (1.0 - 0.8 * step[..., 0]), strands.shape[:2])
    data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", widths.astype(np.float32).ravel())
    graph = Graph("Hair")
    graph.finish(
        graph.node(
            "ShaderNodeBsdfHairPrincipled",
            parametrization="MELANIN",
            Melanin=0.75,
            Melanin_Redness=0.6,
            Roughness=0.3,
            Random_Roughness=0.1,
        )
    )
    return add("Hair", data, graph.material)


@scene("a bust of skin with hair, lit by three lamps and a studio")
def character(opened) -> None:
    skin = _skin()
    head = smooth_profile([(0.0, -0.3), (0.14, -0.26), (0.21, -0.05), (0.23, 0.1), (0.17, 0.25), (0.0, 0.31)])
    add("Head", turned("Head", head, 96), skin, location=(0.0, 0.0, 1.6))
    nose = smooth_profile([(0.0, -0.05), (0.035, -0.03), (0.03, 0.02), (0.0, 0.05)])
    add("Nose", turned("Nose", nose, 32), skin, location=(0.0, -0.23, 1.58))
    add("Neck", turned("Neck", [(0.1, 0.0), (0.09, 0.25)], 64), skin, location=(0.0, 0.02, 1.2))
    shirt = smooth_profile([(0.45, -0.5), (0.42, 0.0), (0.3, 0.12), (0.11, 0.17)])
    add("Shirt", turned("Shirt", shirt, 64), principled("Shirt", (0.08, 0.1, 0.16, 1.0), 0.9, Sheen_Weight=0.5))
    bpy.data.objects["Shirt"].location = (0.0, 0.02, 1.1)
    eye = principled("Eye", (0.9, 0.9, 0.88, 1.0), 0.05, Coat_Weight=1.0)
    ball = smooth_profile([(0.0, -0.035), (0.025, -0.025), (0.035, 0.0), (0.025, 0.025), (0.0, 0.035)])
    for x in (-0.08, 0.08):
        add("Eye", turned("Eye", ball, 32), eye, location=(x, -0.195, 1.65))
    _hair((0.0, 0.01, 1.65), 0.235)
    add(
        "Backdrop",
        plane("Backdrop", (6.0, 4.0)),
        principled("Backdrop", (0.25, 0.27, 0.3, 1.0), 0.9),
        location=(0.0, 1.6, 1.5),
        rotation=(90, 0, 0),
    )
    panorama("Studio", [(-20.0, 40.0, 20.0, (2.0, 1.9, 1.8))], zenith=(0.15, 0.16, 0.2))
    light("Key", "AREA", 45.0, (-1.3, -1.5, 2.4), (0.0, 0.0, 1.6), (1.0, 0.93, 0.85), shape="SQUARE", size=0.7)
    light("Fill", "AREA", 12.0, (1.6, -1.2, 1.7), (0.0, 0.0, 1.6), (0.8, 0.9, 1.0), shape="SQUARE", size=1.2)
    light("Rim", "SPOT", 90.0, (0.9, 1.3, 2.6), (0.0, 0.0, 1.7), spot_size=0.7, shadow_soft_size=0.1)
    camera((0.25, -2.3, 1.7), (0.0, 0.0, 1.58), 28.0, 4.0, (0.0, -0.2, 1.6))
