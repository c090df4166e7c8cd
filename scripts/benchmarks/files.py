# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every .blend in a folder by Cycles and by our engine, each in a separate process, small: exceptions, warnings, means.

Without a folder, all materials and groups of shader nodes in Blender's asset libraries, each on a ball. A file keeps
its own settings, except those that must be equal for a fair comparison.
"""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys
import tempfile

import bpy
import host

from .progress import Progress
from .resume import Parts

HELP = "all .blend files of a folder, or Blender's own assets, in both engines: exceptions, warnings, means"
BRIEF = dict(most=1)
SECONDS = 600  # maximum time for one file


def arguments(parser) -> None:
    parser.add_argument(
        "--folder",
        type=pathlib.Path,
        metavar="FOLDER",
        help="search this folder for .blend files (default: the assets that come with Blender)",
    )
    parser.add_argument("--most", type=int, metavar="N", help="at most so many files, the smallest")
    parser.add_argument("--file-samples", type=int, default=16, metavar="N", help="samples of either engine (16)")
    parser.add_argument("--file-size", type=int, default=96, metavar="N", help="pixels of the longer side (96)")
    parser.add_argument("--keep", type=pathlib.Path, metavar="OUT", help="write a picture of each pair here")


def libraries() -> list[pathlib.Path]:
    """Blender's asset libraries that may contain materials or shader nodes."""
    root = pathlib.Path(bpy.utils.system_resource("DATAFILES", path="assets"))
    return sorted(path for path in root.rglob("*.blend") if "brush" not in path.name)


def summary_of(rows: list[dict]) -> dict:
    known = [row["mean_ratio"] for row in rows if row["mean_ratio"] is not None]
    return dict(
        files=len({row["file"] for row in rows}),
        file_pictures=len(rows),
        files_failed=sum(bool(row["error"]) for row in rows),
        files_with_warnings=sum(bool(row["warnings"]) for row in rows),
        files_within_two_percent=sum(abs(ratio - 1.0) <= 0.02 for ratio in known),
    )


def complaints(rows: list[dict]) -> list[str]:
    """A sentence for each file without a picture by our engine, from the rows of all benchmarks."""
    return [f"{row['file']} {row['part']}: {row['error']}" for row in rows if "file" in row and row["error"]]


def run(options) -> tuple[dict, list[dict]]:
    assets = options.folder is None
    paths = libraries() if assets else sorted(options.folder.rglob("*.blend"), key=lambda path: path.stat().st_size)
    paths = paths[: options.most or (2 if options.quick else None)]
    progress, parts, rows = Progress(max(len(paths), 1)), Parts(options), []
    for path in paths:
        progress.show(path.name)
        rows += parts.of(str(path), lambda: opened(path, assets, options))
        progress.step()
    parts.finish()
    progress.close()
    return summary_of(rows), rows


def opened(path: pathlib.Path, assets: bool, options) -> list[dict]:
    """Rows of one file: one for its scene, or one for each of its assets."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "rows.json"
        job = dict(
            path=str(path.resolve()),
            assets=assets,
            samples=options.file_samples,
            size=options.file_size,
            device=options.device,
            out=str(out),
            keep=str(options.keep.resolve()) if options.keep else "",
        )
        command = [sys.executable, "-m", "benchmarks.file_session", json.dumps(job)]
        try:
            done = subprocess.run(
                command, cwd=host.REPOSITORY / "scripts", capture_output=True, text=True, timeout=SECONDS
            )
            end = (done.stderr.strip().splitlines() or ["no message"])[-1]
            problem = f"the process ended with code {done.returncode}: {end}" if done.returncode else ""
        except subprocess.TimeoutExpired:
            problem = f"not done after {SECONDS} seconds"
        rows = json.loads(out.read_text(encoding="utf-8")) if out.is_file() else []
    if problem or not rows and not assets:
        rows.append(
            dict(
                file=path.name,
                part="",
                nodes="",
                mean_cycles=None,
                mean_ours=None,
                mean_ratio=None,
                error=problem or "no scene could be rendered",
                warnings="",
            )
        )
    return rows
