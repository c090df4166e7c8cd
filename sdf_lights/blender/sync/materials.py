# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials, and the mesh data that their graphs need."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import bpy

from ...graph.formula import Vector
from ...render.material import SHARP_FACE, UNDISPLACED, Attribute, Material, Node, attributes_of
from ...render.nodes.normals import displaced_as_bump
from ...render.scene import Scene
from ..shader_trees import node_tree_of
from .aovs import aovs_of
from .common import Warnings, rgb
from .grids import Found
from .images import Images
from .nodes import Reader
from .volumes import default_medium, medium_of

# Cycles' surface without a material.
DEFAULT = "principled" if bpy.app.version >= (5, 0, 0) else "diffuse"


class Materials:
    """Adds each material to the scene once, or the material that overrides all of them in the view layer."""

    def __init__(self, scene: Scene, depsgraph: bpy.types.Depsgraph, images: Images, warn: Warnings):
        self._scene, self._depsgraph, self._images, self._warn = scene, depsgraph, images, warn
        self._override = depsgraph.view_layer_eval.material_override
        self._known: dict[tuple, int] = {}

    def index(self, material: bpy.types.Material | None) -> int:
        """Index of a material in the scene; None is Blender's default surface."""
        material = self._override or material
        if material is None:
            return self._add(None, None, lambda: Material("default_surface", Node(DEFAULT)))
        return self._add(material, None, lambda: self._read(material))

    def of_volume(self, slots: Iterable[bpy.types.Material | None], grids: Found) -> tuple[int, str] | None:
        """Index of the material of an object with these grids, and how it interpolates them. As in Cycles it is the
        first one with a volume; None if there is none. An object without a material has Cycles' default volume."""
        used = [self._override] if self._override else [material for material in slots if material is not None]
        if not used:
            surface, scaled = Node("transparent"), grids.in_object_space
            default = Material("default_volume", surface, medium=default_medium(scaled))
            return self._add(None, (grids.names, scaled), lambda: default), "LINEAR"
        for material in used:
            key = grids.names, grids.in_object_space
            index = self._add(material, key, lambda material=material: self._read(material, *key))
            if self._scene.materials[index].medium is not None:
                return index, interpolation_of(material)
        return None

    def _add(self, material: bpy.types.Material | None, grids: tuple | None, make: Callable[[], Material]) -> int:
        """Index of the material, made once for each set of ``grids``; None for surfaces."""
        key = 0 if material is None else material.as_pointer(), grids
        if key not in self._known:
            self._scene.materials.append(make())
            self._known[key] = len(self._scene.materials) - 1
        return self._known[key]

    def needs(self, indices: Iterable[int]) -> set[Attribute]:
        """Attributes that these materials look up."""
        materials = [self._scene.materials[index] for index in indices]
        found = set(attributes_of(materials, self._scene.attributes))
        return found | {SHARP_FACE} if any(material.displacement is not None for material in materials) else found

    def _read(
        self, material: bpy.types.Material, grids: frozenset[str] = frozenset(), in_object_space: bool = False
    ) -> Material:
        tree = node_tree_of(material)
        if tree is None:
            return Material(
                material.name, Node("diffuse", {"color": rgb(material.diffuse_color)}), index=material.pass_index
            )
        owner = f"Material '{material.name}'"
        reader = Reader(tree, owner, self._depsgraph, self._images, self._warn, material_index=material.pass_index)
        output = reader.output()
        if output is None:
            return Material(material.name)
        cycles = getattr(material, "cycles", None)  # exists only while the Cycles add-on is enabled
        sampling = getattr(cycles, "emission_sampling", "AUTO")
        surface, displacement, normal = reader.read(output.inputs["Surface"], None), None, None
        if reader.resolve(output.inputs["Displacement"])[0] is not None:
            moved = reader.read(output.inputs["Displacement"], (0.0, 0.0, 0.0))
            method = material.displacement_method
            if isinstance(moved, Vector) and method != "BUMP":
                displacement = moved
            if isinstance(surface, Node) and isinstance(moved, Vector) and method != "DISPLACEMENT":
                surface, normal = displaced_as_bump(
                    surface, moved, None if method == "BUMP" else reader.parametric(UNDISPLACED)
                )
        bounds, medium = reader.resolve(output.inputs["Volume"])[0] is not None, None
        if bounds:
            # Nodes are read again for the volume: inside a mesh, coordinates are not those of its surface.
            inner = Reader(
                tree,
                owner,
                self._depsgraph,
                self._images,
                self._warn,
                "VOLUME",
                material_index=material.pass_index,
                grids=grids,
                volume_interpolation=interpolation_of(material),
            )
            medium = medium_of(inner, output, owner, self._warn, in_object_space)
            if surface is None:
                surface = Node("transparent")  # the surface only bounds a volume
        return Material(
            material.name,
            surface,
            sampling != "NONE",
            reader.parameters,
            medium,
            displacement,
            material.displacement_method == "BOTH",
            normal,
            material.pass_index,
            aovs_of(tree, reader, self._scene.passes),
            material.use_transparent_shadow or bounds,  # as in Cycles
            getattr(cycles, "use_bump_map_correction", True),
        )


def interpolation_of(material: bpy.types.Material) -> str:
    """How a material interpolates grids of voxels: a key of ``lookups.GRID``."""
    return getattr(getattr(material, "cycles", None), "volume_interpolation", "LINEAR")
