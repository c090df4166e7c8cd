# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay that draws the lamps of all viewports."""

overlay = None  # overlay.Overlay, made at the first redraw: in the background there is no graphics context


def shown_lamps(context) -> list:
    """The lamps (``lamps.Placed``) in a viewport, drawn by the overlay or by the path tracer."""
    return overlay.shown(context) if overlay is not None else []
