# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways to draw a direction towards a lamp, or a point of it. See README.md."""
