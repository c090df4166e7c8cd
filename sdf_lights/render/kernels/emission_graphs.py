# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The nodes of lights and of the world, which multiply their radiance."""

from __future__ import annotations

import hashlib
import math

import numpy as np

from ...jit import address_of_record, call_surface_code, fill_table, kernel, table
from ...vec import madd, mul, negate, put
from ..identity import Same
from ..scene import Scene
from . import camera, lights, textures
from .path import path_table, put_depths
from .shading.graphs import Graphs
from .shading.material_records import EMISSION, NO_GRAPH
from .shading.operands import run
from .shading.records import REGISTERS, SURFACE, surface_table
from .workspace import WORKSPACE, secondary_table
from .world_sun import WorldMap, find_disc

NO_RAY = 0  # kind of ray of light sampling, which evaluates emission for all kinds at once, as in Cycles
MAP_ROWS = 512  # of the map of a world's nodes; more if its images have more
MOST_MAP_ROWS = 2048
_READ = ("constants", "emissions", *camera.TABLES, *textures.TABLES)  # by a world's nodes
_KEPT = "world map"

SCALARS = [("emission_graphs", np.int64)]  # 1: lights or the world have varying nodes

emission_table = table("emissions", EMISSION)
_registers = table("registers", np.float64)


@kernel
def emission_of(block, emitter):
    """Row of the nodes of a light or the world."""
    if emitter == lights.world_emitter(block):
        return 0
    return 1 + emitter - block.lamp_count


@kernel
def modulated(block, workspace, emitter, radiance, x, wi, distance, kind):
    """``radiance`` of the light or world that the ray from x along wi hits, times the value of its nodes there. A
    triangle has the nodes of its material, which is shaded elsewhere."""
    if lights.is_triangle(block, emitter):
        return radiance
    record = emission_table(block)[emission_of(block, emitter)]
    if record.graph == NO_GRAPH:
        return radiance
    secondary = secondary_table(workspace)[0]
    _describe(block, workspace, emitter, x, wi, distance, kind)
    run(block, secondary, record.graph, record.slots)
    registers = _registers(secondary)
    return mul(radiance, (registers[0], registers[1], registers[2]))


@kernel
def run_world_aovs(block, workspace, wi, kind):
    """Fill the registers of the second workspace with the shader AOVs of the world along wi."""
    record = emission_table(block)[0]
    _describe(block, workspace, lights.world_emitter(block), (0.0, 0.0, 0.0), wi, math.inf, kind)
    if record.aov_graph != NO_GRAPH:
        run(block, secondary_table(workspace)[0], record.aov_graph, record.aov_slots)


@kernel
def _describe(block, workspace, emitter, x, wi, distance, kind):
    """Fill the surface of the second workspace with what the nodes of an emitter read."""
    surface = surface_table(secondary_table(workspace)[0])[0]
    back = negate(wi)
    put(surface.position, wi if distance == math.inf else madd(x, distance, wi))
    put(surface.wo, back)
    normal = lights.emitter_normal(block, emitter, back)
    put(surface.n, normal)
    put(surface.ng, normal)
    surface.backfacing = 0
    surface.ray_kind = kind
    surface.ray_singular = 0
    surface.ray_length = 0.0 if distance == math.inf else distance
    put_depths(path_table(workspace)[0], surface)


@kernel
def _brightness(block, workspace, graph, slots, d):
    """Mean of RGB of the world's graph along d."""
    surface = surface_table(workspace)[0]
    put(surface.position, d)
    put(surface.wo, negate(d))
    put(surface.n, negate(d))
    put(surface.ng, negate(d))
    call_surface_code(
        graph,
        address_of_record(block),
        address_of_record(workspace),
        workspace.surface_address,
        slots,
        workspace.registers_address,
    )
    registers = _registers(workspace)
    value = abs(registers[0]) + abs(registers[1]) + abs(registers[2])
    return value / 3.0 if value < math.inf else 0.0


@kernel
def _fill_map(block, workspace, graph, slots, directions, values, map):
    """Brightness of a world along directions (n, 3), and in the middle of each cell of longitude and latitude."""
    for index in range(len(directions)):
        values[index] = _brightness(
            block, workspace, graph, slots, (directions[index, 0], directions[index, 1], directions[index, 2])
        )
    rows, columns = map.shape
    for row in range(rows):
        latitude = math.pi * ((row + 0.5) / rows - 0.5)
        for column in range(columns):
            longitude = 2.0 * math.pi * (0.5 - (column + 0.5) / columns)
            d = (math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude), math.sin(latitude))
            map[row, column] = _brightness(block, workspace, graph, slots, d)


def kept_world_map(
    scene: Scene, tables: dict[str, np.ndarray], graphs: Graphs, block: np.dtype, rows: int
) -> WorldMap | None:
    """``world_map``, or that of the scene's last frame if nothing has changed that it depends on."""
    graph = tables["emissions"]["graph"][0]
    if scene.kept is None or graph == NO_GRAPH:
        return world_map(tables, graphs, block, rows)
    numbers = hashlib.blake2b(b"".join(tables[name].tobytes() for name in _READ))
    key = rows, graphs.structures[graph], numbers.digest(), [Same(image.pixels) for image in scene.images]
    before, found = scene.kept.get(_KEPT, (None, None))
    if before != key:
        found = world_map(tables, graphs, block, rows)
        scene.kept[_KEPT] = key, found
    return found


def world_map(tables: dict[str, np.ndarray], graphs: Graphs, block: np.dtype, rows: int) -> WorldMap | None:
    """The map of the world's nodes for light sampling; None without nodes. ``rows`` are those of its images.

    ``tables`` are those of ``shading`` and of the camera, for blocks of the type ``block``.
    """
    record = tables["emissions"][0]
    if record["graph"] == NO_GRAPH:
        return None
    own = np.zeros(1, block)
    for name in _READ:
        fill_table(own, name, tables[name])
    work = np.zeros(1, WORKSPACE)
    surface, registers = np.zeros(1, SURFACE), np.zeros(REGISTERS)
    fill_table(work, "surface", surface)
    fill_table(work, "registers", registers)
    rows = min(max(rows, MAP_ROWS), MOST_MAP_ROWS)
    values = np.zeros((rows, 2 * rows), np.float32)
    addresses = graphs.addresses((block, WORKSPACE))
    slots = tables["constants"].ctypes.data + 8 * int(record["slots"])
    constants = tables["constants"]
    disc = find_disc(graphs.structures[record["graph"]], constants[int(record["slots"]) :], constants)
    points = np.zeros((0, 3)) if disc is None else disc.points()
    found = np.zeros(len(points))
    _fill_map(own[0], work[0], int(addresses[record["graph"]]), slots, points, found, values)
    return WorldMap(values) if disc is None else disc.separate(values, float(found.mean()))
