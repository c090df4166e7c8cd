# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A node for each word of the expression language: every shape, profile, operator, fractal and function.

They are made from the words: an input for each argument, with the limits, unit, default and tooltip that the shape's
parameter has. Words of vectors and the field of a shape have nodes of another form, in ``value_nodes``, and colour
ramps in ``emission_nodes``.
"""

from __future__ import annotations

import ast

import bpy

from ...sdf import evaluation  # noqa: F401 (all words are in FUNCTIONS then)
from ...sdf.builtin_colors import COLDEST, HOTTEST
from ...sdf.builtin_data import DATA, Data
from ...sdf.functions import COLOURS, DATA_WORDS, FUNCTIONS, POINTS, REQUIRED, Argument, Function
from ...sdf.resolver import COLOURS as COLOURS_OF_IMAGE
from ...sdf.shapes import SHAPES, Family
from ...sdf.shapes.base import LARGEST, Parameter
from ...sdf.shapes.operators import SetOperation
from ...sdf.shapes.profiles import PROFILES
from .. import sources
from ..objects import curves
from ..properties import parameter_property, tag
from . import sockets
from .lines import Broken, word
from .tree import LampNode

_ELSEWHERE = {"vec2", "vec3", "distance", "field", "ramp", "ramp_ease", "ramp_constant", COLOURS_OF_IMAGE}

_SOCKETS = {
    "shape": sockets.SHAPE,
    "profile": sockets.PROFILE,
    "condition": sockets.CONDITION,
    "any": sockets.ANY,
    "value": sockets.ANY,
    "number": sockets.NUMBER,
    "angle": sockets.NUMBER,
    "scalar": sockets.NUMBER,
    "numbers": sockets.VECTOR,
    "angles": sockets.VECTOR,
    "vector": sockets.VECTOR,
    "vector3": sockets.VECTOR,
    "corner": sockets.VECTOR,
}

_NUMBERS = {"dot", "length", "noise"}  # of a vector
_VECTORS = {"cross", "normalize"}

# Where a zero would make no sense. Arguments of the language that have to be given have no default there.
_DEFAULTS = {
    "temperature": 3000.0,
    "factor": (1.0, 1.0, 1.0),
    "divisor": 1.0,
    "high": 1.0,
    "exponent": 1.0,
    "count": 6.0,
    "period": 1.0,
    "normal": (0.0, 0.0, 1.0),
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
}


def label_of(function: Function) -> str:
    """Name of the word in menus."""
    found = SHAPES.get(function.name) or PROFILES.get(function.name)
    return found.label() if found and function.makes_shape else function.name.replace("_", " ").title()


def _parameters(function: Function) -> dict[str, Parameter]:
    """Arguments that have a value without a link, as a user interface presents them."""
    shape = (SHAPES | PROFILES).get(function.name) if function.makes_shape else None
    known = {about.name: about for about in shape.fields()} if shape else {}
    if function.group == DATA_WORDS:
        known = {about.name: about for about in DATA[function.name].numbers}
    found = {}
    for argument in function.arguments[function.variadic :]:
        if argument.kind == "text":
            continue
        if argument.name in known:
            found[argument.name] = known[argument.name]
        elif _SOCKETS[argument.kind] not in (sockets.SHAPE, sockets.PROFILE, sockets.CONDITION) and not (
            argument.kind == "any" or argument.name == "point"
        ):
            found[argument.name] = _described(argument)
    return found


def _described(argument: Argument) -> Parameter:
    vector = _SOCKETS[argument.kind] == sockets.VECTOR
    default = argument.default
    if default is REQUIRED:
        default = _DEFAULTS.get(argument.name, 0.0)
    if vector != isinstance(default, tuple):
        default = (default,) * 3 if vector else 0.0
    label = argument.name.replace("_", " ").title()
    unit = "LENGTH" if argument.name == "offset" else "ANGLE" if argument.kind in ("angle", "angles") else "NONE"
    low, high, soft = (COLDEST, HOTTEST, HOTTEST) if argument.name == "temperature" else (-LARGEST, LARGEST, 10.0)
    description = f"{label} where nothing is connected"
    return Parameter(argument.name, label, description, unit, default, low, high, soft, 3 if vector else 1, False)


class _WordNode(LampNode):
    """A call of a word, its ``function``."""

    def match_interface(self):
        """Adds the inputs that a file of an older version lacks."""
        self._add_sockets()

    def _add_sockets(self):
        function = self.function
        repeated = function.arguments[0].name if function.variadic else ""
        known = {socket.identifier for socket in self.inputs}
        for identifier, label, kind in self.takes:
            if identifier not in known:
                self.inputs.new(kind, label, identifier=identifier, use_multi_input=identifier == repeated)
        if not self.outputs:
            ((identifier, label, kind),) = self.gives
            self.outputs.new(kind, label, identifier=identifier)

    def draw_label(self):
        return self.bl_label

    def written(self, writer):
        function = self.function
        positional, named, parameters = [], {}, _parameters(function)
        given = {socket.identifier: socket for socket in self.inputs}
        if function.variadic:
            if _is_difference(function):
                positional.append(writer.needed(given["first"]))
            many = given[function.arguments[0].name]
            positional += writer.inputs(many)
            if not positional:
                positional.append(writer.needed(many))
        for argument in function.arguments[function.variadic :]:
            socket = given.get(argument.name)
            if socket is None:
                continue
            if argument.name == "point" and not socket.is_linked:
                value = ast.Name("p", ast.Load())
            elif argument.name in parameters:
                value = writer.input(socket)
            else:
                value = writer.needed(socket)
            if value is None:
                continue
            if argument.kind in ("angle", "angles"):
                value = writer.degrees(value)
            if argument.default is REQUIRED:
                positional.append(value)
            else:
                named[argument.name] = value
        call = ast.Call(
            ast.Name(function.name, ast.Load()), positional, [ast.keyword(name, value) for name, value in named.items()]
        )
        return {"result": writer.assign(self.label or function.name, call)}


SUBJECTS = {"text": "body", "path": "path", "object": "object", "image": "image"}
"""The property of a data node that holds its data, for each kind of data."""


class _DataNode(_WordNode):
    """A word of data: what it names is a property of the node, and so are its choices."""

    @property
    def data(self) -> Data:
        """The row of the word."""
        return DATA[self.function.name]

    def subject(self) -> bpy.types.ID | str | None:
        """What it names, if that is chosen."""
        return getattr(self, SUBJECTS[self.data.of])

    def names(self):
        return frozenset({(self.data.name, self.subject())}) if self.data.of == "text" else frozenset()

    def things(self):
        subject = self.subject()
        return [subject] if isinstance(subject, bpy.types.ID) else []

    def draw_settings(self, layout):
        layout.prop(self, SUBJECTS[self.data.of], text="")
        for choice in self.data.choices:
            layout.prop(self, choice.name, text="")

    def written(self, writer):
        data, subject = self.data, self.subject()
        if not subject:
            is_text = data.of == "text"
            raise Broken("Nothing is written: write something" if is_text else f"No {data.of} is chosen: choose one")
        name = subject if isinstance(subject, str) else writer.thing(data.name, subject)
        named = {socket.identifier: writer.input(socket) for socket in self.inputs}
        for choice in data.choices:
            named[choice.name] = ast.Constant(getattr(self, choice.name).lower())
        return {"result": writer.assign(self.label or data.name, word(data.name, ast.Constant(name), **named))}


def _read_text(self, context):
    if self.body:
        curves.read_letters(self.body)
    tag(self, context)


def _subject(data: Data):
    common = dict(name=data.name.title(), update=tag)
    if data.of == "text":
        return bpy.props.StringProperty(name="Text", description="What is written", default="OPEN", update=_read_text)
    if data.of == "path":
        return bpy.props.StringProperty(description="File, which may begin with //", subtype="FILE_PATH", **common)
    if data.of == "image":
        return bpy.props.PointerProperty(description="Picture whose outline it is", type=bpy.types.Image, **common)
    types = sources.types_of(data.name)
    return bpy.props.PointerProperty(
        description="Object whose shape it is",
        type=bpy.types.Object,
        poll=lambda self, obj: obj.type in types,
        **common,
    )


def _data_properties(data: Data) -> dict:
    choices = {
        choice.name: bpy.props.EnumProperty(
            name=choice.label,
            description=choice.description,
            items=[(word.upper(), word.title(), meaning, index) for index, (word, meaning) in enumerate(choice.words)],
            update=tag,
        )
        for choice in data.choices
    }
    return {SUBJECTS[data.of]: _subject(data)} | choices


def _is_difference(function: Function) -> bool:
    shape = SHAPES.get(function.name)
    return (
        function.makes_shape
        and shape is not None
        and issubclass(shape, SetOperation)
        and (shape.family == Family.DIFFERENCE)
    )


def _inputs(function: Function) -> list[tuple[str, str, str]]:
    found, parameters = [], _parameters(function)
    for index, argument in enumerate(function.arguments):
        if argument.kind == "text":  # a property of the node
            continue
        label = argument.name.replace("_", " ").title()
        if function.variadic and index == 0:
            if _is_difference(function):
                found.append(("first", "Shape", sockets.SHAPE))
            label = "Without" if found else f"{label}s"
        elif argument.name in parameters:
            label = parameters[argument.name].label
        found.append((argument.name, label, _SOCKETS[argument.kind]))
    return found


def _result(function: Function) -> tuple[str, str]:
    """Label and type of the output."""
    if function.group == "Profiles":
        return "Profile", sockets.PROFILE
    if function.name.startswith("rotate"):
        return "Result", sockets.ANY
    if function.makes_shape or function.name == "displace":
        return "Shape", sockets.SHAPE
    if function.name in _NUMBERS:
        return "Value", sockets.NUMBER
    if function.group == COLOURS:
        return "Color", sockets.COLOR
    if function.group == POINTS or function.name in _VECTORS:
        return "Vector", sockets.VECTOR
    return "Value", sockets.ANY


def _node(name: str, function: Function) -> type:
    description = function.description.split("\n\n")[0].replace("\n", " ").replace("`", "").rstrip(".")
    annotations = {sockets.property_of(key): parameter_property(about) for key, about in _parameters(function).items()}
    data = DATA[function.name] if function.group == DATA_WORDS else None
    if data is not None:
        annotations |= _data_properties(data)
    name = (
        "data_object" if name == "object" else name
    )  # a node that takes the transform of an object has the other name
    return type(
        f"SDFLIGHTS_Node_{name}",
        (_WordNode if data is None else _DataNode, bpy.types.Node),
        {
            "__doc__": description,
            "__annotations__": annotations,
            "function": function,
            "takes": tuple(_inputs(function)),
            "gives": (("result", *_result(function)),),
            "bl_idname": f"SDFLIGHTS_Node_{name}",
            "bl_label": label_of(function),
            "bl_description": description,
            "bl_width_default": 160.0,
        },
    )


def _functions() -> dict[str, Function]:
    found = {}
    for name, function in FUNCTIONS.items():
        if name not in _ELSEWHERE:
            found[name] = function
        if function.other is not None:
            found[f"{name}_{'point' if function.other.group == POINTS else 'value'}"] = function.other
    return found


FUNCTION_NODES: dict[str, type] = {name: _node(name, function) for name, function in _functions().items()}
"""Node of each word; of a word that also serves for numbers, ``round_value`` and the like."""


def node_of(function: Function) -> type | None:
    """The node of a word, if there is one."""
    return next((node for node in FUNCTION_NODES.values() if node.function is function), None)


CLASSES = tuple(FUNCTION_NODES.values())
