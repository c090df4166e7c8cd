# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The definition of a value node: a function from the node's inputs to formulas of its outputs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np

from ...graph.formula import Formula, Vector, parameter
from ..images import Texture
from ..material import Attribute, Table
from .variables import NORMAL

WITHOUT_SURFACE = ("WORLD", "LIGHT", "VOLUME")
"""Domains of nodes that are evaluated at no point of a surface."""


def mean(vector: Vector) -> Formula:
    """Mean of the components; for three equal components it is exactly their value."""
    x, y, z = vector
    return x + ((y - x) + (z - x)) * (1.0 / 3.0)


class NodeInputs(Protocol):
    """A node as its definition sees it. Sockets are named by identifier.

    Constants are parameters: a definition branches only on settings and links, never on values.
    """

    wanted: set[str]  # identifiers of the used outputs

    def number(self, socket: str) -> Formula:
        """A scalar input; a parameter with its value if nothing is linked."""

    def vector(self, socket: str) -> Vector:
        """A vector input."""

    def color(self, socket: str) -> Vector:
        """A colour input, linear RGB."""

    def normal(self, socket: str) -> Vector:
        """A vector input; the shading normal if nothing is linked."""

    def is_linked(self, socket: str) -> bool:
        """Whether a link leads to the input."""

    def is_given(self, socket: str) -> bool:
        """Whether an input with default coordinates or a default normal has another source: a link, or the value of a
        group's input."""

    def varies(self, socket: str) -> bool:
        """Whether something is linked that is not a constant."""

    def is_folded(self) -> bool:
        """Whether Blender computes the node itself and gives Cycles only the result: since 5.0, if all inputs are
        constants."""

    def has(self, socket: str) -> bool:
        """Whether the node has such an input in this version of Blender."""

    def own(self, output: str) -> Formula | Vector:
        """The value stored in an output, as in the nodes Value and RGB."""

    def setting(self, name: str):
        """A property of Blender's node, or of its context: "working_space" is the name of the linear colour space,
        "scene_time" seconds and frame."""

    def parameter(self, value: float | Attribute | Table | Texture) -> Formula:
        """A number of the node that is no socket, or the index of an attribute."""

    def image(self, straight: bool = False, tiled: bool = True) -> Formula:
        """Index of the node's texture, for ``lookups.IMAGE``: the image and its look-up settings.

        ``straight``: colours are divided by alpha, as in Blender if the node's alpha is used, too. ``tiled``: all UDIM
        tiles, else only the first.
        """

    def table(self, values: np.ndarray) -> Formula:
        """Start of the table (rows, columns), for ``lookups.table_of``."""

    def report(self, sentence: str) -> None:
        """Report an unsupported feature."""


class GivenNode(NodeInputs):
    """A node with formulas or constants as inputs and with these settings, for materials made by scripts.

    Constants become parameters: their values are appended to ``parameters``, which are those of the material.
    """

    def __init__(
        self, parameters: list, inputs: dict | None = None, settings: dict | None = None, wanted: set[str] = frozenset()
    ):
        self.wanted = set(wanted)
        self._parameters, self._inputs, self._settings = parameters, inputs or {}, settings or {}

    def number(self, socket: str) -> Formula:
        value = self._inputs.get(socket, 0.0)
        if isinstance(value, Vector):
            return mean(value)
        return value if isinstance(value, Formula) else self.parameter(float(value))

    def vector(self, socket: str) -> Vector:
        value = self._inputs.get(socket, (0.0, 0.0, 0.0))
        if isinstance(value, Vector):
            return value
        if isinstance(value, Formula):
            return Vector(value, value, value)
        return Vector(*(self.parameter(float(entry)) for entry in value))

    color = vector

    def normal(self, socket: str) -> Vector:
        return self.vector(socket) if self.is_linked(socket) else NORMAL

    def has(self, socket: str) -> bool:
        return socket in self._inputs

    def is_linked(self, socket: str) -> bool:
        return isinstance(self._inputs.get(socket), (Formula, Vector))

    is_given = varies = is_linked

    def is_folded(self) -> bool:
        return False

    def own(self, output: str) -> Formula | Vector:
        value = self._inputs[output]
        return Vector(*map(self.parameter, value)) if isinstance(value, tuple) else self.parameter(float(value))

    def setting(self, name: str):
        return self._settings.get(name)

    def parameter(self, value: float | Attribute | Table | Texture) -> Formula:
        self._parameters.append(value)
        return parameter(len(self._parameters) - 1)

    def table(self, values: np.ndarray) -> Formula:
        return self.parameter(Table(np.asarray(values, np.float64)))

    def image(self, straight: bool = False, tiled: bool = True) -> Formula:
        names = "image", "interpolation", "extension", "tiles"
        known = {name: self.setting(name) for name in names if self.setting(name) is not None}
        return self.parameter(Texture(**known, straight=straight and bool(self.setting("has_alpha"))))

    def report(self, sentence: str) -> None:
        raise ValueError(sentence)


Definition = Callable[[NodeInputs], "dict[str, Formula | Vector]"]

DEFINITIONS: dict[str, Definition] = {}
"""bl_idname of a node -> its definition."""


MODES: dict[str, tuple[str, ...]] = {}
"""bl_idname of a node -> its modes, for the reference."""


def defines(*names: str, modes: Iterable[str] = ()) -> Callable[[Definition], Definition]:
    """Register a definition under the bl_idname of one node, or of several equal ones."""

    def register(definition: Definition) -> Definition:
        for name in names:
            DEFINITIONS[name], MODES[name] = definition, tuple(modes)
        return definition

    return register


def node_outputs(
    name: str,
    parameters: list,
    inputs: dict | None = None,
    settings: dict | None = None,
    wanted: set[str] = frozenset(),
) -> dict[str, Formula | Vector]:
    """Outputs of the node with this bl_idname, from ``GivenNode``."""
    return DEFINITIONS[name](GivenNode(parameters, inputs, settings, wanted))
