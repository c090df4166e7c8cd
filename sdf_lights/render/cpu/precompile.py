# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles kernels in advance: when a zip is built, and in processes beside a session.

    python -m sdf_lights.render.cpu.precompile [--beside] [lamps|light_paths|paths|special …]

compiles into the cache folder and prints its progress, each time a line such as «312 of 527», and «finished lamps». The
last line is the ``host_hash`` that the kernels are for. Without a name: all groups. ``--beside``: ends when its
standard input closes.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable

import numpy as np

from ... import jit, kernel_code
from ...emitter.sampling import cut_tables
from ...emitter.tree import interior, moments, slopes, volume
from ...sdf.data import simplest
from ...sdf.emission import EmissionExpression
from ...sdf.shapes import SHAPES, Box, Difference, Sphere
from ..film import Film
from ..kernels import motion
from ..kernels.caustic_paths import code_table as caustic_path_code
from ..kernels.caustic_paths import trace as caustic_trace
from ..kernels.hidden_parts import look_at_parts
from ..kernels.light_paths import code_table as light_path_code
from ..kernels.light_paths import distant, places, trace, tree
from ..kernels.media import code_table as media_code
from ..kernels.outputs import code_table as output_code
from ..kernels.packing import BLOCK
from ..kernels.path_reuse import code_table as path_reuse_code
from ..kernels.shading import special
from ..kernels.shading.graphs import compile_calls
from ..kernels.strands import code_table as strand_code
from ..kernels.subsurface import code_table as subsurface_code
from ..kernels.workspace import WORKSPACE
from ..material import Material, Node
from ..nodes import common
from ..scene import Camera, Instance, Lamp, Mesh, Scene, World
from ..settings import CausticPaths, Settings
from .block import PackedScene, Workspace
from .caustic_paths import CausticTracer
from .hidden_parts import find_hidden_parts
from .light_paths import LightPaths
from .path_reuse import render_tile_reusing
from .path_splitting import render_tile
from .renderer import CpuRenderer

INTERVAL = 0.2  # seconds between two lines


def _lamps() -> tuple[list, Callable[[], None]]:
    """The kernels that build lamps: programs and fields, with uniform and with varying emission."""
    from ...emitter import build_lamp

    entries = [
        *(interior.grow_program, interior.grow_field, interior.finish, moments.sample_leaves, moments.gather),
        *(moments.divide, slopes.bound_all, slopes._spread, volume.sample),
        *(cut_tables.roughness, cut_tables.expected_light),
    ]
    shapes = Difference(Box((0.5, 0.5, 0.5)), Sphere(0.6)), SHAPES["twist"](Box((0.15, 0.1, 0.4)), 1.5)

    def run() -> None:
        for shape in shapes:
            build_lamp("Lamp", shape, np.eye(4))
            build_lamp("Lamp", shape, np.eye(4), emission=EmissionExpression("exp(-depth)").emission())

    return entries, run


def _scene(lamps: bool = True) -> Scene:
    """A floor, and a lamp above it."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    floor = Mesh("Floor", corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    above = np.eye(4)
    above[2, 3] = 2.0
    return Scene(
        camera=Camera(above),
        width=1,
        height=1,
        meshes=[floor],
        instances=[Instance(0, np.eye(4), (0,))],
        materials=[Material("Floor", Node("diffuse", {"color": (0.5, 0.5, 0.5)}))],
        lamps=[Lamp("Lamp", Sphere(0.5), above)] if lamps else [],
        settings=Settings(samples=1),
    )


def _paths() -> tuple[list, Callable[[], None]]:
    """The path tracer, which is the same without lamps: those are another group's."""

    def run() -> None:
        scene = _scene(lamps=False)
        CpuRenderer(scene, Film(scene, ()), lambda: False, lambda text: None)
        path_reuse_code.addresses(True, False, (BLOCK, WORKSPACE))

    return [render_tile, render_tile_reusing, *(kernel for kernel, _ in path_reuse_code.KERNELS.values())], run


