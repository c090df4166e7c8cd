# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading of the viewport."""


def draws(context, item) -> bool:
    """Whether the path tracer shows a lamp in this region."""
    return False
