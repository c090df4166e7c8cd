# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference page of the expression language, made from the docstrings of functions and the parameters of shapes.

python -m sdf_lights.sdf.reference > docs/expressions.md
"""

from __future__ import annotations

import dataclasses
import math
import sys

from ..graph.loops import LONGEST_LOOP
from . import expression  # noqa: F401  (registers all words of the language, in the order of the page)
from .builtin_data import DATA
from .catalogue import grouped
from .declarations import LIMITS
from .emission_presets import presets
from .evaluation import Evaluation  # noqa: F401 (all words are in FUNCTIONS then)
from .examples import Example, examples
from .functions import COLOURS, CONSTANTS, DATA_WORDS, FUNCTIONS, GROUPS, MATHEMATICS, POINTS, Function, show
from .shapes import SHAPES, Parameter
from .shapes.profiles import PROFILES
from .syntax import DEEPEST, LONGEST
from .value_evaluation import MOST_PRIMITIVES

_ANGLE, _VECTOR = LIMITS["angle"], LIMITS["vector"]

_INTRODUCTION = f"""\
# Expressions

<!-- Made by `python -m sdf_lights.sdf.reference`; edit the docstrings instead. -->

An expression is a few lines of text that describe a shape. The last line is the shape. The lines before it give names
to numbers, vectors and shapes. `#` starts a comment.

    size = slider(1, 0.1, 3)              # becomes a slider of the lamp
    hole = sphere(1.35 * size)
    difference(box(size), hole) | torus(1.6 * size, 0.1)

- Numbers: `+ - * / % **`. A vector is `vec3(x, y, z)` or `(x, y, z)`. Arithmetic and functions work on each
  component; a number counts for all three. `v.x`, `v.y` and `v.z` are the components. `v.xy`, `v.zyx` and the like
  are vectors of two or three of them.
- Shapes: `a | b` is `union(a, b)`, `a & b` is `intersection(a, b)`, `a - b` is `difference(a, b)`. `-` binds
  most strongly, then `&`, then `|`.
- Arguments have a position or a name: `torus(1, 0.2)`, `torus(minor_radius=0.2)`. A vector can also be three numbers,
  `box(1, 2, 3)`, or one number for all three, `box(1)`. Combinations take any number of shapes, then their own
  numbers: `smooth_union(a, b, c, 0.1)` or `smooth_union(a, b, radius=0.1)`.
- Texts are in quotes, `"OPEN"` or `'OPEN'`: names of objects and pictures, paths of files, letters to write. `\\n`
  begins a new line, `\\\\` is one `\\`, `\\"` a quote.
- Lengths are in metres. Angles are in degrees, except in `sin` and similar functions, which take radians.
- An expression has at most {LONGEST} characters, {DEEPEST} nested brackets and {MOST_PRIMITIVES} shapes.

A mistake is reported with its line, its column and a cure. Nothing is run as Python.

## Parameters

A line of its own declares a parameter, which becomes a property of the lamp. The comment on that line is its tooltip.
Numbers and limits must not depend on other parameters. Moving a slider recompiles nothing.

| | |
|---|---|
| `size = slider(1, 0.1, 3)` | a number: default, minimum, maximum |
| `count = integer(5, 1, 12)` | a whole number |
| `turn = angle(45)`, `angle(45, 0, 90)` | degrees, from {_ANGLE[0]:g} to {_ANGLE[1]:g} unless limits are given |
| `place = vector((0, 0, 1))`, `vector((0, 0, 1), -2, 2)` | three numbers, from {_VECTOR[0]:g} to {_VECTOR[1]:g} |
| `open = toggle(True)` | a switch: a condition, as in `select(open, a, b)` |

## The point

`p` is the point of space at which the shape is evaluated: a vector. A number that depends on it is a *field*: it has a
value at each point. A field is a shape: the region in which it is negative. And a shape has a field:

    bumps = 0.05 * sin(20 * p.x) * sin(20 * p.y) * sin(20 * p.z)
    sphere(1)(p) + bumps

- `shape(point)` is the field of a shape at a point: `box(1)(rotate_z(p, 90 * p.z))` is a twisted box,
  `torus(1, 0.1)(p - (0, 0, 1))` a moved torus. `circle(1)(p.xz)` is the field of a profile, in a plane.
