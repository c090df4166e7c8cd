# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sampling of a lamp's surface by area, for comparison: directions to uniform points of it.

Points come from lines. A uniform random line through a ball of radius R crosses a surface of area A inside it A/(2πR²)
times on average, and the crossings of all lines together are uniform by area (Santaló 1976, "Integral geometry and
geometric probability"). So a line is drawn, and its crossings are found like those of any ray. For a line with n
crossings, one of them is chosen uniformly with probability n/N, where N is the maximum for a line. A ray that hits the
surface at distances r_i and angles θ_i to its normals has the density

    p(ω|x) = 1/A Σ r_i² / |cos θ_i|

A and N are found by counting the crossings of evenly spread lines. Rarer lines with more crossings than that count as
having N.
"""

from __future__ import annotations

import importlib
import math

import numpy as np

from sdf_lights.affine import inverse
from sdf_lights.emitter import lamps as lamp_tables
from sdf_lights.emitter.building import build
from sdf_lights.emitter.building.pack import new_spans, pack_lamps, pack_scalars
from sdf_lights.emitter.hashing import following, seeded, uniform, uniform_point
from sdf_lights.emitter.lamps import lamps, trace
from sdf_lights.emitter.primitives.disk import disk_point
from sdf_lights.graph.codegen_native import LANES
from sdf_lights.jit import block_dtype, call_field, fill_table, kernel, stack_array, table
from sdf_lights.vec import (
    add,
    dot,
    frame,
    length,
    madd,
    normalize,
    scale,
    sub,
    transform_normal,
    transform_point,
    transform_vector,
    vec,
)

SURFACE = np.dtype(
    [
        ("area", np.float64),  # m², in the world
        ("most", np.int64),  # crossings of a line
        ("address", np.int64),  # of the compiled gradient of the field
        ("parameters", np.int64),  # address of its parameters
        ("inverse", np.float64, (3, 4)),  # the world, relative to the lamp's centre -> the shape's local space
    ],
    align=True,
)

TABLES = {"external_rows": SURFACE}  # as in the renderer, where it is what an external strategy reads

LINES = 1 << 18  # number of lines for measuring areas
ATTEMPTS = 4096  # lines before giving up
INWARD = 1e-6  # of half an interval: where its normals are read, because fields may have a crease at zero
LEAST_COSINE = 1e-9

GRADIENT = 3 * LANES  # offset of gradients in a stack, after all x, all y and all z
STACK = 6 * LANES

BLOCK = block_dtype(lamp_tables.TABLES, lamp_tables.SCALARS)

lamp_surfaces = table("external_rows", SURFACE)


@kernel
def _crossings(block, lamp, u1, u2, u3, u4, spans):
    """Intervals of a uniform random line: origin, direction, and their number."""
    row = lamps(block)[lamp]
    z = 1.0 - 2.0 * u1
    ring, angle = math.sqrt(max(1.0 - z * z, 0.0)), 2.0 * math.pi * u2
    d = (ring * math.cos(angle), ring * math.sin(angle), z)
    x, y = disk_point(u3, u4)
    t, b = frame(d)
    o = madd(vec(row.center), row.bounding_radius, sub(add(scale(t, x), scale(b, y)), d))
    return o, d, trace(block, lamp, o, d, spans)


@kernel
def _end(spans, index, inward):
    """Distance of one end of the intervals, counted in pairs, or of a point at this depth inside it."""
    c, h = spans[index // 2, 0], spans[index // 2, 1]
    h -= inward * h
    return c + h if index % 2 else c - h


@kernel
def sample(block, lamp, x, spans, u1, u2, u3):
    """Unit direction from x to a uniform point of the surface; its density is ``density``."""
    most = lamp_surfaces(block)[lamp].most
    state = seeded(u1, u2, u3)
    d = (0.0, 0.0, 1.0)
    for _ in range(ATTEMPTS):
        u4 = uniform(state)
        state = following(state)
        chosen = int(uniform(state) * most)
        state = following(state)
        o, d, count = _crossings(block, lamp, u1, u2, u3, u4, spans)
        if chosen < 2 * count:
            return normalize(sub(madd(o, _end(spans, chosen, 0.0), d), x))
        u1, u2, u3 = uniform_point(state)
        state = following(state)
    return d


@kernel
def density(block, lamp, x, d, spans, count):
    """Density per solid angle of ``sample`` giving d, from the intervals that ``trace`` found from x."""
    surface = lamp_surfaces(block)[lamp]
    p = transform_point(surface.inverse, sub(x, vec(lamps(block)[lamp].center)))
    way = transform_vector(surface.inverse, d)
    stack = stack_array(STACK)
    points = stack.ctypes.data
    total = 0.0
    for first in range(0, 2 * count, LANES):
        used = min(LANES, 2 * count - first)
        for lane in range(LANES):
            place = madd(p, _end(spans, first + min(lane, used - 1), INWARD), way)
            for k in range(3):
                stack[k * LANES + lane] = place[k]
        call_field(surface.address, LANES, points, surface.parameters, points + 8 * GRADIENT)
        for lane in range(used):
            slope = (stack[GRADIENT + lane], stack[GRADIENT + LANES + lane], stack[GRADIENT + 2 * LANES + lane])
            normal = transform_normal(surface.inverse, slope)
            size = length(normal)
            cosine = abs(dot(d, normal)) / size if size > 0.0 else 1.0
            r = _end(spans, first + lane, 0.0)
            total += r * r / max(cosine, LEAST_COSINE)
    return total / surface.area


@kernel
def _count_crossings(blocks, numbers, spans):
    """The mean number of crossings of lines, one for each row of ``numbers`` (n, 4), and the most."""
    total, most = 0, 0
    for i in range(len(numbers)):
        _, _, count = _crossings(blocks[0], 0, numbers[i, 0], numbers[i, 1], numbers[i, 2], numbers[i, 3], spans)
        total += 2 * count
        most = max(most, 2 * count)
    return total / len(numbers), most


def _spread(count: int) -> np.ndarray:
    """(count, 4) evenly spread points of the unit cube. Roberts 2018, "The unreasonable effectiveness of quasirandom
    sequences"."""
    base = 1.5
    for _ in range(64):
        base = (1.0 + base) ** 0.2
    return (0.5 + np.arange(1, count + 1)[:, None] * base ** -np.arange(1.0, 5.0)) % 1.0


def measure(built: build.BuiltLamp) -> tuple[float, int]:
    """Area of a lamp's surface in the world, and the maximum number of crossings of a line."""
    tables, blocks = pack_lamps([built]), np.zeros(1, BLOCK)
    for name, array in tables.items():
        fill_table(blocks, name, array)
    for name, value in pack_scalars([built]).items():
        blocks[name] = value
    mean, most = _count_crossings(blocks, _spread(LINES), new_spans(int(blocks["lamp_rows"][0]), 1))
    return 2.0 * math.pi * float(built.row["bounding_radius"][0]) ** 2 * mean, most


def pack_surfaces(built: list[build.BuiltLamp], sources: list) -> tuple[np.ndarray, tuple]:
    """Rows of ``SURFACE``, from the built lamps and from objects with their ``shape`` and ``matrix``, and the owner of
    the rest."""
    rows, owner = np.zeros(len(built), SURFACE), []
    for row, lamp, source in zip(rows, built, sources):
        # An extension has a copy of the program by another name, with its own formulas.
        program = type(lamp).__module__.removesuffix(".emitter.building.build")
        gradient = importlib.import_module(f"{program}.graph.gradient").gradient
        compiled = importlib.import_module(f"{program}.graph.codegen_native").compiled
        found = compiled(*gradient(source.shape.formula()))
        parameters = np.ascontiguousarray(source.shape.parameters(), np.float64)
        owner += [found.owner, parameters]
        relative = np.array(source.matrix, np.float64)
        relative[:3, 3] -= lamp.row["center"][0]
        row["inverse"] = inverse(relative)[:3]
        row["area"], row["most"] = measure(lamp)
        row["address"], row["parameters"] = found.address, parameters.ctypes.data
    return rows, tuple(owner)
