# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps that data make: a module a kind, with its tables, its kernels and its shape or profile."""
