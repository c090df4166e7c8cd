# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Participating media: see ``dispatch.py`` and ``code_table.py``."""
