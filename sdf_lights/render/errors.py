# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The one exception that a render raises on purpose."""


class RenderError(Exception):
    """A render, or a part of it, cannot be done. ``str(error)`` is one sentence for the user: what, and the cure."""
