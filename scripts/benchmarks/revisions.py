# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""This checkout, or another revision, beside an older one: start-up, compilation and samples a second, in turns.

All times are processor times of a whole process. The start is that from its launch to a first picture of 64 × 36 pixels
and one sample. Compilation is what that takes longer with empty caches. Rates are of renders with the same work in
both: paths do not split, and all pixels have as many samples. What a sample of a later revision costs more may pay by
less error, so error × time is measured, too, by the scatter of eight seeds. The file with lamps is saved by the older
revision.
"""

from __future__ import annotations

import contextlib
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

import bpy
import host

from . import simple_scenes
from .progress import Progress
from .startup import installed, work_folder

HELP = "this checkout, or another revision, beside an older one: start-up, compilation, samples a second"
SCENES = ("diffuse", "principled", "lamps")
SESSION = pathlib.Path(__file__).with_name("revision_session.py")


def arguments(parser) -> None:
    parser.add_argument("--before", metavar="REVISION", help="the older revision; without one, nothing is measured")
    parser.add_argument("--after", metavar="REVISION", help="the later revision (default: this checkout)")


def _scene(name: str, older: pathlib.Path, path: pathlib.Path) -> None:
    """Save a scene as a file."""
    if name == "lamps":
        _run([older / "scripts" / "demo_scene.py", path], installed(path.parent / "demo"))
        return
    simple_scenes.boxes_and_sphere(64)
    simple_scenes.add_point_light()
    if name == "principled":
        simple_scenes.make_principled()
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)


def _run(command: list, environment: dict) -> None:
    done = subprocess.run([sys.executable, *command], env=environment, capture_output=True, text=True, timeout=900)
    if done.returncode:
        raise RuntimeError(f"{command[0]} failed:\n{done.stdout}{done.stderr}")


def _measure(checkout: pathlib.Path, blend: pathlib.Path, cache: pathlib.Path, options) -> dict:
    size, few, many = (128, 8, 40) if options.quick else (256, 8, 72)
    answer = cache / "answer.json"
    environment = {**installed(cache), "PYTHONPATH": ""}
    _run([SESSION, checkout, blend, *map(str, (size, few, many)), answer], environment)
    return json.loads(answer.read_text(encoding="utf-8"))


def run(options) -> tuple[dict, list[dict]]:
    if not options.before:
        return {}, []
    turns = options.repeats or (1 if options.quick else 5)
    progress = Progress((turns + 1) * len(SCENES))
    found: dict[tuple, list[dict]] = {}
    with contextlib.ExitStack() as stack:
        folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory(dir=work_folder())))
        older = stack.enter_context(host.checkout_of(options.before, folder / "older"))
        later = host.REPOSITORY
        if options.after:
            later = stack.enter_context(host.checkout_of(options.after, folder / "later"))
        checkouts = dict(before=older, now=later)
        for scene in SCENES:
            blend = folder / f"{scene}.blend"
            progress.show(f"{scene}, compiling")
            _scene(scene, older, blend)
            for turn in range(turns + 1):  # the first compiles what is new
                for which, checkout in checkouts.items():
                    cache = folder / which
                    cache.mkdir(exist_ok=True)
                    found.setdefault((scene, which), []).append(_measure(checkout, blend, cache, options))
                progress.step()
                progress.show(f"{scene} {turn + 1}")
    progress.close()
    median = {
        (*key, what): statistics.median(one[what] for one in each[1:])
        for key, each in found.items()
        for what in ("start", "rate", "error")
    }

    def row(what: str, before: float, now: float) -> dict:
        return dict(what=what, before=before, now=now, ratio=now / before)

    first = SCENES[0]
    starts = [median[first, which, "start"] for which in checkouts]
    rows = [
        row("start to the first picture, seconds", *starts),
        row("compilation, seconds", *(found[first, w][0]["start"] - s for w, s in zip(checkouts, starts))),
        *(row(f"samples a second, {s}", *(median[s, w, "rate"] for w in checkouts)) for s in SCENES),
        *(
            row(f"error × time, {s}", *(median[s, w, "error"] / median[s, w, "rate"] for w in checkouts))
            for s in SCENES
        ),
    ]
    names = (
        "start_ratio",
        "compilation_ratio",
        *(f"samples_ratio_{scene}" for scene in SCENES),
        *(f"error_time_ratio_{scene}" for scene in SCENES),
    )
    return dict(zip(names, (each["ratio"] for each in rows))), rows
