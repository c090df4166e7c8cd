# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a node tree to its shape and emission: nodes are written as lines of the expression language.

The language evaluates them, so a node means what its word means, with the same checks and limits, and a tree can be
read as text. A line is a syntax tree; it is never printed and parsed on the way to a shape. Groups are written as often
as they are used, reroutes and muted nodes not at all. The shape and the emission are read one after the other, each
from its input of the Lamp Output.

Numbers of sockets stay out of the lines: there they are names, ``#0``, ``#1`` and so on, of values that may change. So
a slider changes no formula, and compiles nothing.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import bpy
import numpy as np

from ...render.errors import RenderError
from ...sdf import declarations as declared
from ...sdf.declarations import LONGEST_NAME, Declaration
from ...sdf.emission import INPUTS, Emission, as_emission, name_inputs
from ...sdf.evaluation import Evaluation
from ...sdf.expression_values import Condition, Live
from ...sdf.functions import CONSTANTS, FUNCTIONS, as_shape
from ...sdf.resolver import Cache, Resolver
from ...sdf.shapes import Shape
from ...sdf.syntax import KEYWORDS, ExpressionError, parse
from ..naming import NODE_TREE
from ..sources import FileResolver
from . import sockets
from .tree import GROUP, OUTPUT, LampNode, finds_problems, output_of, within

SHAPE, EMISSION = "shape", "emission"
"""Inputs of the Lamp Output."""

DEEPEST_GROUP = 20
MOST_LINES = 4_000

Place = tuple[tuple, "bpy.types.Node"]  # the group nodes that one has to enter, and the node


class Broken(Exception):
    """A node cannot be written; the message says why, or is empty if that is said of the node that it waits for."""


class Line(NamedTuple):
    """``target = value``; or what an expression of several lines (``text``) says for ``given`` parameters.

    ``makes`` is ``SHAPE`` or ``EMISSION``: what such an expression has to say.
    """

    owner: int  # index of the place that it belongs to
    target: str
    value: ast.expr | None
    text: str = ""
    given: tuple[tuple[Declaration, ast.expr], ...] = ()
    makes: str = SHAPE

    def parts(self) -> list[ast.expr]:
        """The values that the line is made of."""
        return [self.value] if self.value is not None else [value for _, value in self.given]


def word(name: str, *arguments: ast.expr, **named: ast.expr) -> ast.Call:
    """The call of a word of the language."""
    return ast.Call(
        ast.Name(name, ast.Load()), list(arguments), [ast.keyword(key, value) for key, value in named.items()]
    )


def is_word(value: ast.expr, name: str) -> bool:
    """Whether it is a call of the word ``name``."""
    return isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == name


