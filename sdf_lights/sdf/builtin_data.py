# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The words of the expression language for data: texts, objects, pictures, meshes, networks. A row of ``DATA`` for
each.

What a name means, the ``Resolver`` of the expression says. Nodes are made from the rows, too.
"""

from __future__ import annotations

import ast
from typing import NamedTuple

from .builtin_numbers import as_formula
from .expression_values import Misuse, Scalar, Work, lifted
from .functions import COLOURS as COLOUR_WORDS
from .functions import DATA_WORDS, Argument, Function, add
from .resolver import COLOURS, Request, Unresolved
from .shapes.base import LARGEST, SMALLEST, Parameter


class Choice(NamedTuple):
    """A setting that is one of some words, with what each of them means; the first is the default."""

    name: str
    label: str
    description: str
    words: tuple[tuple[str, str], ...]


class Data(NamedTuple):
    """A word: its ``name`` is the kind of a ``Request``; ``subject`` is what its first argument is called.

    ``of`` says what that names: an "object" or "image", a file ("path"), or nothing: it is the "text" itself.
    """

    name: str
    subject: str
    of: str
    description: str
    numbers: tuple[Parameter, ...]
    choices: tuple[Choice, ...] = ()


def _length(name: str, description: str, default: float, minimum: float = SMALLEST, soft: float = 10.0) -> Parameter:
    label = name.replace("_", " ").title()
    return Parameter(name, label, description, "LENGTH", default, minimum, LARGEST, soft, 1, False)


_THICKNESS = _length("thickness", "Thickness where the object has no extrusion and no bevel", 0.1, soft=1.0)
_VOXEL = _length(
    "voxel_size",
    "Size of the voxels of a mesh; 0 divides its longest side into 128, in viewports into 64",
    0.0,
    0.0,
    1.0,
)
_NEON = (
    _length("neon_radius", "Radius of a glass tube along the outline or curve; 0 fills it", 0.0, 0.0, 0.2),
    _length("gap", "Gap between both ends of a glass tube that would be closed", 0.03, 0.0, 0.5),
)
PARTS = Choice(
    "part",
    "Part",
    "What of the picture glows",
    (
        ("opaque", "Where its alpha is above the threshold"),
        ("bright", "Where it is brighter than the threshold"),
        ("dark", "Where it is darker than the threshold"),
    ),
)

DATA: dict[str, Data] = {
    row.name: row
    for row in (
        Data(
            "text",
            "text",
            "text",
            'The letters of a text in Blender\'s font, extruded, around the origin: `text("OPEN")`.',
            (
                _length("size", "Size of the letters", 1.0),
                _length("thickness", "Thickness of the letters along z", 0.1, soft=1.0),
                *_NEON,
            ),
        ),
        Data(
            "object",
            "name",
            "object",
            "The shape of a text, curve, mesh or metaball object, in the object's own space. It follows what is edited there.",
            (_THICKNESS, *_NEON, _VOXEL),
        ),
        Data(
            "image",
            "name",
            "image",
            "The outline of a picture, extruded: of an image of the file, or of a path, which may begin with `//`.",
            (
                _length("width", "Width of the whole picture", 1.0, soft=10.0),
                _length("thickness", "Thickness along z", 0.1, soft=1.0),
                Parameter(
                    "threshold",
                    "Threshold",
                    "Alpha or brightness of the edge",
                    "NONE",
                    0.5,
                    0.001,
                    0.999,
                    0.999,
                    1,
                    False,
                ),
            ),
            (PARTS,),
        ),
        Data("mesh", "name", "object", "What a mesh object encloses, by a grid of signed distances.", (_VOXEL,)),
        Data(
            "network", "path", "path", "A network of sines from a `.npz` file. `//` begins a path beside the file.", ()
        ),
    )
}
"""The words, by name."""


def request(data: Data, name: str, given: dict) -> Request:
    """What a resolver is asked. Raises ``Misuse`` for settings beyond their limits."""
    for about in data.numbers:
        if not about.minimum <= given[about.name] <= about.maximum:
            raise Misuse(
                f"{about.name} of {data.name} is {given[about.name]:g}",
                f"use a value from {about.minimum:g} to {about.maximum:g}",
            )
    for choice in data.choices:
        words = [word for word, _ in choice.words]
        if given[choice.name] not in words:
            raise Misuse(
                f"{choice.name} of {data.name} is {given[choice.name]!r:.40}",
                f"write {', '.join(map(repr, words[:-1]))} or {words[-1]!r}",
            )
    settings = tuple((key, value if isinstance(value, str) else float(value)) for key, value in given.items())
    return Request(data.name, name, settings)


def names_in(tree: ast.AST) -> frozenset[tuple[str, str]]:
    """Kinds and names that an expression may ask a resolver for: each word that it calls with each text in it."""
    nodes = list(ast.walk(tree))
    called = {node.func.id for node in nodes if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
    texts = {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    kinds = called & DATA.keys() | ({"image"} if COLOURS in called else set())
    return frozenset((kind, text) for kind in kinds for text in texts)


def _add(data: Data) -> None:
    settings = [
        *(Argument(about.name, "number", about.default) for about in data.numbers),
        *(Argument(choice.name, "text", choice.words[0][0]) for choice in data.choices),
    ]

    def call(slots: Work, name: str, *given):
        asked = request(data, name, dict(zip((setting.name for setting in settings), given)))
        try:
            return slots.resolver.find(asked)
        except Unresolved as error:
            raise Misuse(str(error), error.cure) from None

    add(Function(data.name, DATA_WORDS, (Argument(data.subject, "text"), *settings), call, data.description))


for _row in DATA.values():
    _add(_row)


def _image_color(slots: Work, name: str, u: Scalar, v: Scalar):
    from .data.texture import colour  # it needs Numba, whose import takes a second

    try:
        found = slots.resolver.find(Request(COLOURS, name))
    except Unresolved as error:
        raise Misuse(str(error), error.cure) from None
    slots.operate(_TEXTURE_OPERATIONS)
    return tuple(colour(slots(found.address), *(as_formula(lifted(value, slots)) for value in (u, v))))


_TEXTURE_OPERATIONS = 100  # of the colour at a point, about

add(
    Function(
        COLOURS,
        COLOUR_WORDS,
        (Argument("name", "text"), Argument("u", "scalar"), Argument("v", "scalar")),
        _image_color,
        "The colour of a picture, from its lower left corner at u = v = 0 to its upper right one at u = v = 1.",
    )
)
