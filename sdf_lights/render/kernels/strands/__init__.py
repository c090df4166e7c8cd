# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves of hair and spheres: compiled separately, for scenes that have them."""
