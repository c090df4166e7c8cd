# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Skin, leaves, moss, wax: light enters and leaves at other points."""

from __future__ import annotations

from .shader import material


@material("head")
def skin(s):
    """Pores and freckles over a subsurface that is deepest for red; oily where the face is convex."""
    place = s.coordinates("Object")
    blotches = s.noise(place, 2.4, 4.0, 0.6)
    pores = s.voronoi(place, 38.0, Randomness=0.9)
    freckle = s.map_range(s.voronoi(place, 13.0, Randomness=1.0), 0.12, 0.2, 1.0, 0.0, smooth=True)
    some = s.map_range(s.noise(place, 1.7, 2.0), 0.5, 0.6)
    base = s.ramp(blotches, (0.3, (0.62, 0.32, 0.24)), (0.55, (0.78, 0.48, 0.37)), (0.8, (0.7, 0.33, 0.28)))
    freckled = s.mix(s.math("MULTIPLY", s.math("MULTIPLY", freckle, some), 0.6), base, (0.32, 0.14, 0.08))
    oil = s.map_range(s.geometry("Pointiness"), 0.49, 0.53)
    rough = s.mix_numbers(oil, 0.55, 0.36)
    return s.principled(
        freckled,
        rough,
        Subsurface_Weight=1.0,
        Subsurface_Radius=(1.0, 0.35, 0.17),
        Subsurface_Scale=0.06,
        Normal=s.bump(pores, 0.01, 0.35),
        Sheen_Weight=0.1,
        Sheen_Roughness=0.3,
    )


@material("vase")
def wax(s):
    """A candle: paler and thinner towards the top, with drips."""
    place = s.coordinates("Object")
    up = s.map_range(s.axis(place, "Z"), 0.0, 1.9)
    drips = s.noise(s.mapped(place, scale=(4.0, 4.0, 0.5)), 1.5, 2.0, 0.5)
    color = s.ramp(
        s.math("MULTIPLY_ADD", drips, 0.15, up),
        (0.0, (0.62, 0.36, 0.16)),
        (0.6, (0.85, 0.66, 0.4)),
        (1.0, (0.95, 0.85, 0.65)),
    )
    return s.principled(
        color,
        0.42,
        Subsurface_Weight=1.0,
        Subsurface_Radius=(1.0, 0.7, 0.4),
        Subsurface_Scale=0.14,
        Normal=s.bump(drips, 0.06, 0.6),
        Coat_Weight=0.15,
        Coat_Roughness=0.3,
    )


@material("leaf")
def leaf(s):
    """Veins from the UVs, another colour from below, and light that passes between the veins."""
    uv = s.coordinates("UV")
    u, v = s.axis(uv, "X"), s.axis(uv, "Y")
    aside = s.math("ABSOLUTE", s.math("SUBTRACT", u, 0.5))
    middle = s.map_range(aside, 0.006, 0.02, 1.0, 0.0, smooth=True)
    ribs = s.math("PINGPONG", s.math("ADD", v, s.math("MULTIPLY", aside, -0.9)), 0.045)
    rib = s.map_range(ribs, 0.002, 0.009, 0.8, 0.0, smooth=True)
    veins = s.math("MAXIMUM", middle, rib)
    cells = s.voronoi(uv, 42.0, feature="DISTANCE_TO_EDGE", voronoi_dimensions="2D")
    patchy = s.noise(uv, 4.0, 5.0, 0.6)
    green = s.ramp(patchy, (0.3, (0.03, 0.13, 0.02)), (0.7, (0.09, 0.27, 0.04)))
    upper = s.mix(veins, green, (0.3, 0.42, 0.14))
    color = s.mix(s.geometry("Backfacing"), upper, s.hue(upper, saturation=0.75, value=1.5))
    normal = s.bump(s.math("ADD", s.math("MULTIPLY", cells, 0.4), s.math("MULTIPLY", veins, -0.6)), 0.02, 0.6)
    gloss = s.principled(color, 0.42, Normal=normal)
    through = s.node("ShaderNodeBsdfTranslucent", Color=s.hue(color, hue=0.47, saturation=1.2, value=1.7))
    return s.mix_shaders(s.mix_numbers(veins, 0.45, 0.15), gloss, through)


@material("ball")
def moss(s):
    """Tufts: sheen for the fuzz, hue by a cell's random colour, earth between."""
    place = s.coordinates("Object")
    tufts = s.voronoi(place, 14.0, feature="SMOOTH_F1", Smoothness=0.6, Randomness=1.0)
    each = s.voronoi(place, 14.0, "Color", Randomness=1.0)
    fine = s.noise(place, 55.0, 4.0, 0.75)
    ground = s.map_range(s.noise(place, 1.8, 5.0, 0.6), 0.42, 0.5, smooth=True)
    green = s.hue(
        (0.11, 0.22, 0.03, 1.0),
        hue=s.map_range(s.node("ShaderNodeSeparateColor", "Red", Color=each), 0.0, 1.0, 0.46, 0.54),
        value=s.map_range(fine, 0.3, 0.7, 0.5, 1.5),
    )
    color = s.mix(ground, (0.09, 0.06, 0.035), green)
    height = s.math("MULTIPLY", ground, s.math("SUBTRACT", s.math("MULTIPLY", fine, 0.5), tufts))
    return s.principled(
        color,
        0.95,
        Normal=s.bump(height, 0.09, 0.9),
        Sheen_Weight=s.math("MULTIPLY", ground, 0.8),
        Sheen_Roughness=0.5,
        Sheen_Tint=(0.5, 0.8, 0.3, 1.0),
        Specular_IOR_Level=0.2,
    )
