# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One small graph for each shader node in each of its modes, for comparison with Cycles.

Nodes, modes and outputs are those of the running Blender: a node or mode of a new version gets a case without a change
here. ``node_recipes`` has the inputs with which a node shows structure, the modes that have no effect together, and the
nodes that are not compared, with the reason. ``node_specials`` has cases of more than one node.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import bpy

from sdf_lights.blender.shader_trees import use_nodes

from . import node_structures  # noqa: F401  (adds its cases)
from .node_recipes import BALL, LEFT_OUT, PLANE, RECIPES, Recipe
from .node_sources import Sources
from .node_specials import SPECIALS

MOST_TOGETHER = 64  # combinations of modes of an unknown node; if there are more, modes are tested one by one
# Cases that differ from Cycles, and the reason.
EXPLAINED = {
    "Bevel Normal": "the mean of four normals depends on the sampling pattern: Cycles' own patterns differ as much",
    "NewGeometry Parametric": "triangles are as small as pixels: a hundredth of a pixel beside is another one",
    **dict.fromkeys(
        ("BsdfHair BSDF", *(f"BsdfHairPrincipled {model}BSDF" for model in ("", "HUANG ", "HUANG ABSORPTION "))),
        "light rays do not see all directions that fibers draw, so the light of a wide sun depends on how both are weighted: "
        "where drawn rays do not find its sun, Cycles' own pictures lose 3 to 20 %",
    ),
    "Tangent without UVs": "tangents of a sphere's coordinates jump at its seam and turn fast at its poles; the 99th percentile is "
    "1.1 % in Blender 5.2, where moved rays change our own picture as much, and 1.3 % in 5.0",
    "Group with an unlinked tangent": "a tangent without a length gives no finite numbers in Cycles since Blender 5.0, so it is black",
    **dict.fromkeys(
        (f"Volume{kind} FOURNIER_FORAND Volume" for kind in ("Coefficients", "Scatter")),
        "Henyey and Greenstein's phase function with the same mean stands for this one, and the render says so",
    ),
}
ABSTRACT = {"ShaderNode", "ShaderNodeCustomGroup", "ShaderNodeTree"}
# The link target of a node's output.
VALUE, RAYS, SCATTERED, CLOSURE, VOLUME, DISPLACEMENT, WORLD, LIGHT = (
    "value",
    "rays",
    "scattered",
    "closure",
    "volume",
    "displacement",
    "world",
    "light",
)


@dataclass(frozen=True)
class Case:
    """A node with certain modes, of which one output is examined; ``variant`` names other inputs of its recipe.

    ``place`` is the link target of that output: an Emission on a tile (``value``; ``rays`` if the node traces some), or
    inside glass, so that scattered rays see it, too; the surface, volume or displacement of a lit object; a world; a
    light.
    """

    node: str
    modes: tuple[tuple[str, object], ...] = ()
    output: str = ""
    variant: str = ""
    place: str = VALUE
    shape: str = PLANE

    @property
    def name(self) -> str:
        words = [
            self.node.removeprefix("ShaderNode"),
            *(_word(*mode) for mode in self.modes),
            self.output,
            self.variant,
            "scattered" if self.place == SCATTERED else "",
        ]
        return " ".join(word for word in words if word)

    def build(self, graph) -> bpy.types.NodeSocket:
        """The nodes, in a ``scenery.materials.Graph``; returns the examined output."""
        sources = Sources(graph)
        if self.node in SPECIALS:
            return SPECIALS[self.node].build(sources)
        node = graph.nodes.new(self.node)
        recipe = RECIPES.get(self.node, Recipe())
        if recipe.prepare:
            recipe.prepare(node, self.variant)
        set_modes(node, self.modes)
        feeds = dict(recipe.feeds)
        for _, value in self.modes:
            feeds |= recipe.instead.get(value, {})
        feeds |= recipe.variants.get(self.variant, {})
        set_modes(node, settings_of(feeds))
        for socket in node.inputs:
            if socket.enabled and socket.identifier in feeds:
                sources.feed(socket, feeds[socket.identifier])
            elif socket.enabled and self.node not in RECIPES:
                sources.feed_by_type(socket)
        return next(socket for socket in node.outputs if socket.identifier == self.output)


def _word(name: str, value) -> str:
    if isinstance(value, bool):
        return name.split(".")[-1] if value else f"not {name.split('.')[-1]}"
    return str(value)


def settings_of(feeds: dict) -> list[tuple[str, object]]:
    """The feeds of a variant that are settings: names with a dot before them."""
    return [(name[1:], value) for name, value in feeds.items() if name.startswith(".")]


def set_modes(node, modes) -> None:
    """Settings by name; a name with dots leads to a setting of a setting, such as ``color_ramp.interpolation``."""
    for name, value in modes:
        owner, last = _owner(node, name)
        setattr(owner, last, value)


def _owner(node, name: str):
    *path, last = name.split(".")
    for part in path:
        node = getattr(node, part)
    return node, last


@contextlib.contextmanager
def scratch() -> Iterator[bpy.types.NodeTree]:
    """A material's node tree for experiments with nodes."""
    material = bpy.data.materials.new("Scratch")
    try:
        yield use_nodes(material)
    finally:
        bpy.data.materials.remove(material)


