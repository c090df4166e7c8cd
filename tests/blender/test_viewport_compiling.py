# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A number of a node that is changed while a viewport renders shows at once: nothing is compiled again."""

import time
from collections import OrderedDict

import bpy
import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.graph import codegen_native
from sdf_lights.render.interactive import Change, InteractiveRender

PATIENCE = 300.0  # machine code may have to be compiled first


@pytest.fixture
def viewport(file, synced, add, quad, material, monkeypatch):
    """The node tree of a floor that glows with noise, its output's socket, and a function that gives the viewport's
    picture of the scene as it is, and how many kernels and graphs were compiled for it."""
    monkeypatch.setattr(codegen_native, "_compiled", OrderedDict())  # which forgets graphs when there are many
    _, tree, output = material("Floor")
    glow = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(_noise(tree).outputs["Color"], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], output)
    data = quad()
    data.materials.append(bpy.data.materials["Floor"])
    add("Floor", data, scale=(5.0, 5.0, 1.0))
    file.scene.sdf_lights.device = "CPU"
    render = InteractiveRender()

    def compiled() -> int:
        return jit.compiled_kernels() + len(codegen_native._compiled)

    def shown() -> tuple[np.ndarray, int]:
        before, deadline = compiled(), time.monotonic() + PATIENCE
        render.update(synced(), Change.ALL)
        while not render.finished:
            assert not render.error and time.monotonic() < deadline, render.error or render.status
            time.sleep(0.005)
        return render.picture.pixels.copy(), compiled() - before

    yield tree, shown
    render.stop()


def _noise(tree):
    node = tree.nodes.new("ShaderNodeTexNoise")
    place = tree.nodes.new("ShaderNodeMapping")
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], place.inputs["Vector"])
    tree.links.new(place.outputs[0], node.inputs["Vector"])
    place.inputs["Scale"].default_value = (2.0, 3.0, 4.0)
    node.inputs["Roughness"].default_value = 0.6
    return node


def test_numbers_compile_nothing_and_nodes_do(viewport):
    tree, shown = viewport
    first, compiled = shown()
    assert first.max() > 0.0 and compiled > 0
    noise, place = tree.nodes["Noise Texture"], tree.nodes["Mapping"]
    for socket, value in (
        (noise.inputs["Scale"], 7.5),
        (noise.inputs["Roughness"], 0.3),
        (place.inputs["Scale"], (2.5, 3.5, 0.5)),
        (place.inputs["Rotation"], (0.2, 0.3, 0.4)),
        (tree.nodes["Emission"].inputs["Strength"], 2.5),
    ):
        before = shown()[0]
        socket.default_value = value
        after, compiled = shown()
        assert not np.array_equal(before, after), socket.name
        if socket.name not in ("Rotation", "Strength"):  # which leave 0 and 1, with which they were left out
            assert compiled == 0, socket.name
    for socket, value in (
        (place.inputs["Rotation"], (0.3, 0.1, 0.2)),
        (tree.nodes["Emission"].inputs["Strength"], 1.5),
    ):
        socket.default_value = value
        assert shown()[1] == 0, socket.name
    turned = tree.nodes.new("ShaderNodeInvert")
    tree.links.new(noise.outputs["Color"], turned.inputs["Color"])
    tree.links.new(turned.outputs[0], tree.nodes["Emission"].inputs["Color"])
    assert shown()[1] > 0
