// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Adds the glow of the lamps, drawn at a lower resolution, to the picture. See README.md.

void main()
{
    color = vec4(min(texture(glow, uv).rgb, vec3(6e4)), 0.0);
}