class Writer:
    """Writes the nodes that one input of a tree's output depends on: ``makes`` is ``SHAPE`` or ``EMISSION``.

    ``owner`` is the matrix of the lamp, for nodes that take a transform from another object. ``declarations`` are those
    of the rest of the tree, which these have to agree with.
    """

    def __init__(
        self,
        tree: bpy.types.NodeTree,
        owner: np.ndarray | None,
        makes: str = SHAPE,
        declarations: Mapping[str, Declaration] | None = None,
    ):
        self.makes = makes
        self._declared = dict(declarations or {})
        self.owner = np.eye(4) if owner is None else owner
        self.lines: list[Line] = []
        self.values: list[object] = []
        self.declarations: dict[str, Declaration] = {}
        self.places: list[tuple[tuple[int, str], ...]] = []  # (tree, node) from the outermost group node to the node
        self.problems: dict[int, str] = {}
        self.data: dict[tuple[str, str], bpy.types.ID] = {}  # that nodes point at, by kind and name
        self.result: ast.expr | None = None
        self._results: dict[tuple, dict[str, ast.expr] | None] = {}
        self._names: set[str] = set()
        self._place: Place = ((), None)
        self.output = 0  # index of the output's place
        self._owner = 0
        output = output_of(tree)
        if output is None:
            self.missing = "There is no Lamp Output: add one, and connect the shape that glows to it."
            return
        self.missing = ""
        self._visit(((), output))
        self.result = (self._results[_key(((), output))] or {}).get(makes)
        self.output = len(self.places) - 1

    # -- the order of nodes -------------------------------------------------------------------------------------------

    def _visit(self, root: Place) -> None:
        """Writes what ``root`` depends on, and then ``root``: with a stack of its own, as chains may be long."""
        opened = {_key(root)}
        stack = [(root, self._sources(root))]
        while stack:
            place, rest = stack[-1]
            source = next(rest, None)
            if source is None:
                stack.pop()
                opened.discard(_key(place))
                self._results[_key(place)] = self._written(place)
            elif _key(source) in opened:
                self._problem(source, "It depends on its own result: remove one of the links of the circle")
                self._results.setdefault(_key(source), None)
            elif _key(source) not in self._results:
                opened.add(_key(source))
                stack.append((source, self._sources(source)))

    def _sources(self, place: Place) -> Iterator[Place]:
        for socket in place[1].inputs:
            if place[1].bl_idname == OUTPUT and socket.identifier != self.makes:
                continue
            for link in _links(socket):
                end = _end(place[0], link)
                if end is not None and end[2].is_output:
                    yield end[0], end[1]

    def _written(self, place: Place) -> dict[str, ast.expr] | None:
        node = place[1]
        if _key(place) in self._results:  # part of a circle
            return None
        self._place, self._owner = place, len(self.places)
        self.places.append(_address(place))
        try:
            if not isinstance(node, LampNode) or not hasattr(node, "written"):
                raise Broken(f"{node.name} is not known to this version of SDF Lights: replace it by another node")
            if len(self.lines) > MOST_LINES:
                raise Broken("The tree has too many nodes: use fewer groups in one another")
            return node.written(self)
        except Broken as problem:
            if str(problem):
                self.problems[self._owner] = f"{problem}."
            return None

    def _problem(self, place: Place, sentence: str) -> None:
        self.problems[len(self.places)] = f"{sentence}."
        self.places.append(_address(place))

    # -- what nodes ask for while they are written --------------------------------------------------------------------

    def inputs(self, socket: bpy.types.NodeSocket) -> list[ast.expr]:
        """Values linked to an input, from the top; its own if it has one and nothing is linked."""
        found = []
        for link in _links(socket):
            end = _end(self._place[0], link)
            if end is None:
                continue
            path, node, source = end
            if not source.is_output:
                if sockets.is_value(source):
                    found.append(self.literal(held(source)))
                continue
            if not sockets.takes(socket, sockets.carried(source)):
                raise Broken(
                    f"{socket.name or 'An input'} gets {sockets.carried(source) or 'something else'}, but "
                    f"takes {sockets.carried(socket)}: connect another output"
                )
            results = self._results.get(_key((path, node)))
            if results is None or source.identifier not in results:
                raise Broken("")
            found.append(results[source.identifier])
        if not found and not any(_links(socket)) and sockets.is_value(socket):
            found.append(self.literal(held(socket)))
        return found

    def input(self, socket: bpy.types.NodeSocket) -> ast.expr | None:
        """As ``inputs``, of an input of one link; None if it has no value."""
        return next(iter(self.inputs(socket)), None)

    def needed(self, socket: bpy.types.NodeSocket) -> ast.expr:
        """What is linked to the socket. Raises ``Broken`` where nothing is."""
        found = self.input(socket)
        if found is None:
            raise Broken(f"Nothing is connected to {socket.name}: connect {sockets.carried(socket)}")
        return found

    def literal(self, value) -> ast.expr:
        """A number (bool, int, float) or a vector of them, as a value that may change."""
        if isinstance(value, tuple):
            return ast.Tuple([self.literal(component) for component in value], ast.Load())
        self.values.append(value)
        return ast.Name(f"#{len(self.values) - 1}", ast.Load())

    def degrees(self, value: ast.expr) -> ast.expr:
        """An angle as the language has it: nodes have radians, as everywhere in Blender."""
        if isinstance(value, ast.Name) and value.id.startswith("#"):
            index = int(value.id[1:])
            return self.literal(_degrees(self.values[index]))
        if isinstance(value, ast.Tuple):
            return ast.Tuple([self.degrees(component) for component in value.elts], ast.Load())
        return value.args[0] if is_word(value, "radians") else word("degrees", value)

    def thing(self, kind: str, thing: bpy.types.ID) -> str:
        """The name by which lines ask for an object or image, as a word ``kind`` does."""
        name = thing.name if self.data.setdefault((kind, thing.name), thing) == thing else thing.name_full
        self.data[kind, name] = thing
        return name

    def assign(self, hint: str, value: ast.expr) -> ast.Name:
        """A line that gives a value a name."""
        target = self._name(hint)
        self.lines.append(Line(self._owner, target, value))
        return ast.Name(target, ast.Load())

    def include(self, hint: str, text: str, given: Mapping[Declaration, ast.expr], makes: str) -> ast.Name:
        """The lines of an expression as one: the shape or emission they say gets a name."""
        target = self._name(hint)
        self.lines.append(Line(self._owner, target, None, text, tuple(given.items()), makes))
        return ast.Name(target, ast.Load())

    def declare(self, declaration: Declaration) -> ast.expr:
        """A parameter, which lamps have values for."""
        known = (self._declared | self.declarations).get(declaration.name, declaration)
        if known != declaration:
            raise Broken(f"Another node declares {declaration.name} otherwise: choose another name")
        if self.makes == EMISSION and declaration.name in INPUTS:
            raise Broken(f"{declaration.name} has a meaning of its own in an emission: choose another name")
        self.declarations[declaration.name] = declaration
        self._names.add(declaration.name)
        return ast.Name(declaration.name, ast.Load())

    def _name(self, hint: str) -> str:
        stem = re.sub(r"\W+", "_", hint.lower(), flags=re.ASCII).strip("_")[: LONGEST_NAME - 6] or "value"
        stem = f"{stem}_" if stem[-1].isdigit() else stem
        stem = f"n_{stem}" if stem[0].isdigit() else stem
        number = 1
        while (name := f"{stem.rstrip('_')}_{number}") in self._names or name in FUNCTIONS:
            number += 1
        self._names.add(name)
        return name


