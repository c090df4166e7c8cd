# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps that data make: whether rays find every entry and exit, what a ray costs, how long a grid takes to build, and
the error of direct light at equal time beside Cycles.

Texts, curves and meshes are Blender's own objects, read as lamps read them. The oracle is that of
``intervals``; Cycles renders them as ``lamps`` has it, as volumes in meshes.
"""

from __future__ import annotations

import argparse
import functools
import math
import statistics
import time

import numpy as np

from . import grids as grid_builds
from .intervals import judged
from .progress import Progress
from .resume import Parts

HELP = "lamps of texts, curves, meshes, volumes, pictures and networks: wrong crossings, the cost of a ray, the time to build, error beside Cycles"

RAYS = 1_000_000  # of each kind
QUICK_RAYS = 5_000
COST_RAYS = 20_000
TURNS = 5
LETTER, PARAGRAPH = "g", "\n".join(["the quick brown fox jumpsg over dog"[:20]] * 10)


def _shape(**source):
    """The shape of a lamp from the ``source`` (properties of ``sdf_lamp``)."""
    import bpy

    from sdf_lights.blender.lamp import shape_of

    light = bpy.data.lights.new("Lamp", "POINT")
    light.sdf_lamp.use = True
    for name, value in source.items():
        setattr(light.sdf_lamp, name, value)
    bpy.context.view_layer.update()
    shape = shape_of(light.sdf_lamp)
    bpy.data.lights.remove(light)
    return shape


def _of_object(obj):
    """The shape of a lamp of an object, which is removed."""
    import bpy

    shape = _shape(source="OBJECT", object=obj)
    bpy.data.objects.remove(obj)
    return shape


def _linked(name: str, data):
    import bpy

    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def _text(body: str):
    import bpy

    curve = bpy.data.curves.new(body[:9], "FONT")
    curve.body, curve.extrude = body, 0.05
    return _of_object(_linked("Text", curve))


def _curve():
    import bpy

    data = bpy.data.curves.new("Spring", "CURVE")
    data.dimensions, data.bevel_depth = "3D", 0.1
    spline = data.splines.new("NURBS")
    turn = np.linspace(0.0, 12.0, 60)
    spline.points.add(len(turn) - 1)
    for point, a in zip(spline.points, turn):
        point.co = math.cos(a), math.sin(a), 0.1 * a, 1.0
    return _of_object(_linked("Curve", data))


def _suzanne():
    import bpy

    bpy.ops.mesh.primitive_monkey_add()
    return _of_object(bpy.context.object)


def _picture():
    from .lamp_scenes import logo_image

    return _shape(source="IMAGE", image=logo_image(), image_size=1.8)


def _volume():
    """A level set as a file has it: distances within three voxels of the surface, of a ring with a ball cut out."""
    from sdf_lights.sdf.data.level_set import level_set_grid
    from sdf_lights.sdf.expression import Expression

    size = 1.0 / 40
    shape = Expression("torus(0.7, 0.25) - translate(sphere(0.3), (0.7, 0, 0.1))").shape()
    low, high = (np.round(corner / size).astype(int) for corner in shape.bounds())

    def read(start, counts):
        places = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1) + start
        return np.clip(shape.distance(size * places.reshape(-1, 3)), -3.0 * size, 3.0 * size).reshape(counts)

    return level_set_grid(read, low - 3, high + 3, 3.0 * size, size)


def _scan():
    from sdf_lights.sdf.data.voxels import mesh_grid
    from support import grids

    return mesh_grid(*grids.scan(300_000))


def _network():
    from sdf_lights.sdf.data import network

    return network.read(network.EXAMPLE).shape()


CASES = {
    "text": lambda: _text("OPEN a%&8"),
    "curve": _curve,
    "mesh": _suzanne,
    "scan of 300,000 triangles": _scan,
    "picture": _picture,
    "volume": _volume,
    "network": _network,
}


def _wrong(name: str, count: int) -> dict:
    from support import grids

    row = judged(name, CASES[name](), lambda shape, rng, n: grids.rays_around(shape, n, 5), False, count, 1)
    return {key: row[key] for key in ("case", "certified", "rays", "wrong", "too_fine_to_judge", "ns", "evaluations")}


def _costs(shapes: dict, turns: int, from_in_front: bool) -> dict[str, float]:
    """Processor ns of a ray through each of the shapes, measured in turns."""
    from support import grids
    from support.lamps.rays import Traced

    traced = {name: (Traced(shape), grids.rays_around(shape, COST_RAYS, 6)) for name, shape in shapes.items()}
    if from_in_front:
        traced = {name: (walk, _in_front(walk.shape)) for name, (walk, _) in traced.items()}
    taken: dict[str, list[float]] = {name: [] for name in traced}
    for turn in range(turns + 1):
        for name, (walk, rays) in traced.items():
            started = time.thread_time()
            walk.trace(*rays)
            if turn:
                taken[name].append(time.thread_time() - started)
    return {name: 1e9 * statistics.median(seconds) / COST_RAYS for name, seconds in taken.items()}


def _in_front(shape) -> tuple[np.ndarray, np.ndarray]:
    """Rays of a camera, or of a point that is lit, to a sign."""
    rng = np.random.default_rng(6)
    low, high = shape.bounds()
    size = np.linalg.norm(high - low)
    targets = low + rng.random((COST_RAYS, 3)) * (high - low)
    origins = 0.5 * (low + high) + rng.normal(0.0, 0.3, (COST_RAYS, 3)) * size
    origins[:, 2] = high[2] + size
    directions = targets - origins
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def _cost_rows(turns: int) -> list[dict]:
    from sdf_lights.sdf.data.voxels import mesh_grid
    from sdf_lights.sdf.shapes import SHAPES
    from support.lamps.shapes_under_test import FieldOf

    built = grid_builds.measure("ring", turns)
    grid = mesh_grid(*grid_builds.MESHES["ring"](), grid_builds.VOXEL)
    sponge = SHAPES["menger_sponge"]()
    costs = _costs({"grid": grid, "sponge": sponge, "sponge as a field": FieldOf(sponge)}, turns, False)
    costs |= _costs({"1 letter": _text(LETTER), "200 letters": _text(PARAGRAPH)}, turns, True)
    return [*(dict(cost_of=name, ns_per_ray=value) for name, value in costs.items()), built]


def arguments(parser) -> None:
    """Options of its own."""
    from . import methods

    methods.picture_arguments(parser)


def _beside_cycles(options) -> list[dict]:
    """Comparisons of direct light at equal time."""
    from . import lamp_scenes, lamps, methods

    chosen = argparse.Namespace(**vars(options) | dict(samplers=["CUT"], cycles=True, bounces=0))
    names = lamp_scenes.OF_DATA[:1] if options.quick else lamp_scenes.OF_DATA
    return methods.of_scenes(names, 64 if options.quick else 96, lamps.measure, chosen)[0]


def run(options) -> tuple[dict, list[dict]]:
    import bpy

    from sdf_lights import blender

    bpy.ops.wm.read_factory_settings(use_empty=True)
    if not hasattr(bpy.types.Light, "sdf_lamp"):  # another benchmark may have registered it
        blender.register()
    turns = options.repeats or (2 if options.quick else TURNS)
    count = QUICK_RAYS if options.quick else RAYS
    progress, parts, rows = Progress(len(CASES) + 1), Parts(options), []
    for name in CASES:
        progress.show(name)
        rows.append(parts.of(name, functools.partial(_wrong, name, count)))
        progress.step()
    progress.show("costs")
    costs = parts.of("costs", functools.partial(_cost_rows, turns))
    progress.close()
    compared = _beside_cycles(options)  # has parts of its own
    parts.finish()
    cost = {row["cost_of"]: row["ns_per_ray"] for row in costs if "cost_of" in row}
    sure = [row for row in rows if row["certified"]]
    summary = dict(
        wrong_crossing_fraction_certified=sum(row["wrong"] * row["rays"] for row in sure)
        / sum(row["rays"] for row in sure),
        mse_ratio_cycles_direct_min=min(row["cycles"] for row in compared),
        cost_ratio_grid_to_sponge=cost["grid"] / cost["sponge"],
        cost_ratio_grid_to_sponge_as_field=cost["grid"] / cost["sponge as a field"],
        cost_ratio_200_to_1_letters=cost["200 letters"] / cost["1 letter"],
        build_processor_seconds_of_a_million_voxels=costs[-1]["processor_seconds_per_million"],
        megabytes_of_a_million_voxels=costs[-1]["megabytes_per_million"],
    )
    return summary, rows + costs + compared
