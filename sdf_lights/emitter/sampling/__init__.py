# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sampling of a direction towards a lamp, or of a point in it. See README.md."""
