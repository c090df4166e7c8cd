# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared by tests and benchmarks: scenes, oracles, statistics, and rival estimators. See README.md."""