def _key(place: Place) -> tuple:
    return (*(node.as_pointer() for node in place[0]), place[1].as_pointer())


def _address(place: Place) -> tuple[tuple[int, str], ...]:
    return tuple((node.id_data.session_uid, node.name) for node in (*place[0], place[1]))


def _links(socket: bpy.types.NodeSocket) -> list[bpy.types.NodeLink]:
    """Links of an input that count, from the top."""
    found = [link for link in socket.links if not link.is_muted]
    return sorted(found, key=lambda link: -link.multi_input_sort_id) if socket.is_multi_input else found


def _end(path: tuple, link: bpy.types.NodeLink) -> tuple[tuple, "bpy.types.Node", "bpy.types.NodeSocket"] | None:
    """Where a value comes from: path, node and output; or an input with a value of its own that nothing is linked to.

    Leads through reroutes, muted nodes and the borders of groups. None where it comes from nowhere.
    """
    for _ in range(10_000):
        node, source = link.from_node, link.from_socket
        if node.bl_idname == "NodeReroute":
            inner = node.inputs[0]
        elif node.mute:
            inner = next((i.from_socket for i in node.internal_links if i.to_socket == source), None)
        elif node.bl_idname == "NodeGroupInput":
            if not path:
                return None
            node, path = path[-1], path[:-1]
            inner = _by_identifier(node.inputs, source.identifier)
        elif node.bl_idname == GROUP:
            if node.node_tree is None or len(path) >= DEEPEST_GROUP:
                return path, node, source
            end = group_output(node.node_tree)
            if end is None:
                return path, node, source
            path = (*path, node)
            inner = _by_identifier(end.inputs, source.identifier)
        else:
            return path, node, source
        if inner is None:
            return None
        links = _links(inner)
        if not links:
            return None if inner.node.bl_idname == "NodeReroute" else (path, inner.node, inner)
        link = links[0]
    return None


