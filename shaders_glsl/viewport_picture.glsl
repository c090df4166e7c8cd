// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// A picture, premultiplied by its alpha. See README.md.

void main()
{
    color = texture(picture, uv);
}
