# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences in panels: Blender's labels do not wrap."""

from __future__ import annotations

import textwrap

from ..sdf.syntax import ExpressionError

# mean width of a letter, and width of the panel's edges and the icon, in pixels at a UI scale of 1
_LETTER, _MARGIN = 6.5, 40.0
_FEWEST = 20


def letters(context) -> int:
    """Number of letters in a line of a panel in the present region."""
    width = context.region.width / context.preferences.system.ui_scale
    return max(_FEWEST, int((width - _MARGIN) / _LETTER))


def draw_sentence(layout, text: str, width: int, icon: str = "ERROR") -> None:
    """Draw a sentence as several labels, with an icon before the first. ``width`` is in letters."""
    _draw(layout, textwrap.wrap(text, width), icon)


def draw_expression(layout, owner, is_emission: bool = False) -> None:
    """Draw a one-line expression over the full width, with a button for more."""
    row = layout.row(align=True)
    row.use_property_split = False
    row.prop(owner, "expression", text="")
    row.operator("sdf_lights.expression_edit", text="", icon="FULLSCREEN_ENTER").emission = is_emission


def draw_problem(layout, error: Exception, width: int) -> None:
    """Draw an error as labels. For an error in an expression, the location, the mistake and the cure each begin a new
    line."""
    wrong = error.__cause__
    sentences = [str(error)]
    if isinstance(wrong, ExpressionError):
        sentences = [
            f"Line {wrong.line}, column {wrong.column}:",
            wrong.message,
            f"{wrong.cure[0].upper()}{wrong.cure[1:]}",
        ]
    _draw(layout, [line for sentence in sentences for line in textwrap.wrap(sentence, width)], "ERROR")


def _draw(layout, lines: list[str], icon: str) -> None:
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, line in enumerate(lines):
        column.label(text=line, icon="BLANK1" if i else icon)
