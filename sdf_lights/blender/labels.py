# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences in panels: Blender's labels do not wrap."""

from __future__ import annotations

import textwrap

from ..sdf.syntax import ExpressionError

_LETTER, _MARGIN = 6.5, 40.0  # pixels of a letter on average, and of the panel's edges and the icon, at a UI scale of 1
_FEWEST = 20


def letters(context) -> int:
    """Letters that fit a line of a panel in the region that is drawn."""
    width = context.region.width / context.preferences.system.ui_scale
    return max(_FEWEST, int((width - _MARGIN) / _LETTER))


def draw_sentence(layout, text: str, width: int, icon: str = "ERROR") -> None:
    """A sentence in as many labels as it needs, with an icon before the first; ``width`` in letters."""
    _draw(layout, textwrap.wrap(text, width), icon)


def draw_expression(layout, owner, is_emission: bool = False) -> None:
    """An expression of one line over all the width, with a button for more."""
    row = layout.row(align=True)
    row.use_property_split = False
    row.prop(owner, "expression", text="")
    row.operator("sdf_lights.expression_edit", text="", icon="FULLSCREEN_ENTER").emission = is_emission


def draw_problem(layout, error: Exception, width: int) -> None:
    """An error in labels. Of one in an expression, the place, what is wrong and the cure begin lines of their own."""
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
