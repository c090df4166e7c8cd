# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Unreal light and colour: bubbles, holograms, neon, comics."""

from __future__ import annotations

from .shader import material


@material("ball")
def iridescence(s):
    """A soap bubble: transparent except for a film whose thickness runs down in swirls."""
    place = s.coordinates("Object")
    swirl = s.noise(place, 1.3, 5.0, 0.55, "Color", Distortion=1.5)
    down = s.map_range(s.axis(place, "Z"), -1.0, 1.0, 620.0, 180.0)
    film = s.math("MULTIPLY_ADD", s.node("ShaderNodeSeparateColor", "Red", Color=swirl), 260.0, down)
    shell = s.principled((0.9, 0.9, 0.9), 0.02, Metallic=1.0, Thin_Film_Thickness=film, Thin_Film_IOR=1.33)
    see = s.math("MULTIPLY_ADD", s.math("POWER", s.facing(0.5), 2.0), 0.65, 0.12, clamp=True)
    return s.mix_shaders(see, s.node("ShaderNodeBsdfTransparent"), shell)


@material("head")
def hologram(s):
    """Scan lines of light, brighter at the rim, that flicker and are seen through."""
    place = s.geometry("Position")
    height = s.axis(place, "Z")
    lines = s.math("PINGPONG", height, 0.018)
    line = s.map_range(lines, 0.004, 0.014, smooth=True)
    jitter = s.noise(s.mapped(place, scale=(0.1, 0.1, 6.0)), 3.0, 2.0)
    broken = s.math("GREATER_THAN", jitter, 0.42)
    rim = s.fresnel(1.25)
    seen = s.math("ADD", s.math("MULTIPLY", line, 0.35), rim, clamp=True)
    alpha = s.math("MULTIPLY", seen, s.map_range(broken, 0.0, 1.0, 0.3, 1.0))
    color = s.ramp(
        s.map_range(height, 0.2, 1.8), (0.0, (0.1, 0.3, 1.0)), (0.6, (0.05, 0.8, 1.0)), (1.0, (0.6, 1.0, 0.9))
    )
    glow = s.emission(color, s.math("MULTIPLY_ADD", rim, 2.2, 0.7))
    return s.mix_shaders(alpha, s.node("ShaderNodeBsdfTransparent"), glow)


@material("tube")
def neon_sign(s):
    """A tube that glows more in its middle, is dark at the ends, and lights the floor more than the camera sees."""
    along = s.axis(s.coordinates("UV"), "X")
    ends = s.math("MULTIPLY", s.map_range(along, 0.0, 0.04), s.map_range(along, 1.0, 0.96))
    buzz = s.noise(s.coordinates("UV", scale=(26.0, 1.0, 1.0)), 2.0, 2.0, 0.6)
    middle = s.math("SUBTRACT", 1.0, s.facing(0.5))
    color = s.ramp(
        s.math("POWER", middle, 2.0), (0.0, (1.0, 0.02, 0.18)), (0.6, (1.0, 0.12, 0.3)), (1.0, (1.0, 0.75, 0.8))
    )
    shown = s.node("ShaderNodeLightPath", "Is Camera Ray")
    strength = s.math(
        "MULTIPLY", ends, s.math("MULTIPLY", s.map_range(buzz, 0.2, 0.8, 0.7, 1.2), s.mix_numbers(shown, 5.0, 1.6))
    )
    glass = s.principled((0.9, 0.85, 0.85), 0.05, Coat_Weight=0.5)
    return s.mix_shaders(s.map_range(ends, 0.0, 1.0, 0.0, 0.94), glass, s.emission(color, strength))


@material("head")
def comic(s):
    """Toon steps, dots of ink where it is darker, an outline by the angle."""
    toon = s.node("ShaderNodeBsdfToon", Color=(0.9, 0.55, 0.15), Size=0.75, Smooth=0.03)
    dots = s.vector_math("FRACTION", s.coordinates("Window", scale=(46.0, 46.0, 1.0)))
    away = s.node(
        "ShaderNodeVectorMath",
        "Value",
        _0=s.vector_math("MULTIPLY", dots, (1.0, 1.0, 0.0)),
        _1=(0.5, 0.5, 0.0),
        operation="DISTANCE",
    )
    light = s.map_range(s.axis(s.geometry("Normal"), "Z"), -0.3, 0.6)
    dot = s.math("LESS_THAN", away, s.map_range(light, 0.0, 1.0, 0.45, 0.0))
    ink = s.math("MAXIMUM", dot, s.math("GREATER_THAN", s.facing(0.5), 0.8))
    flat = s.emission((0.5, 0.16, 0.06), 0.35)
    shine = s.node("ShaderNodeBsdfToon", Color=(1.0, 1.0, 0.95), Size=0.25, Smooth=0.0, component="GLOSSY")
    lit = s.add_shaders(s.mix_shaders(0.3, toon, shine), flat)
    return s.mix_shaders(ink, lit, s.node("ShaderNodeBsdfDiffuse", Color=(0.02, 0.015, 0.02)))


@material("cube")
def circuit(s):
    """A board with traces that light runs along: snapped coordinates and white noise make the layout."""
    place = s.coordinates("Object", scale=(6.0, 6.0, 6.0))
    cell = s.vector_math("FLOOR", place)
    inside = s.vector_math("ABSOLUTE", s.vector_math("SUBTRACT", s.vector_math("FRACTION", place), (0.5, 0.5, 0.5)))
    pick = s.random(cell)
    x, z = s.axis(inside, "X"), s.axis(inside, "Z")
    across = s.math("LESS_THAN", s.mix_numbers(s.math("GREATER_THAN", pick, 0.5), x, z), 0.07)
    pad = s.math("LESS_THAN", s.math("MAXIMUM", x, z), s.math("MULTIPLY", pick, 0.2))
    trace = s.math("MAXIMUM", across, pad)
    pulse = s.math("SINE", s.math("MULTIPLY_ADD", s.axis(place, "X"), 1.3, s.math("MULTIPLY", pick, 6.0)))
    lit = s.math("MULTIPLY", trace, s.map_range(pulse, 0.3, 1.0))
    board = s.mix(trace, (0.006, 0.035, 0.012), (0.55, 0.35, 0.08))
    return s.principled(
        board,
        s.mix_numbers(trace, 0.45, 0.25),
        Metallic=trace,
        Normal=s.bump(trace, 0.01, 0.5),
        Emission_Color=(0.1, 1.0, 0.5, 1.0),
        Emission_Strength=s.math("MULTIPLY", lit, 2.0),
    )
