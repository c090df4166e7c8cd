# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stone, and masonry."""

from __future__ import annotations

from .shader import material


@material("ball")
def white_marble(s):
    """Veins are where a noise that is bent by another one crosses a half; light enters a little."""
    place = s.coordinates("Object", scale=0.9)
    warp = s.noise(place, 1.7, 5.0, 0.6, "Color")
    bent = s.vector_math("MULTIPLY_ADD", warp, (0.9, 0.9, 0.9), _2=place)
    veins = s.math("ABSOLUTE", s.math("SUBTRACT", s.noise(bent, 1.9, 8.0, 0.62), 0.5))
    fine = s.math("ABSOLUTE", s.math("SUBTRACT", s.noise(bent, 6.5, 4.0, 0.6), 0.5))
    wide = s.ramp(veins, (0.0, (0.22, 0.23, 0.25)), (0.05, (0.6, 0.6, 0.61)), (0.16, (0.9, 0.89, 0.87)))
    thin = s.ramp(fine, (0.0, 0.6), (0.03, 1.0))
    color = s.mix(0.7, wide, thin, "MULTIPLY")
    return s.principled(
        color,
        0.18,
        Subsurface_Weight=0.15,
        Subsurface_Radius=(0.3, 0.25, 0.2),
        Subsurface_Scale=0.1,
        Coat_Weight=0.3,
        Coat_Roughness=0.05,
    )


@material("vase")
def green_marble(s):
    place = s.coordinates("Generated", scale=(2.0, 2.0, 2.0))
    bands = s.wave(place, 1.3, 9.0, wave_type="BANDS", bands_direction="DIAGONAL", Detail=4.0, Detail_Scale=1.3)
    clouds = s.node("ShaderNodeTexMagic", "Fac", Vector=place, Scale=1.1, Distortion=2.2, turbulence_depth=4)
    mixed = s.math("MULTIPLY", bands, clouds)
    color = s.ramp(
        mixed,
        (0.0, (0.005, 0.03, 0.02)),
        (0.35, (0.02, 0.13, 0.08)),
        (0.6, (0.12, 0.33, 0.2)),
        (0.85, (0.75, 0.82, 0.72)),
        interpolation="B_SPLINE",
    )
    return s.principled(color, s.map_range(bands, 0.0, 1.0, 0.08, 0.2), IOR=1.6)


@material("wall")
def brick(s):
    """Bricks of many tints, with worn edges, soft mortar and stains that ran down."""
    uv = s.coordinates("UV", scale=(5.0, 3.8, 1.0))
    warp = s.noise(uv, 6.0, 3.0, 0.6, "Color")
    bent = s.mix(0.015, uv, warp, "LINEAR_LIGHT")
    bricks = s.node(
        "ShaderNodeTexBrick",
        Vector=bent,
        Color1=(0.42, 0.12, 0.07),
        Color2=(0.2, 0.06, 0.05),
        Mortar=(0.45, 0.42, 0.38),
        Scale=1.6,
        Mortar_Size=0.03,
        Mortar_Smooth=0.25,
        Bias=-0.2,
    )
    mortar = bricks.node.outputs["Fac"]
    pits = s.noise(uv, 22.0, 5.0, 0.7)
    dirt = s.noise(s.mapped(uv, scale=(2.2, 0.4, 1.0)), 2.0, 4.0, 0.6)
    color = s.mix(0.55, bricks, s.ramp(pits, (0.25, 0.45), (0.7, 1.25)), "MULTIPLY")
    stained = s.mix(s.map_range(dirt, 0.5, 0.75, 0.0, 0.7), color, (0.05, 0.045, 0.04))
    height = s.math("SUBTRACT", s.math("MULTIPLY", pits, 0.35), mortar)
    return s.principled(stained, s.map_range(mortar, 0.0, 1.0, 0.75, 0.95), Normal=s.bump(height, 0.05, 0.9))


@material("cube")
def concrete(s):
    place = s.coordinates("Object")
    patches = s.noise(place, 1.6, 6.0, 0.65)
    sand = s.noise(place, 60.0, 2.0, 0.6)
    holes = s.voronoi(place, 13.0, Randomness=1.0)
    pit = s.map_range(holes, 0.06, 0.13, 0.0, 1.0, smooth=True)
    color = s.ramp(patches, (0.3, (0.24, 0.235, 0.225)), (0.55, (0.40, 0.39, 0.37)), (0.75, (0.5, 0.49, 0.47)))
    grained = s.mix(0.25, color, s.ramp(sand, (0.3, 0.3), (0.7, 1.0)), "OVERLAY")
    dark = s.mix(1.0, grained, s.ramp(pit, (0.0, 0.35), (1.0, 1.0)), "MULTIPLY")
    height = s.math("ADD", s.math("MULTIPLY", sand, 0.12), pit)
    return s.principled(dark, s.map_range(patches, 0.3, 0.7, 0.9, 0.6), Normal=s.bump(height, 0.02, 0.7))


@material("wall")
def tiles(s):
    """Glazed tiles: white noise of the cell's number picks one of three patterns."""
    uv = s.coordinates("UV", scale=(7.5, 5.7, 1.0))
    cell = s.vector_math("FLOOR", uv)
    inside = s.vector_math("FRACTION", uv)
    centred = s.vector_math("SUBTRACT", inside, (0.5, 0.5, 0.0))
    away = s.vector_math("ABSOLUTE", centred)
    edge = s.math("MAXIMUM", s.axis(away, "X"), s.axis(away, "Y"))
    joint = s.map_range(edge, 0.46, 0.485, smooth=True)
    ring = s.math("PINGPONG", s.node("ShaderNodeVectorMath", "Value", _0=centred, operation="LENGTH"), 0.17)
    number = s.random(cell)
    plain = s.math("GREATER_THAN", number, 0.45)
    pattern = s.math("MULTIPLY", s.map_range(ring, 0.075, 0.095, smooth=True), plain)
    glaze = s.mix(pattern, (0.82, 0.8, 0.74), (0.03, 0.12, 0.38))
    tinted = s.hue(glaze, value=s.map_range(number, 0.0, 1.0, 0.85, 1.05))
    color = s.mix(joint, tinted, (0.33, 0.31, 0.28))
    tilt = s.math("MULTIPLY", s.random(cell), 0.12)
    height = s.math("SUBTRACT", tilt, joint)
    return s.principled(color, s.mix_numbers(joint, 0.06, 0.85), Normal=s.bump(height, 0.02, 0.6))


@material("ball")
def terracotta(s):
    place = s.coordinates("Object")
    rings = s.wave(place, 6.0, 0.6, wave_type="BANDS", bands_direction="Z", Detail=1.0)
    chalk = s.noise(place, 3.0, 7.0, 0.7)
    grit = s.node("ShaderNodeTexGabor", "Value", Vector=place, Scale=9.0, Frequency=2.0, Anisotropy=0.2)
    color = s.ramp(chalk, (0.35, (0.48, 0.17, 0.08)), (0.6, (0.58, 0.25, 0.13)), (0.75, (0.72, 0.55, 0.45)))
    height = s.math("ADD", s.math("MULTIPLY", rings, 0.4), s.math("MULTIPLY", grit, 0.25))
    return s.principled(
        color, s.map_range(chalk, 0.3, 0.8, 0.7, 0.95), Diffuse_Roughness=0.8, Normal=s.bump(height, 0.02, 0.5)
    )
