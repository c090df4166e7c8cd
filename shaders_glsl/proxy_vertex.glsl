// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// The box around a lamp, from a cube of corners 0 and 1. See README.md.

void main()
{
    point = mix(lamp.low.xyz, lamp.high.xyz, corner);
    gl_Position = projection * vec4(point, 1.0);
}
