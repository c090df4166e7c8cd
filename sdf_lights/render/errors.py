# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The one exception that a render raises on purpose, and the reasons that libraries report."""


class RenderError(Exception):
    """A render, or a part of it, is impossible. ``str(error)`` is one sentence for the user: the problem and the
    cure."""


def reason_of(source, otherwise: str) -> str:
    """Why ``source``, OpenImageIO or one of its files, has failed."""
    try:
        return source.geterror().strip() or otherwise
    except UnicodeDecodeError:  # it quotes the damaged data
        return otherwise
