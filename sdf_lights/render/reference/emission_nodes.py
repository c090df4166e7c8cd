# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emission of the nodes of a world or a light, over arrays of directions and points."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from ...graph.functions import Function
from ..material import Material
from ..scene import Scene
from .geometry import Surface
from .material_lobes import leaves
from .nodes import Graph, Points


class Directions(Points):
    """Formulas without an object, as in ``substitution.without_objects``."""

    def call(self, function: Function, operands: list) -> tuple:
        if not function.of_object:
            return super().call(function, operands)
        return tuple(operands) if len(operands) == function.results else (0.0,) * function.results


class Emission:
    """RGB of the Emission closures of ``material``."""

    def __init__(self, material: Material, scene: Scene):
        self._graph = Graph(material)
        self._geometry = SimpleNamespace(scene=scene, mesh_of=np.zeros(1, int))

    def radiance(self, directions: np.ndarray, kind: np.ndarray | int) -> np.ndarray:
        """(N, 3) along unit directions of rays of a kind of ``scene.Ray``; 0 in light sampling."""
        return self.at(directions, -directions, -directions, kind, np.zeros(len(directions)))

    def at(self, place, wo, normal, kind, length) -> np.ndarray:
        """(N, 3) where rays of this ``length`` (N,) hit a light or the world at ``place``, with this ``normal``, all
        (N, 3)."""
        count = len(place)
        nowhere = np.zeros(count, int)
        surface = Surface(
            place,
            normal,
            normal,
            wo,
            np.zeros(count, bool),
            nowhere,
            nowhere,
            np.zeros((count, 3)),
            np.zeros(count, bool),
            length,
            np.broadcast_to(kind, count),
            np.zeros(count, bool),
            np.zeros((count, 5), int),
            np.zeros(count),
            nowhere,
            np.zeros((count, 3)),
            nowhere - 1,
        )
        points = Directions(self._graph, surface, self._geometry, self._geometry.scene.images, np.zeros(count))
        total = np.zeros((count, 3))
        for node, weight in leaves(self._graph.surface, points, np.ones(count)):
            if node.kind == "emission":
                total += weight[:, None] * points.input(node, "color") * points.input(node, "strength")[:, None]
        return total
