// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Light of one lamp along the ray through a pixel. See README.md.
//
// Before this file come `float field(vec3 p)`, proxy_emission.glsl and intervals.glsl. `point` is where the ray leaves the
// lamp's box.

// Depth along the view axis, from the depth buffer's value.
float depth_of(float stored)
{
    float ndc = 2.0 * stored - 1.0;
    return (ndc * lamp.unproject.w - lamp.unproject.y) / (ndc * lamp.unproject.z - lamp.unproject.x);
}

void main()
{
    vec3 d = normalize(lamp.eye.w > 0.0 ? point - lamp.eye.xyz : lamp.eye.xyz);
    // From the closest approach to the box's centre: numbers are then no larger than the box.
    vec3 center = 0.5 * (lamp.low.xyz + lamp.high.xyz);
    vec3 o = point - dot(point - center, d) * d;

    vec3 safe = mix(vec3(1e-20), d, greaterThan(abs(d), vec3(1e-20)));
    vec3 a = (lamp.low.xyz - o) / safe;
    vec3 b = (lamp.high.xyz - o) / safe;
    vec3 nearest = min(a, b);
    vec3 farthest = max(a, b);
    float start = max(max(nearest.x, nearest.y), nearest.z);
    float end = min(min(farthest.x, farthest.y), farthest.z);

    // The depth along the view axis changes linearly along the ray.
    float depth = dot(lamp.axis, vec4(o, 1.0));
    float slope = dot(lamp.axis.xyz, d);
    start = max(start, (lamp.clip.x - depth) / slope);
    end = min(end, (lamp.clip.y - depth) / slope);
    if (lamp.clip.z > 0.0) {
        float stored = texelFetch(scene_depth, ivec2(gl_FragCoord.xy * lamp.clip.z) - depth_origin, 0).x;
        if (stored < 1.0) {
            end = min(end, (depth_of(stored) - depth) / slope);
        }
    }
    if (start >= end) {
        discard;
    }

    Intervals found = intervals(o, d, start, end, lamp.high.w, lamp.low.w, STEPS);
    if (found.count == 0) {
        discard;
    }
    float metres = length(lamp.along[0].xyz * d.x + lamp.along[1].xyz * d.y + lamp.along[2].xyz * d.z);
    // Below the largest half float, so that a few lamps in line add up to a number.
    vec3 light = lamp.emission.rgb * found.sum * metres;
    if (lamp.least.w > 0.0) {  // an enlarged lamp has too long a path through it
        float brightest = max(max(light.r, light.g), light.b);
        light *= min(1.0, 3.0 * max(max(lamp.least.r, lamp.least.g), lamp.least.b) / max(brightest, 1e-20));
    }
    glow = vec4(clamp(light, lamp.least.rgb, vec3(3e4)), 0.0);
    mask = lamp.mask;
}
