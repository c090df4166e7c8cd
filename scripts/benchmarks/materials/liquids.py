# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass, ice, amber."""

from __future__ import annotations

from .shader import material


@material("vase")
def dirty_glass(s):
    """Clear glass with dust where it lies, fingerprints in the roughness, and rays of shadow let through."""
    place = s.coordinates("Object")
    up = s.map_range(s.axis(s.geometry("Normal"), "Z"), 0.1, 0.9)
    specks = s.noise(place, 9.0, 9.0, 0.75)
    dust = s.math("MULTIPLY", s.map_range(specks, 0.48, 0.62, smooth=True), s.math("MULTIPLY_ADD", up, 0.6, 0.25))
    print_ = s.wave(s.mapped(place, scale=(3.0, 3.0, 3.0), rotation=(0.4, 0.9, 0.2)), 4.0, 6.0, wave_type="RINGS")
    where = s.map_range(s.noise(place, 2.2, 2.0), 0.55, 0.62, smooth=True)
    rough = s.math("MULTIPLY", s.math("MULTIPLY", print_, where), 0.18)
    glass = s.node("ShaderNodeBsdfGlass", Color=(0.92, 0.97, 0.95), Roughness=rough, IOR=1.45)
    clear = s.mix_shaders(
        s.node("ShaderNodeLightPath", "Is Shadow Ray"),
        glass,
        s.node("ShaderNodeBsdfTransparent", Color=(0.85, 0.92, 0.9)),
    )
    dirt = s.node("ShaderNodeBsdfDiffuse", Color=s.mix(specks, (0.28, 0.24, 0.18), (0.46, 0.42, 0.35)), Roughness=1.0)
    return s.mix_shaders(dust, clear, dirt)


@material("ball")
def frosted_glass(s):
    """Rough except for a clear pattern."""
    place = s.coordinates("Object", scale=(2.2, 2.2, 2.2))
    stars = s.voronoi(place, 1.3, distance="MINKOWSKI", Exponent=0.6, Randomness=0.3)
    clear = s.map_range(stars, 0.55, 0.6, smooth=True)
    grain = s.noise(place, 60.0, 2.0, 0.6)
    rough = s.mix_numbers(clear, 0.45, 0.05)
    tint = s.mix(clear, (0.86, 0.95, 0.97), (0.55, 0.8, 0.9))
    return s.principled(
        tint,
        rough,
        Transmission_Weight=1.0,
        IOR=1.35,
        Normal=s.bump(s.math("MULTIPLY", grain, s.math("SUBTRACT", 1.0, clear)), 0.01, 0.25),
    )


@material("gem")
def amber(s):
    """Glass over a volume that swallows blue; bubbles and clouds are bumps."""
    place = s.coordinates("Object")
    clouds = s.noise(place, 2.4, 5.0, 0.6, Distortion=1.0)
    bubbles = s.voronoi(place, 6.0, Randomness=1.0)
    height = s.math("ADD", s.map_range(bubbles, 0.08, 0.15, 1.0, 0.0, smooth=True), s.math("MULTIPLY", clouds, 0.3))
    tint = s.ramp(clouds, (0.3, (1.0, 0.8, 0.45)), (0.7, (0.95, 0.62, 0.22)))
    surface = s.principled(
        tint,
        s.map_range(clouds, 0.3, 0.7, 0.02, 0.12),
        Transmission_Weight=1.0,
        IOR=1.54,
        Normal=s.bump(height, 0.03, 0.4),
    )
    volume = s.node("ShaderNodeVolumeAbsorption", Color=(0.95, 0.55, 0.12), Density=0.9)
    return surface, volume, None


@material("cube")
def ice(s):
    """Cracks inside are white sheets by the surface's own coordinates; frost at the edges."""
    place = s.coordinates("Object")
    bent = s.mix(0.2, place, s.noise(place, 2.0, 4.0, 0.6, "Color"), "ADD")
    cracks = s.voronoi(bent, 2.3, feature="DISTANCE_TO_EDGE", Randomness=1.0)
    crack = s.map_range(cracks, 0.0, 0.035, 1.0, 0.0, smooth=True)
    fuzzy = s.noise(place, 12.0, 6.0, 0.7)
    frost = s.map_range(
        s.math("ADD", s.geometry("Pointiness"), s.math("MULTIPLY", fuzzy, 0.1)), 0.58, 0.64, smooth=True
    )
    white = s.math("MAXIMUM", s.math("MULTIPLY", crack, 0.55), s.math("MULTIPLY", frost, 0.8), clamp=True)
    ice_ = s.principled(
        (0.88, 0.96, 1.0),
        s.map_range(fuzzy, 0.35, 0.65, 0.02, 0.16),
        Transmission_Weight=1.0,
        IOR=1.31,
        Normal=s.bump(fuzzy, 0.03, 0.4),
    )
    snow = s.principled(
        (0.85, 0.9, 0.95), 0.7, Subsurface_Weight=0.4, Subsurface_Radius=(0.6, 0.8, 1.0), Subsurface_Scale=0.1
    )
    return s.mix_shaders(white, ice_, snow)
