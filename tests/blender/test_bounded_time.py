# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user waits for in Blender: panels, node trees with groups inside groups, and cancelling.

Times are of processors, so that other work on the machine does not count.
"""

import threading
import time

import bpy
import numpy as np
import pytest

from sdf_lights.blender import readout
from sdf_lights.blender.lamp import shape_of
from sdf_lights.blender.sync import sync

LONG_LOOP = "q = p\nfor i in range(1000):\n    q = q + 0.001 * sin({} * q)\nfield(length(q) - 1.5) & box(2)"


@pytest.fixture
def long_lamp(file, lamp):
    light = lamp()
    text = bpy.data.texts.new("Rounds")
    text.write(LONG_LOOP.format(3.25))
    light.sdf_lamp.source, light.sdf_lamp.text = "EXPRESSION", text
    return light


def waited(until, seconds=60.0) -> bool:
    end = time.monotonic() + seconds
    while not until() and time.monotonic() < end:
        time.sleep(0.02)
    return until()


def test_panels_do_not_wait(long_lamp):
    """What a panel needs at once takes less than a redraw may; the rest is found by a thread, coarse first."""
    from sdf_lights.emitter.building import build  # noqa: F401  (imports Numba, which the thread would do)

    started = time.thread_time()
    shape = shape_of(long_lamp.sdf_lamp)
    lines = readout.facts(shape, np.eye(4), long_lamp)
    assert "Volume: …" in lines
    finder = readout._Finder(shape, None)
    assert time.thread_time() - started < 0.2
    try:
        assert waited(lambda: finder.news) and (shape, None) in readout._found
        assert shape not in readout._certain and finder.busy  # it goes on
        assert readout.facts(shape, np.eye(4), long_lamp)[0].startswith("Volume: about")
    finally:
        started = time.process_time()
        finder.end()
    assert not finder.busy and time.process_time() - started < 0.5
    assert shape not in readout._certain
    readout._found.clear()


def test_what_panels_ask_for_is_found(file, lamp):
    light = lamp()
    light.sdf_lamp.source, light.sdf_lamp.expression = "EXPRESSION", "field(length(p) - 0.31) & box(1)"
    finder = readout._Finder(shape_of(light.sdf_lamp), None)
    assert waited(lambda: not finder.busy, 300.0)
    assert readout._certain[shape_of(light.sdf_lamp)] is True
    assert not [thread for thread in threading.enumerate() if "readout" in thread.name]
    readout._found.clear()
    readout._certain.clear()


def groups(levels: int, each: int) -> bpy.types.NodeTree:
    """A group with ``each`` of the next in it, one feeding the other, and so on."""
    inner = None
    for level in range(levels):
        tree = bpy.data.node_groups.new("Nested", "ShaderNodeTree")
        tree.interface.new_socket("in", in_out="INPUT", socket_type="NodeSocketFloat")
        tree.interface.new_socket("out", in_out="OUTPUT", socket_type="NodeSocketFloat")
        start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        source = start.outputs[0]
        for _ in range(each):
            part = tree.nodes.new("ShaderNodeGroup" if inner else "ShaderNodeMath")
            if inner:
                part.node_tree = inner
            tree.links.new(source, part.inputs[0])
            source = part.outputs[0]
        tree.links.new(source, end.inputs[0])
        inner = tree
    return inner


@pytest.mark.parametrize(
    "levels, each", [(2, 200), (60, 1), (300, 1), (12, 2), (16, 2), (5, 8)], ids=lambda number: str(number)
)
@pytest.mark.parametrize("socket", ["Roughness", "Base Color"])
def test_groups_inside_groups_answer_within_a_second(stage, levels, each, socket):
    """Hundreds of groups, one in another or side by side, and groups that double at each level.

    Blender itself takes minutes to make 30 levels of two groups each.
    """
    material = bpy.data.materials.new("Nested")
    material.use_nodes = True
    group = material.node_tree.nodes.new("ShaderNodeGroup")
    group.node_tree = groups(levels, each)
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    material.node_tree.links.new(group.outputs[0], shader.inputs[socket])
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    mesh.data.materials.clear()
    mesh.data.materials.append(material)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    sync(depsgraph)  # what only the first synchronisation pays
    started = time.process_time()
    scene = sync(depsgraph)
    taken = time.process_time() - started
    assert len(scene.warnings) <= 1 and all("Material 'Nested'" in warning for warning in scene.warnings)
    assert taken < 1.0
