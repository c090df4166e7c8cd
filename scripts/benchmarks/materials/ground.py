# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ground: slope, height and wetness determine the cover."""

from __future__ import annotations

from .shader import material


@material("terrain")
def terrain(s):
    """Rock where it is steep, grass where it is flat, sand below and snow above."""
    place = s.coordinates("Object")
    slope = s.axis(s.geometry("Normal"), "Z")
    height = s.axis(place, "Z")
    rough = s.noise(place, 7.0, 7.0, 0.65)
    steep = s.map_range(s.math("MULTIPLY_ADD", rough, 0.25, slope), 0.98, 0.86, smooth=True)
    strata = s.wave(place, 2.6, 2.0, bands_direction="Z", Detail=4.0)
    rock = s.mix(strata, (0.12, 0.1, 0.085), (0.3, 0.25, 0.2))
    grass = s.ramp(rough, (0.35, (0.05, 0.09, 0.015)), (0.65, (0.16, 0.2, 0.05)))
    low = s.mix(s.map_range(s.math("MULTIPLY_ADD", rough, 0.2, height), 0.33, 0.42), (0.45, 0.36, 0.22), grass)
    earth = s.mix(steep, low, rock)
    line = s.math("MULTIPLY_ADD", rough, 0.35, height)
    snow = s.math("MULTIPLY", s.map_range(line, 0.92, 1.0, smooth=True), s.math("SUBTRACT", 1.0, steep))
    color = s.mix(snow, earth, (0.88, 0.9, 0.94))
    return s.principled(color, s.mix_numbers(snow, 0.9, 0.55), Normal=s.bump(rough, 0.08, 0.7), Specular_IOR_Level=0.3)


@material("terrain")
def lava(s):
    """Crust with glowing cracks: blackbody by the distance to the crack, and heat that displaces the bump."""
    place = s.coordinates("Object")
    bent = s.mix(0.25, place, s.noise(place, 3.0, 4.0, 0.6, "Color"), "LINEAR_LIGHT")
    edge = s.voronoi(bent, 3.2, feature="DISTANCE_TO_EDGE", Randomness=1.0)
    fine = s.noise(place, 14.0, 7.0, 0.7)
    heat = s.map_range(s.math("MULTIPLY_ADD", fine, 0.08, edge), 0.12, 0.05, smooth=True)
    glow = s.node("ShaderNodeBlackbody", Temperature=s.map_range(heat, 0.0, 1.0, 900.0, 2300.0))
    strength = s.math("MULTIPLY", s.math("POWER", heat, 2.0), 3.0)
    crust = s.ramp(fine, (0.3, (0.008, 0.007, 0.007)), (0.7, (0.06, 0.05, 0.045)))
    return s.principled(
        crust,
        s.map_range(fine, 0.3, 0.7, 0.5, 0.95),
        Normal=s.bump(s.math("ADD", edge, s.math("MULTIPLY", fine, 0.3)), 0.15, 0.9),
        Emission_Color=glow,
        Emission_Strength=strength,
    )


@material("wall")
def wet_asphalt(s):
    """Puddles are where noise is low: smooth, dark, without bumps."""
    uv = s.coordinates("Object")
    grit = s.voronoi(uv, 46.0, "Color", Randomness=1.0)
    stones = s.voronoi(uv, 46.0, Randomness=1.0)
    shade = s.node("ShaderNodeSeparateColor", "Green", Color=grit)
    low = s.noise(uv, 1.7, 5.0, 0.55)
    wet = s.map_range(low, 0.53, 0.47, smooth=True)
    damp = s.map_range(low, 0.62, 0.5, smooth=True)
    line = s.math("COMPARE", s.axis(uv, "X"), 0.45, 0.09)
    worn = s.map_range(s.noise(uv, 13.0, 6.0, 0.7), 0.42, 0.52)
    tar = s.ramp(shade, (0.0, (0.03, 0.03, 0.032)), (0.7, (0.08, 0.078, 0.075)), (1.0, (0.22, 0.21, 0.2)))
    painted = s.mix(s.math("MULTIPLY", line, worn), tar, (0.7, 0.68, 0.6))
    color = s.mix(damp, painted, s.hue(painted, saturation=1.1, value=0.45))
    rough = s.mix_numbers(wet, s.mix_numbers(damp, 0.9, 0.5), 0.03)
    height = s.math("MULTIPLY", s.math("SUBTRACT", 1.0, wet), s.math("SUBTRACT", 1.0, stones))
    return s.principled(color, rough, IOR=1.4, Normal=s.bump(height, 0.03, 0.7))
