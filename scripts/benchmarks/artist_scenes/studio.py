# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A product on a shadow catcher."""

from __future__ import annotations

from scenery.materials import Graph, principled
from scenery.modelling import add, box, plane, smooth_profile, turned
from scenery.staging import camera, light, panorama

from .stage import scene


@scene("a bottle and a box on a shadow catcher, for a picture with alpha")
def product(opened) -> None:
    opened.render.film_transparent = True
    ground = add("Ground", plane("Ground", (6.0, 6.0)), principled("Ground", (0.8, 0.8, 0.8, 1.0), 0.8))
    ground.is_shadow_catcher = True
    glass = Graph("Glass")
    glass.finish(glass.node("ShaderNodeBsdfGlass", Color=(0.75, 0.9, 0.8), Roughness=0.0, IOR=1.45))
    outline = smooth_profile([(0.0, 0.0), (0.28, 0.0), (0.3, 0.5), (0.1, 0.8), (0.1, 1.0), (0.0, 1.0)])
    add("Bottle", turned("Bottle", outline, 64), glass.material, location=(-0.25, 0.0, 0.001))
    gold = principled("Gold", (0.95, 0.7, 0.3, 1.0), 0.2, Metallic=1.0)
    add("Cap", turned("Cap", [(0.0, 0.0), (0.12, 0.0), (0.12, 0.16), (0.0, 0.17)]), gold, location=(-0.25, 0.0, 1.0))
    card = Graph("Card")
    wave = card.node("ShaderNodeTexWave", Vector=card.node("ShaderNodeTexCoord", "UV"), Scale=2.0, Distortion=3.0)
    ramp = card.node("ShaderNodeValToRGB", Fac=wave)
    ends = ramp.node.color_ramp.elements
    ends[0].color, ends[1].color = (0.05, 0.1, 0.3, 1.0), (0.9, 0.85, 0.7, 1.0)
    card.finish(card.node("ShaderNodeBsdfPrincipled", Base_Color=ramp, Roughness=0.3, Coat_Weight=0.5))
    add("Box", box("Box", (0.6, 0.4, 0.8), bevel=0.01), card.material, location=(0.5, 0.25, 0.401), rotation=(0, 0, 25))
    panorama("Studio", [(60.0, 35.0, 18.0, (6.0, 5.8, 5.5)), (-100.0, 20.0, 25.0, (1.5, 1.8, 2.4))])
    light("Key", "AREA", 80.0, (1.8, -1.6, 2.4), (0.0, 0.0, 0.4), shape="RECTANGLE", size=1.0, size_y=0.6)
    light("Rim", "AREA", 40.0, (-1.6, 1.6, 1.6), (0.0, 0.0, 0.5), (0.8, 0.9, 1.0), shape="SQUARE", size=0.5)
    camera((0.3, -3.4, 1.3), (0.05, 0.0, 0.55), 42.0, 8.0)
