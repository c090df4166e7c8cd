# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random programs of the whole expression language, typed: every registered function, loops, conditions, parameters.

Most are valid. The generator knows the kinds of values of a function's arguments and result, but not its meaning.
"""

from __future__ import annotations

import numpy as np

from sdf_lights.sdf.expression import ExpressionError, evaluate
from sdf_lights.sdf.functions import COLOURS, FUNCTIONS, MATHEMATICS, POINTS, REQUIRED, SHAPE_GROUPS
from sdf_lights.sdf.shapes import Shape

DEEPEST = 4
_VECTORS = ("cross", "normalize", "mirror")  # functions of fields whose result is a vector
_SCALARS = ("dot", "length", "distance", "noise")  # … or a number, for any arguments


class _Writer:
    def __init__(self, rng: np.random.Generator):
        self.rng = rng
        self.lines: list[str] = []
        self.names: dict[str, list[str]] = {"scalar": [], "vector": []}
        self.count = 0

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def pick(self, values):
        return values[int(self.rng.integers(len(values)))]

    def new(self, kind: str) -> str:
        self.count += 1
        name = f"v{self.count}"
        self.names[kind].append(name)
        return name

    def number(self, low: float = 0.05, high: float = 1.2) -> str:
        return f"{self.rng.uniform(low, high):.3g}"

    # -- values of each kind, as text ---------------------------------------------------------------------------

    def scalar(self, depth: int) -> str:
        if depth <= 0 or self.chance(0.15):
            leaves = ["p.x", "p.y", "p.z", "p.x", "p.z", self.number(-1.5, 1.5), "length(p)", *self.names["scalar"]]
            return self.pick(leaves)
        kind = self.rng.integers(10)
        one, two = lambda: self.scalar(depth - 1), lambda: self.scalar(depth - 2)
        if kind < 3:
            return f"({one()} {self.pick('+-*/%+-*')} {two()})"
        if kind == 3:
            return f"({one()} if {self.condition(depth - 2)} else {two()})"
        if kind == 4:
            return f"{self.vector(depth - 1)}.{self.pick('xyz')}"
        if kind == 5:
            return f"length({self.vector(depth - 1)})"
        if kind == 6:
            return self.pick(
                [
                    f"dot({self.vector(depth - 1)}, {self.vector(depth - 2)})",
                    f"noise({self.number(1, 6)} * {self.vector(depth - 1)})",
                    f"{self.shape(0)}({self.vector(depth - 1)})",
                    f"({one()}) ** {self.pick(['2', '0.5', '-1', '3', '1.5', '2.5'])}",
                ]
            )
        words = [w for w in _words(MATHEMATICS) if w not in ("vec2", "vec3", "select", *_VECTORS, *_SCALARS)]
        return self.call(FUNCTIONS[self.pick(words)], depth)

    def vector(self, depth: int) -> str:
        if depth <= 0 or self.chance(0.3):
            return self.pick(["p", "p", *self.names["vector"]])
        return self.pick(
            [
                f"({self.scalar(depth - 1)}, {self.scalar(depth - 2)}, {self.scalar(depth - 2)})",
                f"repeat({self.vector(depth - 1)}, {self.number(0.3, 1.5)})",
                f"polar({self.vector(depth - 1)}, {self.pick(['3', '5', '6', '2.5'])})",
                f"fold({self.vector(depth - 1)}, {self.pick(['(1, -1, 0)', '(0, 1, 0.5)'])}, {self.number(-0.3, 0.3)})",
                f"mirror({self.vector(depth - 1)})",
                f"abs({self.vector(depth - 1)})",
                f"rotate_z({self.vector(depth - 1)}, {self.scalar(depth - 2)} * 90)",
                f"({self.vector(depth - 1)} * {self.number(0.5, 3)})",
                f"({self.vector(depth - 1)} - {self.number(-0.5, 0.5)})",
                f"fract({self.vector(depth - 1)})",
            ]
        )

    def condition(self, depth: int) -> str:
        test = f"{self.scalar(depth)} {self.pick(['<', '<=', '>', '>='])} {self.scalar(min(depth, 1))}"
        return (
            f"({test} {self.pick(['and', 'or'])} {self.scalar(0)} < {self.number(-0.5, 0.5)})"
            if self.chance(0.2)
            else test
        )

    def call(self, function, depth: int) -> str:
        given = []
        for argument in function.arguments:
            given.append(self.argument(argument, depth - 1))
            if function.variadic and argument is function.arguments[0]:
                given += [self.argument(argument, depth - 2) for _ in range(int(self.rng.integers(1, 3)))]
        if function.name in ("smoothstep", "clamp"):
            given = (
                [self.number(-0.8, 0), self.number(0.1, 1), given[-1]]
                if function.name == "smoothstep"
                else [given[0], self.number(-0.8, 0), self.number(0.1, 1)]
            )
        return f"{function.name}({', '.join(filter(None, given))})"

    def argument(self, argument, depth: int) -> str:
        if argument.kind in ("value", "scalar"):
            return self.scalar(depth)
        if argument.kind in ("vector", "vector3"):
            return self.vector(depth)
        if argument.kind == "condition":
            return self.condition(depth)
        if argument.kind == "shape":
            return self.shape(depth)
        if argument.kind == "profile":
            return self.profile()
        if argument.kind == "corner":
            return f"({self.number(-0.5, 0.5)}, {self.number(-0.5, 0.5)})"
        default = argument.default
        if default is REQUIRED:
            return self.number()
        if isinstance(default, tuple):
            return f"({', '.join(self.number(0.1, 0.8) for _ in default)})" if self.chance(0.3) else _literal(default)
        if self.chance(0.4) and "angle" not in argument.kind and default != int(default):
            return f"{default * self.rng.uniform(0.6, 1.4):.4g}"
        return f"{np.degrees(default):.6g}" if "angle" in argument.kind else f"{default:.6g}"

    def profile(self) -> str:
        words = [w for w in _words("Profiles") if w != "polygon"]
        return self.call(FUNCTIONS[self.pick(words)], 0)

    def shape(self, depth: int) -> str:
        if depth <= 0 or self.chance(0.2):
            return self.call(FUNCTIONS[self.pick(_words("Shapes"))], 0)
        kind = self.rng.integers(8)
        if kind < 3:
            bound = f" & {self.pick(['box(1)', 'sphere(1.2)', 'box(0.7)'])}"
            return f"(field({self.scalar(depth)}){bound})"
        if kind == 3:
            return f"displace({self.shape(depth - 1)}, {self.number(0.02, 0.2)} * {self.scalar(depth)})"
        group = self.pick(["Combinations", "Combinations", "Operators", "Solids from Profiles", "Transforms"])
        word = self.pick(_words(group))
        if group == "Transforms":
            return self.pick(
                [
                    f"translate({self.shape(depth - 1)}, ({self.number(-0.3, 0.3)}, {self.number(-0.3, 0.3)}, 0.1))",
                    f"rotate_z({self.shape(depth - 1)}, {self.number(0, 90)})",
                    f"scale({self.shape(depth - 1)}, ({self.number(0.5, 1)}, {self.number(0.5, 1.2)}, 1))",
                ]
            )
        return self.call(FUNCTIONS[word], depth)

    # -- statements ---------------------------------------------------------------------------------------------

    def statement(self) -> None:
        kind = self.rng.integers(6)
        if kind == 0:
            self.lines.append(f"v{self.count + 1} = slider({self.number()}, 0.01, 3)")
            self.new("scalar")
        elif kind in (1, 2):
            text = self.scalar(DEEPEST - 1)
            self.lines.append(f"{self.new('scalar')} = {text}")
        elif kind == 3:
            text = self.vector(2)
            self.lines.append(f"{self.new('vector')} = {text}")
        else:
            text = self.vector(1)
            name = self.new("vector")
            self.lines += [f"{name} = {text}", f"for i in range({self.rng.integers(2, 7)}):"]
            if self.chance(0.4):
                self.lines.append(f"    if length({name}) > {self.number(0.5, 2.5)}: break")
            body = self.pick(
                [
                    f"abs({name}) * {self.number(0.8, 1.6)} - {self.number(0.1, 0.6)}",
                    f"fold({name}, (1, -1, 0.3)) - {self.number(0.05, 0.3)}",
                    f"rotate_z(abs({name}), {self.number(10, 80)}) - (0.2, 0.1, 0)",
                    f"{name} - 0.3 * sin(3 * {name}.x)",
                    f"({name} * 1.2 if {name}.x > {self.number(-0.3, 0.3)} else {name} - 0.1)",
                    f"{name} - 0.5 * floor({name} + {self.number(0, 1)})",
                ]
            )
            self.lines.append(f"    {name} = {body}")

    def text(self) -> str:
        for _ in range(int(self.rng.integers(0, 4))):
            self.statement()
        return "\n".join([*self.lines, self.shape(DEEPEST)])


def _words(group: str) -> list[str]:
    return sorted(
        name
        for name, function in FUNCTIONS.items()
        if function.group == group or (group in SHAPE_GROUPS and function.group == group)
    )


def _literal(vector) -> str:
    return f"({', '.join(f'{component:.6g}' for component in vector)})"


def program(seed: int) -> str:
    """The text of program number ``seed``."""
    return _Writer(np.random.default_rng([27, seed])).text()


def valid(seed: int) -> tuple[str, Shape] | None:
    """Text and shape of a program; None if the language refuses it, or if its size makes it no lamp."""
    text = program(seed)
    try:
        shape = evaluate(text)
    except ExpressionError:
        return None
    low, high = shape.bounds()
    sized = np.isfinite([low, high]).all() and np.all(high > low) and (high - low).max() < 100.0
    return (text, shape) if sized and not shape.validate() else None


UNUSED_GROUPS = ("Fields", COLOURS, POINTS)  # functions that the generator writes by hand, or never
