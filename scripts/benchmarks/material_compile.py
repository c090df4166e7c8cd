# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of compiling a scene's materials: those of ``materials``, and one for each of further nodes, 100 in all.

Each time is that of a new process: with an empty cache of kernels, with the cache of the process before, or with the
kernels that a zip ships and that are otherwise compiled in the background. It is processor time of all threads, from
the materials' formulas to code, and includes no kernel that these materials do not call.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import time

import bpy
import host

from . import materials, node_cases, node_scenes
from .isolation import Isolated
from .materials.stage import material_of
from .startup import work_folder

COUNT, QUICK_COUNT = 100, 20
SIZE = 8


def measured(quick: bool) -> dict[str, float]:
    """A row: seconds with an empty cache, with a filled one, and, unless ``quick``, with the kernels of a zip; the
    number of distinct graphs."""
    with tempfile.TemporaryDirectory(dir=work_folder()) as cache:
        cold, graphs, _ = _in_new_process(cache, quick)
        warm, _, changed = _in_new_process(cache, quick)
    row = dict(
        compiled_materials=QUICK_COUNT if quick else COUNT,
        graphs=graphs,
        seconds=cold,
        seconds_from_disk=warm,
        graphs_compiled_after_changes=changed,
    )
    return row if quick else row | dict(seconds_installed=_installed())


def _installed() -> float:
    """Seconds with the kernels of a zip, which take a minute and a half to compile."""
    with tempfile.TemporaryDirectory(dir=work_folder()) as cache:
        shipped = [sys.executable, "-m", "sdf_lights.render.cpu.precompile", "special"]
        environment = os.environ | {"SDF_LIGHTS_CACHE": cache}
        subprocess.run(shipped, cwd=host.REPOSITORY, env=environment, check=True, stdout=subprocess.DEVNULL)
        return _in_new_process(cache, False)[0]


def _in_new_process(cache: str, quick: bool) -> tuple[float, int, int]:
    other = Isolated()
    with _environment(SDF_LIGHTS_CACHE=cache):
        found = other.call(compiled, quick)
    other.close()
    return found


@contextlib.contextmanager
def _environment(**values: str):
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    yield
    for name, value in before.items():
        if value is None:
            del os.environ[name]
        else:
            os.environ[name] = value


def compiled(quick: bool) -> tuple[float, int, int]:
    """Seconds for all materials, the number of graphs, and how many of them a change of every number compiles again."""
    from sdf_lights_checkout.sdf_lights.blender.sync import sync
    from sdf_lights_checkout.sdf_lights.graph import codegen_native
    from sdf_lights_checkout.sdf_lights.render.cpu.block import BLOCK, WORKSPACE
    from sdf_lights_checkout.sdf_lights.render.kernels import shading
    from sdf_lights_checkout.sdf_lights.render.kernels.shading import special

    _build(QUICK_COUNT if quick else COUNT)
    bpy.context.scene.render.engine = host.ENGINE

    def run() -> tuple[float, int]:
        scene = sync(bpy.context.evaluated_depsgraph_get())
        known, started = len(codegen_native._compiled), time.process_time()
        tables, graphs = shading.pack_materials(scene)
        graphs.addresses((BLOCK, WORKSPACE))
        special.addresses(tables["lobes"], (BLOCK, WORKSPACE))
        return time.process_time() - started, len(codegen_native._compiled) - known

    seconds, graphs = run()
    _change()
    return seconds, graphs, run()[1]


def _build(count: int) -> None:
    """Open a new file with a tile for each material."""
    names = list(materials.MATERIALS)[:count]
    cases = [case for case in node_cases.cases() if case.place == node_cases.VALUE]
    nodes = {case.node: case for case in cases}  # one of each
    rest = [case for case in cases if nodes[case.node] is not case]
    chosen = [*nodes.values(), *rest][: count - len(names)] or cases[:1]
    node_scenes.build(node_scenes.grid_of(chosen, SIZE))
    place = bpy.data.objects["Tile 0"]
    for name in names:
        thing = place.copy()
        thing.data = place.data.copy()
        thing.data.materials.clear()
        thing.data.materials.append(material_of(name))
        thing.name = name
        for slot in thing.material_slots:
            slot.link, slot.material = "DATA", thing.data.materials[0]
        bpy.context.scene.collection.objects.link(thing)


def _change() -> None:
    """Multiply all numbers of unlinked sockets, except 0 and 1, which are folded."""
    for material in bpy.data.materials:
        for node in material.node_tree.nodes if material.node_tree else ():
            for socket in node.inputs:
                if socket.type == "VALUE" and not socket.is_linked and socket.default_value not in (0.0, 1.0):
                    socket.default_value *= 1.0009765625
    bpy.context.view_layer.update()
