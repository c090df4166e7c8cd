# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samplers at equal samples on the four kinds of scenes of Huang et al. 2026, beside the figures of that paper.

The paper gives MAPE and FLIP of pictures with 64 samples of direct light: by BSDF samples, by projection sampling, and
by a competitor, which samples the surface for its simple shapes and the bounding volume for the others. Pictures here
use the renderer's own samplers. Points hit by a grid of camera rays are also lit by the estimators of
``support/rivals/baselines.py``, without occlusion.
"""

from __future__ import annotations

import functools
import math

import bpy
import numpy as np
from mathutils import Vector
from scipy.stats import qmc

from sdf_lights.sdf.expression import Expression
from support.rivals import baselines, samplers
from support.rivals.baselines import DIMENSIONS, LampBlock, Technique

from . import lamp_scenes, methods, paper_scenes, some_of
from .methods import Method
from .progress import Progress
from .resume import Parts

HELP = "samplers at equal samples on the scenes of the paper, beside its figures"

SAMPLES = 64
PUBLISHED = {  # scene: competitor, then MAPE and FLIP of BSDF samples, the competitor and projection sampling
    "dragon": ("surface area", (0.699, 0.448), (0.078, 0.054), (0.024, 0.021)),
    "room": ("surface area", (0.755, 0.647), (0.155, 0.094), (0.122, 0.077)),
    "kitchen": ("bounding volume", (0.945, 0.761), (0.079, 0.083), (0.013, 0.020)),
    "corridor": ("bounding volume", (0.805, 0.587), (0.239, 0.179), (0.047, 0.045)),
}
AT_POINTS = (
    Technique.COSINE,
    Technique.BOUNDING,
    Technique.SURFACE,
    Technique.PROJECTION,
    Technique.MIS,
    Technique.CUT,
)
TURNS = 16  # pixels of a point
BRIEF = dict(paper_scenes=["kitchen"], size=48, reference_seconds=0.5)


def arguments(parser) -> None:
    parser.add_argument(
        "--paper-scenes",
        type=some_of(PUBLISHED),
        default=",".join(PUBLISHED),
        metavar="SCENES",
        help=f"of {', '.join(PUBLISHED)}, with commas between",
    )
    methods.picture_arguments(parser)


def _seen(across: int) -> list[tuple[Vector, Vector]]:
    """Points and normals that face the camera, of a grid of camera rays of the open scene."""
    bpy.context.view_layer.update()
    scene, graph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
    corners = [scene.camera.matrix_world.to_3x3() @ corner for corner in scene.camera.data.view_frame(scene=scene)]
    eye, (a, b, _, d) = scene.camera.matrix_world.translation, corners
    found = []
    for row in range(across):
        for column in range(across):
            ray = a + (d - a) * ((column + 0.5) / across) + (b - a) * ((row + 0.5) / across)
            hit, place, normal, *_ = scene.ray_cast(graph, eye, ray.normalized())
            if hit:
                found.append((place, -normal if normal.dot(ray) > 0.0 else normal))
    return found


def at_points(across: int) -> dict[str, float]:
    """MAPE of pixels of ``SAMPLES`` samples at points that the camera sees, without occlusion, by each technique."""
    lamps = []
    for thing in bpy.data.collections[lamp_scenes.LAMPS].objects:
        lamp = thing.data.sdf_lamp
        shape = Expression(lamp.expression).shape()
        block = LampBlock(shape, np.array(thing.matrix_world), surface=True)
        # A block's lamp has 1 W/sr.
        lamps.append((block, lamp.density * block.built.row["volume"][0]))
    numbers = np.concatenate(
        [qmc.Sobol(DIMENSIONS, scramble=True, rng=np.random.default_rng(seed)).random(SAMPLES) for seed in range(TURNS)]
    )
    pixels = {technique: [] for technique in AT_POINTS}
    for place, normal in _seen(across):
        for technique in AT_POINTS:
            values = sum(
                intensity * baselines.values(technique, block.blocks, 0, place, normal, numbers)[0]
                for block, intensity in lamps
            )
            pixels[technique].append(values.reshape(TURNS, SAMPLES).mean(axis=1))
    found = {technique: np.array(values) for technique, values in pixels.items()}
    truth = np.mean([found[technique].mean(axis=1) for technique in (Technique.MIS, Technique.CUT)], axis=0)
    floor = 0.01 * truth.mean()
    return {
        technique.name.lower(): float(np.mean(np.abs(values - truth[:, None]) / (truth[:, None] + floor)))
        for technique, values in found.items()
    }


def measure(name: str, options, progress) -> list[dict]:
    """Rows of one scene: pictures by each sampler, then points by each technique."""
    size = options.size or (64 if options.quick else 256)
    paper_scenes.SCENES[name].build(size)
    seeds = options.repeats or (1 if options.quick else 8)
    by_paper = methods.by_paper()
    truth = methods.reference_of_scene(by_paper, 0, options)
    triangles = sum(len(mesh.loop_triangles) for mesh in _triangulated())
    ours = [Method(sampler, sampler, plain=True) for sampler in samplers.SAMPLERS]

    def told(what: str) -> None:
        progress.show(f"{name}, {what}")

    methods.take_turns(ours, [SAMPLES], seeds, 0, options.device, told)
    methods.complete(truth, by_paper, ours, 0, options, told)
    rows = [
        row | dict(triangles=triangles, reference=methods.doubt(truth, ours))
        for method in ours
        for row in method.rows(name, 0, truth)
    ]
    if options.pictures:
        kept = {method.name: method.pictures[SAMPLES][0].pixels for method in ours}
        digest = methods.keep_pictures(options.pictures, name, kept | {"reference": truth.pixels})
        rows = [row | dict(renders=digest) for row in rows]
    progress.show(f"{name}, points")
    return [
        *rows,
        *(
            dict(scene=name, technique=technique, samples=SAMPLES, mape_at_points=mape)
            for technique, mape in at_points(6 if options.quick else 24).items()
        ),
    ]


def _triangulated():
    for thing in bpy.context.scene.objects:
        if thing.type == "MESH":
            thing.data.calc_loop_triangles()
            yield thing.data


def compared(rows: list[dict]) -> list[dict]:
    """One row per scene: the paper's ratios of MAPE and FLIP to projection sampling, and ours."""
    found = []
    for name, (competitor, bsdf, other, projection) in PUBLISHED.items():
        pictures = {row["method"]: row for row in rows if row["scene"] == name and "method" in row}
        points = {
            row["technique"]: row["mape_at_points"] for row in rows if row["scene"] == name and "technique" in row
        }
        if not pictures:
            continue
        row = dict(scene=name, competitor=competitor)
        for place, metric in enumerate(("mape", "flip")):
            row |= {
                f"paper_{metric}_bsdf": bsdf[place],
                f"paper_{metric}_competitor": other[place],
                f"paper_{metric}_projection": projection[place],
            }
            row[f"paper_{metric}_bsdf_to_projection"] = bsdf[place] / projection[place]
            row[f"paper_{metric}_competitor_to_projection"] = other[place] / projection[place]
            for sampler in ("BSDF", "BOUNDING", "SURFACE", "MIS", "CUT"):
                ours, least = pictures[sampler][metric], pictures["PROJECTION"][metric]
                row[f"{metric}_{sampler.lower()}_to_projection"] = None if least is None else ours / least
        row["points_cosine_to_projection"] = points["cosine"] / points["projection"]
        for technique in ("bounding", "surface"):
            row[f"points_{technique}_to_projection"] = points[technique] / points["projection"]
        found.append(row)
    return found


def run(options) -> tuple[dict, list[dict]]:
    names = options.paper_scenes
    progress, parts, rows = Progress(len(names)), Parts(options), []
    for name in names:
        rows += parts.of(name, functools.partial(measure, name, options, progress))
        progress.step()
    parts.finish()
    progress.close()
    ratios = compared(rows)

    def mean(key: str) -> float:
        return math.exp(np.mean([math.log(row[key]) for row in ratios]))

    return dict(
        mape_ratio_bsdf_to_projection=mean("mape_bsdf_to_projection"),
        mape_ratio_bounding_to_projection=mean("mape_bounding_to_projection"),
        mape_ratio_surface_to_projection=mean("mape_surface_to_projection"),
        mape_ratio_mis_to_cut=mean("mape_mis_to_projection") / mean("mape_cut_to_projection"),
        mape_ratio_bounding_to_projection_at_points=mean("points_bounding_to_projection"),
    ), [*ratios, *rows]
