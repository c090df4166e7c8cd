// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// A line around the marked pixels of a mask: red for selected lamps, green for the active one. See README.md.

void main()
{
    vec2 here = texture(mask, uv).rg;
    vec2 around = vec2(0.0);
    for (int i = -1; i <= 1; i++) {
        for (int j = -1; j <= 1; j++) {
            around = max(around, texture(mask, uv + vec2(float(i), float(j)) * width).rg);
        }
    }
    vec2 line = clamp(around - here, 0.0, 1.0);
    float strength = max(line.x, line.y);
    if (strength < 0.05) {
        discard;
    }
    vec4 chosen = line.y > 0.5 ? active_color : selected_color;
    color = vec4(chosen.rgb, chosen.a * strength);
}
