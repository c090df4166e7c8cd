// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Relative emission of a lamp, integrated over an interval of a ray inside it.
//
// If it varies, `#define VARIES` and `vec3 colour(vec3 p)` come before this file.

#ifdef VARIES

// Minimum and maximum number of points in an interval.
const int FEWEST_POINTS = 4;
const int MOST_POINTS = 64;

// The rule of `sdf_lights/emitter/emission/varying.py`, with a fixed shift: t = s³ (10 − 15 s + 6 s²), whose points are
// densest at the ends.
vec3 emitted(vec3 o, vec3 d, float start, float end)
{
    vec3 sum = vec3(0.0);
    float size = end - start;
    int points = clamp(int(ceil(lamp.emission.w * size)), FEWEST_POINTS, MOST_POINTS);
    for (int i = 0; i < points; i++) {
        float s = (float(i) + 0.5) / float(points);
        float r = 1.0 - s;
        float t = s * s * s * (10.0 + s * (6.0 * s - 15.0));
        sum += 30.0 * s * s * r * r * colour(o + (start + size * t) * d);
    }
    return sum * (size / float(points));
}

#else

vec3 emitted(vec3 o, vec3 d, float start, float end)
{
    return vec3(end - start);
}

#endif
