# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The first minutes, on empty caches: the demo after its downloads, the first F12 of an installed zip, and how long its
window is busy while kernels compile beside it. Also how far the demo's quick picture is from one of many samples.
"""

from __future__ import annotations

import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import host
import numpy as np
import OpenImageIO
import shipped_kernels
from sessions import SessionError, seen_by

from . import errors, some_of
from .progress import Progress
from .resume import Parts
from .startup import work_folder

HELP = "the first minutes: the demo, the first F12 of an installed zip, and the window meanwhile"

PARTS = ("demo", "f12", "pixels", "window", "picture")
BRIEF = dict(parts=[])  # each takes minutes

LIMITS = dict(demo_seconds_after_downloads=120.0, cold_first_pixels_seconds=15.0, longest_stall_ms=50.0)
SESSION = pathlib.Path(__file__).with_name("start_session.py")
WATCHED_SECONDS, RUNS = 30.0, 3  # without the add-on, and then with it, in each run of the window
MANY_SAMPLES, COMPARED_SIZE = "48", "480x270"  # of the demo, where its quick picture is compared


def _environment(**more: str) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if not name.startswith("SDF_LIGHTS_CACHE")}
    return kept | more


def _demo() -> dict:
    """Seconds until the demo's preview and its picture are on disk, without kernels, and without its scene."""
    for scene in (host.REPOSITORY / "build" / "demo").glob("demo-*.blend"):
        scene.unlink()
    with tempfile.TemporaryDirectory(dir=work_folder()) as folder:
        out = pathlib.Path(folder) / "demo"
        preview = out.with_name("demo-preview.png")
        command = [sys.executable, host.REPOSITORY / "scripts" / "demo.py", "--out", out]
        started, seen = time.perf_counter(), None
        process = subprocess.Popen(
            command,
            env=_environment(SDF_LIGHTS_CACHE=str(pathlib.Path(folder) / "kernels")),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        while process.poll() is None:
            if seen is None and preview.is_file():
                seen = time.perf_counter() - started
            time.sleep(0.05)
        if process.returncode:
            raise RuntimeError(f"The demo failed:\n{process.stderr.read() if process.stderr else ''}")
        return dict(preview=seen, picture=time.perf_counter() - started)


def _shown(folder: pathlib.Path, *arguments: str) -> np.ndarray:
    """The demo's picture as a screen shows it, (height, width, 3) in [0, 1]."""
    out = folder / "-".join(("demo", *arguments))
    done = subprocess.run(
        [sys.executable, host.REPOSITORY / "scripts" / "demo.py", "--out", out, "--size", COMPARED_SIZE, *arguments],
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"The demo failed:\n{done.stderr}")
    return OpenImageIO.ImageBuf(f"{out}.png").get_pixels(OpenImageIO.FLOAT)[..., :3]


def _difference() -> dict | None:
    """FLIP of the demo's picture to one of ``MANY_SAMPLES``, and to one of as many samples with another seed; None
    without flip-evaluator."""
    if importlib.util.find_spec("flip_evaluator") is None:
        return None
    with tempfile.TemporaryDirectory(dir=work_folder()) as name:
        folder = pathlib.Path(name)
        many = _shown(folder, "--samples", MANY_SAMPLES)
        quick, other = _shown(folder), _shown(folder, "--seed", "1")
        return dict(flip=errors.flip_of_shown(quick, many), seeds=errors.flip_of_shown(quick, other))


def _zip(folder: pathlib.Path, python: str, kernels: bool) -> pathlib.Path:
    import build_extension

    return build_extension.build(build_extension.this_platform(), python, folder, with_kernels=kernels)


def _first_picture() -> dict:
    with tempfile.TemporaryDirectory(dir=work_folder()) as name:
        folder = pathlib.Path(name)
        path = _zip(folder, "%d.%d" % sys.version_info[:2], kernels=True)
        report = folder / "report.json"
        (folder / "resources").mkdir()
        done = subprocess.run(
            [sys.executable, SESSION, report, path, "F12"],
            env=_environment(BLENDER_USER_RESOURCES=str(folder / "resources")),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        if not report.is_file():
            raise RuntimeError(f"The first render failed:\n{done.stdout}")
        return json.loads(report.read_text(encoding="utf-8"))


def _in_window(folder: pathlib.Path, path: pathlib.Path, *words: str) -> dict:
    """The report of a session in a Blender with a window and with empty user folders."""
    with tempfile.TemporaryDirectory(dir=folder) as name:
        resources = pathlib.Path(name) / "resources"
        resources.mkdir()
        without = _environment(BLENDER_USER_RESOURCES=str(resources))
        kept = os.environ.pop("SDF_LIGHTS_CACHE", None)
        try:
            command = host.windowed_blender()
            return seen_by(command, SESSION, pathlib.Path(name), str(path), *words, environment=without)
        except SessionError as error:
            raise RuntimeError(str(error)) from error
        finally:
            if kept is not None:
                os.environ["SDF_LIGHTS_CACHE"] = kept


def _first_pixels() -> dict | None:
    """Seconds until the first pixels in a window, each in a new installation; None if there is no Blender with one, or
    no zip with kernels for its Python."""
    command = host.windowed_blender()
    if command is None or shipped_kernels.compiler(host.python_of(command)) is None:
        return None
    with tempfile.TemporaryDirectory(dir=work_folder()) as name:
        path = _zip(pathlib.Path(name), host.python_of(command), kernels=True)
        return {kind: _in_window(pathlib.Path(name), path, "PIXELS", kind) for kind in ("VIEWPORT", "F12")}


def _stalls() -> list[dict] | None:
    """The measurements in the window, several times; None if there is no Blender with one."""
    command = host.windowed_blender()
    if command is None:
        return None
    with tempfile.TemporaryDirectory(dir=work_folder()) as name:
        path = _zip(pathlib.Path(name), host.python_of(command), kernels=False)
        return [_in_window(pathlib.Path(name), path, "STALLS", str(WATCHED_SECONDS)) for _ in range(RUNS)]


def arguments(parser) -> None:
    parser.add_argument(
        "--parts", type=some_of(PARTS), default=list(PARTS), metavar="NAMES", help=f"some of {','.join(PARTS)}"
    )


def run(options) -> tuple[dict, list[dict]]:
    parts, progress = Parts(options), Progress(max(len(options.parts), 1))
    measures = dict(demo=_demo, f12=_first_picture, pixels=_first_pixels, window=_stalls, picture=_difference)
    found = {}
    for name in options.parts:
        progress.show(name)
        found[name] = parts.of(name, measures[name])
        progress.step()
    parts.finish()
    progress.close()
    summary, rows = {}, []

    def add(name: str, value: float, title: str) -> None:
        summary[name] = value
        limit = LIMITS[name]
        rows.append(dict(what=title, value=value, limit=limit, holds="yes" if value <= limit else "no"))

    if demo := found.get("demo"):
        add("demo_seconds_after_downloads", demo["picture"], "the demo's picture, seconds")
        rows.append(dict(also="the demo's preview, seconds", value=demo["preview"]))
    first, seen = found.get("f12"), found.get("pixels")
    if first or seen:
        cold = [first["first"]] if first else []
        cold += [times["from_begin"] for times in (seen or {}).values()]
        add("cold_first_pixels_seconds", max(cold), "the first pixels after an installation, at most, seconds")
    if first:
        rows.append(dict(also="the first F12 of an installed zip, without a window, seconds", value=first["first"]))
        rows.append(dict(also="the same, time of processors", value=first["first_processor"]))
        rows.append(dict(also="the same, most memory, MB", value=first["memory"]))
        rows.append(dict(also="F12 again, seconds", value=first["later"]))
    for kind, times in (seen or {}).items():
        title = f"{kind.lower() if kind == 'VIEWPORT' else kind} in a window"
        rows.append(dict(also=f"{title}, from the begin of the installation", value=times["from_begin"]))
        rows.append(dict(also=f"{title}, from its end", value=times["from_end"]))
    if window := found.get("window"):
        # What the add-on does shows in every run, what other programs do only in some: the least of the longest times.
        longest, alone = (
            min(max(each[phase]["drawing"], each[phase]["other"]) for each in window) for phase in ("after", "before")
        )
        add(
            "longest_stall_ms", longest, f"the window without an answer while kernels compile, least of {RUNS} runs, ms"
        )
        summary["longest_stall_ms_without_the_add_on"] = alone
        rows[-1]["without"] = alone
        # The processor time of one thread hardly depends on other programs: its maximum over all runs.
        summary["longest_work_ms"] = max(each["after"]["work"] for each in window)
        kinds = dict(
            drawing="the same while Blender draws its status bar, ms",
            other="the same at all other times, ms",
            work="what the thread of the window computed at once, ms",
            over_50="number of times of more than 50 ms",
        )
        for number, each in enumerate(window, 1):
            rows += [
                dict(also=f"run {number}: {title}", value=each["after"][kind], without=each["before"][kind])
                for kind, title in kinds.items()
            ]
        texts = window[0]["texts"]
        rows += [dict(status=text) for text in texts[:: max(len(texts) // 8, 1)]]
    if picture := found.get("picture"):
        summary["demo_flip"] = picture["flip"]
        rows.append(dict(also=f"FLIP of the demo's picture to that of {MANY_SAMPLES} samples", value=picture["flip"]))
        rows.append(dict(also="FLIP of two such pictures with different seeds", value=picture["seeds"]))
    elif "picture" in found:
        rows.append(dict(also="FLIP is left out: scripts/README.md says how to install flip-evaluator"))
    return summary, rows
