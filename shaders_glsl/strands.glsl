// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Rays against curves and spheres, as Embree defines them.
//
// Before this file come rays.glsl, and `#define`s of HAS_name as its number for each scene.Primitive that the scene has,
// and of KINDS, as in bvh.py.

vec4 control_point(int place) { return uintBitsToFloat(item_at(place)); }

// The first of two crossings of a ray with a closed surface that is not before t_min; −1 if there is none.
float first_of(vec2 crossings, float t_min) { return crossings.x >= t_min ? crossings.x : crossings.y >= t_min ? crossings.y : -1.0; }

#ifdef HAS_SPHERES
float hit_sphere(Line line, vec4 ball, float t_min)
{
    vec3 c = ball.xyz - line.o;
    float square = dot(line.d, line.d);
    float middle = dot(c, line.d) / square;
    vec3 aside = c - middle * line.d;
    float rest = ball.w * ball.w - dot(aside, aside);
    if (rest < 0.0) {
        return -1.0;
    }
    float chord = sqrt(rest / square);
    return first_of(vec2(middle - chord, middle + chord), t_min);
}
#endif

#if defined(HAS_CONES) || defined(HAS_STRANDS)
// Crossings, first x, then y, of a ray with the hull of two spheres, x > y if it misses. `places`: of the inscribed
// spheres that touch the hull there, from 0 at `a` to 1 at `b`. The ray's origin should be near.
vec2 cross_hull(vec3 o, vec3 d, vec4 a, vec4 b, out vec2 places)
{
    vec2 found = vec2(INFINITE, -INFINITE);
    places = vec2(0.0);
    vec3 way = b.xyz - a.xyz;
    vec3 from_a = o - a.xyz;
    vec3 from_b = o - b.xyz;
    float square = dot(d, d);
    float shrinks = a.w - b.w;
    for (int end = 0; end < 2; end++) {
        vec3 apart = end == 0 ? from_a : from_b;
        float radius = end == 0 ? a.w : b.w;
        float half_slope = dot(apart, d) / square;
        vec3 aside = apart - half_slope * d;
        float rest = radius * radius - dot(aside, aside);
        if (rest >= 0.0) {
            float chord = sqrt(rest / square);
            if (-half_slope - chord < found.x) {
                found.x = -half_slope - chord;
                places.x = float(end);
            }
            if (-half_slope + chord > found.y) {
                found.y = -half_slope + chord;
                places.y = float(end);
            }
        }
    }
    // Between the spheres: a cone around the line of their centres, as far as it touches inscribed spheres.
    float length_square = dot(way, way);
    float touching = length_square - shrinks * shrinks;
    if (touching <= 0.0) {
        return found;  // one sphere is inside the other
    }
    float along = dot(way, from_a);
    float slope = dot(way, d);
    float k2 = touching * square - slope * slope;
    float k1 = touching * dot(d, from_a) - along * slope + slope * shrinks * a.w;
    float k0 = touching * dot(from_a, from_a) - along * along + 2.0 * along * shrinks * a.w - length_square * a.w * a.w;
    float rest = k1 * k1 - k0 * k2;
    if (rest >= 0.0 && abs(k2) > 1e-12 * touching * square) {
        float root = sqrt(rest);
        for (int sign = -1; sign <= 1; sign += 2) {
            float t = (-k1 + float(sign) * root) / k2;
            float place = (along - a.w * shrinks + t * slope) / touching;
            if (place > 0.0 && place < 1.0) {
                if (t < found.x) {
                    found.x = t;
                    places.x = place;
                }
                if (t > found.y) {
                    found.y = t;
                    places.y = place;
                }
            }
        }
    }
    return found;
}
#endif

