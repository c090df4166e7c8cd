# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloth and leather."""

from __future__ import annotations

from .shader import material


@material("cloth")
def denim(s):
    """Diagonal threads of two colours, faded where the cloth is worn."""
    uv = s.coordinates("UV", scale=(60.0, 50.0, 1.0))
    diagonal = s.math("FRACT", s.math("MULTIPLY", s.math("ADD", s.axis(uv, "X"), s.axis(uv, "Y")), 0.25))
    twill = s.map_range(s.math("PINGPONG", diagonal, 0.5), 0.1, 0.35, smooth=True)
    slub = s.noise(s.mapped(uv, scale=(1.0, 0.04, 1.0)), 1.0, 3.0, 0.7)
    worn = s.noise(s.coordinates("UV"), 3.0, 5.0, 0.6)
    blue = s.mix(slub, (0.012, 0.03, 0.09), (0.05, 0.11, 0.26))
    white = s.mix(s.map_range(worn, 0.4, 0.7), (0.16, 0.2, 0.27), (0.55, 0.56, 0.55))
    color = s.mix(twill, white, blue)
    height = s.math("MULTIPLY_ADD", slub, 0.3, twill)
    return s.principled(
        color,
        0.9,
        Normal=s.bump(height, 0.01, 0.7),
        Sheen_Weight=0.3,
        Sheen_Roughness=0.6,
        Diffuse_Roughness=0.7,
        Specular_IOR_Level=0.2,
    )


@material("cloth")
def velvet(s):
    """Dark in the face and bright at the rim, with stripes pressed into the pile."""
    uv = s.coordinates("UV")
    crush = s.noise(uv, 5.0, 6.0, 0.65, "Color", Distortion=0.8)
    stripe = s.wave(s.mapped(uv, scale=(3.0, 1.0, 1.0)), 1.6, 0.4, wave_profile="TRI")
    pressed = s.map_range(stripe, 0.45, 0.55, smooth=True)
    rim = s.math("POWER", s.facing(0.5), 1.6)
    deep = s.mix(pressed, (0.09, 0.004, 0.03), (0.16, 0.01, 0.05))
    color = s.mix(rim, deep, (0.5, 0.09, 0.2))
    lean = s.vector_math(
        "ADD",
        s.geometry("Normal"),
        s.vector_math("SCALE", s.vector_math("SUBTRACT", crush, (0.5, 0.5, 0.5)), Scale=0.8),
    )
    diffuse = s.node("ShaderNodeBsdfDiffuse", Color=color, Roughness=1.0, Normal=s.vector_math("NORMALIZE", lean))
    pile = s.node("ShaderNodeBsdfSheen", Color=(0.75, 0.3, 0.4), Roughness=s.mix_numbers(pressed, 0.25, 0.5))
    return s.add_shaders(diffuse, pile)


@material("cloth")
def silk(s):
    """Brocade: satin whose anisotropy turns with the pattern."""
    uv = s.coordinates("UV", scale=(5.0, 4.2, 1.0))
    inside = s.vector_math("SUBTRACT", s.vector_math("FRACTION", uv), (0.5, 0.5, 0.0))
    length = s.node("ShaderNodeVectorMath", "Value", _0=inside, operation="LENGTH")
    angle = s.math("ARCTAN2", s.axis(inside, "Y"), s.axis(inside, "X"))
    petals = s.math("MULTIPLY_ADD", s.math("COSINE", s.math("MULTIPLY", angle, 6.0)), 0.09, 0.3)
    flower = s.map_range(s.math("SUBTRACT", petals, length), -0.01, 0.02, smooth=True)
    threads = s.wave(s.coordinates("UV"), 55.0, 0.0, bands_direction="Y")
    color = s.mix(flower, (0.55, 0.06, 0.12), (0.85, 0.6, 0.22))
    return s.principled(
        color,
        0.32,
        Metallic=s.math("MULTIPLY", flower, 0.5),
        Anisotropic=0.7,
        Anisotropic_Rotation=s.math("MULTIPLY", flower, 0.25),
        Normal=s.bump(threads, 0.002, 0.25),
        Sheen_Weight=0.4,
    )


@material("ball")
def leather(s):
    """Grain of rounded cells in cells, creases, darker in the folds."""
    place = s.coordinates("Object")
    bent = s.mix(0.06, place, s.noise(place, 7.0, 2.0, 0.5, "Color"), "LINEAR_LIGHT")
    large = s.voronoi(bent, 7.0, feature="DISTANCE_TO_EDGE", Randomness=0.9)
    small = s.voronoi(bent, 19.0, feature="DISTANCE_TO_EDGE", Randomness=1.0)
    cushion = s.math("MULTIPLY", s.map_range(large, 0.0, 0.1, smooth=True), s.map_range(small, 0.0, 0.13, smooth=True))
    tan = s.noise(place, 2.2, 5.0, 0.55)
    color = s.ramp(tan, (0.3, (0.15, 0.05, 0.02)), (0.6, (0.31, 0.12, 0.045)), (0.8, (0.42, 0.2, 0.09)))
    dark = s.mix(1.0, color, s.ramp(cushion, (0.0, 0.3), (0.5, 1.0)), "MULTIPLY")
    return s.principled(
        dark,
        s.map_range(cushion, 0.0, 1.0, 0.75, 0.42),
        Normal=s.bump(cushion, 0.025, 0.7),
        Coat_Weight=0.12,
        Coat_Roughness=0.3,
    )
