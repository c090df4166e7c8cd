# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials, and what their graphs need of a mesh."""

from __future__ import annotations

from collections.abc import Iterable

import bpy

from ...render.material import Material, Node
from ...render.scene import Scene
from .common import Warnings, node_tree_of, rgb
from .images import Images
from .nodes import Reader


class Materials:
    """Puts each material into the scene once. ``override`` stands in for all of them, as a view layer may ask."""

    def __init__(self, scene: Scene, images: Images, warn: Warnings, override: bpy.types.Material | None = None):
        self._scene, self._images, self._warn, self._override = scene, images, warn, override
        self._known: dict[int, int] = {}
        self._needs: list[tuple[set[str], set[str]]] = []

    def index(self, material: bpy.types.Material | None) -> int:
        """Index of a material in the scene; None is Blender's default surface."""
        material = self._override or material
        key = 0 if material is None else material.as_pointer()
        if key not in self._known:
            built = Material("", Node("diffuse")) if material is None else self._read(material)
            self._scene.materials.append(built)
            self._needs.append(_needs(built.surface))
            self._known[key] = len(self._needs) - 1
        return self._known[key]

    def needs(self, indices: Iterable[int]) -> tuple[set[str], set[str]]:
        """Names of the UV maps, and of those with tangents, that these materials read ("": the active one)."""
        uv_maps: set[str] = set()
        tangents: set[str] = set()
        for index in indices:
            uv_maps |= self._needs[index][0]
            tangents |= self._needs[index][1]
        return uv_maps, tangents

    def _read(self, material: bpy.types.Material) -> Material:
        tree = node_tree_of(material)
        if tree is None:
            return Material(material.name, Node("diffuse", {"color": rgb(material.diffuse_color)}))
        owner = f"Material '{material.name}'"
        reader = Reader(tree, owner, self._images, self._warn)
        output = reader.output()
        if output is None:
            self._warn(
                f"{owner} has no Material Output node, so it is black: add one and link a shader to its Surface.")
            return Material(material.name)
        for name in ("Volume", "Displacement"):
            if reader.resolve(output.inputs[name])[0] is not None:
                self._warn(f"{owner}: {name.lower()} is not supported and is left out.")
        sampling = getattr(getattr(material, "cycles", None), "emission_sampling", "AUTO")
        return Material(material.name, reader.read(output.inputs["Surface"], None), sampling != "NONE")


def _needs(surface) -> tuple[set[str], set[str]]:
    """Names of the UV maps and of the tangents in a graph."""
    uv_maps: set[str] = set()
    tangents: set[str] = set()
    pending, seen = [surface], set()
    while pending:
        node = pending.pop()
        if not isinstance(node, Node) or id(node) in seen:
            continue
        seen.add(id(node))
        if node.kind == "uv":
            uv_maps.add(node.settings["uv_map"])
        elif node.kind == "image" and "vector" not in node.inputs:
            uv_maps.add("")
        elif node.kind == "normal_map" and node.settings["space"] == "TANGENT":
            tangents.add(node.settings["uv_map"])
        pending.extend(node.inputs.values())
    return uv_maps, tangents
