# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that scatters below surfaces on the CPU: see README.md in this folder."""
