# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GLSL reading of kernels: the functions that Numba compiles for the CPU, as source for a GPU, in float32.

A kernel is written once. What it may contain is what Numba's kernels of this project contain anyway: scalars, tuples,
records and tables, calls of other kernels, ``if``, ``while`` and ``for … in range``. Types are inferred from the
arguments of a call, and each combination of types gives one GLSL function, named after its module and itself.

- float64 becomes float, all integers become int, uint32 uint; a tuple of two to four floats becomes a vector, any other
  tuple a structure.
- The block and the workspace are no arguments. A record of a table of the block is the int at which it begins in the
  buffer ``words``; tables of the workspace are global variables.
- Values of small integer fields are known from the scene's own tables (``Tables.values``): a comparison that can have one
  outcome only is decided here, so a program holds no code for kinds of lights, lobes or shapes that the scene lacks.

GLSL has no recursion, no pointers and no 64-bit integers. Kernels that need such things, call foreign code, or draw random
numbers have a function by the same name in ``shaders_glsl/`` (see ``Native``).
"""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
import types
from dataclasses import dataclass, field, replace

import numpy as np

from ...sdf.read_glsl import literal
from .layout import Array, Record, Tables

FLOAT, INT, UINT, BOOL = "float", "int", "uint", "bool"
_SCALARS = (BOOL, INT, UINT, FLOAT)  # each can be converted to those after it

# Words that GLSL keeps for itself, or has as functions that generated code calls.
_RESERVED = frozenset("""
    active asm attribute bool break buffer bvec2 bvec3 bvec4 case cast centroid class coherent common const continue
    default discard do double else enum extern external false filter fixed flat float for goto half highp if image in
    inline inout input int interface invariant ivec2 ivec3 ivec4 layout long lowp mat2 mat3 mat4 mediump namespace
    noinline noperspective out output packed partition patch precise precision public readonly resource restrict return
    sample sampler shared short sizeof smooth static struct subroutine superp switch template texture this true typedef
    uint uniform union unsigned using uvec2 uvec3 uvec4 varying vec2 vec3 vec4 void volatile while writeonly
    abs acos asin atan ceil clamp cos cross distance dot exp floor fract inversesqrt isinf isnan length log max min mix
    mod normalize pow reflect refract sign sin sqrt step tan words
