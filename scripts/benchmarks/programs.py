# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs that the GPU's driver compiles: how long that takes, and how fast they run, without a render around
them.

Each program of the plain scene and of the lamp scenes is compiled in a process of its own, as it is and in
other forms, which all compute the same (``program_session.py``). Then it takes samples of all pixels in one dispatch.
"""

from __future__ import annotations

import contextlib
import os
import pathlib
import tempfile
from collections.abc import Iterable, Iterator

import bpy
import host
import numpy as np

from sdf_lights.render.settings import LampSampling

from . import lamp_scenes, pictures, program_session, simple_scenes, some_of

HELP = "compile time and speed of the GPU's programs, in several forms"

PLAIN = "plain"
SCENES = (PLAIN, *lamp_scenes.THE_FIVE, "blob")
Case = tuple[str, int, LampSampling]  # scene, bounces, sampling of lamps
PLAIN_CASES: list[Case] = [(PLAIN, 0, LampSampling.CUT), (PLAIN, 4, LampSampling.CUT)]
BRIEF = dict(program_scenes=[PLAIN])


def lamp_cases(scene: str) -> list[Case]:
    """Direct light by cuts and by projection, and bounces, with which the GPU has no cuts."""
    return [(scene, 0, LampSampling.CUT), (scene, 0, LampSampling.MIS), (scene, 4, LampSampling.CUT)]


def processes_argument(parser) -> None:
    parser.add_argument(
        "--processes", type=int, help="that compile the GPU's programs at the same time (default: one a processor)"
    )


def arguments(parser) -> None:
    parser.add_argument(
        "--program-scenes", metavar="SCENES", type=some_of(SCENES), help="separated by commas (default: all)"
    )
    parser.add_argument(
        "--forms",
        type=some_of(program_session.FORMS),
        help="of each program, separated by commas (default: all; in the quick form only as it is)",
    )
    processes_argument(parser)
    parser.add_argument("--keep-programs", type=pathlib.Path, metavar="FOLDER", help="with their data, there")
    parser.add_argument("--only-keep", action="store_true", help="compile nothing")
    parser.add_argument("--for-card", action="store_true", help="programs as an NVIDIA card gets them")


@contextlib.contextmanager
def _kept(folder: pathlib.Path, name: str, known: dict[str, str]) -> Iterator[None]:
    """Renders on the GPU put their program into ``folder`` under ``name`` instead of compiling it, unless it is one of
    ``known``: source -> name. The CPU renders."""
    renderer, device = host.program("render.gpu.renderer"), host.program("render.gpu.device")
    usual = renderer.GpuRenderer._prepare

    def prepare(self, context, scene, watch) -> None:
        packed = self._packed_at(0)
        source = packed.source()
        if source not in known:
            known[source] = name
            (folder / f"{name}.glsl").write_text(source, encoding="utf-8")
            words, second, uniforms = packed.tables.pack(packed.scalars)
            np.savez_compressed(
                folder / f"{name}.npz",
                **dict(words=words, second=second, uniforms=uniforms, thread_words=packed.tables.arrays.words),
                **dict(nodes=packed.hierarchy.nodes, items=packed.hierarchy.items, lamps=len(packed.lamps)),
                **dict(film_seed=self._seed, film_offset=self._offset, size=self._size),
                film_place=np.array([*self._film.window[:2], self._film.width]),
                pixels=np.flatnonzero(self._film.active).astype(np.uint32),
            )
        raise device.DeviceError("its program is only kept")

    renderer.GpuRenderer._prepare = prepare
    try:
        yield
    finally:
        renderer.GpuRenderer._prepare = usual


def keep_programs(folder: pathlib.Path, cases: Iterable[Case], size: int, for_card: bool = False) -> int:
    """Put the programs of cases into a folder: those of this machine's device, or those of an NVIDIA card. Returns
    their number."""
    known: dict[str, str] = {}
    folder.mkdir(parents=True, exist_ok=True)
    devices = host.program("render.gpu.device")
    device = devices.device()
    usual = device.software, device.group
    if for_card:
        device.software, device.group = False, devices.GROUP_OF_NVIDIA
    try:
        for scene, bounces, sampling in cases:
            if scene == PLAIN:
                simple_scenes.boxes_and_sphere(size)
                simple_scenes.add_point_light()
            else:
                lamp_scenes.SCENES[scene].build(size)
                lamp_scenes.show(volumes=False)
            simple_scenes.plain_sdf_lights(bpy.context.scene, 1, bounces, "GPU")
            bpy.context.scene.sdf_lights.lamp_sampling = sampling.value
            with _kept(folder, f"{scene}_{sampling.value.lower()}_{bounces}", known):
                pictures.render()
    finally:
        device.software, device.group = usual
    return len(known)


def fill_cache(cases: Iterable[Case], processes: int) -> None:
    """Let the driver compile the programs of these cases, all at the same time, and keep them on disk."""
    with tempfile.TemporaryDirectory() as folder:
        keep_programs(pathlib.Path(folder), cases, 16)
        program_session.fill_cache(pathlib.Path(folder), processes)


def run(options) -> tuple[dict, list[dict]]:
    scenes = options.program_scenes or (SCENES[:2] if options.quick else SCENES)
    forms = options.forms or ([program_session.AS_IT_IS] if options.quick else list(program_session.FORMS))
    cases = [case for scene in scenes for case in (PLAIN_CASES if scene == PLAIN else lamp_cases(scene))]
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep_programs or pathlib.Path(temporary)
        summary = dict(programs=keep_programs(folder, cases, 64 if options.quick else 512, options.for_card))
        if options.only_keep:
            return summary, []
        rows = program_session.run_all(folder, forms, options.processes or os.cpu_count() or 1)
    seconds = [
        row["compile_seconds"] for row in rows if row["form"] == program_session.AS_IT_IS and "problem" not in row
    ]
    return summary | dict(longest_compile_seconds=max(seconds, default=float("nan"))), rows