def nodes() -> list[str]:
    """bl_idname of each shader node of this Blender that is compared."""
    return [
        name
        for name in sorted(dir(bpy.types))
        if name.startswith("ShaderNode") and name not in ABSTRACT and name not in LEFT_OUT
    ]


def cases() -> list[Case]:
    """All of them, in alphabetical order of the nodes."""
    found = [
        Case(name, place=special.place, shape=special.shape)
        for name, special in SPECIALS.items()
        if special.since <= bpy.app.version
    ]
    with scratch() as tree:
        for name in nodes():
            found += _cases_of(tree, name)
    by_name = {case.name: case for case in found}
    return list(by_name.values())


def _cases_of(tree: bpy.types.NodeTree, name: str) -> list[Case]:
    recipe = RECIPES.get(name, Recipe())
    found, first = [], True
    for modes in _combinations(tree, name, recipe):
        node = tree.nodes.new(name)
        if recipe.prepare:
            recipe.prepare(node, "")
        try:
            set_modes(node, modes)
        except TypeError:  # an item of the enumeration that shader trees do not have
            tree.nodes.remove(node)
            continue
        found += _outputs(node, recipe, modes, "", all_of_them=first)
        first = False
        tree.nodes.remove(node)
    for variant, feeds in (recipe.variants | {name: {} for name in recipe.shapes}).items():
        node = tree.nodes.new(name)
        if recipe.prepare:
            recipe.prepare(node, variant)
        names = {socket.identifier for socket in node.inputs} | {socket.identifier for socket in node.outputs}
        try:
            set_modes(node, settings_of(feeds))
        except (TypeError, AttributeError):  # of another version of Blender
            continue
        if all(key.startswith(".") or key in names for key in feeds):
            found += _outputs(node, recipe, (), variant, all_of_them=True)
        tree.nodes.remove(node)
    return found


def _outputs(node, recipe: Recipe, modes, variant: str, all_of_them: bool) -> list[Case]:
    """A case for each examined output."""
    found = []
    for socket in node.outputs:
        wanted = all_of_them or recipe.outputs is None or socket.identifier in recipe.outputs
        if not socket.enabled or not wanted or socket.type == "CUSTOM":
            continue
        place, shape = VALUE, PLANE
        if socket.type == "SHADER":
            place, shape = (VOLUME if "Volume" in socket.identifier else CLOSURE), BALL
        elif socket.identifier == "Displacement":
            place, shape = DISPLACEMENT, BALL
        elif recipe.rays:
            place = RAYS
        given = recipe.shape(_all_settings(node)) if callable(recipe.shape) else recipe.shape
        shape = recipe.shapes.get(variant) or given or shape
        found.append(Case(node.bl_idname, tuple(modes), socket.identifier, variant, place, shape))
        if recipe.scattered:
            found.append(Case(node.bl_idname, tuple(modes), socket.identifier, variant, SCATTERED, BALL))
    return found


def _all_settings(node) -> dict:
    return {name: getattr(node, name) for name in _enumerations(node) + _switches(node)}


def _own(node) -> list:
    common = bpy.types.Node.bl_rna.properties.keys()
    return [item for item in node.bl_rna.properties if item.identifier not in common and not item.is_readonly]


def _enumerations(node) -> list[str]:
    return [item.identifier for item in _own(node) if item.type == "ENUM"]


def _switches(node) -> list[str]:
    return [item.identifier for item in _own(node) if item.type == "BOOLEAN" and not item.is_array]


def _combinations(tree: bpy.types.NodeTree, name: str, recipe: Recipe) -> list[tuple[tuple[str, object], ...]]:
    """Settings that differ from the node's defaults; the first of them is empty."""
    node = tree.nodes.new(name)
    if recipe.prepare:
        recipe.prepare(node, "")
    options = {}
    for key in _enumerations(node):
        options[key] = [item.identifier for item in node.bl_rna.properties[key].enum_items]
    for key in _switches(node):
        options[key] = [False, True]
    for key, items in recipe.nested.items():
        owner, last = _owner(node, key)
        options[key] = list(items or (item.identifier for item in owner.bl_rna.properties[last].enum_items))
    options = {key: items for key, items in options.items() if key not in recipe.ignored}
    normal = {}
    for key in options:
        owner, last = _owner(node, key)
        normal[key] = getattr(owner, last)
    together = [
        key
        for key in options
        if (key in recipe.together if recipe.together is not None else not isinstance(normal[key], bool))
    ]
    products = list(itertools.product(*(options[key] for key in together)))
    if name not in RECIPES and len(products) > MOST_TOGETHER:
        products, together = [], []
    found = [normal | dict(zip(together, items)) for items in products]
    found += [normal | {key: item} for key in options if key not in together for item in options[key]]
    tree.nodes.remove(node)
    changes = [
        tuple((key, value) for key, value in settings.items() if value != normal[key])
        for settings in found
        if recipe.matters(settings)
    ]
    return sorted(dict.fromkeys([(), *changes]), key=len)
