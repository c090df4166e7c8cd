# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a formula as GLSL: the source of one function, in float32.

It is plain GLSL 4.30 without version, layout, extension or global variable, so Blender's ``gpu`` module accepts it too.
The caller supplies the text that reads a parameter. The same formula always gives the same text.

float32 holds numbers up to 3.4e38. Greater constants are clamped to that, and those below 1.2e-38 may count as 0.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence, Set
from typing import Any

import numpy as np

from .formula import CALL, CONSTANT, ITERATE, PARAMETER, RESULT, STATE, VARIABLE, Formula, axis_of, order
from .functions import Function
from .operations import CONDITIONS, OPERATIONS

_TYPES = {1: "float", 2: "vec2", 3: "vec3", 4: "vec4"}
_NAME = re.compile(r"(?!gl_)(?!.*__)[A-Za-z]\w*", re.ASCII)
_LONGEST = 600  # characters of an expression: compilers limit the nesting

# GLSL leaves pow undefined for some operands for which NumPy has values, and promises little for its inverse functions:
# asin is wrong in the fourth digit on Mesa. The polynomial is that of atanf in the Cephes library (S. Moshier), within
# 2 units in the last place for |x| ≤ tan(π/8). Helpers come after those that they use.
_HELPERS = {
    "power": """\
float {name}_power(float a, float b)
{{
    if (b == 0.0) {{
        return 1.0;
    }}
    if (a == 0.0) {{
        return b > 0.0 ? 0.0 : {greatest};
    }}
    if (a < 0.0 && b != floor(b)) {{
        return sqrt(a);
    }}
    float size = pow(abs(a), b);
    return a < 0.0 && 0.5 * b != floor(0.5 * b) ? -size : size;
}}
""",
    "atan2": """\
float {name}_atan2(float y, float x)
{{
    float least = min(abs(x), abs(y));
    float most = max(abs(x), abs(y));
    if (most == 0.0) {{
        return 0.0;
    }}
    bool large = least > 0.41421356 * most;
    float t = large ? (least - most) / (least + most) : least / most;
    float s = t * t;
    float angle = (((0.080537445 * s - 0.13877686) * s + 0.1997771) * s - 0.3333295) * s * t + t;
    angle = large ? 0.7853982 + angle : angle;
    angle = abs(y) > abs(x) ? 1.5707964 - angle : angle;
    angle = x < 0.0 ? 3.1415927 - angle : angle;
    return y < 0.0 ? -angle : angle;
}}
""",
    "atan": """\
float {name}_atan(float a)
{{
    return {name}_atan2(a, 1.0);
}}
""",
    "asin": """\
float {name}_asin(float a)
{{
    return {name}_atan2(a, sqrt((1.0 - a) * (1.0 + a)));
}}
""",
    "acos": """\
float {name}_acos(float a)
{{
    return {name}_atan2(sqrt((1.0 - a) * (1.0 + a)), a);
}}
""",
}
_NEEDS_ATAN2 = frozenset({"atan", "asin", "acos"})


class UnwrittenError(ValueError):
    """A formula calls a function without a GLSL version."""


def function(
    formula: Formula | Sequence[Formula], name: str, parameters: str = "k[{}]", written: set[str] | None = None
) -> str:
    """Source of ``float name(vec3 p)``; for two to four formulas, of a function that returns a vector.

    ``parameters`` is GLSL for the value in a slot, with ``{}`` for the slot's number. Names of functions start with
    ``name``; all others are local. ``table_number(i)`` reads the tables. ``written`` collects the names of functions
    that read tables and are already written; they are not written again. Raises UnwrittenError if there is no form for
    the graphics card, and ValueError for a wrong name or number of values.
    """
    formulas = (formula,) if isinstance(formula, Formula) else tuple(formula)
    if not _NAME.fullmatch(name):
        raise ValueError(
            f"{name!r} is not a valid name of a GLSL function: it needs letters, digits and single underscores"
        )
    if len(formulas) not in _TYPES:
        raise ValueError(f"a GLSL function gives 1 to 4 values, not {len(formulas)}")
    sources: list[str] = []

    def call(called: Function, operands: list[str], declare: Callable[[str, str], str]) -> list[str]:
        glsl = getattr(called, "glsl", "")
        if written is None or not glsl:
            raise UnwrittenError(f"lamps of the kind '{called.name}' cannot be drawn by the graphics card yet")
        for part in (*getattr(called, "needs", ()), called):
            if part.name not in written:
                written.add(part.name)
                sources.append(part.glsl)
        tables = [f"int({operand})" for operand in operands[: called.tables]]
        return [declare("float", f"{called.name}({', '.join([*tables, *operands[called.tables :]])})")]

    writer = _Writer(name, parameters, call=call)
    values = writer.write(formulas)
    kind = _TYPES[len(formulas)]
    result = values[0] if len(values) == 1 else f"{kind}({', '.join(values)})"
    used = writer.used | ({"atan2"} if writer.used & _NEEDS_ATAN2 else set())
    lines = [f"{kind} {name}(vec3 p)", "{", *writer.lines, f"    return {result};", "}", ""]
    return "\n".join([*sources, *helpers(name, used), "\n".join(lines)])


def helpers(name: str, used: Set[str] = _NEEDS_ATAN2 | {"atan2"}) -> list[str]:
    """Sources of functions ``name_atan2``, … for operations that GLSL lacks or computes badly: those in ``used``."""
    return [text.format(name=name, greatest=literal(np.inf)) for kind, text in _HELPERS.items() if kind in used]


