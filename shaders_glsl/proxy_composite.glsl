// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Glow of the lamps, drawn at a lower resolution, onto the picture. See README.md.

void main()
{
    color = vec4(min(texture(glow, uv).rgb, vec3(6e4)), 0.0);
}
