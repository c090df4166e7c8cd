# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of values drawn at random: any node in any mode, linked to sockets of any kind, in groups, muted, and with
unusual numbers.

They know no node by its name: nodes, modes and sockets are those of the running Blender. ``node_recipes`` gives nodes
the data that they need.
"""

from __future__ import annotations

import functools
import random
from dataclasses import dataclass

import bpy

from . import node_data
from .node_cases import CLOSURE, Case, scratch
from .node_cases import nodes as compared_nodes
from .node_recipes import BACK, BALL, BOX, PLANE, RECIPES

MOST_NODES = 14  # of a tree with its groups
DEEPEST_GROUP = 2
VALUES = {"VALUE", "VECTOR", "RGBA", "INT", "BOOLEAN"}
GROUP_SOCKETS = ("NodeSocketFloat", "NodeSocketVector", "NodeSocketColor", "NodeSocketInt", "NodeSocketBool")
USUAL = (0.0, 1.0, -1.0, 0.5, 2.0)
# Nodes that send rays have noise; displacement is no value.
NO_VALUES = {"ShaderNodeAmbientOcclusion", "ShaderNodeBevel", "ShaderNodeDisplacement", "ShaderNodeVectorDisplacement"}


@functools.cache
def value_nodes() -> tuple[str, ...]:
    """bl_idname of each node of this Blender that gives values."""
    with scratch() as tree:
        return tuple(
            name
            for name in compared_nodes()
            if name not in NO_VALUES and any(socket.type in VALUES for socket in tree.nodes.new(name).outputs)
        )


class Tree:
    """Nodes drawn at random for a node tree; ``outputs`` are those of the tree itself, in the order in which they were
    made."""

    def __init__(self, numbers: random.Random, tree: bpy.types.NodeTree, left: int = MOST_NODES, depth: int = 0):
        self.numbers, self.tree, self.left, self.depth = numbers, tree, left, depth
        self.outputs: list[bpy.types.NodeSocket] = []

    def value(self) -> bpy.types.NodeSocket:
        """The output of a new node, or of one that is there."""
        numbers = self.numbers
        if self.outputs and (self.left <= 0 or numbers.random() < 0.2):
            return numbers.choice(self.outputs)
        self.left -= 1
        if self.depth < DEEPEST_GROUP and numbers.random() < 0.12:
            node = self._group()
        else:
            node = self._node(numbers.choice(value_nodes()))
        made = [socket for socket in node.outputs if socket.enabled and socket.type in VALUES]
        if not made:
            return self.value()
        found = numbers.choice(made)
        if numbers.random() < 0.1:
            reroute = self.tree.nodes.new("NodeReroute")
            self.tree.links.new(found, reroute.inputs[0])
            found = reroute.outputs[0]
        self.outputs.append(found)
        return found

    def _node(self, kind: str) -> bpy.types.Node:
        node = self.tree.nodes.new(kind)
        self._settings(node)
        self._feed(node)
        node.mute = self.numbers.random() < 0.06
        return node

    def _feed(self, node) -> None:
        """Links and values of a node's inputs."""
        numbers = self.numbers
        for socket in node.inputs:
            if not socket.enabled or socket.type not in VALUES | {"ROTATION"}:
                continue
            if socket.type in VALUES and self.left > 0 and numbers.random() < 0.45:
                self.tree.links.new(self.value(), socket)
            elif numbers.random() < 0.6:
                self.set(socket)

    def set(self, socket) -> None:
        """Give a socket a value of its own."""
        if socket.type == "BOOLEAN":
            socket.default_value = self.numbers.random() < 0.5
        elif socket.type == "INT":
            socket.default_value = self.numbers.randint(-3, 6)
        else:
            self._number_or_numbers(socket)

    def _number_or_numbers(self, owner) -> None:
        if hasattr(owner.default_value, "__len__"):
            owner.default_value = [self._number() for _ in owner.default_value]
        else:
            owner.default_value = self._number()

    def _number(self) -> float:
        numbers = self.numbers
        kind = numbers.random()
        if kind < 0.25:
            return numbers.choice(USUAL)
        return numbers.uniform(0.0, 1.0) if kind < 0.6 else numbers.uniform(-3.0, 5.0)

    def _settings(self, node) -> None:
        numbers = self.numbers
        recipe = RECIPES.get(node.bl_idname)
        if recipe is not None and recipe.prepare is not None and numbers.random() < 0.9:
            recipe.prepare(node, numbers.choice(list(_variants(node, recipe)) or [""]))
        common = bpy.types.Node.bl_rna.properties.keys()
        for item in node.bl_rna.properties:
            if item.identifier in common or item.is_readonly or numbers.random() < 0.4:
                continue
            if item.type == "ENUM" and not item.is_enum_flag and item.enum_items:
                self._set(node, item.identifier, numbers.choice(item.enum_items.keys()))
            elif item.type == "BOOLEAN" and not item.is_array:
                self._set(node, item.identifier, numbers.random() < 0.5)
            elif item.type in ("INT", "FLOAT") and not item.is_array:
                low, high = max(item.soft_min, -2.0), min(item.soft_max, 6.0)
                chosen = numbers.uniform(low, max(low, high))
                self._set(node, item.identifier, round(chosen) if item.type == "INT" else chosen)
        if node.bl_idname == "ShaderNodeTexSky":
            node.sun_disc = False  # smaller than a pixel
        if hasattr(node, "mode") and node.bl_idname == "ShaderNodeTexIES":
            node.mode = "INTERNAL"
        if hasattr(node, "color_ramp"):
            self._ramp(node.color_ramp)
        if hasattr(node, "mapping"):
            self._curves(node.mapping)
        if hasattr(node, "texture_mapping") and numbers.random() < 0.15:
            self._mapping(node.texture_mapping)
        for socket in node.outputs:
            if not socket.is_unavailable and node.bl_idname in OWN_VALUES:
                self.set(socket)

    @staticmethod
    def _set(owner, name: str, value) -> None:
        try:
            setattr(owner, name, value)
        except TypeError:  # an item of the enumeration that this node does not have
            pass

    def _enumerations(self, owner) -> None:
        for item in owner.bl_rna.properties:
            if item.type == "ENUM" and not item.is_readonly:
                self._set(owner, item.identifier, self.numbers.choice(item.enum_items.keys()))

    def _ramp(self, ramp) -> None:
        numbers = self.numbers
        self._enumerations(ramp)
        while len(ramp.elements) > 1:
            ramp.elements.remove(ramp.elements[0])
        count = numbers.choice((1, 2, 2, 3, 4, 7))
        places = [numbers.choice((0.0, 1.0, 0.5, numbers.random(), numbers.random())) for _ in range(count)]
        ramp.elements[0].position = places[0]
        for place in places[1:]:
            ramp.elements.new(place)
        for element in ramp.elements:
            element.color = [numbers.uniform(0.0, 1.2) for _ in "rgba"]

    def _curves(self, mapping) -> None:
        numbers = self.numbers
        self._enumerations(mapping)
        mapping.use_clip = numbers.random() < 0.5
        if not mapping.use_clip:
            for curve in mapping.curves:
                for _ in range(numbers.choice((0, 1, 1, 2, 4))):
                    point = curve.points.new(numbers.uniform(-1.0, 1.5), numbers.uniform(-1.0, 2.0))
                    point.handle_type = numbers.choice(("AUTO", "VECTOR", "AUTO_CLAMPED"))
        else:
            for curve in mapping.curves:
                for _ in range(numbers.choice((0, 1, 2))):
                    curve.points.new(numbers.random(), numbers.random())
        mapping.update()

    def _mapping(self, mapping) -> None:
        numbers = self.numbers
        mapping.vector_type = numbers.choice(("POINT", "TEXTURE", "VECTOR", "NORMAL"))
        mapping.translation = [numbers.uniform(-1.0, 1.0) for _ in "xyz"]
        mapping.rotation = [numbers.uniform(-3.0, 3.0) for _ in "xyz"]
        # Where a scale of zero divides, only rounding counts.
        least = 0.0 if mapping.vector_type in ("POINT", "VECTOR") else 0.1
        mapping.scale = [numbers.choice((least, 1.0, -0.5, 2.0, numbers.uniform(0.2, 2.0))) for _ in "xyz"]
        for axis in "xyz":
            if numbers.random() < 0.3:
                setattr(mapping, f"mapping_{axis}", numbers.choice(("NONE", "X", "Y", "Z")))

    def _group(self) -> bpy.types.Node:
        """A group of random nodes, with inputs that are linked and others that are not."""
        numbers = self.numbers
        made = bpy.data.node_groups.new("Group", "ShaderNodeTree")
        for place in range(numbers.randint(0, 3)):
            item = made.interface.new_socket(f"In {place}", in_out="INPUT", socket_type=numbers.choice(GROUP_SOCKETS))
            item.hide_value = numbers.random() < 0.2
            if item.socket_type in GROUP_SOCKETS[:3]:
                self._number_or_numbers(item)
        count = numbers.randint(1, 2)
        for place in range(count):
            made.interface.new_socket(f"Out {place}", in_out="OUTPUT", socket_type=numbers.choice(GROUP_SOCKETS[:3]))
        inner = Tree(numbers, made, min(self.left, 5), self.depth + 1)
        entry, end = made.nodes.new("NodeGroupInput"), made.nodes.new("NodeGroupOutput")
        inner.outputs += [socket for socket in entry.outputs if socket.type in VALUES]
        for socket in end.inputs:
            if socket.type in VALUES and numbers.random() < 0.9:
                made.links.new(inner.value(), socket)
            elif socket.type in VALUES:
                self.set(socket)
        self.left -= min(self.left, 5) - inner.left
        node = self.tree.nodes.new("ShaderNodeGroup")
        node.node_tree = made
        self._feed(node)
        node.mute = numbers.random() < 0.05
        return node


