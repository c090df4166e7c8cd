# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics of lamps by light paths that are connected to the camera: see docs/sampling.md. Compiled apart, for scenes
that use them."""
