# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of a formula says what the formula computes: of every shape it is read as Python and run."""

import re

import numpy as np
import pytest

from sdf_lights.graph import formula_text, numpy_evaluation
from sdf_lights.graph.operations import OPERATIONS
from support.shapes import samples

_MEANING = {kind: operation.meaning for kind, operation in OPERATIONS.items()}


def _as_python(text: str) -> str:
    """A function ``value`` of the coordinates and ``k``; only loops are written otherwise than in Python."""
    *lines, result = text.splitlines()
    lines = [re.sub(r"repeat (.+) times, at most (\d+):", r"for _ in range(rounds(\1, \2)):", line) for line in lines]
    lines = [re.sub(r"stop unless (.+)", r"if not (\1): break", line) for line in lines]
    body = "\n".join(f"    {line}" for line in [*lines, f"return {result}"])
    return re.sub(r"\bk(\d+)\b", r"k[\1]", f"def value(x, y, z, k):\n{body}\n")


@pytest.mark.parametrize("name", samples.SHAPES_TO_TRY)
def test_the_text_of_a_shape_computes_its_field(name):
    shape = samples.SHAPES_TO_TRY[name]
    names = {**_MEANING, "rounds": numpy_evaluation.rounds}
    exec(_as_python(formula_text.text(shape.formula())), names)
    at = samples.points(shape)[::150]
    with np.errstate(all="ignore"):
        found = [names["value"](*point, shape.parameters()) for point in at]
    # Sines of arrays are rounded otherwise than those of single numbers.
    np.testing.assert_allclose(found, shape.distance(at), rtol=1e-12, atol=1e-13)