#if defined(HAS_RIBBONS) || defined(HAS_STRANDS)
// A curve by Catmull and Rom 1974 with its radius, at u from 0 to 1, and its first two derivatives.
vec4 curve_at(mat4 points, float u)
{
    float s = 1.0 - u;
    return points * (0.5 * vec4(-u * s * s, 2.0 + u * u * (3.0 * u - 5.0), 2.0 + s * s * (3.0 * s - 5.0), -s * u * u));
}
vec4 curve_slope(mat4 points, float u)
{
    float s = 1.0 - u;
    return points * (0.5 * vec4(s * (2.0 * u - s), u * (9.0 * u - 10.0), -s * (9.0 * s - 10.0), u * (u - 2.0 * s)));
}
vec4 curve_bend(mat4 points, float u) { return points * vec4(2.0 - 3.0 * u, 9.0 * u - 5.0, 4.0 - 9.0 * u, 3.0 * u - 1.0); }
#endif

#ifdef HAS_STRANDS
#define PIECES 4

// A hit with the discs around a curve at right angles to it, near a distance `t` along the ray and a place u: where the
// ray is in the plane of a disc (f = 0), at its rim (g = 0), by Newton's method. INFINITE if there is none.
float at_rim(mat4 points, vec3 o, vec3 d, float t, inout float u)
{
    for (int turn = 0; turn < 8; turn++) {
        vec4 p = curve_at(points, u);
        vec4 slope = curve_slope(points, u);
        vec3 apart = o + t * d - p.xyz;
        float f = dot(apart, slope.xyz);
        float g = dot(apart, apart) - p.w * p.w;
        float f_u = dot(apart, curve_bend(points, u).xyz) - dot(slope.xyz, slope.xyz);
        float f_t = dot(d, slope.xyz);
        float g_u = -2.0 * (f + p.w * slope.w);
        float g_t = 2.0 * dot(apart, d);
        float determinant = f_u * g_t - f_t * g_u;
        if (determinant == 0.0) {
            return INFINITE;
        }
        float step_u = (f * g_t - f_t * g) / determinant;
        float step_t = (f_u * g - f * g_u) / determinant;
        u -= step_u;
        t -= step_t;
        if (abs(step_u) < 1e-4 && step_t * step_t * dot(d, d) < 1e-6 * p.w * p.w) {
            return u >= -1e-4 && u <= 1.0001 ? t : INFINITE;
        }
        if (!(u > -1.0 && u < 2.0)) {
            return INFINITE;
        }
    }
    return INFINITE;
}

float hit_round(Line line, mat4 points, float t_min, float t_max, out float place)
{
    float best = t_max;
    // A straight piece is this far from the curve at most.
    vec3 start_bend = curve_bend(points, 0.0).xyz;
    vec3 end_bend = curve_bend(points, 1.0).xyz;
    float room = sqrt(max(dot(start_bend, start_bend), dot(end_bend, end_bend))) / float(8 * PIECES * PIECES);
    vec4 a = curve_at(points, 0.0);
    a.w += room;
    for (int piece = 0; piece < PIECES; piece++) {
        vec4 b = curve_at(points, float(piece + 1) / float(PIECES));
        b.w += room;
        float shift = dot(a.xyz - line.o, line.d) / dot(line.d, line.d);
        vec3 o = line.o + shift * line.d;
        vec2 places;
        vec2 crossings = cross_hull(o, line.d, a, b, places);
        if (crossings.x <= crossings.y && crossings.y >= t_min - shift && crossings.x <= best - shift) {
            for (int side = 0; side < 2; side++) {
                float u = (float(piece) + (side == 0 ? places.x : places.y)) / float(PIECES);
                float t = at_rim(points, o, line.d, side == 0 ? crossings.x : crossings.y, u) + shift;
                if (t >= t_min && t < best) {
                    best = t;
                    place = clamp(u, 0.0, 1.0);
                    break;
                }
            }
        }
        a = b;
    }
    return best < t_max ? best : -1.0;
}
#endif

#ifdef HAS_RIBBONS
// Where the ray, which is the origin of the plane, meets a triangle of corners (x, y, depth): its weights of b and c.
bool in_triangle(vec3 a, vec3 b, vec3 c, out vec2 weights)
{
    float first = c.x * a.y - c.y * a.x;
    float second = a.x * b.y - a.y * b.x;
    float third = b.x * c.y - b.y * c.x;
    float sum = first + second + third;
    weights = vec2(first, second) / sum;
    return sum > 0.0 && min(min(first, second), third) >= 0.0;
}

