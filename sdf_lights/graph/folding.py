# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Formulas with numbers for their parameters: constant parts then become constants."""

from __future__ import annotations

from collections.abc import Sequence

from .formula import PARAMETER, Formula, constant, numbers_may_change
from .substitution import rewritten


class Folding:
    """Folds formulas that share their parameters, whose values are ``numbers``."""

    def __init__(self, numbers: Sequence[float]):
        self._numbers = [constant(number) for number in numbers]
        self._known: dict[Formula, Formula] = {}

    def fold(self, formula: Formula) -> Formula:
        """The formula with numbers for its parameters. Parts that depend on no variable become one constant."""
        if formula not in self._known:
            with numbers_may_change():
                rewritten((formula,), self._known, self._replace)
        return self._known[formula]

    def _replace(self, node: Formula) -> Formula:
        return self._numbers[node.value] if node.kind == PARAMETER else node