def literal(value: float) -> str:
    """A decimal number that float32 reads as its nearest value. A nonzero number stays nonzero, because formulas divide
    by it."""
    limits = np.finfo(np.float32)
    if value != 0.0:
        value = np.copysign(np.clip(abs(value), float(limits.tiny), float(limits.max)), value)
    number = np.float32(value)
    text = np.format_float_positional(number, unique=True, trim="0")
    if len(text) > 12:
        text = np.format_float_scientific(number, unique=True, trim="0")
    return text


def _component(node: Formula) -> str:
    return "p." + "xyz"[axis_of(node)]


def statements(
    formulas: Sequence[Formula],
    name: str,
    parameters: str,
    variable: Callable[[Formula], str],
    call: Callable[[Function, list[str], Callable[[str, str], str]], list[str]],
) -> tuple[list[str], list[str], set[str]]:
    """Lines of a function body, the expressions for the formulas after them, and the ``helpers`` used.

    ``variable`` returns GLSL for a variable. ``call(function, operands, declare)`` returns GLSL for the results of a
    function; in it, ``declare(kind, value)`` declares a local variable and returns its name.
    """
    writer = _Writer(name, parameters, variable, call)
    values = writer.write(tuple(formulas))
    return writer.lines, values, writer.used | ({"atan2"} if writer.used & _NEEDS_ATAN2 else set())


class _Writer:
    """Statements of one function, one for each node that is used more than once."""

    def __init__(self, name: str, parameters: str, variable: Callable = _component, call: Callable | None = None):
        self.name, self.parameters, self.variable = name, parameters, variable
        self.call: Any = call
        self.lines: list[str] = []
        self.used: set[str] = set()  # kinds of operations
        self._count = 0  # number of names so far
        self._depth = 1

    def _say(self, line: str) -> None:
        self.lines.append("    " * self._depth + line)

    def _variable(self, kind: str, value: str) -> str:
        name = f"a{self._count}"
        self._count += 1
        self._say(f"{kind} {name} = {value};")
        return name

    def write(self, roots: tuple[Formula, ...]) -> list[str]:
        """Expressions for the roots, after the statements that they need."""
        nodes = order(*roots)
        written: dict = {}
        self._write(nodes, _uses(roots, nodes), written)
        return [written[root] for root in roots]

    def _write(self, nodes: list[Formula], uses: dict[Formula, int], written: dict) -> None:
        for node in nodes:
            if node in written:
                continue
            operands = [written[operand] for operand in node.operands]
            if node.kind == CONSTANT:
                number = literal(node.value)
                written[node] = f"({number})" if number.startswith("-") else number
            elif node.kind == VARIABLE:
                written[node] = self.variable(node)
            elif node.kind == PARAMETER:
                written[node] = self.parameters.format(node.value)
            elif node.kind == ITERATE:
                written[node] = self._loop(node, operands)
            elif node.kind == RESULT:
                written[node] = operands[0][node.value]
            elif node.kind == CALL:
                written[node] = self.call(node.value, operands, self._variable)
            else:
                self.used.add(node.kind)
                text = OPERATIONS[node.kind].glsl.format(*operands, name=self.name)
                if uses[node] > 1 or len(text) > _LONGEST:
                    text = self._variable("bool" if node.kind in CONDITIONS else "float", text)
                written[node] = text

    def _loop(self, node: Formula, operands: list) -> list[str]:
        """A loop; its states are variables that keep their values after it."""
        loop, size = node.value, len(node.value.steps)
        written: dict = {}
        for capture, text in zip(node.operands[1 + size :], operands[1 + size :]):
            plain = capture.kind in (VARIABLE, PARAMETER) or not isinstance(text, str) or text.isidentifier()
            written[capture] = text if plain else self._variable("float", text)
        states = [self._variable("float", value) for value in operands[1 : 1 + size]]
        rounds = self._variable("float", operands[0])
        counter = f"i{self._count}"
        self._count += 1
        self._say(f"for (int {counter} = 0; {counter} < {loop.limit}; {counter}++) {{")
        self._depth += 1
        self._leave_unless(f"(float({counter} + 1) <= {rounds})")
        first = (loop.going,) if loop.going is not None else ()
        nodes = order(*first, *loop.steps, known=set(written))
        written |= {n: states[n.value[1]] for n in nodes if n.kind == STATE and n.value[0] == loop.level}
        uses = _uses((*first, *loop.steps), nodes)
        if first:
            self._write(nodes[: nodes.index(loop.going) + 1], uses, written)
            self._leave_unless(written[loop.going])
        self._write(nodes, uses, written)
        following = [self._variable("float", written[step]) for step in loop.steps]
        for state, value in zip(states, following):
            self._say(f"{state} = {value};")
        self._depth -= 1
        self._say("}")
        return states

    def _leave_unless(self, condition: str) -> None:
        self._say(f"if (!{condition}) {{")
        self._say("    break;")
        self._say("}")


def _uses(roots: tuple[Formula, ...], nodes: list[Formula]) -> dict[Formula, int]:
    """How often each node is an operand or a root."""
    uses = dict.fromkeys(nodes, 0)
    for used in (*roots, *(operand for node in nodes for operand in node.operands)):
        if used in uses:
            uses[used] += 1
    return uses
