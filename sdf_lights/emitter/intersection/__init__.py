# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which part of a ray, a point or a box is inside a shape. See README.md."""
