# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of benchmarks, as ``bench --out`` writes them, and how they are made again."""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys
from dataclasses import dataclass

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
RESULTS = REPOSITORY / "docs" / "report"
PICTURES = REPOSITORY / "build" / "report"  # too large to be kept; the report keeps what it draws of them

_PICTURES = ["--pictures", "build/report"]
_LAMPS = ["--size", "96", *_PICTURES]
RUNS = {  # result: arguments of ./scripts/bench
    "cycles_direct": ["cycles", "--bounces", "0", "--ladder", "4,16,64", "--reference-seconds", "10", *_LAMPS],
    "cycles_bounces": [
        "cycles", "--bounces", "4", "--size", "128", "--ladder", "4,16,64", "--reference-seconds", "16", *_PICTURES],
    "paper": ["paper", "--reference-seconds", "15", *_LAMPS],
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
METRICS = {"rel_mse": "relMSE", "mape": "MAPE", "flip": "FLIP"}


@dataclass(frozen=True)
class Result:
    """One object of ``bench --json``."""

    name: str
    command: str
    summary: dict[str, float]
    rows: list[dict]
    machine: dict

    def of(self, **wanted) -> list[dict]:
        """Rows that have these values."""
        return [row for row in self.rows if all(key in row and row[key] == value for key, value in wanted.items())]


def read(folder: pathlib.Path = RESULTS) -> dict[str, Result]:
    """All results in a folder by name, those of ``RUNS`` first and in their order."""
    found = {}
    order = list(RUNS)
    paths = sorted(folder.glob("*.json"), key=lambda path: (
        order.index(path.stem) if path.stem in order else len(order), path.stem))
    for path in paths:
        data = json.loads(path.read_text(encoding="utf-8"))
        if {"command", "summary", "rows", "machine"} <= set(data):
            found[path.stem] = Result(path.stem, data["command"], data["summary"], data["rows"], data["machine"])
    return found


def run(name: str) -> None:
    """Measure one of ``RUNS``; an interrupted run goes on."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    path = RESULTS / f"{name}.json"
    subprocess.run([sys.executable, REPOSITORY / "scripts" / "bench.py", *RUNS[name], "--out",
                    path.relative_to(REPOSITORY)], cwd=REPOSITORY, check=True, stdout=subprocess.DEVNULL)
