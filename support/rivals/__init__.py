# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimators and rules of marching that those of the program are compared with. See README.md."""