OWN_VALUES = {"ShaderNodeValue", "ShaderNodeRGB", "ShaderNodeNormal"}


def _variants(node, recipe):
    """Variants that give a node other data."""
    return {
        "ShaderNodeTexImage": node_data.IMAGES,
        "ShaderNodeAttribute": node_data.ATTRIBUTES,
    }.get(node.bl_idname, recipe.variants)


@dataclass(frozen=True)
class RandomCase(Case):
    """The tree of a seed; ``place`` is VALUE. ``output``: which of its values is looked at, from the last one on."""

    seed: int = 0
    back: int = 0

    @property
    def name(self) -> str:
        return f"Random {self.seed}" + (f" -{self.back}" if self.back else "")

    def build(self, graph) -> bpy.types.NodeSocket:
        made = self.tree(graph.material.node_tree)
        return made.outputs[-1 - self.back]

    def tree(self, tree: bpy.types.NodeTree) -> Tree:
        """The nodes, in an empty tree."""
        made = Tree(random.Random(self.seed), tree)
        made.value()
        return made


def case(seed: int, back: int = 0) -> RandomCase:
    shape = random.Random(f"shape {seed}").choice((PLANE, BACK, BALL, BOX))
    return RandomCase("Random", shape=shape, seed=seed, back=back)


# -- closures ----------------------------------------------------------------------------------------------------------

