# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference page of the expression language, made from the words' docstrings and the shapes' parameters.

    python -m sdf_lights.sdf.reference > docs/expressions.md
"""

from __future__ import annotations

import dataclasses
import math
import sys

from .expression import MOST_PRIMITIVES
from .functions import CONSTANTS, FUNCTIONS, GROUPS, MATHEMATICS, POINTS, Function, show
from .shapes import SHAPES, Parameter
from .shapes.profiles import PROFILES
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

_TABLES = (MATHEMATICS, POINTS)  # groups that are a line a word
_DISTANCE = {
    "exact": "The field is the exact distance to the surface.",
    "bound": "The field never exceeds the distance to the surface.",
    "none": "The field is not a distance."}


def reference_page() -> str:
    """Text of ``docs/expressions.md``."""
    parts = [_INTRODUCTION]
    words = [form for word in FUNCTIONS.values() for form in (word, word.other) if form]
    for group in GROUPS:
        parts.append(f"## {group}\n")
        of_group = [word for word in words if word.group == group]
        if group == MATHEMATICS:
            constants = ", ".join(f"`{name}` = {value:.6g}" for name, value in CONSTANTS.items())
            parts.append(f"Constants: {constants}.\n")
        if group in _TABLES:
            parts.append("| | |\n|---|---|")
            parts += [f"| `{word.signature()}` | {' '.join(word.description.split())} |" for word in of_group]
            parts.append("")
        else:
            parts += [_entry(word) for word in of_group]
    return "\n".join(parts).rstrip("\n") + "\n"


def _entry(word: Function) -> str:
    lines = [f"### `{word.signature()}`\n", word.description, ""]
    shape = SHAPES.get(word.name) or PROFILES.get(word.name)
    if shape is None:
        return "\n".join(lines)
    if shape.fields():
        lines += ["| parameter | default | limits | |", "|---|---|---|---|"]
        lines += [_row(about) for about in shape.fields()]
        lines.append("")
    if not any("part" in field.metadata for field in dataclasses.fields(shape)) and not word.variadic:
        lines += [_DISTANCE[shape().exactness], ""]
    return "\n".join(lines)


def _row(about: Parameter) -> str:
    factor, unit = {"LENGTH": (1.0, " m"), "ANGLE": (180.0 / math.pi, "°"), "NONE": (1.0, "")}[about.unit]
    default = show(tuple(c * factor for c in about.default) if about.size == 3 else about.default * factor)
    minimum, maximum = about.minimum * factor, about.maximum * factor
    limits = f"{minimum:g} to {maximum:g}{unit}" + ", whole" * about.whole
    return f"| `{about.name}` | {default}{unit} | {limits} | {about.description} |"


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8", newline="\n")
    sys.stdout.write(reference_page())
