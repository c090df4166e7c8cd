# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The one exception that a render raises on purpose, and the reasons that libraries give."""


class RenderError(Exception):
    """A render, or a part of it, cannot be done. ``str(error)`` is one sentence for the user: what, and the cure."""


def reason_of(source, otherwise: str) -> str:
    """Why ``source``, OpenImageIO or a file of its, could not do something."""
    try:
        return source.geterror().strip() or otherwise
    except UnicodeDecodeError:  # it quotes what is damaged
        return otherwise