- A field can stand for a shape, also as the last line. Its limits are found automatically. If they cannot be found, use
  an intersection, `field & box(2)`, or `field(value, bounds=2)`.
- `p` can get another value, such as `p = abs(p)`. The lines below then use that point.
- A field need not be a distance, but rays are faster the closer it is to one. Shapes without fields are faster still.

## Loops and conditions

    q = p
    size = 1
    for i in range(4):
        q = abs(q) * 2 - 1
        size = size * 2
        if length(q) > 8:
            break
    field(box(1)(q) / size, bounds=1.5)

- `for i in range(count):` repeats the indented lines. `count` is a number or a parameter, at most {LONGEST_LOOP}.
  `i` is 0 in the first round. Names with a value before the loop keep it from round to round and after the loop. Other
  names end with the loop. A loop over fields is a loop of the compiled formula. A loop over shapes combines shapes.
- `break` ends a loop at the points where its condition holds: `if length(q) > 4: break`.
- `if`, `elif` and `else` choose between values of a name. `a if condition else b` and `select(condition, a, b)` choose
  between two values. All sides are computed. A condition on the point chooses at each point, between fields or vectors.
- Conditions: `a < b`, `<=`, `>`, `>=`, combined with `and`, `or`, `not`.
"""

_EMISSION = """\
## Emission

An expression can also be the brightness at each point of a lamp. Its last line is then a number, a field or a colour,
and it has more names:

- `depth` is the depth of a point below the surface, in metres of the lamp's own space. It is the field of the shape
  without its sign, and as exact as that.
- `height` is 0 at the bottom of the lamp and 1 at its top, along its own z axis.
- `u` and `v` are the same along its x and y axis. So they are coordinates across its box, and in the plane of an extrusion.
- `along` is 0 where the curve of a tube begins and 1 where it ends, by its length: of a curve object or of neon. It is that of the nearest tube of
  a combination, also where it is bent, repeated or displaced, and 0 in a lamp without tubes.

Only ratios matter, as the power of the lamp sets its light. Without *Normalize*, the radiance per metre is multiplied.
The lamp is dark where the last line is negative or undefined. The presets are such expressions:
"""

_GROUPED = ("Shapes", "Combinations", "Operators")  # groups with many entries
_TABLES = (MATHEMATICS, POINTS, COLOURS)  # groups with one line per function
_DISTANCE = {
    "exact": "The field is the exact distance to the surface.",
    "bound": "The field never exceeds the distance to the surface.",
    "none": "The field is not a distance.",
}


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
            parts += _entries(of_group) if group in _GROUPED else map(_entry, of_group)
    parts.append("## Examples\n")
    parts.append("They are in the menu Load Example of a lamp.\n")
    parts.append("![Every example as a lamp](images/examples.png)\n")
    parts += _texts(examples())
    parts += [_EMISSION, *_texts(presets())]
    return "\n".join(parts).rstrip("\n") + "\n"


def _texts(examples: dict[str, Example]) -> list[str]:
    """Examples under their titles."""
    parts = []
    for example in examples.values():
        lines = example.text.splitlines()[1:]
        parts += [f"### {example.title}\n", *(f"    {line}".rstrip() for line in lines), ""]
    return parts


def _entries(words: list[Function]) -> list[str]:
    """Entries of shapes under the titles of their groups."""
    by_name = {word.name: word for word in words}
    parts = []
    for title, shapes in grouped(SHAPES[name] for name in by_name).items():
        parts += [f"**{title}**\n", *(_entry(by_name[shape.name()]) for shape in shapes)]
    return parts


def _entry(word: Function) -> str:
    lines = [f"### `{word.signature()}`\n", word.description, ""]
    shape = SHAPES.get(word.name) or PROFILES.get(word.name)
    fields = DATA[word.name].numbers if word.group == DATA_WORDS else () if shape is None else shape.fields()
    if fields:
        lines += ["| parameter | default | limits | |", "|---|---|---|---|"]
        lines += [_row(about) for about in fields]
        lines.append("")
    for choice in DATA[word.name].choices if word.group == DATA_WORDS else ():
        lines += [f"{choice.description}, `{choice.name}`:\n"]
        lines += [f'- `"{name}"`: {meaning[0].lower()}{meaning[1:]}.' for name, meaning in choice.words]
        lines.append("")
    if shape is None:
        return "\n".join(lines)
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
