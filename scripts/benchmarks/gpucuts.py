# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Variance times time of light rays to lamps on the GPU: by cuts of flat boxes, and by projection with MIS.

The methods take turns, seed after seed. The error is the relative variance of a pixel between seeds, which needs no
reference. A sample's time is the additional time of a longer render compared with a short one. With bounces there are
cuts, too, although the GPU has none by default.
"""

from __future__ import annotations

import contextlib
import itertools
import statistics

import bpy
import host

from sdf_lights.render.settings import LampSampling

from . import errors, lamp_scenes, pictures, simple_scenes, some_of
from .resume import in_parts
from .turns import in_turns, stack_of, work_of

HELP = "variance times time of samplers of lamps on the GPU"

SAMPLERS = LampSampling.MIS.value, LampSampling.CUT.value
SIZE = 96
FEW = 4


def arguments(parser) -> None:
    parser.add_argument(
        "--cut-scenes",
        metavar="SCENES",
        type=some_of(lamp_scenes.SCENES),
        help="of the lamp scenes, with commas between (default: S1,S3,S5; S1 in the quick form)",
    )
    parser.add_argument("--cut-bounces", type=int, default=0, help="of light")


@contextlib.contextmanager
def cuts_with(bounces: int):
    """The GPU uses cuts in renders with so many bounces, too."""
    program = host.program("render.gpu.packed_scene")
    usual, program.CUT_BOUNCES = program.CUT_BOUNCES, bounces
    try:
        yield
    finally:
        program.CUT_BOUNCES = usual


def measure(name: str, options) -> dict:
    many, repeats = (20 if options.quick else 68), options.repeats or (2 if options.quick else 4)
    lamp_scenes.SCENES[name].build(SIZE)
    lamp_scenes.show(volumes=False)

    def render(sampler: str, samples: int, seed: int) -> pictures.Picture:
        device = "GPU" if options.device == "AUTOMATIC" else options.device
        simple_scenes.plain_sdf_lights(bpy.context.scene, samples, options.cut_bounces, device)
        settings = bpy.context.scene.sdf_lights
        settings.seed, settings.lamp_sampling, settings.lamp_paths = seed, sampler, "NEVER"
        return pictures.render()

    with cuts_with(options.cut_bounces):
        for sampler in SAMPLERS:
            render(sampler, 1, 0)  # compiles
        pairs = itertools.product(SAMPLERS, (FEW, many))
        made = in_turns(pairs, range(repeats), lambda pair, seed: render(*pair, seed))
    row = dict(scene=name)
    for sampler in SAMPLERS:
        short, long = (work_of(made[sampler, samples]) for samples in (FEW, many))
        pixels = stack_of(made[sampler, many])
        # If other work disturbs short renders, the longer ones may seem faster.
        row[f"{sampler}_seconds"] = max(long - short, 1e-9) / (many - FEW)
        row[f"{sampler}_variance"] = errors.rel_variance(pixels.var(axis=0, ddof=1), pixels.mean(axis=0))
        row[f"{sampler}_mean"] = float(pixels.mean())
    mis, cut = (row[f"{sampler}_seconds"] * row[f"{sampler}_variance"] for sampler in SAMPLERS)
    return row | dict(gain=mis / cut)


def run(options) -> tuple[dict, list[dict]]:
    names = options.cut_scenes or (["S1"] if options.quick else ["S1", "S3", "S5"])
    rows = in_parts(names, lambda name: measure(name, options), options)
    return dict(gpu_cut_gain=statistics.geometric_mean(row["gain"] for row in rows)), rows
