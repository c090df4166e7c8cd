# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a node tree to its shape and its emission.

The lines that ``lines.Writer`` writes are evaluated by the expression language. So a node means what its word means,
with the same checks and limits. The shape and the emission are read one after the other, each from its input of the
Lamp Output.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping

import bpy
import numpy as np

from ...render.errors import RenderError
from ...sdf.declarations import Declaration
from ...sdf.emission import INPUTS, Emission, as_emission, name_inputs
from ...sdf.evaluation import Evaluation
from ...sdf.expression_values import Condition, Live
from ...sdf.functions import CONSTANTS, as_shape
from ...sdf.resolver import Cache, Resolver
from ...sdf.shapes import Shape
from ...sdf.syntax import ExpressionError, parse
from ..naming import NODE_TREE
from ..sources import FileResolver
from .lines import EMISSION, SHAPE, Line, Writer, is_declaration, links_of
from .tree import LampNode, finds_problems, output_of, within


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


def _addressed(writer: Writer, problems: Mapping[int, str]) -> list[tuple[tuple[int, str], str]]:
    """Problems by (tree, node): of the node itself, and of each group node around it."""
    found = {}
    for index, problem in (writer.problems | dict(problems)).items():
        *around, (uid, name) = writer.places[index]
        found[uid, name] = problem
        for group in around:
            found.setdefault(group, f"In the group, {name}: {problem}")
    return list(found.items())


def writers_of(tree: bpy.types.NodeTree, owner: np.ndarray | None) -> tuple[Writer, Writer]:
    """Writers of the shape and of the emission. ``owner`` as for ``shape_of``."""
    shape = Writer(tree, owner)
    return shape, Writer(tree, owner, EMISSION, shape.declarations)


@finds_problems
def problems_of(tree: bpy.types.NodeTree) -> list[tuple[tuple[int, str], str]]:
    """What is wrong with nodes, by tree and node: all that can be said at once."""
    found = {}
    for writer in writers_of(tree, None):
        for place, problem in _addressed(writer, _evaluated(writer, {})[1]):
            found.setdefault(place, problem)
    return list(found.items())


def declarations_of(tree: bpy.types.NodeTree | None) -> tuple[Declaration, ...]:
    """Parameters that a tree declares."""
    if tree is None:
        return ()
    shape, emission = writers_of(tree, None)
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

    ``owner`` (4 × 4, to the world) is the matrix of the lamp's object, ``lamp`` its ``Light.sdf_lamp``, which holds
    what texts of nodes name. Raises RenderError.
    """
    if tree is None:
        raise RenderError("It has no node tree: make a new one, or choose one.")
    if tree.bl_idname != NODE_TREE:
        raise RenderError(f"Its node tree '{tree.name}' is not for SDF lamps: choose a tree of SDF Lamp nodes.")
    writer = Writer(tree, owner)
    if writer.missing:
        raise RenderError(writer.missing)
    return _read(writer, given, lamp)


def has_emission(tree: bpy.types.NodeTree | None) -> bool:
    """Whether a tree says the emission too: a link leads to that input of its output."""
    output = output_of(tree) if tree is not None and tree.bl_idname == NODE_TREE else None
    return output is not None and any(socket.identifier == EMISSION and links_of(socket) for socket in output.inputs)


def emission_of(
    tree: bpy.types.NodeTree, given: Mapping[str, object], owner: np.ndarray | None, lamp=None
) -> Emission | None:
    """As ``shape_of``, the emission of a tree that has one; None where its link comes from nowhere."""
    writer = writers_of(tree, owner)[1]
    return _read(writer, given, lamp) if writer.result is not None or writer.problems else None


def _read(writer: Writer, given: Mapping[str, object], lamp) -> Shape | Emission:
    read, problems = _evaluated(writer, given, lamp)
    problems = writer.problems | problems
    if problems or read is None:
        index = min(problems, default=None)
        if index is None:
            raise RenderError(f"Its nodes do not define its {writer.makes}: look for a node with an error.")
        raise RenderError(f"In its nodes, {writer.places[index][-1][1]}: {problems[index]}")
    return read
