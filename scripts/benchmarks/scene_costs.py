# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Costs of a scene of ``artist_scenes`` beside its samples: the start of a process, synchronisation, memory.

The start is a whole process: Blender with the engine, the file, and its first sample in a small picture. Kernels and
Python's bytecode are on disk by then. ``first`` is that first render alone, in which we import what Cycles has in
Blender's own executable. Later renders synchronise the whole scene again, and give ``sync``. Those with Blender's
Persistent Data, which synchronise only changes, are ``again``. Memory is the peak of a process during the render,
minus its memory before with the scene in Blender. All times are processor times.
"""

from __future__ import annotations

import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import bpy
import host

from . import artist_scenes, pictures
from .beside_cycles import GUIDED, settings
from .isolation import Isolated
from .node_pictures import CYCLES
from .scene_pictures import ENGINES, width_of
from .startup import installed, work_folder

TINY = 16  # pixels across, so that samples cost nothing
TURNS = 3
LEAST_SECONDS, LEAST_BYTES = 0.1, 64 << 20  # too small to notice: smaller values are rounded up to this


def ratios(name: str, options) -> dict:
    """Ours over Cycles', for start, synchronisation and memory, with the figures of both."""
    found = {}
    for engine in ENGINES:
        process = Isolated()
        try:
            found[engine] = process.call(costs, name, engine, options)
        finally:
            process.close()
    row = {}
    for cost, least in (
        ("start", LEAST_SECONDS),
        ("first", LEAST_SECONDS),
        ("sync", LEAST_SECONDS),
        ("again", LEAST_SECONDS),
        ("memory", LEAST_BYTES),
    ):
        ours, theirs = found[GUIDED][cost], found[CYCLES][cost]
        row |= {cost: ours, f"cycles_{cost}": theirs}
        if ours is not None and theirs is not None:
            row[f"{cost}_ratio"] = max(ours, least) / max(theirs, least)
    return row


def costs(name: str, engine: str, options) -> dict:
    """Seconds of processes and of later small renders, and bytes of a whole one, in a process that has not rendered
    yet."""
    scene = artist_scenes.build(name, TINY)
    settings(scene, engine, 1, 0, options.device)
    start, first = _starts(engine)
    _forget_peak()
    before = _resident("VmRSS")
    pictures.render()
    sync = statistics.median(pictures.render().work for _ in range(TURNS))
    scene.render.use_persistent_data = True
    pictures.render()
    again = statistics.median(pictures.render().work for _ in range(TURNS))
    scene.render.use_persistent_data = False
    scene.render.resolution_x = width_of(options)
    scene.render.resolution_y = round(width_of(options) * artist_scenes.stage.ASPECT)
    settings(scene, engine, 2, 0, options.device)
    pictures.render()
    peak = _resident("VmHWM")
    return dict(start=start, first=first, sync=sync, again=again, memory=None if before is None else peak - before)


def _starts(engine: str) -> tuple[float, float]:
    """Processor seconds of a process that renders the open scene once, and of its render alone: medians."""
    with tempfile.TemporaryDirectory(dir=work_folder()) as folder:
        blend, answer = pathlib.Path(folder) / "scene.blend", pathlib.Path(folder) / "answer.json"
        bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True)
        command = f"from benchmarks import scene_costs; scene_costs.start({str(blend)!r}, {engine!r}, {str(answer)!r})"
        found = []
        for _ in range(1 + TURNS):
            subprocess.run(
                [sys.executable, "-c", command],
                env=installed(host.REPOSITORY / "build" / "kernels"),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                check=True,
            )
            found.append(json.loads(answer.read_text(encoding="utf-8")))
    # The first one may compile.
    return tuple(map(statistics.median, zip(*found[1:])))


def start(blend: str, engine: str, answer: str) -> None:
    """A process whose start is measured. Cycles' has no add-on."""
    if engine != CYCLES:
        host.register_extension()
    bpy.ops.wm.open_mainfile(filepath=blend)
    before = time.process_time()
    bpy.ops.render.render()
    done = time.process_time()
    pathlib.Path(answer).write_text(json.dumps((done, done - before)), encoding="utf-8")
    host.finish(0)


def _resident(entry: str) -> int | None:
    """Bytes of this process by an entry of Linux' status file; None elsewhere."""
    if not sys.platform.startswith("linux"):
        return None
    for line in pathlib.Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
        if line.startswith(entry + ":"):
            return 1024 * int(line.split()[1])
    return None


def _forget_peak() -> None:
    """Reset the peak resident size, if the system allows it."""
    try:
        pathlib.Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")
    except OSError:
        pass
