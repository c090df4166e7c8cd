# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every shader node of the running Blender is modelled, by all three back ends."""

import bpy
import numpy as np
import pytest
from benchmarks import node_cases, node_pictures, node_scenes, pictures
from benchmarks.node_cases import CLOSURE, SCATTERED, VALUE, VOLUME

from sdf_lights import jit
from sdf_lights.blender.sync import closure_nodes, sync, volumes
from sdf_lights.render.film import Film
from sdf_lights.render.gpu.packed_scene import GpuScene
from sdf_lights.render.nodes import DEFINITIONS

SIZE = 6  # pixels a side of a node's tile
DIFFERENCE = 0.01
REFUSED = {"ShaderNodeShaderToRGB"}  # Cycles does not have it either


def first_cases(places: set[str]) -> list[node_cases.Case]:
    """One case of each node that has one in these places."""
    wanted = set(node_cases.nodes()) - REFUSED
    found = (case for case in reversed(node_cases.cases()) if case.place in places and case.node in wanted)
    return list({case.node: case for case in found}.values())


def built(cases) -> node_scenes.Grid:
    """Open a file with the cases."""
    grid = node_scenes.grid_of(cases, SIZE)
    _, problems = node_scenes.build(grid)
    assert problems == {}
    return grid


def test_every_node_is_a_value_a_closure_or_a_volume():
    known = DEFINITIONS.keys() | closure_nodes.CLOSURES.keys() | volumes.SHADERS.keys()
    assert set(node_cases.nodes()) - known == REFUSED


@pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")
@pytest.mark.parametrize("places", [{VALUE}, {CLOSURE, SCATTERED, VOLUME}], ids=["values", "closures"])
def test_the_gpu_has_every_node(places):
    cases = first_cases(places)
    grid = built(cases)
    scene = sync(bpy.context.evaluated_depsgraph_get())
    assert len(scene.materials) >= len(grid.cases)
    # It raises an error for a kernel that cannot be translated.
    packed = GpuScene(scene, Film(scene, ()))
    source = packed.source()
    assert "run_graph(" in source
    assert [warning for warning in scene.warnings if "as in Cycles" not in warning] == []


def test_the_reference_has_every_value():
    """Without lights, only rays a hundredth of a pixel apart make pictures differ."""
    grid = built(first_cases({VALUE}))
    scene, made = bpy.context.scene, []
    for device in ("CPU", "REFERENCE"):
        node_scenes.settings(scene, node_pictures.OURS, node_pictures.SHARP, 0, False, device)
        made.append(pictures.render().pixels)
    differing = []
    for index, case in enumerate(grid.cases):
        ours, theirs = (grid.tile(picture, index) for picture in made)
        if np.abs(ours - theirs).mean() > DIFFERENCE * max(np.abs(theirs).mean(), 0.1):
            differing.append(case.name)
    assert differing == []
