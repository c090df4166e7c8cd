# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics of lamps by light paths: error × time of path tracing, over that of light paths which are connected to the
camera (``connect``; ``aimed``: with light paths that leave the lamp towards mirror or glass), or merged around what the
camera sees. A prototype: see "Caustics" in docs/sampling.md.

A caustic is light that mirrors and glass alone have scattered between a lamp and what the camera sees. Path tracing
finds it if the lamp is seen by way of mirrors and glass. So a picture less one with the same seed, whose lamp such rays
do not see, is the caustic part, with its noise alone.
"""

from __future__ import annotations

import functools
import math
import statistics
import time
from dataclasses import dataclass

import bpy
import numpy as np
from scenery.modelling import add, plane, turned

from . import caustics_kernels, errors, lamp_scenes, pictures, simple_scenes, some_of
from .resume import in_parts
from .turns import in_turns, stack_of, work_of

HELP = "what light paths could gain for caustics: connected to the camera, and merged"
BRIEF = dict(caustics=["ball_large"])

BOUNCES = 8  # beyond the first surface
SIZE, QUICK_SIZE = 64, 32
SAMPLES, QUICK_SAMPLES = 64, 32
SEEDS, QUICK_SEEDS = 10, 4
BRANCHES = 16  # the most that a path splits into
PASSES, QUICK_PASSES = 64, 16
PATHS = 4  # of light, for each pixel and pass
RADII = 1.0, 2.0, 4.0  # of merging, in widths of a pixel in the middle of the picture
MASK_NUMBERS = 1 << 20  # of passes for the mask alone
MASK_PASSES = 32
EYE, TARGET, DEGREES = (0.0, -2.4, 1.8), (0.0, 0.0, 0.1), 40.0
CONNECTED = "connect", "aimed"
AT = (0.9, -0.8, 1.9)  # of the lamp: on the side of the camera, so that this sees the caustics
VISIBLE, HIDDEN = True, False  # the lamp, to rays that mirrors and glass have scattered


def _glass():
    return simple_scenes.material("Glass", "ShaderNodeBsdfGlass", (1.0, 1.0, 1.0), roughness=0.0)


def _ball() -> None:
    angles = [math.pi * step / 64 for step in range(65)]
    profile = [(0.3 * math.sin(angle), -0.3 * math.cos(angle)) for angle in angles]
    add("Thing", turned("Thing", profile, 128), _glass(), location=(0.1, 0.1, 0.45))


def _ring() -> None:
    metal = simple_scenes.material("Metal", "ShaderNodeBsdfAnisotropic", (0.9, 0.8, 0.6), roughness=0.0)
    add("Thing", turned("Thing", [(0.45, 0.0), (0.45, 0.4)], 256), metal, location=(0.0, 0.1, 0.01))


def _water() -> None:
    """A round sheet with waves. Its rim is flat: smooth normals must be close to those of the faces, as light paths and
    paths from the camera raise bent normals differently."""
    top = [(0.01 * step, 0.5 + 0.015 * math.cos(0.4 * step)) for step in range(81)]
    mesh = turned("Thing", [(0.0, 0.4), (0.8, 0.4), *reversed(top)], 256)
    for face in mesh.polygons:
        face.use_smooth = abs(face.normal.z) > 0.5
    add("Thing", mesh, _glass(), location=(0.2, 0.2, 0.0))


THINGS = dict(ball=_ball, ring=_ring, water=_water)
LAMPS = dict(small=0.03, large=0.3)  # radius in metres
SCENES = tuple(f"{thing}_{lamp}" for thing in THINGS for lamp in LAMPS)


def build(name: str, size: int) -> bpy.types.Scene:
    """A thing on a diffuse floor, under a lamp of 8 W/sr."""
    thing, lamp = name.split("_")
    scene = simple_scenes.empty(size, EYE, TARGET, DEGREES)
    add("Floor", plane("Floor", (6.0, 6.0)), simple_scenes.diffuse("Floor", (0.7, 0.68, 0.65)))
    THINGS[thing]()
    radius = LAMPS[lamp]
    density = lamp_scenes.INTENSITY / (4.0 / 3.0 * math.pi * radius**3)
    lamp_scenes.add_lamp("Lamp", f"sphere({radius})", None, lamp_scenes.turned(at=AT), density)
    return scene


def arguments(parser) -> None:
    parser.add_argument(
        "--caustics", type=some_of(SCENES), metavar="SCENES", help=f"with commas between: {', '.join(SCENES)}"
    )


def _settings(scene, samples: int, seed: int, device: str) -> None:
    simple_scenes.plain_sdf_lights(scene, samples, BOUNCES, device)
    settings = scene.sdf_lights
    settings.indirect_paths, settings.lamp_paths, settings.path_reuse = BRANCHES, "NEVER", "NEVER"
    # Light that was scattered diffusely twice does not find caustics: the difference has no other light.
    settings.diffuse_bounces, settings.filter_glossy, settings.seed = 1, 0.0, seed


def _render(scene, visible: bool, samples: int, seed: int, device: str) -> pictures.Picture:
    _settings(scene, samples, seed, device)
    lamp = bpy.data.objects["Lamp"]
    lamp.visible_glossy = lamp.visible_transmission = visible
    return pictures.render()


@dataclass
class Estimates:
    """Pictures (passes, height, width, RGB) of the caustic alone, and processor seconds for each."""

    stack: np.ndarray
    work: float

    def variance(self) -> np.ndarray:
        """Of one pass, in each value."""
        return self.stack.var(axis=0, ddof=1)

    def mean(self, mask: np.ndarray) -> tuple[float, float]:
        """Of all values in the mask, and its standard error."""
        each = self.stack[:, mask].mean(axis=(1, 2))
        return float(each.mean()), float(each.std(ddof=1)) / math.sqrt(len(each))

    def cost(self, square: np.ndarray, mask: np.ndarray) -> tuple[float, float]:
        """Error × time relative to ``square``, and its standard error."""
        each = ((self.stack - self.stack.mean(axis=0)) ** 2 / square)[:, mask].mean(axis=(1, 2))
        count = len(each)
        factor = count / (count - 1) * self.work
        return factor * float(each.mean()), factor * float(each.std(ddof=1)) / math.sqrt(count)


def by_light_paths(scene, passes: int) -> tuple[dict[str, Estimates], np.ndarray]:
    """Estimates by connections and by merging with each radius, and which pixels and neighbors show nothing but what is
    diffuse."""
    _settings(scene, 1, 0, "CPU")
    scene.sdf_lights.lamp_paths = "ALWAYS"
    # Light paths count the surface that the camera sees.
    scene.sdf_lights.max_bounces = BOUNCES + 1
    tracer = caustics_kernels.Tracer(bpy.context.evaluated_depsgraph_get())
    width = tracer.pixel_width(math.dist(EYE, TARGET))
    paths = PATHS * tracer.height * tracer.width
    center, radius = _ball_around(bpy.data.objects["Thing"])
    plain = functools.partial(tracer.vertices, paths=paths)
    aimed = functools.partial(tracer.aimed_vertices, paths=paths, center=center, radius=radius)

    def connect(number: int, vertices: np.ndarray) -> np.ndarray:
        return tracer.connect(vertices)

    def merge(number: int, vertices: np.ndarray, pixels: float) -> np.ndarray:
        return tracer.merge(number, vertices, pixels * width)[0]

    makers = dict(connect=(plain, connect), aimed=(aimed, connect))
    makers |= {f"merge_{pixels:g}": (plain, functools.partial(merge, pixels=pixels)) for pixels in RADII}
    found: dict[str, list[np.ndarray]] = {name: [] for name in makers}
    work: dict[str, list[float]] = {name: [] for name in makers}
    for number in range(passes + 1):  # the first one compiles
        for name, (trace, make) in makers.items():
            started = time.process_time()
            vertices = trace(number)
            found[name].append(make(number, vertices))
            work[name].append(time.process_time() - started)
    none = vertices[:0]
    mask = np.all([tracer.merge(MASK_NUMBERS + i, none, width)[1] for i in range(MASK_PASSES)], axis=0)
    # A mirror may fill so little of a pixel that no pass has met it, and show the lamp.
    around = np.pad(mask, 1, mode="edge")
    mask = np.lib.stride_tricks.sliding_window_view(around, (3, 3)).all(axis=(2, 3))
    made = {name: Estimates(np.array(pile[1:]), statistics.median(work[name][1:])) for name, pile in found.items()}
    return made, mask


def _ball_around(thing) -> tuple[np.ndarray, float]:
    """Center and radius of a ball around an object that is only moved."""
    corners = np.array(thing.bound_box) + np.array(thing.location)
    low, high = corners.min(axis=0), corners.max(axis=0)
    points = np.array([vertex.co for vertex in thing.data.vertices]) + np.array(thing.location)
    center = (low + high) / 2.0
    return center, float(np.linalg.norm(points - center, axis=1).max())


def measure(name: str, options) -> dict:
    """The row of a scene."""
    quick = options.quick
    scene = build(name, QUICK_SIZE if quick else SIZE)
    samples = QUICK_SAMPLES if quick else SAMPLES
    seeds = max(options.repeats or (QUICK_SEEDS if quick else SEEDS), 2)
    by_light, mask = by_light_paths(scene, QUICK_PASSES if quick else PASSES)
    scene.sdf_lights.max_bounces = BOUNCES
    for variant in (VISIBLE, HIDDEN):
        _render(scene, variant, 2, 0, options.device)  # compiles, and fills caches
    before = statistics.median(_render(scene, VISIBLE, 1, seed, options.device).work for seed in range(3))
    made = in_turns(
        (VISIBLE, HIDDEN),
        range(seeds),
        lambda variant, seed: _render(scene, variant, samples, seed, options.device),
    )
    stacks = {variant: stack_of(pile) for variant, pile in made.items()}
    work = (work_of(made[VISIBLE]) - before) * samples / (samples - 1)
    return dict(caustic=name) | row_of(stacks[VISIBLE], stacks[HIDDEN], work, by_light, mask)


def row_of(
    visible: np.ndarray, hidden: np.ndarray, work: float, by_light: dict[str, Estimates], mask: np.ndarray
) -> dict:
    """Figures of pictures (seeds, height, width, RGB) with and without caustics, which took ``work`` each, and of
    estimates by light paths.

    ``part``: of the light, in the caustic. ``noise_paths``: root of the mean square relative error of the caustic by
    paths after a second. ``gain_…``: error × time by paths over that by light paths, of the caustic alone.
    ``bias_…``: as ``noise_paths``, that of the mean: its difference from connections, without what noise explains.
    ``whole_…``: error × time of the whole picture by paths, over that with the caustic by connections, with the best
    share of time for these. ``deviation_…``: of the mean from that of paths, relative. ``…_error``: standard errors.
    """
    caustic = Estimates(visible - hidden, work)
    reference = visible.mean(axis=0)
    square = reference**2 + errors.FLOOR * reference[mask].mean() ** 2
    paths, paths_error = caustic.cost(square, mask)
    mean, mean_error = caustic.mean(mask)
    row = dict(part=mean / float(reference[mask].mean()), noise_paths=math.sqrt(paths))
    rest = Estimates(hidden, work).cost(square, mask)[0]
    whole = Estimates(visible, work).cost(square, mask)[0]
    for name, each in by_light.items():
        cost, cost_error = each.cost(square, mask)
        row[f"gain_{name}"] = paths / cost
        row[f"gain_{name}_error"] = paths / cost * math.hypot(paths_error / paths, cost_error / cost)
        if name.startswith("merge"):
            apart = Estimates(each.stack - by_light["connect"].stack, 0.0)
            excess = apart.stack.mean(axis=0) ** 2 - apart.variance() / len(apart.stack)
            row[f"bias_{name}"] = math.sqrt(max(float((excess / square)[mask].mean()), 0.0))
        else:
            row[f"whole_{name}"] = whole / (math.sqrt(rest) + math.sqrt(cost)) ** 2
            found, error = each.mean(mask)
            row[f"deviation_{name}"] = found / mean - 1.0
            row[f"deviation_{name}_error"] = math.hypot(error, mean_error) / mean
    return row


def summary_of(rows: list[dict]) -> dict:
    """The geometric means of gains for each size of lamp, and the greatest deviation in standard errors."""
    summary = {}
    for lamp in LAMPS:
        for key in ("gain_connect", "gain_aimed", "whole_aimed"):
            found = [row[key] for row in rows if row["caustic"].endswith(lamp)]
            if found:
                summary[f"caustics_{lamp}_{key}"] = statistics.geometric_mean(found)
    worst = max(abs(row[f"deviation_{name}"] / row[f"deviation_{name}_error"]) for row in rows for name in CONNECTED)
    return summary | dict(caustics_deviation_max=worst)


def run(options) -> tuple[dict, list[dict]]:
    rows = in_parts(options.caustics or SCENES, lambda name: measure(name, options), options)
    return summary_of(rows), rows
