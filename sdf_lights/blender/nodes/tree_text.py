# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a node tree to text: the shape or the emission as an expression that people can read."""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping

import bpy
import numpy as np

from ...render.errors import RenderError
from ...sdf.declarations import Declaration
from ...sdf.emission import INPUTS
from ...sdf.functions import FUNCTIONS
from ...sdf.syntax import parse
from .lines import SHAPE, Line, Writer, is_declaration, word
from .reading import emission_of, shape_of, writers_of


def text_of(tree: bpy.types.NodeTree, values: Mapping[str, object], owner: np.ndarray | None, lamp=None) -> str:
    """The shape of a tree as an expression. ``values`` of parameters become their defaults. ``owner`` as for
    ``reading.shape_of``. Raises RenderError."""
    shape_of(tree, values, owner, lamp)  # what has no shape has no text
    return _text(Writer(tree, owner), values)


def emission_text_of(
    tree: bpy.types.NodeTree, values: Mapping[str, object], owner: np.ndarray | None, lamp=None
) -> str:
    """As ``text_of``, the emission of a tree that has one; empty where its link comes from nowhere."""
    return _text(writers_of(tree, owner)[1], values) if emission_of(tree, values, owner, lamp) is not None else ""


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
