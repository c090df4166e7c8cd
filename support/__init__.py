# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests and benchmarks share: scenes, oracles, statistics, and estimators to compare with. See README.md."""