// A strip of quadrilaterals that face the ray.
float hit_ribbon(Line line, mat4 points, int pieces, float t_min, float t_max, out vec2 place)
{
    float size = length(line.d);
    vec3 z = line.d / size;
    vec3 x = normalize(abs(z.x) > abs(z.y) ? vec3(-z.z, 0.0, z.x) : vec3(0.0, z.z, -z.y));
    vec3 y = cross(z, x);
    mat4 seen;
    for (int i = 0; i < 4; i++) {
        vec3 p = points[i].xyz - line.o;
        seen[i] = vec4(dot(p, x), dot(p, y), dot(p, z), points[i].w);
    }
    float best = t_max * size;
    float low = t_min * size;
    bool found = false;
    vec4 a = curve_at(seen, 0.0);
    vec2 slope_a = curve_slope(seen, 0.0).xy;
    for (int piece = 0; piece < pieces; piece++) {
        float u = float(piece + 1) / float(pieces);
        vec4 b = curve_at(seen, u);
        vec2 slope_b = curve_slope(seen, u).xy;
        vec2 way_a = dot(slope_a, slope_a) > 0.0 ? slope_a : b.xy - a.xy;
        vec2 way_b = dot(slope_b, slope_b) > 0.0 ? slope_b : b.xy - a.xy;
        vec2 side_a = a.w * normalize(vec2(way_a.y, -way_a.x));
        vec2 side_b = b.w * normalize(vec2(way_b.y, -way_b.x));
        vec3 right_a = vec3(a.xy + side_a, a.z), left_a = vec3(a.xy - side_a, a.z);
        vec3 right_b = vec3(b.xy + side_b, b.z), left_b = vec3(b.xy - side_b, b.z);
        vec2 weights;
        vec2 at;
        float depth = -1.0;
        if (in_triangle(right_a, right_b, left_a, weights)) {
            at = weights;
            depth = right_a.z + weights.x * (right_b.z - right_a.z) + weights.y * (left_a.z - right_a.z);
        } else if (in_triangle(left_b, left_a, right_b, weights)) {
            at = 1.0 - weights;
            depth = left_b.z + weights.x * (left_a.z - left_b.z) + weights.y * (right_b.z - left_b.z);
        }
        if (depth >= low && depth < best) {
            best = depth;
            found = true;
            place = vec2((float(piece) + at.x) / float(pieces), 2.0 * at.y - 1.0);
        }
        a = b;
        slope_a = slope_b;
    }
    return found ? best / size : -1.0;
}
#endif

// Distance of a curve's segment, or a sphere, along a ray; −1 if it misses. `uv`: the place along it and across it.
float hit_strand(Line line, uvec4 item, float t_min, float t_max, out vec2 uv)
{
    int first = int(item.x);
    int kind = int(item.z) % KINDS;
    uv = vec2(0.0);
#ifdef HAS_SPHERES
    if (kind == HAS_SPHERES) {
        return hit_sphere(line, control_point(first), t_min);
    }
#endif
#ifdef HAS_CONES
    if (kind == HAS_CONES) {
        vec4 a = control_point(first);
        vec4 b = control_point(first + 1);
        float shift = dot(a.xyz - line.o, line.d) / dot(line.d, line.d);
        vec2 places;
        vec2 crossings = cross_hull(line.o + shift * line.d, line.d, a, b, places);
        if (crossings.x > crossings.y) {
            return -1.0;
        }
        float t = first_of(crossings + shift, t_min);
        uv.x = t == crossings.x + shift ? places.x : places.y;
        return t;
    }
#endif
#if defined(HAS_RIBBONS) || defined(HAS_STRANDS)
    mat4 points = mat4(control_point(first), control_point(first + 1), control_point(first + 2), control_point(first + 3));
#ifdef HAS_RIBBONS
    if (kind == HAS_RIBBONS) {
        return hit_ribbon(line, points, int(item.z) / KINDS, t_min, t_max, uv);
    }
#endif
#ifdef HAS_STRANDS
    return hit_round(line, points, t_min, t_max, uv.x);
#endif
#endif
    return -1.0;
}
