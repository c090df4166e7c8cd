# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wood and bark."""

from __future__ import annotations

from .shader import material


@material("cube")
def oak(s):
    """Rings cut lengthwise: noise stretched along the grain bends the bands, pores are a finer, longer noise."""
    place = s.coordinates("Object", scale=(1.0, 1.0, 0.14))
    warp = s.noise(place, 3.0, 4.0, 0.6, "Color")
    bent = s.mix(0.12, place, warp, "LINEAR_LIGHT")
    rings = s.wave(bent, 3.2, 3.0, Detail=3.0, Detail_Scale=1.5, bands_direction="X", wave_profile="SAW")
    pores = s.noise(s.mapped(place, scale=(60.0, 60.0, 6.0)), 1.0, 2.0, 0.6)
    tint = s.ramp(rings, (0.0, (0.36, 0.19, 0.08)), (0.45, (0.55, 0.33, 0.15)), (1.0, (0.24, 0.11, 0.045)))
    dark = s.ramp(pores, (0.32, 0.35), (0.5, 1.0))
    color = s.mix(0.8, tint, dark, "MULTIPLY")
    rough = s.map_range(pores, 0.3, 0.7, 0.62, 0.38)
    height = s.math("MULTIPLY_ADD", rings, 0.25, pores)
    return s.principled(color, rough, Normal=s.bump(height, 0.006, 0.6), Coat_Weight=0.25, Coat_Roughness=0.2)


@material("wall")
def planks(s):
    """A floor of boards: bricks give each board its own tint and its own place in the grain."""
    uv = s.coordinates("UV", scale=(4.0, 4.0, 1.0))
    boards = s.node(
        "ShaderNodeTexBrick",
        Vector=uv,
        Color1=(0.0, 0.0, 0.0),
        Color2=(1.0, 1.0, 1.0),
        Mortar=(0.0, 0.0, 0.0),
        Scale=1.0,
        Mortar_Size=0.012,
        Brick_Width=1.6,
        Row_Height=0.4,
        offset=0.37,
    )
    number = boards.node.outputs["Color"]
    shifted = s.vector_math("ADD", uv, s.vector_math("SCALE", number, Scale=17.3))
    grain = s.noise(s.mapped(shifted, scale=(1.3, 14.0, 1.0)), 2.2, 6.0, 0.65, Distortion=0.6)
    color = s.ramp(grain, (0.25, (0.11, 0.05, 0.025)), (0.55, (0.33, 0.17, 0.08)), (0.8, (0.5, 0.3, 0.16)))
    tinted = s.hue(color, hue=0.5, value=s.map_range(number, 0.0, 1.0, 0.65, 1.25))
    gap = boards.node.outputs["Fac"]
    joined = s.mix(gap, tinted, (0.02, 0.012, 0.008))
    height = s.math("SUBTRACT", s.math("MULTIPLY", grain, 0.2), gap)
    return s.principled(joined, s.map_range(grain, 0.2, 0.8, 0.5, 0.28), Normal=s.bump(height, 0.02, 0.8))


@material("vase")
def bark(s):
    """Furrows that run up the trunk, with moss where it is wet."""
    place = s.coordinates("Object", scale=(1.0, 1.0, 0.3))
    warp = s.noise(place, 4.0, 5.0, 0.6, "Color")
    bent = s.mix(0.18, place, warp, "ADD")
    furrows = s.voronoi(bent, 6.5, feature="F1", distance="MANHATTAN", Randomness=0.85)
    fine = s.noise(place, 26.0, 6.0, 0.7, noise_type="RIDGED_MULTIFRACTAL", normalize=False)
    height = s.math("ADD", furrows, s.math("MULTIPLY", fine, 0.12))
    brown = s.ramp(height, (0.1, (0.30, 0.22, 0.16)), (0.45, (0.17, 0.11, 0.07)), (0.9, (0.03, 0.02, 0.015)))
    wet = s.noise(s.coordinates("Object"), 2.2, 3.0, 0.6)
    moss = s.math("MULTIPLY", s.map_range(wet, 0.5, 0.62, smooth=True), s.map_range(height, 0.7, 0.3))
    color = s.mix(moss, brown, (0.09, 0.16, 0.03))
    return s.principled(color, 0.9, Normal=s.bump(s.math("SUBTRACT", 1.0, height), 0.12, 0.9), Specular_IOR_Level=0.2)
