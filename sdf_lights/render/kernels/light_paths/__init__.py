# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that surfaces have scattered, sampled as a light: see docs/sampling.md. Compiled apart, for scenes that use
it."""
