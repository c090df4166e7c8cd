# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of F12 before the first picture, on the demo scene.

Each figure is the time of a render of one sample in 64 × 36 pixels, minus the time of the same render with an engine
that only returns an empty picture: Blender's own share. A child process renders twice. Its first render loads the
compiled files on disk, or compiles if the cache is empty.
"""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

import bpy
import host

from .progress import Progress
from .resume import Parts

LIMIT, COLD_LIMIT = 1.0, 60.0  # maximum seconds that a user should wait

HELP = "time to the first pixels, with compiled kernels and without"
BRIEF = dict(cold=False)


def arguments(parser) -> None:
    parser.add_argument("--no-cold", dest="cold", action="store_false", help="leave out the start with empty caches")


def work_folder() -> pathlib.Path:
    """A folder for files that live as long as one measurement."""
    folder = host.REPOSITORY / "build" / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


class EmptyEngine(bpy.types.RenderEngine):
    """Blender's own cost of a render: evaluating the scene, decoding image files and showing a result."""

    bl_idname = "SDF_LIGHTS_BENCH_EMPTY"
    bl_label = "Empty"

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)

    def render(self, depsgraph):
        for image in bpy.data.images:
            if image.has_data or image.packed_file or image.filepath:
                image.pixels[0]  # Blender decodes a file on first use, once for all engines
        result = self.begin_result(0, 0, self.resolution_x, self.resolution_y, layer=depsgraph.view_layer.name)
        self.end_result(result)


def _seconds(engine: str) -> float:
    scene = bpy.context.scene
    scene.render.engine = engine
    started = time.perf_counter()
    bpy.ops.render.render()
    return time.perf_counter() - started


def child(blend: str, device: str) -> dict:
    """Seconds above Blender's own, of the first and of later renders in this process."""
    bpy.utils.register_class(EmptyEngine)
    host.register_extension()
    bpy.ops.wm.open_mainfile(filepath=blend)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 36, 100
    settings = scene.sdf_lights
    settings.samples, settings.device, settings.denoise, settings.noise_threshold = 1, device, False, 0.0
    _seconds(EmptyEngine.bl_idname)
    empty = statistics.median(_seconds(EmptyEngine.bl_idname) for _ in range(3))
    first = _seconds(host.ENGINE)
    later = statistics.median(_seconds(host.ENGINE) for _ in range(3))
    return dict(blender=empty, first=first - empty, later=later - empty)


def installed(cache: pathlib.Path) -> dict[str, str]:
    """Environment of a process that is to behave as an installation does, with this folder of compiled files."""
    return {
        **os.environ,
        "SDF_LIGHTS_CACHE": str(cache),
        "PYTHONPATH": str(host.REPOSITORY / "scripts"),
        # Python's bytecode is part of what an installation compiles once, for any option of this process.
        "PYTHONPYCACHEPREFIX": str(cache / "bytecode"),
        "PYTHONDONTWRITEBYTECODE": "",
    }


def _measure(blend: pathlib.Path, device: str, cache: str) -> dict:
    command = f"from benchmarks import startup; startup.answer({str(blend)!r}, {device!r}, {{!r}})"
    with tempfile.TemporaryDirectory(dir=work_folder()) as folder:
        answer = pathlib.Path(folder) / "answer.json"
        done = subprocess.run(
            [sys.executable, "-c", command.format(str(answer))],
            env=installed(pathlib.Path(cache)),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=900,
        )
        if not answer.is_file():
            raise RuntimeError(f"The render that was to be timed failed:\n{done.stdout}")
        return json.loads(answer.read_text(encoding="utf-8"))


def answer(blend: str, device: str, path: str) -> None:
    """Entry of the child process."""
    pathlib.Path(path).write_text(json.dumps(child(blend, device)), encoding="utf-8")
    host.finish(0)


def turns(options) -> int:
    return options.repeats or (1 if options.quick else 3)


def measured(options, parts: Parts, progress: Progress) -> tuple[dict, list[dict]]:
    """Summary and rows; of the progress this is one step more than ``turns``."""
    import demo

    blend, device = demo.demo_scene(), options.device
    # This cache is kept while the run is unfinished: an interrupted run continues with the compiled files.
    cache = work_folder() / f"kernels-{device.lower()}" if options.cold else host.REPOSITORY / "build" / "kernels"

    def measure() -> dict:
        return _measure(blend, device, str(cache))

    def anew() -> dict:
        shutil.rmtree(cache, ignore_errors=True)
        return measure()

    progress.show("start-up, with empty caches" if options.cold else "start-up, which may compile")
    cold = parts.of("cold start-up", anew if options.cold else measure)
    if not cache.is_dir():
        anew()
    progress.step()
    warm = []
    for turn in range(turns(options)):
        progress.show(f"start-up {turn}")
        warm.append(parts.of(f"start-up {turn}", measure))
        progress.step()
    if options.cold:
        shutil.rmtree(cache, ignore_errors=True)
    first, later = (statistics.median(one[name] for one in warm) for name in ("first", "later"))
    rows = [
        dict(start="Blender's own share", seconds=statistics.median(one["blender"] for one in warm)),
        dict(start=f"F12 in a new process, over Blender's own: under {LIMIT:g} s wanted", seconds=first),
        dict(start=f"F12 again, over Blender's own: under {LIMIT:g} s wanted", seconds=later),
    ]
    summary = dict(startup_seconds=first, startup_seconds_later=later)
    if options.cold:
        rows.insert(
            1, dict(start=f"F12 after the installation: compiles, under {COLD_LIMIT:g} s wanted", seconds=cold["first"])
        )
        summary["cold_compile_seconds"] = cold["first"] - first
    return summary, rows


def run(options) -> tuple[dict, list[dict]]:
    progress, parts = Progress(1 + turns(options)), Parts(options)
    found = measured(options, parts, progress)
    parts.finish()
    progress.close()
    return found