""".split())


class Untranslatable(Exception):
    """A kernel uses something that has no GLSL reading: what, and where."""


@dataclass(frozen=True)
class Tuple:
    """Type of a tuple."""

    items: tuple

    @property
    def vector(self) -> bool:
        return 2 <= len(self.items) <= 4 and all(item == FLOAT for item in self.items)


@dataclass(frozen=True)
class Ref:
    """Type of a place: a record or an array in the buffer, or in the workspace (``lvalue`` is its GLSL then).

    The value is an int: the place's first word in the buffer, or what stands for ``{}`` in ``lvalue``.
    """

    layout: Record | Array
    lvalue: str = ""


@dataclass(frozen=True)
class Value:
    """What an expression stands for: GLSL ``text`` of a ``type``, or a Python object that is known now (``CONSTANT``)."""

    type: object
    text: str = ""
    constant: object = None
    items: tuple = ()  # of a tuple that is written out
    possible: frozenset | None = None  # values that an int may have, where that is known
    count: str = ""  # of the elements of an array in the buffer


CONSTANT = "constant"


class Scope:
    """A block or a workspace: ``prefix`` is that of the names of its tables in GLSL."""

    def __init__(self, prefix: str = ""):
        self.prefix = prefix


BLOCK, WORKSPACE, ASIDE = Scope(), Scope(), Scope("aside_")


@dataclass(frozen=True)
class Native:
    """A kernel that is written in GLSL by hand, under this ``name``. ``result`` is its type; None for none.

    Arguments that are known now (the block, a table) are left out of the call.
    """

    name: str
    result: object = None


VECTOR = Tuple((FLOAT, FLOAT, FLOAT))


def known(value) -> Value:
    return Value(CONSTANT, constant=value)


def is_number(value) -> bool:
    return isinstance(value, (bool, int, float, np.number, np.bool_))


def _type_of(number) -> str:
    if isinstance(number, (bool, np.bool_)):
        return BOOL
    if isinstance(number, np.uint32):
        return UINT
    return INT if isinstance(number, (int, np.integer)) else FLOAT


def constant_text(number, kind: str) -> str:
    """GLSL for a number of this type."""
    if kind == BOOL:
        return "true" if number else "false"
    if kind == INT:
        return str(int(number)) if int(number) != -(1 << 31) else "(-2147483647 - 1)"
    if kind == UINT:
        return f"{int(number) & 0xFFFFFFFF}u"
    number = float(number)
    if math.isnan(number):
        return "NOT_A_NUMBER"
    if math.isinf(number):
        return "INFINITE" if number > 0.0 else "(-INFINITE)"
    if 1.0 - 2.0**-25 < number < 1.0:
        number = 1.0 - 2.0**-24  # what is below one stays below it
    text = literal(number)
    return f"({text})" if text.startswith("-") else text


def join(a, b):
    """The type that holds values of both."""
    if a == b:
        return a
    if a in _SCALARS and b in _SCALARS:
        return max(a, b, key=_SCALARS.index)
    if isinstance(a, Tuple) and isinstance(b, Tuple) and len(a.items) == len(b.items):
        return Tuple(tuple(map(join, a.items, b.items)))
    raise Untranslatable(f"a name or a result is {a} here and {b} there")


def safe_name(name: str) -> str:
    """A Python name as a GLSL one."""
    name = name.strip("_").replace("__", "_")
    return name + "_" if name in _RESERVED or name.startswith("gl_") else name


class Translator:
    """Translates kernels for one scene. ``functions`` are the GLSL functions so far, callees first."""

    def __init__(self, tables: Tables, natives: dict, constants: dict | None = None):
        """``natives``: kernel -> ``Native``. ``constants``: (module's name, name) -> value in place of the module's."""
        self.tables, self.natives, self.constants = tables, natives, constants or {}
        self.functions: list[str] = []
        self.globals: list[str] = []
        self.structures: dict[Tuple, str] = {}
        self._known: dict[tuple, tuple[str, object]] = {}
        self._names: dict[str, int] = {}

    def glsl_type(self, kind) -> str:
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
        return "\n".join(
            f"struct {name} {{ " + " ".join(
                f"{self.glsl_type(item)} v{index};" for index, item in enumerate(kind.items)) + " };"
            for kind, name in self.structures.items())

    def function(self, kernel, arguments: list[Value]) -> tuple[str, Value]:
        """Name of the GLSL function for a kernel and arguments of these types, and its result: a type, or a number that
        it always gives."""
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

    def local_array(self, count: int) -> Value:
        """An array of floats that a function uses; GLSL passes only global ones on without a copy."""
        name = f"stack{len(self.globals)}"
        self.globals.append(f"float {name}[{count}];")
        return Value(Ref(Array(FLOAT, count, packed=True), name + "[{}]"), "0", count=str(count))


def _signature(argument: Value):
    if argument.type == CONSTANT:
        value = argument.constant
        if isinstance(value, tuple):
            return "tuple", value
        return (_type_of(value), False, None) if is_number(value) else ("object", id(value))
    possible = None if argument.text.isdigit() else argument.possible
    return argument.type, bool(argument.count), possible


def _parse(python) -> ast.FunctionDef:
    return ast.parse(textwrap.dedent(inspect.getsource(python))).body[0]


@dataclass
class _Function:
    """Translation of one kernel for arguments of some types."""

    translator: Translator
    python: object
    name: str
    arguments: list[Value]
    lines: list[str] = field(default_factory=list)
    depth: int = 1

    def translate(self) -> tuple[str, object]:
        tree = _parse(self.python)
        stored = [node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
        self.stores = {name: stored.count(name) for name in stored}
        self.types: dict[str, object] = {}  # of local variables
        self.result = None
        self.returns = False
        for _ in range(8):  # until the types of variables that are set more than once agree
            before, result = dict(self.types), self.result
            self.lines, self.locals, self.used, self._count, self.returned = [], {}, {}, 0, set()
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

    def _is_pure(self) -> bool:
        """Whether the function sets nothing but its own variables and calls nothing by itself."""
        starts = (line.split()[0] for line in self.lines)
        return all(start in self.used or start == "return" for start in starts)

    # Names

    def _bind(self, tree: ast.FunctionDef) -> list[str]:
        """Give the parameters their arguments; GLSL of those that remain."""
        names = [argument.arg for argument in tree.args.args]
        defaults = [known(ast.literal_eval(default)) for default in tree.args.defaults]
        values = list(self.arguments) + defaults[len(self.arguments) - len(names) + len(defaults):]
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

    def _lookup(self, name: str) -> Value:
        if name in self.locals:
            return self.locals[name]
        module = self.python.__globals__
        replaced = self.translator.constants.get((self.python.__module__.rpartition(".")[2], name))
        if replaced is not None:
            return known(replaced)
        if name in module:
            return known(module[name])
        builtins = module["__builtins__"]
        builtins = builtins if isinstance(builtins, dict) else vars(builtins)
        if name in builtins:
            return known(builtins[name])
        raise self._error(f"{name} has no value")

    def _error(self, text: str, node: ast.AST | None = None) -> Untranslatable:
        line = self.python.__code__.co_firstlineno + (node.lineno - 1 if node is not None else 0)
        return Untranslatable(f"{self.python.__module__}.{self.python.__name__}, line {line}: {text}")

    def _temporary(self, kind, text: str) -> str:
        name = f"tmp{self._count}"
        self._count += 1
        self.used[name] = kind
        self._say(f"{name} = {text};")
        return name

    def _set(self, name: str, value: Value) -> None:
        """Assign to a local variable."""
        if value.type == CONSTANT and not _is_value(value.constant):
            self.locals[name] = value
            return
        value = self._value(value)
        kind = value.type
        if isinstance(kind, Ref) and kind.lvalue and "{}" not in kind.lvalue:
            self.locals[name] = value
            return
        text = safe_name(name)
        if isinstance(kind, Ref):
            text += "_at"
        else:
            kind = self.types[name] = join(self.types[name], kind) if name in self.types else kind
        self.used[text] = kind
        self._say(f"{text} = {self._converted(value, kind).text};")
        count = ""
        if value.count:
            count = text + "_count"
            self.used[count] = INT
            self._say(f"{count} = {value.count};")
        # What is known of a variable's values holds only where nothing else sets it.
        once = self.stores.get(name, 0) == 1 and kind == value.type
        self.locals[name] = Value(kind, text, count=count, possible=value.possible if once else None)

    # Statements

    def _say(self, line: str) -> None:
        self.lines.append("    " * self.depth + line)

    def _block(self, statements: list[ast.stmt]) -> bool:
        """Translate statements; True where none that follows can be reached."""
        for statement in statements:
            method = getattr(self, "_do_" + type(statement).__name__, None)
            if method is None:
                raise self._error(f"{type(statement).__name__} has no GLSL reading", statement)
            try:
                if method(statement):
                    return True
            except Untranslatable:
                raise
            except Exception as error:
                raise self._error(f"{type(error).__name__}: {error} in {ast.unparse(statement)[:120]!r}", statement) from error
        return False

    def _do_Expr(self, node: ast.Expr):
        if isinstance(node.value, ast.Constant):
            return
        value = self._expression(node.value)
        if value.text:
            self._say(value.text + ";")

    def _do_Pass(self, node):
        pass

    def _do_Return(self, node: ast.Return):
        if node.value is None:
            self.returned.add(None)
            self._say("return;")
            return True
        value = self._expression(node.value)
        self.returned.add(value.constant if value.type == CONSTANT and is_number(value.constant) else None)
        value = self._value(value)
        self.result = value.type if self.result is None else join(self.result, value.type)
        self._say(f"return {self._converted(value, self.result).text};")
        return True

    def _do_Break(self, node):
        self._say("break;")
        return True

    def _do_Continue(self, node):
        self._say("continue;")
        return True

    def _do_If(self, node: ast.If):
        test = self._condition(node.test)
        if test.type == CONSTANT:
            return self._block(node.body if test.constant else node.orelse)
        self._say(f"if ({test.text}) {{")
        before = dict(self.locals)
        first = self._nested(node.body)
        after_first, self.locals = self.locals, before if not node.orelse else dict(before)
        second = False
        if node.orelse:
            self._say("} else {")
            second = self._nested(node.orelse)
        self._say("}")
        if second:
            self.locals = after_first
        elif not first:
            for name, value in after_first.items():
                other = self.locals.setdefault(name, value)
                if other is not value and isinstance(value.type, Ref) and other.type != value.type:
                    self.locals[name] = known(f"{name}, which is a place of two kinds")
        return first and second

    def _nested(self, statements) -> bool:
        self.depth += 1
        over = self._block(statements)
        self.depth -= 1
        return over

    def _do_While(self, node: ast.While):
        test = self._condition(node.test)
        if test.type == CONSTANT and not test.constant:
            return
        self._say("while (true) {")
        self.depth += 1
        if test.type != CONSTANT:
            self._say(f"if (!({test.text})) {{ break; }}")
        self._block(node.body)
        self.depth -= 1
        self._say("}")

    def _do_For(self, node: ast.For):
        call = node.iter
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range"):
            raise self._error("for runs over a range only", node)
        bounds = [self._converted(self._value(self._expression(argument)), INT) for argument in call.args]
        start, end, step = "0", bounds[0].text, "1"
        if len(bounds) > 1:
            start, end = bounds[0].text, bounds[1].text
        if len(bounds) > 2:
            step = bounds[2].text
        if not end.lstrip("-").isdigit():
            end = self._temporary(INT, end)
        counter = f"loop{self._count}"
        self._count += 1
        down = step.startswith(("-", "(-"))
        self._say(f"for (int {counter} = {start}; {counter} {'>' if down else '<'} {end}; {counter} += {step}) {{")
        self.depth += 1
        if node.target.id != "_":
            self._set(node.target.id, Value(INT, counter))
        self._block(node.body)
        self.depth -= 1
        self._say("}")

    def _do_Assign(self, node: ast.Assign):
        value = self._expression(node.value)
        if len(node.targets) > 1:
            value = self._value(value)
            value = Value(value.type, self._temporary(value.type, value.text))
        for target in node.targets:
            self._assign(target, value)

    def _do_AugAssign(self, node: ast.AugAssign):
        target = ast.copy_location(ast.parse(ast.unparse(node.target), mode="eval").body, node.target)
        self._assign(node.target, self._operation(
            type(node.op).__name__, self._expression(target), self._expression(node.value)))

    def _assign(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            if target.id != "_":
                self._set(target.id, value)
            return
        if isinstance(target, ast.Tuple):
            self._unpack(target.elts, value)
            return
        place = self._place(target)
        if isinstance(place, Value) and not isinstance(place.type, Ref):
            self._say(f"{place.text} = {self._converted(self._value(value), place.type).text};")
            return
        raise self._error("this cannot be assigned to", target)

    def _unpack(self, targets: list[ast.expr], value: Value) -> None:
        if value.type == CONSTANT:
            parts = [known(part) for part in value.constant]
        elif value.items:
            # All are computed before any name changes.
            parts = []
            for item in value.items:
                if item.type == CONSTANT or not item.text or (isinstance(item.type, Ref) and not item.text):
                    parts.append(item)
                else:
                    parts.append(replace(item, text=self._temporary(item.type, item.text)))
        else:
            text = self._temporary(value.type, value.text)
            parts = [self._item(Value(value.type, text), index) for index in range(len(targets))]
        for target, part in zip(targets, parts, strict=True):
            self._assign(target, part)

    # Places

    def _place(self, node: ast.expr) -> Value:
        """What a field or an element names: a ``Ref``, or a scalar or vector whose text can be assigned to."""
        if isinstance(node, ast.Attribute):
            base = self._expression(node.value)
            return self._field(base, node.attr, node)
        base = self._expression(node.value)
        return self._element(base, node.slice, node)

    def _field(self, base: Value, name: str, node: ast.AST) -> Value:
        layout = base.type.layout
        if name not in layout.fields:
            raise self._error(f"there is no field {name}", node)
        offset, inner = layout.fields[name]
        if base.type.lvalue:
            lvalue = f"{base.type.lvalue}.{safe_name(name)}"
            if not isinstance(inner, Array):
                return Value(inner, lvalue.replace("{}", base.text))
            if inner.vector:
                return Value(Ref(inner, lvalue), base.text)
            if "{}" in lvalue:
                raise self._error(f"{name} is an array in an array of the workspace", node)
            return Value(Ref(inner, lvalue + "[{}]"), "0")
        address = _sum(base.text, offset)
        if isinstance(inner, Array):
            return Value(Ref(inner), address)
        return Value(inner, _read(inner, address), possible=self.translator.tables.values(layout, name))

    def _element(self, base: Value, index: ast.expr, node: ast.AST) -> Value:
        layout = base.type.layout
        if isinstance(index, ast.Slice):
            start = self._converted(self._value(self._expression(index.lower)), INT).text if index.lower else "0"
            count = ""
            if index.upper is not None:
                count = f"({self._converted(self._value(self._expression(index.upper)), INT).text}) - ({start})"
            elif base.count:
                count = f"{base.count} - ({start})"
            return Value(base.type, f"{base.text} + {_times(start, layout.stride)}", count=count)
        parts = index.elts if isinstance(index, ast.Tuple) else [index]
        inner = layout
        indices = []
        for part in parts:
            indices.append(self._converted(self._value(self._expression(part)), INT).text)
        if layout.vector and base.type.lvalue:
            return Value(inner.element, f"{base.type.lvalue.replace('{}', base.text)}[{indices[0]}]")
        if base.type.lvalue and "{}" not in base.type.lvalue:
            return Value(Ref(inner.inner, base.type.lvalue))  # the only row
        address = base.text or "0"
        for text in indices:
            if not isinstance(inner, Array):
                raise self._error("too many indices", node)
            address = _sum(address, _times(text, inner.stride))
            inner = inner.inner
        if isinstance(inner, (Array, Record)):
            return Value(Ref(inner, base.type.lvalue), address)
        if base.type.lvalue:
            return Value(inner, base.type.lvalue.replace("{}", address))
        return Value(inner, _read(inner, address))

    # Expressions

    def _value(self, value: Value) -> Value:
        """As something that has a type in GLSL."""
        if value.type != CONSTANT:
            return value
        constant = value.constant
        if is_number(constant):
            kind = _type_of(constant)
            return Value(kind, constant_text(constant, kind), possible=frozenset([int(constant)]) if kind == INT else None)
        if isinstance(constant, tuple):
            return self._tuple([known(item) for item in constant])
        raise self._error(f"{constant!r} has no value in GLSL")

    def _converted(self, value: Value, kind) -> Value:
        if value.type == CONSTANT:
            if is_number(value.constant) and kind in _SCALARS:
                return Value(kind, constant_text(value.constant, kind))
            value = self._value(value)
        if value.type == kind:
            return value
        if isinstance(kind, Tuple) and isinstance(value.type, Tuple):
            items = value.items or [self._item(value, index) for index in range(len(kind.items))]
            return self._tuple([self._converted(item, part) for item, part in zip(items, kind.items, strict=True)], kind)
        if kind in _SCALARS and value.type in _SCALARS:
            return Value(kind, f"{kind}({value.text})")
        raise self._error(f"{value.type} is not {kind}")

    def _tuple(self, items: list[Value], kind: Tuple | None = None) -> Value:
        items = [item if item.type == CONSTANT and not is_number(item.constant) and not isinstance(item.constant, tuple)
                 else self._value(item) for item in items]
        if any(item.type == CONSTANT or isinstance(item.type, Ref) for item in items):
            return Value(None, items=tuple(items))  # only to be taken apart
        kind = kind or Tuple(tuple(item.type for item in items))
        text = f"{self.translator.glsl_type(kind)}({', '.join(item.text for item in items)})"
        return Value(kind, text, items=tuple(items))

    def _item(self, value: Value, index: int) -> Value:
        if value.items:
            return value.items[index]
        kind = value.type
        index = index if index >= 0 else len(kind.items) + index
        text = value.text if value.text.isidentifier() or value.text.endswith(")") else f"({value.text})"
        return Value(kind.items[index], f"{text}.{'xyzw'[index]}" if kind.vector else f"{text}.v{index}")

    def _expression(self, node: ast.expr) -> Value:
        method = getattr(self, "_read_" + type(node).__name__, None)
        if method is None:
            raise self._error(f"{type(node).__name__} has no GLSL reading", node)
        return method(node)

    def _read_Constant(self, node):
        return known(node.value)

    def _read_Name(self, node):
        return self._lookup(node.id)

    def _read_Tuple(self, node):
        return self._tuple([self._expression(item) for item in node.elts])

    def _read_Attribute(self, node):
        base = self._expression(node.value)
        if base.type != CONSTANT:
            return self._field(base, node.attr, node)
        if base.constant is BLOCK:
            return self.translator.tables.scalar(node.attr)
        if isinstance(base.constant, types.ModuleType):
            replaced = self.translator.constants.get((base.constant.__name__.rpartition(".")[2], node.attr))
            if replaced is not None:
                return known(replaced)
        return known(getattr(base.constant, node.attr))

    def _read_Subscript(self, node):
        base = self._expression(node.value)
        if base.type == CONSTANT:
            index = self._expression(node.slice)
            if isinstance(base.constant, Scope):
                return base
            if index.type == CONSTANT:
                return known(base.constant[index.constant])
            return Value(FLOAT, f"({self._value(base).text})[{index.text}]")
        if isinstance(base.type, Ref):
            return self._element(base, node.slice, node)
        index = self._expression(node.slice)
        if index.type == CONSTANT:
            return self._item(base, index.constant)
        return Value(FLOAT, f"{base.text}[{self._converted(index, INT).text}]")

    def _read_UnaryOp(self, node):
        if isinstance(node.op, ast.Not):
            value = self._condition(node.operand)
            return known(not value.constant) if value.type == CONSTANT else Value(BOOL, f"!{value.text}")
        value = self._expression(node.operand)
        if value.type == CONSTANT:
            number = value.constant
            return known(-number if isinstance(node.op, ast.USub) else ~number if isinstance(node.op, ast.Invert) else number)
        if value.type == BOOL:
            value = self._converted(value, INT)
        return Value(value.type, f"({'-' if isinstance(node.op, ast.USub) else '~'}{value.text})")

    def _read_BinOp(self, node):
        return self._operation(type(node.op).__name__, self._expression(node.left), self._expression(node.right))

    def _operation(self, name: str, a: Value, b: Value) -> Value:
        if a.type == CONSTANT and b.type == CONSTANT:
            return known(_PYTHON[name](a.constant, b.constant))
        a, b = self._value(a), self._value(b)
        kind = join(a.type, b.type)
        if name == "Pow":
            return self._power(a, b)
        if name == "Div":
            kind = FLOAT
        if kind == BOOL:
            kind = INT
        if name in ("LShift", "RShift"):
            return Value(a.type if a.type != BOOL else INT, f"({self._converted(a, INT).text} {_SYMBOLS[name]} {b.text})")
        if name == "BitAnd" and kind == INT:
            for value, mask in ((a, b), (b, a)):
                if value.possible is not None and mask.possible is not None and len(mask.possible) == 1:
                    found = frozenset(number & next(iter(mask.possible)) for number in value.possible)
                    if len(found) == 1:
                        return known(next(iter(found)))
        left, right = self._converted(a, kind).text, self._converted(b, kind).text
        if name == "Mod":
            if kind == FLOAT:
                return Value(FLOAT, f"mod({left}, {right})")
            return Value(kind, f"modulo({left}, {right})")
        return Value(kind, f"({left} {_SYMBOLS[name]} {right})")

    def _power(self, a: Value, b: Value) -> Value:
        base = self._converted(a, FLOAT).text
        if b.text in ("2", "2.0"):
            return Value(FLOAT, f"square({base})")
        if b.text in ("3", "3.0"):
            return Value(FLOAT, f"cube({base})")
        return Value(FLOAT, f"pow({base}, {self._converted(b, FLOAT).text})")

    def _condition(self, node: ast.expr) -> Value:
        """An expression as a truth value."""
        value = self._expression(node)
        if value.type == CONSTANT:
            return known(bool(value.constant))
        if value.type == BOOL:
            return value
        if value.possible is not None and (0 not in value.possible or value.possible == {0}):
            return known(0 not in value.possible)
        zero = {INT: "0", UINT: "0u", FLOAT: "0.0"}[value.type]
        return Value(BOOL, f"({value.text} != {zero})")

    def _read_BoolOp(self, node):
        every = isinstance(node.op, ast.And)
        parts = []
        for operand in node.values:
            value = self._condition(operand)
            if value.type == CONSTANT:
                if value.constant != every:
                    if not parts:
                        return known(not every)
                    parts.append("false" if every else "true")
                    break
                continue
            parts.append(value.text)
        if not parts:
            return known(every)
        return Value(BOOL, parts[0] if len(parts) == 1 else f"({(' && ' if every else ' || ').join(parts)})")

    def _read_Compare(self, node):
        values = [self._expression(operand) for operand in (node.left, *node.comparators)]
        parts = []
        for operator, a, b in zip(node.ops, values, values[1:]):
            name = type(operator).__name__
            if name in ("Is", "IsNot"):
                both = a.type == CONSTANT and b.type == CONSTANT and a.constant is b.constant
                parts.append(known(both == (name == "Is")))
            else:
                parts.append(self._compare(name, a, b))
        if all(part.type == CONSTANT for part in parts):
            return known(all(part.constant for part in parts))
        if any(part.type == CONSTANT and not part.constant for part in parts):
            return known(False)
        texts = [part.text for part in parts if part.type != CONSTANT]
        return Value(BOOL, texts[0] if len(texts) == 1 else f"({' && '.join(texts)})")

    def _compare(self, name: str, a: Value, b: Value) -> Value:
        if a.type == CONSTANT and b.type == CONSTANT:
            return known(_PYTHON[name](a.constant, b.constant))
        if CONSTANT in (a.type, b.type) and (a.constant is None) != (b.constant is None) and not (
                is_number(a.constant) or is_number(b.constant) or isinstance(a.constant or b.constant, tuple)):
            return known(name == "NotEq")
        a, b = self._value(a), self._value(b)
        if a.possible is not None and b.possible is not None:
            outcomes = {bool(_PYTHON[name](x, y)) for x in a.possible for y in b.possible}
            if len(outcomes) == 1:
                return known(outcomes.pop())
        kind = join(a.type, b.type)
        return Value(BOOL, f"({self._converted(a, kind).text} {_SYMBOLS[name]} {self._converted(b, kind).text})")

    def _read_IfExp(self, node):
        test = self._condition(node.test)
        if test.type == CONSTANT:
            return self._expression(node.body if test.constant else node.orelse)
        a, b = self._expression(node.body), self._expression(node.orelse)
        if a.type == CONSTANT and b.type == CONSTANT and is_number(a.constant) and is_number(b.constant):
            possible = frozenset([a.constant, b.constant]) if isinstance(a.constant, int) and isinstance(
                b.constant, int) else None
        else:
            possible = None
        a, b = self._value(a), self._value(b)
        kind = join(a.type, b.type)
        if isinstance(kind, Ref):
            return Value(kind, f"({test.text} ? {a.text} : {b.text})")
        return Value(kind, f"({test.text} ? {self._converted(a, kind).text} : {self._converted(b, kind).text})",
                     possible=possible)

    # Calls

    def _read_Call(self, node):
        function = self._expression(node.func)
        if function.type != CONSTANT:
            raise self._error("what is called is not known", node)
        arguments = [self._expression(argument) for argument in node.args]
        called = function.constant
        native = self.translator.natives.get(inspect.unwrap(called) if callable(called) else called)
        if isinstance(native, Native):
            return self._native(native, arguments)
        if native is not None:
            called = native
        name = getattr(called, "table_name", None)
        if name is not None:
            return self.translator.tables.table(name, called.table_dtype, arguments[0])
        if hasattr(called, "__wrapped__"):
            if inspect.unwrap(called).__module__.rpartition(".")[2] == "vec":
                vector = self._vector(inspect.unwrap(called).__name__, arguments)
                if vector is not None:
                    return vector
            name, result = self.translator.function(called, arguments)
            if result.type == CONSTANT:
                return result
            return replace(result, text=f"{name}({', '.join(self._passed(arguments))})")
        return self._builtin(called, arguments, node)

    def _passed(self, arguments: list[Value]) -> list[str]:
        texts = []
        for argument in arguments:
            if argument.type == CONSTANT:
                if not is_number(argument.constant):
                    continue
                argument = self._value(argument)
            if isinstance(argument.type, Ref) and argument.type.lvalue and "{}" not in argument.type.lvalue:
                continue
            texts.append(argument.text)
            if argument.count:
                texts.append(argument.count)
        return texts

    def _native(self, native: Native, arguments: list[Value]) -> Value:
        if callable(native.name):
            return native.name(self, arguments)
        texts = self._passed([replace(argument, count="") for argument in arguments])
        return Value(native.result, f"{native.name}({', '.join(texts)})")

    def _vector(self, name: str, arguments: list[Value]) -> Value | None:
        """Operators of GLSL for what ``vec`` does with vectors."""
        if name == "vec" and isinstance(arguments[0].type, Ref):
            return self._as_vector(arguments[0])
        if name not in _VECTOR_TEXTS:
            return None
        arguments = [self._value(argument) for argument in arguments]
        if not all(argument.type in (VECTOR, FLOAT, INT) for argument in arguments):
            return None
        template, kind = _VECTOR_TEXTS[name]
        texts = [argument.text if argument.type == VECTOR else self._converted(argument, FLOAT).text
                 for argument in arguments]
        return Value(kind, template.format(*texts))

    def _as_vector(self, place: Value) -> Value:
        if place.type.lvalue:
            text = place.type.lvalue.replace("{}", place.text)
            if place.type.layout.vector:
                return Value(VECTOR, text)
            items = [place.type.lvalue.replace("{}", _sum(place.text, axis)) for axis in range(3)]
            return Value(VECTOR, f"vec3({', '.join(items)})")
        return Value(VECTOR, f"vector_at({place.text})")

    def _builtin(self, called, arguments: list[Value], node: ast.Call) -> Value:
        if called is len:
            return Value(INT, f"({arguments[0].count})")
        if called in (min, max):
            return self._extremum(called, arguments)
        if called in (int, np.int64, np.uint64, np.int32):
            if arguments[0].type == CONSTANT:
                return known(int(arguments[0].constant))
            return self._converted(arguments[0], INT)
        if called is np.uint32:
            return self._converted(arguments[0], UINT)
        if called in (float, np.float64, np.float32):
            return self._converted(arguments[0], FLOAT)
        if called is bool:
            return self._condition(node.args[0])
        if called is abs:
            value = self._value(arguments[0])
            return Value(value.type, f"abs({value.text})")
        name = getattr(called, "__name__", str(called))
        if name not in _FUNCTIONS:
            raise self._error(f"{name} has no GLSL reading", node)
        if all(argument.type == CONSTANT for argument in arguments):
            return known(called(*(argument.constant for argument in arguments)))
        texts = [self._converted(argument, FLOAT).text for argument in arguments]
        template, kind = _FUNCTIONS[name]
        return Value(kind, template.format(*texts))

    def _extremum(self, called, arguments: list[Value]) -> Value:
        if all(argument.type == CONSTANT for argument in arguments):
            return known(called(*(argument.constant for argument in arguments)))
        arguments = [self._value(argument) for argument in arguments]
        kind = arguments[0].type
        for argument in arguments[1:]:
            kind = join(kind, argument.type)
        texts = [self._converted(argument, kind).text for argument in arguments]
        text = texts[0]
        for other in texts[1:]:
            text = f"{called.__name__}({text}, {other})"
        return Value(kind, text)


def _is_value(constant) -> bool:
    return is_number(constant) or (isinstance(constant, tuple) and all(map(is_number, constant)) and len(constant) > 0)


def _sum(a: str, b) -> str:
    if b in (0, "0"):
        return a
    return f"{a} + {b}" if a not in ("", "0") else str(b)


def _times(text: str, factor: int) -> str:
    if factor == 1:
        return text
    return str(int(text) * factor) if text.isdigit() else f"({text}) * {factor}"


def _read(kind: str, address: str) -> str:
    return f"{kind}_at({address})"


_VECTOR_TEXTS = {
    "add": ("({} + {})", VECTOR), "sub": ("({} - {})", VECTOR), "mul": ("({} * {})", VECTOR),
    "scale": ("({} * {})", VECTOR), "madd": ("({} + {} * {})", VECTOR), "negate": ("(-{})", VECTOR),
    "dot": ("dot({}, {})", FLOAT), "cross": ("cross({}, {})", VECTOR), "length": ("length({})", FLOAT)}

_FUNCTIONS = {
    "sqrt": ("sqrt({})", FLOAT), "sin": ("sin({})", FLOAT), "cos": ("cos({})", FLOAT), "tan": ("tan({})", FLOAT),
    "exp": ("exp({})", FLOAT), "log": ("log({})", FLOAT), "acos": ("angle_acos({})", FLOAT),
    "asin": ("angle_asin({})", FLOAT), "atan": ("angle_atan({})", FLOAT), "atan2": ("angle_atan2({}, {})", FLOAT),
    "hypot": ("length(vec2({}, {}))", FLOAT), "copysign": ("copy_sign({}, {})", FLOAT), "isnan": ("isnan({})", BOOL),
    "isfinite": ("is_finite({})", BOOL), "floor": ("floor({})", FLOAT), "ceil": ("ceil({})", FLOAT)}

_SYMBOLS = {
    "Add": "+", "Sub": "-", "Mult": "*", "Div": "/", "FloorDiv": "/", "BitAnd": "&", "BitOr": "|", "BitXor": "^",
    "LShift": "<<", "RShift": ">>", "Lt": "<", "LtE": "<=", "Gt": ">", "GtE": ">=", "Eq": "==", "NotEq": "!="}

_PYTHON = {
    "Add": lambda a, b: a + b, "Sub": lambda a, b: a - b, "Mult": lambda a, b: a * b, "Div": lambda a, b: a / b,
    "FloorDiv": lambda a, b: a // b, "Mod": lambda a, b: a % b, "Pow": lambda a, b: a**b, "BitAnd": lambda a, b: a & b,
    "BitOr": lambda a, b: a | b, "BitXor": lambda a, b: a ^ b, "LShift": lambda a, b: a << b,
    "RShift": lambda a, b: a >> b, "Lt": lambda a, b: a < b, "LtE": lambda a, b: a <= b, "Gt": lambda a, b: a > b,
    "GtE": lambda a, b: a >= b, "Eq": lambda a, b: a == b, "NotEq": lambda a, b: a != b}
