// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// The intervals of a ray inside a shape: all parts of it with field(p) <= 0. See README.md.
//
// Before this file come `float field(vec3 p)` and optional definitions: `#define INTERVALS n` for room for other than
// 16 intervals, `#define CROSSING_ERROR e` if crossings may be off by that much of t, and `#define INTERVALS_SUM f` for
// a sum over all intervals of `vec3 f(vec3 o, vec3 d, float start, float end)`.

#ifndef INTERVALS
#define INTERVALS 16
#endif

#ifndef CROSSING_ERROR
#define CROSSING_ERROR 0.0
#endif

struct Intervals {
    int count;
    vec2 spans[INTERVALS];  // (start, end), in the unit of the ray's direction, in order
    float unresolved;       // total length in which crossings may have been missed
    float dropped;          // total length of the intervals without room
    int evaluations;
#ifdef INTERVALS_SUM
    vec3 sum;
#endif
};

// Point between a and b where the field changes its sign, from its values there: regula falsi, Illinois variant (Dowell
// and Jarratt 1971).
float intervals_crossing(vec3 o, vec3 d, float a, float fa, float b, float fb, inout int evaluations)
{
    float c = b;
    for (int i = 0; i < 12; i++) {
        float last = c;
        c = (a * fb - b * fa) / (fb - fa);
        if (!(c >= min(a, b) && c <= max(a, b))) {
            c = 0.5 * (a + b);
        }
        if (abs(c - last) <= max(2.4e-7 * abs(c), CROSSING_ERROR)) {
            break;
        }
        float fc = field(o + c * d);
        evaluations++;
        if ((fc <= 0.0) == (fb <= 0.0)) {
            fa *= 0.5;
        }
        else {
            a = b;
            fa = fb;
        }
        b = c;
        fb = fc;
    }
    return c;
}

void intervals_add(inout Intervals found, vec3 o, vec3 d, float start, float end)
{
#ifdef INTERVALS_SUM
    found.sum += INTERVALS_SUM(o, d, start, end);
#endif
    if (found.count < INTERVALS) {
        found.spans[found.count] = vec2(start, end);
        found.count++;
    }
    else {
        found.dropped += end - start;
    }
}

// Intervals of the ray o + t d inside the shape, for t from `start` to `end`.
//
// `lipschitz` bounds the slope of the field along the ray: that of the field in space times the length of d. Steps are
// at least `least` long. There are at most `steps` of them; the last quarter is long enough to reach the end.
Intervals intervals(vec3 o, vec3 d, float start, float end, float lipschitz, float least, int steps)
{
    Intervals found;
    found.count = 0;
    found.unresolved = 0.0;
    found.dropped = 0.0;
    found.evaluations = 1;
#ifdef INTERVALS_SUM
    found.sum = vec3(0.0);
#endif
    float t = start;
    float f = field(o + t * d);
    bool inside = f <= 0.0;
    float entry = start;
    float slope = -lipschitz;  // of |field|: an estimate, from the last step
    for (int i = 0; i < steps && t < end; i++) {
        if (4 * i >= 3 * steps) {
            least = max(least, (end - t) / float(steps - i));
        }
        float distance = abs(f);
        float safe = distance / lipschitz;
        // The ball around the next point touches the one around this, if |field| continues linearly.
        float far = max(safe, 1.9 * distance / (lipschitz - slope));
        float s = min(max(far, least), end - t);
        float g = field(o + (t + s) * d);
        found.evaluations++;
        bool certain = (g <= 0.0) == inside && distance + abs(g) >= lipschitz * s;
        if (!certain && s > max(safe, least)) {
            s = min(max(safe, least), end - t);
            g = field(o + (t + s) * d);
            found.evaluations++;
            slope = -lipschitz;
        }
        else {
            slope = clamp(0.3 * slope + 0.7 * (abs(g) - distance) / s, -lipschitz, 0.9 * lipschitz);
        }
        if (s > safe) {
            found.unresolved += max(s - (distance + abs(g)) / lipschitz, 0.0);
        }
        float next = t + s;
        if ((g <= 0.0) != inside) {
            float crossing = intervals_crossing(o, d, t, f, next, g, found.evaluations);
            if (inside) {
                intervals_add(found, o, d, entry, crossing);
            }
            entry = crossing;
            inside = !inside;
            slope = -lipschitz;
        }
        if (next <= t) {  // the rest is below the resolution of float32
            break;
        }
        t = next;
        f = g;
    }
    if (t < end) {
        found.unresolved += end - t;
    }
    if (inside) {
        intervals_add(found, o, d, entry, end);
    }
    return found;
}
