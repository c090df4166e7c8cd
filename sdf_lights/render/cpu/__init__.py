# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The CPU back end: Embree, a packed scene, and threads that run the kernels."""
