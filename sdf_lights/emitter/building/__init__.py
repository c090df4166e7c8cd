# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes lamps in the form that kernels read, from shapes. See README.md."""
