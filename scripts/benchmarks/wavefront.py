# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The possible gain of splitting the GPU's path tracer into a wavefront of small kernels, and its minimum cost.

A wavefront sorts paths by their next step, so that no thread waits for others with a different step (Laine et al. 2013,
"Megakernels considered harmful"). It can gain at most the waiting threads. These are counted: for each sample, the
rounds of the program's loop, those in which a surface is shaded, and those in which a light ray is traced; and in
groups of threads, the waiting for the slowest ones at the end. Between its kernels, paths are in memory, while threads
of one kernel keep them in registers. The same program writes a path to a buffer and reads it again, once per round,
which is the minimum that a wavefront does.
"""

from __future__ import annotations

import itertools
import statistics
from contextlib import contextmanager

import bpy
import host
import numpy as np

from sdf_lights.render.settings import LampSampling

from . import lamp_scenes, pictures, simple_scenes
from .resume import in_parts
from .throughput import LAMP_SCENES

HELP = "what the GPU's path tracer could gain as a wavefront, and what that costs"

BOUNCES = (0, 4)
GROUPS = (8, 32)  # threads of a group: llvmpipe's, and those of most graphics cards
STATE = 5  # binding of the buffer that paths are in
ROUND = "fresh = integrator_advance(false)"


def counting(source: str) -> tuple[str, int]:
    """A program whose picture is (rounds, those that shade, those that trace a light ray), per sample."""
    for place, text in (
        ("void path_clear_sample()", "vec3 rounds;\n\nvoid path_clear_sample()"),
        ("PATH.index = film_offset + index;", "PATH.index = film_offset + index;\n            rounds = vec3(0.0);"),
        (ROUND, f"rounds.x += 1.0;\n        {ROUND}"),
        ("add_sample(index);", "SAMPLE.combined = rounds;\n            add_sample(index);"),
        ("void surface_shade()\n{", "void surface_shade()\n{\n    rounds.y += 1.0;"),
        ("void integrator_light_vertex()\n{", "void integrator_light_vertex()\n{\n    rounds.z += 1.0;"),
    ):
        source = _replaced(source, place, text)
    return source, 0


def _replaced(source: str, place: str, text: str) -> str:
    assert source.count(place) == 1, place
    return source.replace(place, text)


def _parts(source: str, record: str) -> list[str]:
    """Numbers of a record of the workspace, as GLSL, each with its type."""
    body = source.split(f"struct Record_{record} {{", 1)[1].split("}", 1)[0]
    found = []
    for kind, name in (member.split() for member in body.split(";") if member.strip()):
        texts = [f"{record}_row.{name}.{axis}" for axis in "xyz"] if kind == "vec3" else [f"{record}_row.{name}"]
        found += [("float" if kind == "vec3" else kind, text) for text in texts]
    return found


def remembering(source: str) -> tuple[str, int]:
    """A program that moves paths through a buffer once per round."""
    parts = _parts(source, "path") + _parts(source, "sample")
    into = {"float": "floatBitsToUint({})", "int": "uint({})", "uint": "{}"}
    back = {"float": "uintBitsToFloat({})", "int": "int({})", "uint": "{}"}
    lines = [f"layout(std430, binding = {STATE}) volatile buffer State {{ uint state[]; }};"]
    for name in ("store", "load"):
        lines += [f"void {name}_path(int thread, int threads)", "{"]
        for index, (kind, text) in enumerate(parts):
            place = f"state[{index} * threads + thread]"
            lines.append(
                f"    {place} = {into[kind].format(text)};"
                if name == "store"
                else f"    {text} = {back[kind].format(place)};"
            )
        lines.append("}")
    source = _replaced(source, "void main()", "\n".join([*lines, "", "void main()"]))
    return _replaced(
        source, ROUND, f"store_path(thread, work.y);\n        load_path(thread, work.y);\n        {ROUND}"
    ), len(parts)


@contextmanager
def changed(change):
    """The GPU's programs after ``change``, which also returns how many words of a buffer each pixel needs."""
    renderer = host.program("render.gpu.renderer")
    scene, device = renderer.GpuScene, renderer.GpuRenderer
    source, bind = scene.source, device._bind

    def source_of(self) -> str:
        text, self.state_words = change(source(self))
        return text

    def binds(self) -> None:
        bind(self)
        if not hasattr(self, "_state"):
            size = max(self._packed.state_words * len(self._film.active), 1)
            self._state = self._buffer(self._device.context, np.zeros(size, np.uint32))
        self._state.bind_to_storage_buffer(STATE)

    scene.source, device._bind = source_of, binds
    try:
        yield
    finally:
        scene.source, device._bind = source, bind


def _render(samples: int, bounces: int) -> pictures.Picture:
    simple_scenes.plain_sdf_lights(bpy.context.scene, samples, bounces, "GPU")
    settings = bpy.context.scene.sdf_lights
    settings.lamp_sampling, settings.lamp_paths = LampSampling.MIS.value, "NEVER"
    return pictures.render()


def measure(name: str, size: int, bounces: int, options) -> dict:
    few, many = (1, 33) if options.quick else (4, 36)
    repeats = options.repeats or (1 if options.quick else 3)
    lamp_scenes.SCENES[name].build(size)
    lamp_scenes.show(volumes=False)
    _render(1, bounces)
    with changed(counting):
        counts = _render(32, bounces).pixels.reshape(-1, 3)
    seconds = {(kind, samples): [] for kind in ("plain", "remembering") for samples in (few, many)}
    for turn in range(repeats + 1):
        for kind, samples in seconds:
            if kind == "plain":
                picture = _render(samples, bounces)
            else:
                with changed(remembering):
                    picture = _render(samples, bounces)
            if turn:  # the first turn compiles
                seconds[kind, samples].append(picture.seconds)
    plain, memory = (
        max(statistics.median(np.subtract(seconds[kind, many], seconds[kind, few])), 1e-9)
        for kind in ("plain", "remembering")
    )
    rounds, shaded, lit = counts.mean(0)
    row = dict(scene=name, bounces=bounces, rounds=rounds, shading=shaded / rounds, light_rays=lit / rounds)
    for group in GROUPS:
        together = counts[: len(counts) // group * group, 0].reshape(-1, group)
        row[f"busy_in_{group}"] = float(together.mean() / together.max(1).mean())
    return row | dict(memory_time_ratio=memory / plain)


def run(options) -> tuple[dict, list[dict]]:
    names = LAMP_SCENES[:1] if options.quick else ("S1", "S3")
    size = 96 if options.quick else 128
    rows = in_parts(
        itertools.product(names, BOUNCES), lambda name, bounces: measure(name, size, bounces, options), options
    )
    return dict(
        wavefront_gain_at_most=max(1.0 / (min(row["shading"], row["light_rays"]) * row["busy_in_8"]) for row in rows),
        wavefront_memory_time_ratio=statistics.geometric_mean(row["memory_time_ratio"] for row in rows),
    ), rows