def _light_paths() -> tuple[list, Callable[[], None]]:
    """Light paths, their tree, and connections with them; caustic paths; and hidden parts of lamps."""
    kernels = [
        *(kernel for kernel, _ in (light_path_code.KERNELS | path_reuse_code.WITH_LIGHT_PATHS).values()),
        *(tree.build, tree.place, trace.trace_light_paths, trace.weight_by_visibility),
        *(places.find_places, distant.measure, look_at_parts, motion.stop_at),
        *(kernel for kernel, _ in caustic_path_code.KERNELS.values()),
        *(caustic_trace.trace_caustic_paths, caustic_trace.add_to_image, caustic_trace.find_mirrors),
    ]

    def run() -> None:
        scene = _scene()
        scene.world = World((0.1, 0.1, 0.1), 1.0)
        packed = PackedScene(scene, Film(scene, ()))
        workspace = Workspace(packed)
        find_hidden_parts(scene, packed, workspace)
        motion.stop_at(workspace.scene, workspace.block, 0.0)
        light_paths = LightPaths.of(scene, packed, [workspace])
        assert light_paths is not None
        light_paths.use(0)
        packed.set_path_reuse(1, connects=True)
        scene.materials = [Material("Floor", Node("glossy", {"color": (0.5, 0.5, 0.5), "roughness": 0.0}))]
        scene.settings.caustic_paths = CausticPaths.ALWAYS
        film = Film(scene, ())
        packed = PackedScene(scene, film)
        caustics = CausticTracer.of(scene, packed, [Workspace(packed)])
        assert caustics is not None and caustics.begin(lambda: None)
        caustics.use(film, 0, 1, lambda: False)

    return kernels, run


def _special() -> tuple[list, Callable[[], None]]:
    """Kernels of special scenes: lamps of data, textures, media, subsurface scattering, hair, special closures,
    passes."""
    from ...emitter import build_lamp

    records = BLOCK, WORKSPACE
    kernels = [
        *(kernel for kernel, _ in (*media_code.KERNELS.values(), *media_code.VARYING.values())),
        *subsurface_code.KERNELS.values(),
        *(kernel for _, kernel, _ in output_code.KERNELS.values()),
        *special.kernels(),
        *(function.kernel for function, _ in common.calls()),
        *(part.kernel for each in simplest.FUNCTIONS for part in (each, each.bounds) if part is not None),
    ]

    def run() -> None:
        for shape in simplest.simplest():
            build_lamp("Lamp", shape, np.eye(4))
        compile_calls(common.calls(), records)
        special.compile_all(records)
        media_code.addresses(True, False, records)
        media_code.addresses(True, True, records)
        subsurface_code.addresses(True, records)
        strand_code.addresses(True, records)
        output_code.compile_all(records)

    return kernels, run


GROUPS: dict[str, Callable[[], tuple[list, Callable[[], None]]]] = {
    "paths": _paths,
    "lamps": _lamps,
    "light_paths": _light_paths,
    "special": _special,
}


def _say(line: str) -> None:
    """Print in one piece: ``print`` writes the end of the line by itself, and two threads print."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def _end_with_input() -> None:
    sys.stdin.read()
    os._exit(1)


def main(words: list[str]) -> None:
    """Compile groups, and print the progress to standard output."""
    if "--beside" in words:
        threading.Thread(target=_end_with_input, daemon=True).start()
    groups = {name: GROUPS[name]() for name in [word for word in words if word in GROUPS] or GROUPS}
    kernels = [kernel for entries, _ in groups.values() for kernel in entries]
    ended = threading.Event()

    def tell() -> None:
        while not ended.wait(INTERVAL):
            done, total = jit.progress(kernels)
            _say(f"{done} of {total}")

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    for name, (_, run) in groups.items():
        run()
        _say(f"finished {name}")
    ended.set()
    teller.join()
    total = jit.progress(kernels)[1]
    _say(f"{total} of {total}")
    _say(f"for {kernel_code.host_hash()}")


if __name__ == "__main__":
    main(sys.argv[1:])
