# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces whose light a group of paths shares: see docs/sampling.md. Compiled apart, for scenes that use it."""