# Of hair, without a definition by its node alone, or a closure of another place.
NO_SURFACES = {"Background", "BsdfHair", "BsdfHairPrincipled", "BsdfRayPortal", "EeveeSpecular", "Holdout", "Script"}
RANGES = {  # of numbers of closures; all others are between 0 and 1
    "IOR": (1.0, 2.5),
    "Coat IOR": (1.0, 2.0),
    "Thin Film IOR": (1.0, 2.0),
    "Thin Film Thickness": (0.0, 900.0),
    "Scale": (0.02, 0.5),
    "Subsurface Scale": (0.02, 0.5),
    "Strength": (0.0, 2.0),
    "Anisotropy": (-1.0, 1.0),
}


@functools.cache
def surfaces() -> tuple[str, ...]:
    """bl_idname of each closure of a surface, without mixes."""
    with scratch() as tree:
        found = {name: tree.nodes.new(name).outputs for name in compared_nodes()}
        return tuple(
            name
            for name, outputs in found.items()
            if name.removeprefix("ShaderNode") not in NO_SURFACES
            and not name.startswith("ShaderNodeVolume")
            and any(socket.type == "SHADER" for socket in outputs)
            and name not in ("ShaderNodeMixShader", "ShaderNodeAddShader")
        )


def closure(tree: Tree, depth: int = 0) -> bpy.types.NodeSocket:
    """A closure, or a mix or sum of some."""
    numbers = tree.numbers
    kind = numbers.random()
    if depth < 2 and kind < 0.3:
        made = tree.tree.nodes.new("ShaderNodeMixShader" if kind < 0.22 else "ShaderNodeAddShader")
        for socket in made.inputs:
            if socket.type == "SHADER":
                if numbers.random() < 0.95:
                    tree.tree.links.new(closure(tree, depth + 1), socket)
            elif numbers.random() < 0.5:
                tree.tree.links.new(tree.value(), socket)
            else:
                socket.default_value = numbers.random()
        return made.outputs[0]
    name = "ShaderNodeBsdfPrincipled" if numbers.random() < 0.5 else numbers.choice(surfaces())
    made = tree.tree.nodes.new(name)
    for item in made.bl_rna.properties:
        if item.type == "ENUM" and not item.is_readonly and item.identifier not in bpy.types.Node.bl_rna.properties:
            tree._set(made, item.identifier, numbers.choice(item.enum_items.keys()))
    for socket in made.inputs:
        if not socket.enabled or socket.type not in VALUES or numbers.random() < 0.5:
            continue
        if numbers.random() < 0.2:
            tree.tree.links.new(tree.value(), socket)
        elif socket.hide_value or socket.type == "BOOLEAN":
            continue
        elif socket.type == "VALUE":
            socket.default_value = numbers.uniform(*RANGES.get(socket.name, (0.0, 1.0)))
        else:
            socket.default_value = [numbers.uniform(0.05, 0.95) for _ in socket.default_value]
    return made.outputs[0]


@dataclass(frozen=True)
class RandomClosure(Case):
    """The closures of a seed, on a lit ball."""

    seed: int = 0

    @property
    def name(self) -> str:
        return f"Random closure {self.seed}"

    def build(self, graph) -> bpy.types.NodeSocket:
        tree = Tree(random.Random(self.seed), graph.material.node_tree, left=5)
        return closure(tree)


def closure_case(seed: int) -> RandomClosure:
    return RandomClosure("Random", place=CLOSURE, shape=BALL, seed=seed)
