# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of benchmarks, as ``bench --out`` writes them, their summaries, and the commands that make them again."""

from __future__ import annotations

import functools
import hashlib
import json
import pathlib
import subprocess
import sys
from dataclasses import dataclass

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
RESULTS = REPOSITORY / "docs" / "report"
# All rows, and renders. Too large to be kept: the report keeps summaries, and the images that were drawn from them.
RAW = REPOSITORY / "build" / "report"

# Enough for references whose standard error is a tenth of the least error that they judge; they stop then.
_LAMPS = ["--size", "96", "--reference-seconds", "1200"]
_LADDER = ["--ladder", "4,16,64"]
RUNS = {  # result: arguments of ./scripts/bench
    "cycles_direct": ["cycles", "--bounces", "0", *_LADDER, *_LAMPS],
    "cycles_bounces": ["cycles", "--bounces", "4", *_LADDER, *_LAMPS],
    "corridor": [
        *("cycles", "--bounces", "0", "--samplers", "CUT", *_LADDER, *_LAMPS),
        *("--only", "corridor_sign,corridor_voxels,corridor_network"),
    ],
    "kinds": ["kinds"],
    "grids": ["grids"],
    "paper": ["paper", *_LAMPS],
    "estimators": ["estimators"],
    "intervals": ["intervals"],
    "throughput": ["throughput"],
    "scaling": ["scaling"],
    "hard": ["hard"],
}

METHODS = {  # name in the results: label, colour, marker
    "CUT": ("SDF Lights: cuts, the default", "#1f6fb4", "o"),
    "MIS": ("SDF Lights: the paper's sampler", "#e08214", "s"),
    "PROJECTION": ("SDF Lights: projection sampling", "#8073ac", "v"),
    "BSDF": ("SDF Lights: BSDF samples", "#878787", "x"),
    "Cycles volume": ("Cycles: emission volume", "#2a8a4a", "^"),
    "Cycles mesh light": ("Cycles: mesh light (another lamp)", "#c0392b", "D"),
}
RULES = (  # key of the evaluations on a ray: label, colour, marker
    ("evaluations", "SDF Lights", "#1f6fb4", "o"),
    ("published_coarse_evaluations", "published rule, coarse", "#fdb863", "s"),
    ("published_evaluations", "published rule, at our resolution", "#e08214", "s"),
    ("spheres_evaluations", "sphere tracing, at our resolution", "#2a8a4a", "^"),
)
NUMBERS = {  # of scaling
    "lamps": "lamps",
    "parts": "balls in one lamp",
    "triangles": "triangles",
    "resolution": "pixels to a side",
}
METRICS = {"rel_mse": "relMSE", "mape": "MAPE", "flip": "FLIP"}


@dataclass(frozen=True)
class Result:
    """One object of ``bench --json``, or a summary of it. ``full_digest``: of all that was measured, in a summary."""

    name: str
    command: str
    summary: dict[str, float]
    rows: list[dict]
    machine: dict
    full_digest: str | None = None

    def of(self, **wanted) -> list[dict]:
        """Rows with these values."""
        return [row for row in self.rows if all(key in row and row[key] == value for key, value in wanted.items())]

    @functools.cached_property
    def digest(self) -> str:
        """Hash of all measured values."""
        if self.full_digest is not None:
            return self.full_digest
        content = json.dumps([self.command, self.summary, self.rows, self.machine], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    def renders(self, scene: str) -> set[str]:
        """Hashes of the files with renders of a scene that were kept when it was measured."""
        return {row["renders"] for row in self.of(scene=scene) if "renders" in row}


def read(folder: pathlib.Path = RESULTS) -> dict[str, Result]:
    """All results in a folder by name, those of ``RUNS`` first and in their order."""
    found = {}
    order = list(RUNS)
    paths = sorted(
        folder.glob("*.json"),
        key=lambda path: (order.index(path.stem) if path.stem in order else len(order), path.stem),
    )
    for path in paths:
        data = json.loads(path.read_text(encoding="utf-8"))
        if {"command", "summary", "rows", "machine"} <= set(data):
            found[path.stem] = Result(
                path.stem, data["command"], data["summary"], data["rows"], data["machine"], data.get("full_digest")
            )
    return found


def write(summary: Result, folder: pathlib.Path = RESULTS) -> None:
    """Keep a summary, a line for each row."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = ",\n".join(json.dumps(row, ensure_ascii=False) for row in summary.rows)
    data = {key: getattr(summary, key) for key in ("command", "full_digest", "machine", "summary")}
    text = json.dumps(data, indent=1, ensure_ascii=False).removesuffix("\n}")
    (folder / f"{summary.name}.json").write_text(f'{text},\n "rows": [\n{rows}\n]\n}}\n', encoding="utf-8")


def raw_folder(folder: pathlib.Path) -> pathlib.Path:
    """Folder of all rows, and of the renders, that the summaries in a folder are of."""
    return RAW if folder == RESULTS else folder / "raw"


def _named(path: pathlib.Path) -> str:
    """As a command of the repository."""
    path = path.resolve()
    return str(path.relative_to(REPOSITORY) if path.is_relative_to(REPOSITORY) else path)


def run(name: str, folder: pathlib.Path = RESULTS, quick: bool = False) -> int:
    """Measure one of ``RUNS``, into the ``raw_folder`` of a folder of summaries; the exit code, which is 0 unless it
    failed or a limit does not hold.

    An interrupted run continues. ``quick``: only shows that it works.
    """
    folder = raw_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    arguments = [*RUNS[name], *(["--quick"] if quick else []), "--out", _named(folder / f"{name}.json")]
    if RUNS[name][0] in ("cycles", "paper"):
        arguments += ["--pictures", _named(folder)]
    return subprocess.run(
        [sys.executable, REPOSITORY / "scripts" / "bench.py", *arguments], cwd=REPOSITORY, stdout=subprocess.DEVNULL
    ).returncode
