// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Intervals of a ray in the field of a lamp, into `spans_rows`: their number, and the length that is not certain. o, d and
// the stretch of the ray are in tree space. Before this file come lamps.glsl and intervals.glsl.
vec2 field_crossings(int row, vec3 o, vec3 d, float start, float end)
{
    int at = choose_field(row);
    float speed = length(d);
    Intervals found = intervals(o, d, start, end, float_at(at + FIELD_LIPSCHITZ) * speed, float_at(at + FIELD_LEAST) / speed,
                                FIELD_STEPS);
    for (int i = 0; i < found.count; i++) {
        spans_rows[2 * i] = found.spans[i].x;
        spans_rows[2 * i + 1] = found.spans[i].y;
    }
    return vec2(float(found.count), found.unresolved + found.dropped);
}
