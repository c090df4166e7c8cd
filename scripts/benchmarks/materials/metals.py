# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Metals, bright and rusty."""

from __future__ import annotations

from .shader import material


@material("ball")
def brushed_metal(s):
    """Streaks around the axis: anisotropic, with a roughness that varies across them."""
    place = s.coordinates("Object", scale=(1.5, 1.5, 90.0))
    streaks = s.noise(place, 1.0, 4.0, 0.7)
    rough = s.map_range(streaks, 0.3, 0.7, 0.18, 0.42)
    tangent = s.node("ShaderNodeTangent", direction_type="RADIAL", axis="Z")
    color = s.mix(streaks, (0.52, 0.52, 0.54), (0.72, 0.71, 0.69))
    smudge = s.noise(s.coordinates("Object"), 2.5, 3.0, 0.6)
    dull = s.math("MULTIPLY_ADD", s.map_range(smudge, 0.55, 0.7), 0.12, rough)
    return s.principled(
        color, dull, Metallic=1.0, Anisotropic=0.75, Tangent=tangent, Normal=s.bump(streaks, 0.002, 0.4)
    )


@material("head")
def gold(s):
    place = s.coordinates("Object")
    dents = s.noise(place, 2.6, 2.0, 0.5)
    fine = s.noise(place, 40.0, 2.0, 0.6)
    rough = s.map_range(fine, 0.3, 0.7, 0.1, 0.26)
    hollow = s.ramp(s.geometry("Pointiness"), (0.44, 0.25), (0.5, 1.0))
    color = s.mix(1.0, (1.0, 0.72, 0.30), hollow, "MULTIPLY")
    return s.node(
        "ShaderNodeBsdfMetallic",
        Base_Color=color,
        Edge_Tint=(1.0, 0.9, 0.6),
        Roughness=rough,
        Normal=s.bump(dents, 0.05, 0.3),
    )


@material("vase")
def hammered_copper(s):
    """Blows of a hammer, verdigris in the hollows."""
    place = s.coordinates("Object")
    blows = s.voronoi(place, 5.5, feature="SMOOTH_F1", Smoothness=0.35, Randomness=0.8)
    patina = s.noise(place, 3.2, 7.0, 0.68)
    mask = s.math("MULTIPLY", s.map_range(patina, 0.52, 0.62, smooth=True), s.map_range(blows, 0.25, 0.55))
    copper = s.principled((0.93, 0.52, 0.36), 0.2, Metallic=1.0, Normal=s.bump(s.math("POWER", blows, 2.0), 0.08, 0.7))
    green = s.ramp(s.noise(place, 17.0, 4.0, 0.6), (0.3, (0.06, 0.24, 0.2)), (0.7, (0.26, 0.5, 0.42)))
    crust = s.principled(green, 0.9, Normal=s.bump(patina, 0.03, 0.8))
    return s.mix_shaders(mask, copper, crust)


@material("cube")
def rusty_iron(s):
    """Two shaders and a mask with edges: rust is rough and no metal."""
    place = s.coordinates("Object")
    flakes = s.noise(place, 4.2, 9.0, 0.68, Distortion=0.3)
    spots = s.voronoi(place, 16.0, Randomness=1.0)
    mask = s.map_range(s.math("SUBTRACT", flakes, s.math("MULTIPLY", spots, 0.16)), 0.38, 0.47, smooth=True)
    rust = s.ramp(flakes, (0.4, (0.09, 0.025, 0.01)), (0.55, (0.30, 0.09, 0.02)), (0.7, (0.5, 0.2, 0.06)))
    scratch = s.noise(s.mapped(place, scale=(2.0, 60.0, 2.0), rotation=(0.3, 0.2, 0.5)), 1.0, 2.0, 0.6)
    iron = s.principled((0.32, 0.32, 0.33), s.map_range(scratch, 0.3, 0.7, 0.25, 0.5), Metallic=1.0)
    crust = s.principled(rust, 0.92, Normal=s.bump(flakes, 0.06, 0.9))
    return s.mix_shaders(mask, iron, crust)


@material("ball")
def scratched_steel(s):
    """Hairlines in all directions: stretched Voronoi edges in three turns."""
    lines = None
    for turn, scale in ((0.3, 5.0), (1.4, 7.0), (2.5, 4.0)):
        place = s.coordinates("UV", scale=(2.0, 40.0, 1.0), rotation=(0.0, 0.0, turn))
        edge = s.voronoi(place, scale, feature="DISTANCE_TO_EDGE", voronoi_dimensions="2D")
        line = s.map_range(edge, 0.0, 0.02, 1.0, 0.0)
        lines = line if lines is None else s.math("MAXIMUM", lines, line)
    patchy = s.math("MULTIPLY", lines, s.map_range(s.noise(s.coordinates("Object"), 3.0, 3.0), 0.45, 0.6))
    rough = s.mix_numbers(patchy, 0.12, 0.45)
    return s.principled(
        (0.56, 0.57, 0.58), rough, Metallic=1.0, Specular_Tint=(0.9, 0.95, 1.0, 1.0), Normal=s.bump(patchy, 0.004, 0.5)
    )