def group_output(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The Group Output that counts: the active one, which Blender does not choose by itself in trees of this kind."""
    ends = [node for node in tree.nodes if node.bl_idname == "NodeGroupOutput"]
    return next((node for node in ends if node.is_active_output), next(iter(ends), None))


def _by_identifier(found, identifier: str):
    return next((socket for socket in found if socket.identifier == identifier), None)


def held(socket: bpy.types.NodeSocket):
    """The value that an input has by itself: a number or a tuple of numbers."""
    value = (
        getattr(socket.node, sockets.property_of(socket.identifier))
        if sockets.held_by_node(socket)
        else socket.default_value
    )
    if socket.type == "RGBA":
        return tuple(value)[:3]
    return value if isinstance(value, (bool, int, float)) else tuple(value)


def _degrees(radians: float) -> float:
    # Blender's properties have seven digits: 90 degrees are 90 again.
    return float(f"{math.degrees(radians):.7g}")


# -- shapes and emissions ----------------------------------------------------------------------------------------------


class _Script:
    """Lines and values that are equal to others if they say the same shape or emission."""

    def __init__(self, writer: Writer):
        self.lines, self.values, self.result = tuple(writer.lines), tuple(writer.values), writer.result
        self.output, self.makes = writer.output, writer.makes
        self.declarations = tuple(writer.declarations.values())
        parts = [(line.owner, line.target, line.text, line.makes, *map(ast.dump, line.parts())) for line in self.lines]
        self._key = (
            self.makes,
            self.output,
            tuple(parts),
            tuple(map(repr, self.values)),
            self.declarations,
            self.result and ast.dump(self.result),
        )

    def __hash__(self):
        return hash(self._key)

    def __eq__(self, other):
        return self._key == other._key


_kept = Cache(64)


def _evaluated(
    writer: Writer, given: Mapping[str, object], lamp=None
) -> tuple[Shape | Emission | None, dict[int, str]]:
    """The shape or emission, if there is one, and what is wrong by the index of the place."""
    script, values = _Script(writer), tuple(given.items())
    return _kept.get((script, values), FileResolver(lamp, writer.data), lambda found: _run(script, values, found))


def _run(script: _Script, given: tuple, resolver: Resolver) -> tuple[Shape | Emission | None, dict[int, str]]:
    evaluation = Evaluation({}, {}, resolver)
    if script.makes == EMISSION:
        name_inputs(evaluation)
    for index, value in enumerate(script.values):
        evaluation.names[f"#{index}"] = _bound(value)
    given = dict(given)
    for declaration in script.declarations:
        evaluation.names[declaration.name] = declaration.live(given.get(declaration.name, declaration.default))
    problems: dict[int, str] = {}
    failed: set[str] = set()
    with np.errstate(all="ignore"):
        for line in script.lines:
            if any(isinstance(n, ast.Name) and n.id in failed for part in line.parts() for n in ast.walk(part)):
                failed.add(line.target)
                continue
            try:
                evaluation.names[line.target] = (
                    evaluation.value(line.value) if line.value is not None else _included(evaluation, line)
                )
            except ExpressionError as error:
                failed.add(line.target)
                problems.setdefault(line.owner, _sentence(error, line))
    if (
        script.result is None
        or problems
        or any(isinstance(n, ast.Name) and n.id in failed for n in ast.walk(script.result))
    ):
        return None, problems
    try:
        if script.makes == EMISSION:
            value = evaluation.value(script.result)
            return evaluation.attempt(script.result, lambda: as_emission(value, evaluation.slots)), problems
        return evaluation.run(ast.Module([ast.Expr(script.result)], [])), problems
    except ExpressionError as error:
        return None, {script.output: _sentence(error, None)}


def _sentence(error: ExpressionError, line: Line | None) -> str:
    where = f"Line {error.line}, column {error.column}: " if line is not None and line.text else ""
    cure = "" if error.cure.startswith(("write ", "give it a number, or write")) and not where else f": {error.cure}"
    return f"{where}{error.message[0].upper()}{error.message[1:]}{cure}."


def _bound(value):
    if isinstance(value, bool):
        return Condition(Live(value))
    # A zero stays one, for words that leave out what is multiplied by it.
    return Live(value) if value else 0.0


def _included(evaluation: Evaluation, line: Line):
    """The shape or emission that an expression says, whose names are its own."""
    tree, _ = parse(line.text)
    given = {}
    for declaration, value in line.given:
        try:
            given[declaration.name] = declaration.live(declaration.held(_number(evaluation.value(value))))
        except (TypeError, ValueError, OverflowError):
            raise ExpressionError(f"{declaration.name} differs from point to point", 1, 1, "give it a number") from None
    outer = evaluation.names
    evaluation.names = CONSTANTS | {name: outer[name] for name in ("p", *INPUTS) if name in outer} | given
    try:
        body = [part for part in tree.body if not is_declaration(part)]
        if not body or not isinstance(body[-1], ast.Expr):
            raise ExpressionError(
                "the last line does not say what glows",
                1,
                1,
                ("end with a line that is a shape" if line.makes == SHAPE else "end with a line that is a brightness"),
            )
        evaluation.block(body[:-1])
        result = evaluation.value(body[-1].value)
        if line.makes == EMISSION:
            evaluation.attempt(body[-1], lambda: as_emission(result, evaluation.slots))
            return result
        return evaluation.attempt(body[-1], lambda: as_shape(result, evaluation.slots))
    finally:
        evaluation.names = outer


def _number(value):
    return value.truth if isinstance(value, Condition) else value


def is_declaration(part: ast.stmt) -> bool:
    """Whether it gives a parameter its name."""
    return isinstance(part, ast.Assign) and any(is_word(part.value, name) for name in declared.USAGE)


def _addressed(writer: Writer, problems: Mapping[int, str]) -> list[tuple[tuple[int, str], str]]:
    """Problems by (tree, node): of the node itself, and of each group node around it."""
    found = {}
    for index, problem in (writer.problems | dict(problems)).items():
        *around, (uid, name) = writer.places[index]
        found[uid, name] = problem
        for group in around:
            found.setdefault(group, f"In the group, {name}: {problem}")
    return list(found.items())


def _writers(tree: bpy.types.NodeTree, owner: np.ndarray | None) -> tuple[Writer, Writer]:
    """Of the shape and of the emission."""
    shape = Writer(tree, owner)
    return shape, Writer(tree, owner, EMISSION, shape.declarations)


@finds_problems
def problems_of(tree: bpy.types.NodeTree) -> list[tuple[tuple[int, str], str]]:
    """What is wrong with nodes, by tree and node: all that can be said at once."""
    found = {}
    for writer in _writers(tree, None):
        for place, problem in _addressed(writer, _evaluated(writer, {})[1]):
            found.setdefault(place, problem)
    return list(found.items())


def declarations_of(tree: bpy.types.NodeTree | None) -> tuple[Declaration, ...]:
    """Parameters that a tree declares."""
    if tree is None:
        return ()
    shape, emission = _writers(tree, None)
    return tuple((shape.declarations | emission.declarations).values())


def texts_in(tree: bpy.types.NodeTree | None) -> frozenset[tuple[str, str]]:
    """Kinds and names of data in texts of nodes, see ``builtin_data.names_in``; texts of Text nodes among them."""
    return frozenset().union(*(node.names() for node in _nodes(tree)))


def things_in(tree: bpy.types.NodeTree | None) -> list[bpy.types.ID]:
    """Objects and images that nodes point at, whose shapes they are made of."""
    return [thing for node in _nodes(tree) for thing in node.things()]


def _nodes(tree: bpy.types.NodeTree | None) -> list[LampNode]:
    return [node for part in within(tree) for node in part.nodes if isinstance(node, LampNode)]


def shape_of(
    tree: bpy.types.NodeTree | None, given: Mapping[str, object], owner: np.ndarray | None, lamp=None
) -> Shape:
    """The shape of a tree for the values of its parameters.

    ``owner`` is the matrix of the lamp's object, ``lamp`` its ``Light.sdf_lamp``, which holds what texts of nodes name.
    Raises RenderError.
    """
    if tree is None:
        raise RenderError("It has no node tree: make a new one, or choose one.")
    if tree.bl_idname != NODE_TREE:
        raise RenderError(f"Its node tree '{tree.name}' is for something else: choose one of SDF Lamp nodes.")
    writer = Writer(tree, owner)
    if writer.missing:
        raise RenderError(writer.missing)
    return _read(writer, given, lamp)


def has_emission(tree: bpy.types.NodeTree | None) -> bool:
    """Whether a tree says the emission too: a link leads to that input of its output."""
    output = output_of(tree) if tree is not None and tree.bl_idname == NODE_TREE else None
    return output is not None and any(socket.identifier == EMISSION and _links(socket) for socket in output.inputs)


def emission_of(
    tree: bpy.types.NodeTree, given: Mapping[str, object], owner: np.ndarray | None, lamp=None
) -> Emission | None:
    """As ``shape_of``, the emission of a tree that has one; None where its link comes from nowhere."""
    writer = _writers(tree, owner)[1]
    return _read(writer, given, lamp) if writer.result is not None or writer.problems else None


def _read(writer: Writer, given: Mapping[str, object], lamp) -> Shape | Emission:
    read, problems = _evaluated(writer, given, lamp)
    problems = writer.problems | problems
    if problems or read is None:
        index = min(problems, default=None)
        if index is None:
            raise RenderError(f"Its nodes do not say its {writer.makes}: look for a node with an error.")
        raise RenderError(f"In its nodes, {writer.places[index][-1][1]}: {problems[index]}")
    return read


# -- text --------------------------------------------------------------------------------------------------------------


def text_of(tree: bpy.types.NodeTree, values: Mapping[str, object], owner: np.ndarray | None, lamp=None) -> str:
    """The shape of a tree as an expression. ``values`` of parameters become their defaults. Raises RenderError."""
    shape_of(tree, values, owner, lamp)  # what has no shape has no text
    return _text(Writer(tree, owner), values)


def emission_text_of(
    tree: bpy.types.NodeTree, values: Mapping[str, object], owner: np.ndarray | None, lamp=None
) -> str:
    """As ``text_of``, the emission of a tree that has one; empty where its link comes from nowhere."""
    return _text(_writers(tree, owner)[1], values) if emission_of(tree, values, owner, lamp) is not None else ""


def _text(writer: Writer, values: Mapping[str, object]) -> str:
    constants = _Constants(writer.values)
    head, body = [], []
    for declaration in writer.declarations.values():
        remark = f"  # {declaration.description}" if declaration.description else ""
        head.append(f"{declaration.name} = {_declaration(declaration, values)}{remark}")
    for line in writer.lines:
        if line.value is not None:
            body.append(ast.Assign([ast.Name(line.target, ast.Store())], constants.visit(line.value)))
        else:
            body += _renamed(
                line,
                {
                    declaration.name: _limited(declaration, value, writer, constants)
                    for declaration, value in line.given
                },
            )
    body.append(ast.Expr(constants.visit(writer.result)))
    body = _inlined(body)
    lines = [ast.unparse(ast.fix_missing_locations(statement)) for statement in body]
    return "\n".join([*head, *([""] if head else []), *lines, ""])


def text_of_call(call: ast.Call) -> str:
    """A call of a word as text."""
    return ast.unparse(ast.fix_missing_locations(ast.Expr(call)))


def number(value: float) -> ast.expr:
    """A number as one writes it: what Blender keeps with seven digits is shown with seven."""
    if isinstance(value, bool):
        return ast.Constant(value)
    value = float(f"{value:.7g}")
    whole = int(value) if value == math.floor(value) and abs(value) < 1e15 else value
    return ast.Constant(whole) if whole >= 0 else ast.UnaryOp(ast.USub(), ast.Constant(-whole))


def _limited(declaration: Declaration, value: ast.expr, writer: Writer, constants: "_Constants") -> ast.expr:
    """A value that an expression gets for a parameter, held to the limits where it could leave them."""
    known = writer.declarations.get(getattr(value, "id", ""))
    if (
        declaration.kind in ("toggle", "vector")
        or known is not None
        and (declaration.minimum <= known.minimum and known.maximum <= declaration.maximum)
    ):
        return constants.visit(value)
    written = constants.visit(value)
    try:
        return number(declaration.held(ast.literal_eval(written)))
    except ValueError:
        return word("clamp", written, number(declaration.minimum), number(declaration.maximum))


class _Constants(ast.NodeTransformer):
    """Puts numbers in place of names such as ``#0``."""

    def __init__(self, values: list):
        self._values = values

    def visit_Name(self, node):
        return number(self._values[int(node.id[1:])]) if node.id.startswith("#") else node


def _declaration(declaration: Declaration, values: Mapping[str, object]) -> str:
    value = values.get(declaration.name, declaration.default)
    shown = [
        ast.unparse(
            ast.Tuple([number(c) for c in value], ast.Load())
            if isinstance(value, tuple)
            else ast.Constant(value > 0.5)
            if declaration.kind == "toggle"
            else number(value)
        )
    ]
    if declaration.kind != "toggle":
        shown += [ast.unparse(number(limit)) for limit in (declaration.minimum, declaration.maximum)]
    return f"{declaration.kind}({', '.join(shown)})"


def _renamed(line: Line, names: Mapping[str, ast.expr]) -> list[ast.stmt]:
    """The statements of an included expression, with names that are not used elsewhere."""
    body = [part for part in parse(line.text).tree.body if not is_declaration(part)]
    stored = {n.id for part in body for n in ast.walk(part) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    stored |= set(names)
    called = {
        n.func.id for part in body for n in ast.walk(part) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)
    }
    clash = min(stored & called & set(FUNCTIONS), default="")
    if clash:  # which of the two is meant depends on the value
        raise RenderError(
            f"In its nodes, an expression gives {clash} a value, which is a word too: choose another name."
        )

    class Rename(ast.NodeTransformer):
        def visit_Name(self, node):
            return ast.Name(f"{line.target}_{node.id}", node.ctx) if node.id in stored else node

    known = ("p",) if line.makes == SHAPE else ("p", *INPUTS)
    start = dict(names) | {name: ast.Name(name, ast.Load()) for name in known if name in stored and name not in names}
    renamed = [Rename().visit(part) for part in body]
    made = [ast.Assign([ast.Name(f"{line.target}_{name}", ast.Store())], value) for name, value in start.items()]
    result = renamed.pop()
    return [*made, *renamed, ast.Assign([ast.Name(line.target, ast.Store())], result.value)]


_WIDEST = 80  # letters of a line that is still put into another


def _inlined(statements: list[ast.stmt]) -> list[ast.stmt]:
    """Names that are used once, in the very next line or later, replaced by their short values."""
    uses: dict[str, int] = {}
    for n in (n for statement in statements for n in ast.walk(statement)):
        if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load):
            uses[n.id] = uses.get(n.id, 0) + 1
    stored = [
        n.id
        for statement in statements
        for n in ast.walk(statement)
        if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
    ]
    known: dict[str, ast.expr] = {}

    class Inline(ast.NodeTransformer):
        def visit_Name(self, node):
            return known.get(node.id, node) if isinstance(node.ctx, ast.Load) else node

    written = []
    blocks = any(isinstance(statement, (ast.For, ast.If, ast.AugAssign)) for statement in statements)
    for statement in statements:
        statement = Inline().visit(statement)
        if not blocks and isinstance(statement, ast.Assign):
            name = statement.targets[0].id
            plain = all(
                n.id in FUNCTIONS or n.id not in stored for n in ast.walk(statement.value) if isinstance(n, ast.Name)
            )
            if (
                uses.get(name) == 1
                and stored.count(name) == 1
                and plain
                and (len(ast.unparse(statement.value)) <= _WIDEST)
            ):
                known[name] = statement.value
                continue
        written.append(statement)
    return written


RESERVED = KEYWORDS | set(declared.USAGE) | {"range", "p", *CONSTANTS}
"""Names that a parameter cannot have."""
