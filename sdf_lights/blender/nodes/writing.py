# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From expressions of shapes and emissions to nodes: the way back of ``reading``.

The expression is evaluated while it is walked, so it is known of every part what it is. What has no node (a loop, a
block of conditions) makes the whole expression one node.
"""

from __future__ import annotations

import ast
import math

import bpy

from ...sdf.builtin_data import DATA
from ...sdf.emission import INPUTS, name_inputs
from ...sdf.evaluation import Evaluation
from ...sdf.expression_values import kind_of
from ...sdf.functions import CONSTANTS, FUNCTIONS
from ...sdf.resolver import COLOURS, PlaceholderResolver
from ...sdf.syntax import parse
from ..naming import NODE_TREE
from ..sources import FileResolver
from . import emission_nodes, function_nodes, scene, sockets, value_nodes
from .layout import arrange
from .lines import EMISSION, SHAPE, is_declaration
from .tree import OUTPUT, output_of


class NoNode(Exception):
    """There is no node for a part of the expression."""


class _Recorder(Evaluation):
    """Keeps the value of each part of the syntax tree."""

    def __init__(self):
        super().__init__({}, {}, PlaceholderResolver())
        self.found: dict[ast.expr, object] = {}

    def value(self, node):
        self.found[node] = super().value(node)
        return self.found[node]


def new_tree(name: str) -> tuple[bpy.types.NodeTree, bpy.types.Node]:
    """An empty tree and its output."""
    tree = bpy.data.node_groups.new(name, NODE_TREE)
    return tree, tree.nodes.new(OUTPUT)


def tree_of(name: str, text: str, lamp=None) -> bpy.types.NodeTree:
    """A new node tree that says the same shape as an expression, of ``lamp``, if any.

    Raises ``ExpressionError`` if that says none.
    """
    syntax = parse(text)
    recorder = _Recorder()
    recorder.remarks = syntax.remarks
    recorder.run(syntax.tree)
    tree, end = new_tree(name)
    try:
        result = _Builder(tree, recorder, lamp).run(syntax.tree)
    except NoNode:
        tree.nodes.clear()
        end = tree.nodes.new(OUTPUT)
        node = tree.nodes.new(scene.SDFLIGHTS_Node_expression.bl_idname)
        result = _with_text(node, name, text)
    tree.links.new(result, _input(end, SHAPE))
    arrange(tree)
    return tree


def add_emission(tree: bpy.types.NodeTree, text: str, lamp=None) -> dict[str, str]:
    """Adds an emission to a tree with an output.

    Returns the names that its parameters have in the tree, where they must differ from those that are there, by their
    names in the text. Raises ``ExpressionError`` if the text says no emission.
    """
    syntax = parse(text)
    recorder = _Recorder()
    recorder.remarks = syntax.remarks
    name_inputs(recorder)
    recorder.last(syntax.tree, "", "", "")
    taken = {node.parameter for node in tree.nodes if node.bl_idname == value_nodes.SDFLIGHTS_Node_parameter.bl_idname}
    taken |= set(INPUTS)
    renamed = {name: f"{EMISSION}_{name}" if name in taken else name for name in recorder.declarations}
    before = set(tree.nodes)
    try:
        result = _Builder(tree, recorder, lamp, renamed).run(syntax.tree)
    except NoNode:
        for node in set(tree.nodes) - before:
            tree.nodes.remove(node)
        node = tree.nodes.new(emission_nodes.SDFLIGHTS_Node_pattern.bl_idname)
        node.pattern, renamed = emission_nodes.EXPRESSION, {}
        result = _with_text(node, f"{tree.name} Emission", text)
    tree.links.new(result, _input(output_of(tree), EMISSION))
    arrange(tree)
    return renamed


def _with_text(node: bpy.types.Node, name: str, text: str) -> bpy.types.NodeSocket:
    """Gives a node a text, in a block of its own if it has several lines; returns its output."""
    if "\n" in text.strip():
        block = bpy.data.texts.new(name)
        block.write(text)
        node.text = block
    else:
        node.expression = text.strip()
    node.match_interface()
    return node.outputs[0]


def _input(node: bpy.types.Node, identifier: str) -> bpy.types.NodeSocket:
    return next(socket for socket in node.inputs if socket.identifier == identifier)


class _Builder:
    """Makes nodes of the parts of an expression. ``renamed``: names of parameters in the tree by those in the text."""

    def __init__(self, tree: bpy.types.NodeTree, recorder: _Recorder, lamp=None, renamed: dict[str, str] | None = None):
        self._resolver = FileResolver(lamp)
        self._tree, self._recorder, self._renamed = tree, recorder, renamed or {}
        self._names: dict[str, object] = {}

    def run(self, module: ast.Module) -> bpy.types.NodeSocket:
        for statement in module.body[:-1]:
            if not isinstance(statement, ast.Assign):
                raise NoNode
            name = statement.targets[0].id
            if is_declaration(statement):
                self._names[name] = self._parameter(self._recorder.declarations[name])
                continue
            self._names[name] = part = self.part(statement.value)
            if isinstance(part, bpy.types.NodeSocket) and not part.node.label and name != "p":
                part.node.label = name.replace("_", " ").title()
        result = self.part(module.body[-1].value)
        return result if isinstance(result, bpy.types.NodeSocket) else self._value(result)

    def _new(self, kind: type | None) -> bpy.types.Node:
        if kind is None:
            raise NoNode
        return self._tree.nodes.new(kind.bl_idname)

    def _parameter(self, declaration) -> bpy.types.NodeSocket:
        node = self._new(value_nodes.SDFLIGHTS_Node_parameter)
        node.parameter = self._renamed.get(declaration.name, declaration.name)
        node.tooltip = declaration.description
        angle = declaration.kind == "angle"
        for name in ("minimum", "maximum"):
            limit = getattr(declaration, name)
            setattr(node, f"{name}_angle" if angle else name, math.radians(limit) if angle else limit)
        if declaration.kind == "vector":
            node.default_vector = declaration.default
        elif declaration.kind == "toggle":
            node.default_toggle = declaration.default > 0.5
        elif angle:
            node.default_angle = math.radians(declaration.default)
        else:
            node.default = declaration.default
        node.kind = declaration.kind
        return node.outputs[0]

    # -- parts --------------------------------------------------------------------------------------------------------

    def part(self, node: ast.expr):
        """An output, or a number, truth or tuple of numbers. Raises NoNode if a value is not known."""
        build = _PARTS.get(type(node))
        if build is None:
            raise NoNode
        return build(self, node)

    def _constant(self, node):
        return node.value if isinstance(node.value, bool) else float(node.value)

    def _name(self, node):
        if node.id in self._names:
            return self._names[node.id]
        if node.id in CONSTANTS:
            return CONSTANTS[node.id]
        if node.id == "p":
            self._names["p"] = self._new(value_nodes.SDFLIGHTS_Node_position).outputs[0]
            return self._names["p"]
        if node.id in INPUTS:
            interior = self._new(emission_nodes.SDFLIGHTS_Node_interior)
            self._names |= {socket.identifier: socket for socket in interior.outputs}
            return self._names[node.id]
        raise NoNode

    def _vector(self, node):
        parts = [self.part(element) for element in node.elts]
        return self._combined(parts)

    def _combined(self, parts: list):
        if len(parts) == 3 and all(isinstance(part, float) for part in parts):
            return tuple(parts)
        node = self._new(value_nodes.SDFLIGHTS_Node_combine)
        node.plane = len(parts) == 2
        for name, part in zip("xyz", parts):
            self._put(node, name, part)
        return node.outputs[0]

    def _component(self, node):
        vector = self.part(node.value)
        if isinstance(vector, tuple):
            parts = [vector["xyz".index(letter)] for letter in node.attr]
        else:
            separate = self._separated(vector)
            parts = [next(s for s in separate.outputs if s.identifier == letter) for letter in node.attr]
        return self._combined(parts) if len(parts) > 1 else parts[0]

    def _separated(self, vector) -> bpy.types.Node:
        for link in vector.links:
            if link.to_node.bl_idname == value_nodes.SDFLIGHTS_Node_separate.bl_idname:
                return link.to_node
        node = self._new(value_nodes.SDFLIGHTS_Node_separate)
        self._put(node, "vector", vector)
        return node

    def _binary(self, node):
        kind = type(node.op)
        if self._makes_shape(node):
            operands, rest = [node.right], node.left
            while isinstance(rest, ast.BinOp) and type(rest.op) is kind and self._makes_shape(rest):
                operands.append(rest.right)
                rest = rest.left
            operands = [self.part(operand) for operand in [rest, *reversed(operands)]]
            name = {ast.BitOr: "union", ast.BitAnd: "intersection", ast.Sub: "difference"}[kind]
            return self._combination(FUNCTIONS[name], operands, {})
        a, b = self.part(node.left), self.part(node.right)
        operation = next(name for name, operator in value_nodes.OPERATORS.items() if operator is kind)
        return self._math(operation, a, b)

    def _makes_shape(self, node: ast.expr) -> bool:
        if node in self._recorder.found:
            return kind_of(self._recorder.found[node]) == "shape"
        # A link of a chain of operators, which the evaluation walks without asking for its value.
        return (
            isinstance(node.op, (ast.BitOr, ast.BitAnd))
            or isinstance(node.op, ast.Sub)
            and (self._makes_shape(node.left) or self._makes_shape(node.right))
        )

    def _math(self, operation: str, a, b):
        node = self._new(value_nodes.SDFLIGHTS_Node_math)
        node.operation = operation
        self._put(node, "a", a)
        self._put(node, "b", b)
        return node.outputs[0]

    def _unary(self, node):
        operand = self.part(node.operand)
        if isinstance(node.op, ast.UAdd):
            return operand
        if isinstance(node.op, ast.Not):
            return self._boolean("NOT", [operand])
        if isinstance(operand, float):
            return -operand
        if isinstance(operand, tuple):
            return tuple(-component for component in operand)
        return self._math("MULTIPLY", operand, -1.0)

    def _boolean(self, operation: str, parts: list):
        if not all(isinstance(part, bpy.types.NodeSocket) for part in parts):
            raise NoNode
        node = self._new(value_nodes.SDFLIGHTS_Node_boolean)
        node.operation = operation
        for name, part in zip("ab", parts):
            self._put(node, name, part)
        return node.outputs[0]

    def _logic(self, node):
        parts = [self.part(value) for value in node.values]
        while len(parts) > 1:
            parts[:2] = [self._boolean("AND" if isinstance(node.op, ast.And) else "OR", parts[:2])]
        return parts[0]

    def _comparison(self, node):
        made = self._new(value_nodes.SDFLIGHTS_Node_compare)
        made.operation = next(name for name, kind in value_nodes.COMPARISONS.items() if isinstance(node.ops[0], kind))
        self._put(made, "a", self.part(node.left))
        self._put(made, "b", self.part(node.comparators[0]))
        return made.outputs[0]

    def _selection(self, node):
        named = dict(condition=self.part(node.test), then=self.part(node.body), otherwise=self.part(node.orelse))
        return self._call_of(FUNCTIONS["select"], [], named)

    def _call(self, node):
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        callable_name = kind_of(self._recorder.names.get(name, 0.0)) in ("shape", "profile")
        if name not in FUNCTIONS or (name in self._names and callable_name):
            return self._field(self.part(node.func), self.part(node.args[0]))
        if any(keyword.arg is None for keyword in node.keywords):
            raise NoNode
        if name in emission_nodes.RAMPS.values():
            return self._ramp(name, [self.part(argument) for argument in node.args])
        if name == COLOURS:
            return self._image_color(node)
        if name in DATA:
            return self._data(name, node)
        function = FUNCTIONS[name]
        nodes = [*node.args, *(keyword.value for keyword in node.keywords)]
        found = [self._recorder.found[part] for part in nodes]
        parts = {id(value): self.part(part) for value, part in zip(found, nodes)}
        positional = found[: len(node.args)]
        if function.other is not None and kind_of(positional[0]) not in ("shape", "profile"):
            function = function.other
        if name in ("vec2", "vec3"):
            return self._vector_of(int(name[-1]), [parts[id(value)] for value in positional], positional)
        named = {keyword.arg: value for keyword, value in zip(node.keywords, found[len(node.args) :])}
        repeated, given = function.bound(positional, named)

        def made(value):
            return parts[id(value)] if id(value) in parts else self._combined([parts[id(v)] for v in value])

        arguments = {key: made(value) for key, value in given.items()}
        if name == "distance":
            if kind_of(given["shape"]) == "vector":
                return self._call_of(
                    FUNCTIONS["length"], [], {"vector": self._math("SUBTRACT", arguments["shape"], arguments["point"])}
                )
            return self._field(arguments["shape"], arguments["point"])
        if name == "field":
            return self._shape_of_field(arguments)
        return self._call_of(function, [made(value) for value in repeated], arguments)

    def _data(self, name: str, node: ast.Call):
        function = FUNCTIONS[name]
        settings = dict(zip((argument.name for argument in function.arguments), node.args))
        settings |= {keyword.arg: keyword.value for keyword in node.keywords}
        subject, prop = settings.pop(function.arguments[0].name), function_nodes.SUBJECTS[DATA[name].of]
        if not isinstance(subject, ast.Constant):
            raise NoNode
        thing = subject.value if DATA[name].of in ("text", "path") else self._resolver.thing(name, subject.value)
        if not thing:
            raise NoNode
        made = self._new(function_nodes.node_of(function))
        setattr(made, prop, thing)
        for setting, part in settings.items():
            if any(choice.name == setting for choice in DATA[name].choices):
                if not isinstance(part, ast.Constant):
                    raise NoNode
                setattr(made, setting, part.value.upper())
            else:
                self._put(made, setting, self.part(part))
        return made.outputs[0]

    def _image_color(self, node: ast.Call):
        given = dict(zip(("name", "u", "v"), node.args)) | {keyword.arg: keyword.value for keyword in node.keywords}
        name = given.pop("name")
        image = self._resolver.thing("image", name.value) if isinstance(name, ast.Constant) else None
        if image is None:
            raise NoNode
        made = self._new(emission_nodes.SDFLIGHTS_Node_image_color)
        made.image = image
        for key, part in given.items():
            self._tree.links.new(self._socket(self.part(part)), _input(made, key))
        return made.outputs[0]

    def _socket(self, part) -> bpy.types.NodeSocket:
        return part if isinstance(part, bpy.types.NodeSocket) else self._value(part)

    def _ramp(self, name: str, parts: list):
        node = self._new(emission_nodes.SDFLIGHTS_Node_ramp)
        node.interpolation = next(key for key, found in emission_nodes.RAMPS.items() if found == name)
        node.stops = (len(parts) - 1) // 2
        for identifier, part in zip((identifier for identifier, _, _ in node.wanted_inputs()), parts):
            self._put(node, identifier, part)
        return node.outputs[0]

    def _vector_of(self, size: int, parts: list, found: list):
        flat = []
        for part, value in zip(parts, found):
            if kind_of(value) != "vector":
                flat.append(part)
            elif isinstance(part, tuple):
                flat += part
            else:
                outputs = self._separated(part).outputs
                flat += [outputs[index] for index in range(len(value))]
        return self._combined(flat * size if len(flat) == 1 else flat)

    def _field(self, shape, point):
        node = self._new(value_nodes.SDFLIGHTS_Node_distance)
        self._put(node, "shape", shape)
        self._put(node, "point", point)
        return node.outputs[0]

    def _shape_of_field(self, arguments: dict):
        node = self._new(value_nodes.SDFLIGHTS_Node_field)
        self._put(node, "value", arguments["value"])
        if "bounds" in arguments:
            node.use_bounds = True
            self._put(node, "bounds", arguments["bounds"])
        return node.outputs[0]

    def _call_of(self, function, repeated: list, arguments: dict):
        if function.variadic:
            return self._combination(function, repeated, arguments)
        node = self._new(function_nodes.node_of(function))
        self._set(node, function, arguments)
        return node.outputs[0]

    def _combination(self, function, repeated: list, arguments: dict):
        node = self._new(function_nodes.node_of(function))
        many = function.arguments[0].name
        if any(s.identifier == "first" for s in node.inputs):
            self._put(node, "first", repeated[0])
            repeated = repeated[1:]
        for part in reversed(repeated):  # the last link that is made is at the top
            self._put(node, many, part)
        self._set(node, function, arguments)
        return node.outputs[0]

    def _set(self, node, function, arguments: dict) -> None:
        angles = {argument.name for argument in function.arguments if argument.kind in ("angle", "angles")}
        for name, part in arguments.items():
            self._put(node, name, self._radians(part) if name in angles else part)

    def _radians(self, part):
        if isinstance(part, float):
            return math.radians(part)
        if isinstance(part, tuple):
            return tuple(map(math.radians, part))
        if part.node.bl_idname == value_nodes.SDFLIGHTS_Node_parameter.bl_idname and part.node.kind == "angle":
            return part
        return self._call_of(FUNCTIONS["radians"], [], {"degrees": part})

    def _put(self, node, identifier: str, part) -> None:
        """Gives an input a value or a link."""
        socket = next(s for s in node.inputs if s.identifier == identifier)
        if isinstance(part, bpy.types.NodeSocket):
            if (
                part.node.bl_idname == value_nodes.SDFLIGHTS_Node_parameter.bl_idname
                and part.node.kind == "angle"
                and (not _takes_angle(node, identifier))
            ):
                part = self._call_of(FUNCTIONS["degrees"], [], {"radians": part})
            self._tree.links.new(part, socket)
        elif not sockets.held_by_node(socket) or isinstance(part, bool):
            self._tree.links.new(self._value(part), socket)
        else:
            prop = node.bl_rna.properties[sockets.property_of(identifier)]
            vector = prop.is_array
            if isinstance(part, tuple) and not vector:
                self._tree.links.new(self._value(part), socket)
                return
            part = (part,) * 3 if vector and not isinstance(part, tuple) else part
            setattr(node, prop.identifier, int(round(part)) if prop.type == "INT" else part)

    def _value(self, part):
        """A node for a value that an input cannot hold."""
        if isinstance(part, bool):
            raise NoNode
        node = self._new(
            value_nodes.SDFLIGHTS_Node_vector if isinstance(part, tuple) else value_nodes.SDFLIGHTS_Node_number
        )
        node.value = part
        return node.outputs[0]


def _takes_angle(node, identifier: str) -> bool:
    function = getattr(node, "function", None)
    return function is not None and (
        function.name == "degrees"
        or any(argument.name == identifier and argument.kind in ("angle", "angles") for argument in function.arguments)
    )


_PARTS = {
    ast.Constant: _Builder._constant,
    ast.Name: _Builder._name,
    ast.Tuple: _Builder._vector,
    ast.Attribute: _Builder._component,
    ast.BinOp: _Builder._binary,
    ast.UnaryOp: _Builder._unary,
    ast.BoolOp: _Builder._logic,
    ast.Compare: _Builder._comparison,
    ast.IfExp: _Builder._selection,
    ast.Call: _Builder._call,
}
