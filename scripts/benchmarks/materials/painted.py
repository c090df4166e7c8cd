# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint, lacquer, ceramics, plastics."""

from __future__ import annotations

from .shader import material


@material("ball")
def car_paint(s):
    """A dark base that shifts at grazing angles, flakes with normals of their own, a clear coat."""
    flakes = s.voronoi(s.coordinates("Object"), 70.0, "Color", Randomness=1.0)
    bent = s.vector_math("SUBTRACT", flakes, (0.5, 0.5, 0.5))
    normal = s.vector_math(
        "NORMALIZE", s.vector_math("ADD", s.geometry("Normal"), s.vector_math("SCALE", bent, Scale=0.35))
    )
    color = s.mix(s.facing(0.35), (0.45, 0.01, 0.015), (0.08, 0.0, 0.03))
    sparkle = s.math("GREATER_THAN", s.node("ShaderNodeSeparateColor", "Red", Color=flakes), 0.72)
    tint = s.mix(sparkle, color, (0.8, 0.25, 0.2))
    peel = s.noise(s.coordinates("Object"), 30.0, 1.0)
    coat = s.bump(peel, 0.002, 0.15)
    return s.principled(tint, 0.32, Metallic=0.7, Normal=normal, Coat_Weight=1.0, Coat_Roughness=0.02, Coat_Normal=coat)


@material("cube")
def peeling_paint(s):
    """Layers of paint over wood: one mask a layer, the edge of each is lifted."""
    place = s.coordinates("Object")
    shape = s.noise(place, 2.1, 8.0, 0.6, Distortion=0.4)
    top = s.map_range(shape, 0.5, 0.515, smooth=True)
    below = s.map_range(shape, 0.43, 0.445, smooth=True)
    cracks = s.voronoi(
        s.mix(0.1, place, s.noise(place, 5.0, 3.0, 0.5, "Color"), "ADD"), 5.0, feature="DISTANCE_TO_EDGE"
    )
    crack = s.map_range(cracks, 0.0, 0.035)
    grain = s.noise(s.mapped(place, scale=(20.0, 20.0, 1.5)), 1.0, 4.0, 0.6)
    wood = s.ramp(grain, (0.3, (0.12, 0.07, 0.04)), (0.7, (0.34, 0.23, 0.14)))
    primer = s.mix(below, wood, (0.62, 0.58, 0.48))
    paint = s.mix(s.math("MULTIPLY", top, crack), primer, (0.10, 0.33, 0.38))
    rough = s.mix_numbers(top, 0.85, 0.4)
    height = s.math("ADD", s.math("ADD", top, below), s.math("MULTIPLY", crack, 0.3))
    return s.principled(paint, rough, Normal=s.bump(height, 0.03, 0.8, s.bump(grain, 0.01, 0.5)))


@material("vase")
def glazed_ceramic(s):
    """Glaze that runs down over clay, crackled."""
    place = s.coordinates("Object")
    up = s.axis(place, "Z")
    drip = s.math("MULTIPLY_ADD", s.noise(s.mapped(place, scale=(3.0, 3.0, 0.4)), 1.6, 3.0), 0.8, up)
    glazed = s.map_range(drip, 0.92, 1.0, smooth=True)
    crackle = s.voronoi(place, 7.0, feature="DISTANCE_TO_EDGE")
    line = s.map_range(crackle, 0.004, 0.016, 0.75, 1.0)
    shade = s.ramp(
        s.map_range(up, 0.5, 1.9), (0.0, (0.02, 0.17, 0.2)), (0.5, (0.08, 0.42, 0.4)), (1.0, (0.55, 0.75, 0.62))
    )
    glaze = s.principled(s.mix(1.0, shade, line, "MULTIPLY"), 0.08, Coat_Weight=0.6, Coat_Roughness=0.02)
    clay = s.principled((0.42, 0.24, 0.15), 0.9, Normal=s.bump(s.noise(place, 40.0, 3.0), 0.01, 0.6))
    return s.mix_shaders(glazed, clay, glaze)


@material("head")
def worn_plastic(s):
    """Edges are rubbed bright by Pointiness, hollows keep dirt."""
    point = s.geometry("Pointiness")
    edge = s.map_range(point, 0.51, 0.56, smooth=True)
    hollow = s.map_range(point, 0.49, 0.44, smooth=True)
    place = s.coordinates("Object")
    patchy = s.noise(place, 6.0, 5.0, 0.7)
    rubbed = s.math("MULTIPLY", edge, s.map_range(patchy, 0.4, 0.6))
    dirty = s.math("MULTIPLY", hollow, s.map_range(patchy, 0.65, 0.4), clamp=True)
    color = s.mix(dirty, s.mix(rubbed, (0.75, 0.32, 0.03), (0.92, 0.68, 0.42)), (0.07, 0.055, 0.04))
    rough = s.mix_numbers(rubbed, 0.32, 0.6)
    return s.principled(color, s.mix_numbers(dirty, rough, 0.9), Normal=s.bump(s.noise(place, 55.0, 2.0), 0.003, 0.4))


@material("ball")
def pearl(s):
    """Thin layers shift the hue by the angle, through a ramp and a little film."""
    angle = s.facing(0.3)
    swirl = s.noise(s.coordinates("Object"), 1.4, 3.0, 0.5, Distortion=1.2)
    shifted = s.math("MULTIPLY_ADD", swirl, 0.35, angle)
    hue = s.ramp(
        shifted,
        (0.1, (0.85, 0.78, 0.72)),
        (0.35, (0.82, 0.65, 0.72)),
        (0.55, (0.62, 0.75, 0.82)),
        (0.8, (0.72, 0.85, 0.68)),
    )
    return s.principled(
        hue,
        0.22,
        Specular_IOR_Level=0.8,
        Coat_Weight=0.8,
        Coat_Roughness=0.08,
        Sheen_Weight=0.2,
        Thin_Film_Thickness=s.map_range(swirl, 0.3, 0.7, 250.0, 480.0),
    )


@material("cube")
def carbon_fiber(s):
    """Twill: two directions of threads by a checker that is shifted row by row, each with its own tangent."""
    uv = s.coordinates("UV", scale=(9.0, 9.0, 1.0))
    row = s.math("FLOOR", s.axis(uv, "Y"))
    across = s.math("FLOOR", s.math("ADD", s.axis(uv, "X"), s.math("MULTIPLY", row, 1.0)))
    warp = s.math("LESS_THAN", s.math("FLOORED_MODULO", across, 4.0), 2.0)
    thread = s.mix_numbers(warp, s.math("FRACT", s.axis(uv, "Y")), s.math("FRACT", s.axis(uv, "X")))
    round_ = s.math("SINE", s.math("MULTIPLY", thread, 3.14159))
    color = s.mix(round_, (0.004, 0.004, 0.005), (0.05, 0.05, 0.055))
    return s.principled(
        color,
        0.35,
        Metallic=0.6,
        Anisotropic=0.7,
        Anisotropic_Rotation=s.math("MULTIPLY", warp, 0.25),
        Normal=s.bump(round_, 0.01, 0.7),
        Coat_Weight=1.0,
        Coat_Roughness=0.03,
    )
