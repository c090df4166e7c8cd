# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random trees of groups, reroutes, muted nodes and repeat zones are what Blender makes of them, which takes such trees
apart itself since 5.0."""

import random

import bpy
import numpy as np
import pytest

from sdf_lights.blender.sync.common import Warnings
from sdf_lights.blender.sync.nodes import Reader
from sdf_lights.graph.formula import Vector
from sdf_lights.graph.numpy_evaluation import Inputs, evaluate_inputs
from sdf_lights.render.material import Material
from sdf_lights.render.reference.nodes import Graph

pytestmark = pytest.mark.skipif(
    not hasattr(bpy.types, "InlineShaderNodes"), reason="this Blender does not take trees apart for others"
)

ZONES = bpy.app.version >= (5, 1, 0)
SEEDS = range(130), pytest.param(range(130, 350), marks=pytest.mark.slow)
NODES, DEEPEST, POINTS = 7, 3, 4
NEAR = 2e-4  # Blender rounds the weights of a luminance to four digits, and computes in single precision
KINDS = {"Float": "VALUE", "Vector": "VECTOR", "Color": "RGBA"}
# Of each kind of node its settings, of which one is chosen. None gives infinite numbers, and Blender computes each
# itself where its inputs are constants: a constant is converted by sockets of groups and muted nodes, what varies is
# not.
PLAIN = {
    "ShaderNodeMath": ("operation", ("ADD", "MULTIPLY", "SUBTRACT", "MINIMUM", "MAXIMUM", "SINE", "MULTIPLY_ADD")),
    "ShaderNodeVectorMath": ("operation", ("ADD", "MULTIPLY", "CROSS_PRODUCT", "DOT_PRODUCT", "SCALE", "ABSOLUTE")),
    "ShaderNodeMix": ("data_type", ("FLOAT", "VECTOR", "RGBA")),
    "ShaderNodeMapRange": ("clamp", (True, False)),
    "ShaderNodeClamp": ("clamp_type", ("MINMAX", "RANGE")),
    "ShaderNodeCombineXYZ": None,
    "ShaderNodeSeparateXYZ": None,
    "ShaderNodeNewGeometry": None,
}


class Tree:
    """Fills a node tree with nodes whose inputs are linked to outputs of those before, or have values of their own."""

    def __init__(self, tree: bpy.types.NodeTree, chance: random.Random, depth: int):
        self.tree, self.chance, self.depth = tree, chance, depth
        self.pool: list[bpy.types.NodeSocket] = []

    def fill(self) -> None:
        for _ in range(NODES):
            kind = self.chance.random()
            if kind < 0.2 and self.depth < DEEPEST:
                self._group()
            elif kind < 0.3 and ZONES:
                self._repeat()
            else:
                self._plain()

    def any(self) -> bpy.types.NodeSocket:
        """An output, through a reroute now and then."""
        socket = self.chance.choice(self.pool)
        if self.chance.random() < 0.2:
            reroute = self.tree.nodes.new("NodeReroute")
            self.tree.links.new(socket, reroute.inputs[0])
            socket = reroute.outputs[0]
        return socket

    def link_inputs(self, node: bpy.types.Node) -> None:
        for socket in node.inputs:
            if socket.is_unavailable or socket.type not in KINDS.values():
                continue
            if self.pool and self.chance.random() < 0.6:
                self.tree.links.new(self.any(), socket).is_muted = self.chance.random() < 0.05
            if socket.type == "VALUE":
                socket.default_value = self.chance.uniform(-1.0, 1.0)
            else:
                socket.default_value = [self.chance.uniform(-1.0, 1.0) for _ in socket.default_value]

    def add(self, node: bpy.types.Node) -> None:
        self.link_inputs(node)
        node.mute = self.chance.random() < 0.15
        self.pool += [socket for socket in node.outputs if not socket.is_unavailable and socket.type in KINDS.values()]

    def _plain(self) -> None:
        name = self.chance.choice(list(PLAIN))
        node = self.tree.nodes.new(name)
        if PLAIN[name] is not None:
            setting, values = PLAIN[name]
            setattr(node, setting, self.chance.choice(values))
        if name == "ShaderNodeNewGeometry":
            self.pool += [node.outputs["Position"], node.outputs["Normal"]]
            return
        self.add(node)

    def _group(self) -> None:
        tree = bpy.data.node_groups.new("Group", "ShaderNodeTree")
        for side in ("INPUT", "OUTPUT"):
            for number in range(self.chance.randint(1, 3)):
                kind = self.chance.choice(list(KINDS))
                tree.interface.new_socket(f"{side} {number}", in_out=side, socket_type=f"NodeSocket{kind}")
        inner = Tree(tree, self.chance, self.depth + 1)
        begin, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        inner.pool += [socket for socket in begin.outputs if socket.type in KINDS.values()]
        inner.fill()
        inner.link_inputs(end)
        for _ in range(self.chance.randint(1, 2)):
            node = self.tree.nodes.new("ShaderNodeGroup")
            node.node_tree = tree
            self.add(node)

    def _repeat(self) -> None:
        nodes, link = self.tree.nodes, self.tree.links.new
        first, last = nodes.new("GeometryNodeRepeatInput"), nodes.new("GeometryNodeRepeatOutput")
        first.pair_with_output(last)
        last.repeat_items.clear()
        last.repeat_items.new("VECTOR", "Value")
        self.link_inputs(first)
        for taken in list(first.inputs["Iterations"].links):
            self.tree.links.remove(taken)
        first.inputs["Iterations"].default_value = self.chance.randint(0, 3)
        step = nodes.new("ShaderNodeVectorMath")
        step.operation = "MULTIPLY_ADD"
        for socket in step.inputs[1:3]:
            socket.default_value = [self.chance.uniform(-1.0, 1.0) for _ in range(3)]
        link(first.outputs["Value"], step.inputs[0])
        link(step.outputs[0], last.inputs["Value"])
        self.pool.append(last.outputs["Value"])


class Anywhere(Inputs):
    """Points of no surface: numbers for what formulas ask for, the same for the same names."""

    def variable(self, name: str, component: int) -> np.ndarray:
        return np.random.default_rng([component, *name.encode()]).uniform(-1.0, 1.0, POINTS)


def emitted(tree: bpy.types.NodeTree) -> tuple[np.ndarray, list[str]]:
    """The colour (3, POINTS) that a material emits, and the warnings."""
    warnings: list[str] = []
    reader = Reader(tree, "Material", bpy.context.evaluated_depsgraph_get(), None, Warnings(warnings))
    surface = reader.read(reader.output().inputs["Surface"], None)
    color = Graph(Material("Material", surface, parameters=reader.parameters)).surface["color"]
    if isinstance(color, Vector):
        color = evaluate_inputs(tuple(color), Anywhere())
    return np.stack([np.broadcast_to(value, POINTS) for value in color]), warnings


@pytest.mark.parametrize("seeds", SEEDS, ids=str)
def test_random_trees_are_what_blender_makes_of_them(seeds, file, material):
    different, varied = [], 0
    for seed in seeds:
        made, tree, output = material(f"Seed {seed}")
        random_tree = Tree(tree, random.Random(seed), 0)
        random_tree.fill()
        emission = tree.nodes.new("ShaderNodeEmission")
        tree.links.new(random_tree.any(), emission.inputs["Color"])
        tree.links.new(emission.outputs[0], output)
        inlined = bpy.types.InlineShaderNodes.from_material(made)
        (ours, said), (theirs, _) = emitted(tree), emitted(inlined.node_tree)
        varied += len(np.unique(ours)) > 1
        if said or not np.allclose(ours, theirs, rtol=NEAR, atol=NEAR):
            different.append((seed, said, ours[:, 0], theirs[:, 0]))
    assert different == [], [row[0] for row in different]
    assert varied > len(seeds) // 3
