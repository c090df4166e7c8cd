# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Repeat zones, bundles, closures and switches of Blender 5 dissolve into formulas."""

import bpy
import numpy as np
import pytest

from sdf_lights.render.reference.nodes import Graph

pytestmark = pytest.mark.skipif(
    not hasattr(bpy.types, "NodeClosureOutput") or bpy.app.version < (5, 1, 0),
    reason="this Blender's shaders have no zones",
)

START, SCALE, SHIFT = np.array([0.5, 0.25, 1.0]), np.array([0.5, 0.75, 2.0]), np.array([0.125, 0.25, 0.5])


@pytest.fixture
def emitted(synced, add, quad, material):
    """Function: the constant colour that a vector of ``build(nodes, links)`` is emitted with, and the warnings."""

    def run(build):
        made, tree, output = material()
        emission = tree.nodes.new("ShaderNodeEmission")
        tree.links.new(build(tree.nodes, tree.links.new), emission.inputs["Color"])
        tree.links.new(emission.outputs[0], output)
        data = quad()
        data.materials.append(made)
        add("Quad", data)
        scene = synced()
        return Graph(scene.materials[scene.instances[0].materials[0]]).surface["color"], scene.warnings

    return run


def mapping(nodes):
    node = nodes.new("ShaderNodeMapping")
    node.inputs["Scale"].default_value, node.inputs["Location"].default_value = SCALE, SHIFT
    return node


def start(nodes):
    node = nodes.new("ShaderNodeMapping")
    node.inputs["Location"].default_value = START
    return node.outputs[0]


@pytest.mark.parametrize("rounds", [0, 1, 3])
def test_repeat_zone(emitted, rounds):
    def build(nodes, link):
        first, last = nodes.new("GeometryNodeRepeatInput"), nodes.new("GeometryNodeRepeatOutput")
        first.pair_with_output(last)
        last.repeat_items.new("VECTOR", "Value")
        first.inputs["Iterations"].default_value = rounds
        step = mapping(nodes)
        link(start(nodes), first.inputs["Value"])
        link(first.outputs["Value"], step.inputs["Vector"])
        link(step.outputs[0], last.inputs["Value"])
        return last.outputs["Value"]

    expected = START
    for _ in range(rounds):
        expected = expected * SCALE + SHIFT
    color, warnings = emitted(build)
    assert color == pytest.approx(expected) and warnings == []


def test_bundle(emitted):
    def build(nodes, link):
        packed, opened = nodes.new("NodeCombineBundle"), nodes.new("NodeSeparateBundle")
        for name in ("Other", "Value"):
            packed.bundle_items.new("VECTOR", name)
            opened.bundle_items.new("VECTOR", name)
        link(start(nodes), packed.inputs["Value"])
        link(packed.outputs[0], opened.inputs[0])
        return opened.outputs["Value"]

    color, warnings = emitted(build)
    assert color == pytest.approx(START) and warnings == []


def test_closure_that_is_evaluated_twice(emitted):
    def build(nodes, link):
        given, end = nodes.new("NodeClosureInput"), nodes.new("NodeClosureOutput")
        given.pair_with_output(end)
        end.input_items.new("VECTOR", "In")
        end.output_items.new("VECTOR", "Out")
        step = mapping(nodes)
        link(given.outputs["In"], step.inputs["Vector"])
        link(step.outputs[0], end.inputs["Out"])
        value = start(nodes)
        for _ in range(2):
            evaluated = nodes.new("NodeEvaluateClosure")
            evaluated.input_items.new("VECTOR", "In")
            evaluated.output_items.new("VECTOR", "Out")
            link(end.outputs[0], evaluated.inputs["Closure"])
            link(value, evaluated.inputs["In"])
            value = evaluated.outputs["Out"]
        return value

    color, warnings = emitted(build)
    assert color == pytest.approx((START * SCALE + SHIFT) * SCALE + SHIFT) and warnings == []


def test_menu_switch(emitted):
    def build(nodes, link):
        switch = nodes.new("GeometryNodeMenuSwitch")
        switch.data_type = "VECTOR"
        link(start(nodes), switch.inputs["Item_1"])
        switch.inputs["Menu"].default_value = switch.enum_items[1].name
        return switch.outputs["Output"]

    color, warnings = emitted(build)
    assert color == pytest.approx(START) and warnings == []
