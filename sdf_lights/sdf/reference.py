# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference page of the expression language, made from the words' docstrings and the shapes' parameters.

    python -m sdf_lights.sdf.reference > docs/expressions.md
"""

from __future__ import annotations

import sys

from .expression import MOST_PRIMITIVES
from .functions import CONSTANTS, FUNCTIONS, show
from .shapes import SHAPES
from .syntax import DEEPEST, LONGEST

_INTRODUCTION = f"""\
# Expressions

<!-- Made by `python -m sdf_lights.sdf.reference`; edit the docstrings instead. -->

An expression is a few lines of text that say a shape. The last line is the shape; the lines before it give names to
numbers, vectors and shapes. `#` starts a remark.

    size = slider(1, 0.1, 3)              # becomes a slider of the lamp
    hole = sphere(1.35 * size)
    difference(box(size), hole) | torus(1.6 * size, 0.1)

- `name = slider(default, minimum, maximum)` declares a parameter. Moving it recompiles nothing.
- Numbers: `+ - * / % **`. Vectors are written `vec3(x, y, z)` or `(x, y, z)`; arithmetic and functions work on each
  component, a number counting for all three. `v.x`, `v.y` and `v.z` are the components.
- Shapes: `a | b` is `union(a, b)`, `a & b` is `intersection(a, b)`, `a - b` is `difference(a, b)`. `-` binds
  most strongly, then `&`, then `|`.
- Arguments go by position or by name: `torus(1, 0.2)`, `torus(minor_radius=0.2)`. Where a vector is wanted, three plain
  numbers also do if all are there, `box(1, 2, 3)`, and one number stands for three equal ones, `box(1)`.
- Lengths are in metres; angles are in degrees in transforms, in radians in `sin` and its like.
- An expression has at most {LONGEST} characters, {DEEPEST} brackets inside one another and {MOST_PRIMITIVES} shapes.

A mistake is reported with its line, its column and a cure, and nothing is ever run as Python.
"""

_GROUPS = ("Shapes", "Combinations", "Transforms", "Numbers and vectors")
_DISTANCE = {
    "exact": "The field is the exact distance to the surface.",
    "bound": "The field never exceeds the distance to the surface.",
    "none": "The field is not a distance."}


def reference_page() -> str:
    """Text of ``docs/expressions.md``."""
    parts = [_INTRODUCTION]
    for group in _GROUPS:
        parts.append(f"## {group}\n")
        words = [function for function in FUNCTIONS.values() if function.group == group]
        if group == "Numbers and vectors":
            constants = ", ".join(f"`{name}` = {value:.6g}" for name, value in CONSTANTS.items())
            parts.append(f"Constants: {constants}.\n")
            parts.append("| | |\n|---|---|")
            parts += [f"| `{word.signature()}` | {word.description} |" for word in words]
            parts.append("")
        else:
            parts += [_entry(word) for word in words]
    return "\n".join(parts).rstrip("\n") + "\n"


def _entry(word) -> str:
    lines = [f"### `{word.signature()}`\n", word.description, ""]
    shape = SHAPES.get(word.name)
    fields = shape.fields() if shape else ()
    if fields:
        lines += ["| parameter | default | limits | |", "|---|---|---|---|"]
        for field in fields:
            unit = {"LENGTH": " m", "ANGLE": " rad", "NONE": ""}[field.unit]
            limits = f"{field.minimum:g} to {field.maximum:g}{unit}"
            lines.append(f"| `{field.name}` | {show(field.default)}{unit} | {limits} | {field.description} |")
        lines += ["", _DISTANCE[shape.exactness], ""]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8", newline="\n")
    sys.stdout.write(reference_page())
