# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a node tree to lines of the expression language.

A line is a syntax tree. It is never printed and parsed on the way to a shape. Groups are written as often as they are
used, reroutes and muted nodes not at all.

The numbers of sockets are not in the lines. Lines have names for them, ``#0``, ``#1`` and so on, of values that may
change. So a slider changes no formula, and compiles nothing.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import bpy
import numpy as np

from ...sdf import declarations as declared
from ...sdf.declarations import LONGEST_NAME, Declaration
from ...sdf.emission import INPUTS
from ...sdf.functions import CONSTANTS, FUNCTIONS
from ...sdf.syntax import KEYWORDS
from . import sockets
from .tree import GROUP, OUTPUT, LampNode, output_of

SHAPE, EMISSION = "shape", "emission"
"""Inputs of the Lamp Output."""

DEEPEST_GROUP = 20
MOST_LINES = 4_000

Place = tuple[tuple, "bpy.types.Node"]  # the group nodes that one has to enter, and the node


class Broken(Exception):
    """A node cannot be written. The message gives the reason. It is empty if the reason is that of an earlier node."""


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
            for link in links_of(socket):
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
        """Values linked to an input, from the top; its own if it has one and nothing is linked. Raises Broken."""
        found = []
        for link in links_of(socket):
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
        if not found and not any(links_of(socket)) and sockets.is_value(socket):
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
        """A parameter, which lamps have values for. Raises Broken."""
        known = (self._declared | self.declarations).get(declaration.name, declaration)
        if known != declaration:
            raise Broken(f"Another node declares {declaration.name} differently: choose another name")
        if self.makes == EMISSION and declaration.name in INPUTS:
            raise Broken(f"{declaration.name} has a special meaning in an emission: choose another name")
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


def links_of(socket: bpy.types.NodeSocket) -> list[bpy.types.NodeLink]:
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
        links = links_of(inner)
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


def is_declaration(part: ast.stmt) -> bool:
    """Whether it gives a parameter its name."""
    return isinstance(part, ast.Assign) and any(is_word(part.value, name) for name in declared.USAGE)


RESERVED = KEYWORDS | set(declared.USAGE) | {"range", "p", *CONSTANTS}
"""Names that a parameter cannot have."""
