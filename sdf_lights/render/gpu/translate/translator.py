# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GLSL functions of a scene: one for each kernel and types of its arguments."""

from __future__ import annotations

import ast
import collections
import functools
import inspect
import textwrap
from dataclasses import replace
from typing import TYPE_CHECKING

from ..layout import Array
from .statements import Statements
from .values import CONSTANT, FLOAT, Ref, Tuple, Value, is_number, known, safe_name, type_of

if TYPE_CHECKING:
    from ..tables import Tables


class Translator:
    """Translates kernels for one scene. ``functions`` are the GLSL functions so far, callees first."""

    def __init__(self, tables: Tables, natives: dict, constants: dict | None = None):
        """``natives``: kernel -> ``Native``. ``constants``: (module, name) -> value that replaces the module's."""
        self.tables, self.natives = tables, natives
        self.constants = {(module.__name__, name): value for (module, name), value in (constants or {}).items()}
        self.functions: list[str] = []
        self.globals: list[str] = []
        self.named: set[str] = set()  # functions that natives have added themselves
        self.structures: dict[Tuple, str] = {}
        self._known: dict[tuple, tuple[str, object]] = {}
        self._names: dict[str, int] = {}

    def glsl_type(self, kind) -> str:
        """GLSL name of a type; tuples that are not vectors become structures."""
        if isinstance(kind, Tuple):
            if kind.vector:
                return f"vec{len(kind.items)}"
            if kind not in self.structures:
                for item in kind.items:
                    self.glsl_type(item)
                self.structures[kind] = f"Result{len(self.structures)}"
            return self.structures[kind]
        return "int" if isinstance(kind, Ref) else "void" if kind is None else kind

    def structure_source(self) -> str:
        """GLSL definitions of these structures."""
        return "\n".join(
            f"struct {name} {{ "
            + " ".join(f"{self.glsl_type(item)} v{index};" for index, item in enumerate(kind.items))
            + " };"
            for kind, name in self.structures.items()
        )

    def function(self, kernel, arguments: list[Value]) -> tuple[str, Value]:
        """Name of the GLSL function for a kernel and arguments of these types, and its result: a type, or a constant
        number."""
        python = inspect.unwrap(kernel)
        key = (python, tuple(_signature(argument) for argument in arguments))
        if key not in self._known:
            name = safe_name(f"{python.__module__.rpartition('.')[2]}_{python.__name__.strip('_')}")
            self._names[name] = number = self._names.get(name, 0) + 1
            name = name if number == 1 else f"{name}_v{number}"
            function = _Function(self, python, name, arguments)
            source, result = function.translate()
            if result.type != CONSTANT:
                self.functions.append(source)
            self._known[key] = name, result
        return self._known[key]

    def local_array(self, name: str, count: int) -> Value:
        """An array of floats that a function uses, with a name of its own in the program; in GLSL only global ones are
        passed without a copy."""
        lvalue, first = f"{name}[{{}}]", "0"
        if self.tables.arrays.in_buffer(FLOAT, count):
            lvalue, first = self.tables.arrays.place(name, FLOAT, count)
        elif (declared := f"float {name}[{count}];") not in self.globals:
            self.globals.append(declared)
        return Value(Ref(Array(FLOAT, packed=True), lvalue), first, count=str(count))


def _signature(argument: Value):
    if argument.type == CONSTANT:
        value = argument.constant
        if isinstance(value, tuple):
            return "tuple", value
        return (type_of(value), False, None) if is_number(value) else ("object", id(value))
    possible = None if argument.text.isdigit() else argument.possible
    return argument.type, bool(argument.count), possible


@functools.cache
def _parse(python) -> tuple[ast.FunctionDef, dict[str, int]]:
    """The tree of a function, and how often it assigns each name. Reading sources took two thirds of the time of a
    translation, and every render translates. Nobody changes these results."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(python))).body[0]
    stored = [node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
    return tree, collections.Counter(stored)


class _Function(Statements):
    """Translation of one kernel for arguments of some types."""

    def translate(self) -> tuple[str, object]:
        tree, self.stores = _parse(self.python)
        self.types: dict[str, object] = {}  # of local variables
        self.result = None
        self.returns = False
        for _ in range(8):  # until the types of variables with several assignments agree
            before, result = dict(self.types), self.result
            self.lines, self.locals, self.used, self._count, self.returned = [], {}, {}, 0, set()
            self._arrays = 0
            parameters = self._bind(tree)
            self._block(tree.body)
            if self.types == before and self.result == result:
                break
        glsl = self.translator.glsl_type
        head = f"{glsl(self.result)} {self.name}({', '.join(parameters)})\n{{"
        declared = [f"    {glsl(kind)} {name};" for name, kind in self.used.items()]
        result = Value(self.result)
        if len(self.returned) == 1 and None not in self.returned and self._is_pure():
            result = known(next(iter(self.returned)))
        return "\n".join([head, *declared, *self.lines, "}"]), result

    def array(self, count: int) -> Value:
        """An array of floats of its own: the same in each of these translations."""
        self._arrays += 1
        return self.translator.local_array(f"{self.name}_array{self._arrays}", count)

    def _is_pure(self) -> bool:
        """Whether the function sets only its own variables and calls nothing."""
        starts = (line.split()[0] for line in self.lines)
        return all(start in self.used or start == "return" for start in starts)

    def _bind(self, tree: ast.FunctionDef) -> list[str]:
        """Assign the arguments to the parameters; returns GLSL of the remaining parameters."""
        names = [argument.arg for argument in tree.args.args]
        defaults = [known(ast.literal_eval(default)) for default in tree.args.defaults]
        values = list(self.arguments) + defaults[len(self.arguments) - len(names) + len(defaults) :]
        parameters = []
        for name, value in zip(names, values, strict=True):
            if value.type == CONSTANT:
                if not is_number(value.constant):
                    self.locals[name] = value
                    continue
                value = replace(self._value(value), possible=None)
            elif value.text.isdigit():
                value = replace(value, possible=None)
            kind = value.type
            if isinstance(kind, Ref) and kind.lvalue and "{}" not in kind.lvalue:
                self.locals[name] = replace(value, text="")
                continue
            text = safe_name(name)
            own = text + "_given" if name in self.stores else text
            parameters.append(f"{self.translator.glsl_type(kind)} {own}")
            count = ""
            if value.count:
                count = f"{text}_count"
                parameters.append(f"int {count}")
            given = Value(kind, own, count=count, possible=None if name in self.stores else value.possible)
            if name in self.stores and not isinstance(kind, Ref):
                self._set(name, given)
            else:
                self.locals[name] = given
        return parameters
