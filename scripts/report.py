# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/report.md and its plots from summaries of benchmarks in docs/report, which it can measure again."""

from __future__ import annotations

import argparse
import hashlib
import pathlib
import sys

from reporting import page, plots, prose, records, results, summaries

PAGE = results.REPOSITORY / "docs" / "report.md"
FIGURES = {"intervals": plots.crossings, "scaling": plots.scaling}
IMAGES = results.REPOSITORY / "docs" / "images"


def draw(found: dict[str, results.Result], images: pathlib.Path, kept: pathlib.Path) -> None:
    """All plots of results; pictures only of renders that are still ``kept``, and belong to these results."""
    for name in prose.DRAWN:
        if name not in found:
            continue
        result = found[name]
        if name in FIGURES:
            FIGURES[name](result, images / f"report_{name}.png")
            continue
        if name in prose.LIGHT:
            for metric in plots.METRICS:
                path = images / f"report_{name}_{metric}.png"
                if not plots.against_time(result, metric, path):
                    path.unlink(missing_ok=True)  # of other results
            bounces = {row["bounces"] for row in result.rows}
            files = [
                (row["scene"], kept / f"{row['scene']} {count}.npz")
                for count in bounces
                for row in result.rows
                if "method" not in row
            ]
            methods = [prose.OURS, prose.PAPER, *prose.PEERS]
        else:
            files = [(row["scene"], kept / f"{row['scene']}.npz") for row in result.rows if "competitor" in row]
            methods = ["PROJECTION", prose.OURS]
        for scene, file in files:
            own = result.renders(scene)
            if not file.is_file():
                continue
            if own and hashlib.sha256(file.read_bytes()).hexdigest() not in own:
                print(f"{file} holds other renders than those of {name}.", file=sys.stderr)
                continue
            plots.pictures(file, methods, images / f"report_pictures_{name}_{scene}.png", result if own else None)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="report", description="Write docs/report.md and its plots.")
    parser.add_argument(
        "--run",
        nargs="*",
        choices=list(results.RUNS),
        metavar="RESULT",
        help=f"measure these again first (default: all): {', '.join(results.RUNS)}",
    )
    parser.add_argument(
        "--keep", nargs="+", default=[], metavar="RESULT", help="show these, which bench --out wrote to build/report"
    )
    parser.add_argument("--quick", action="store_true", help="measure as bench --quick does: only to see that it works")
    parser.add_argument(
        "--to", type=pathlib.Path, metavar="FOLDER", help="keep summaries, plots and the page there, instead of in docs"
    )
    options = parser.parse_args(arguments)
    if options.quick and not options.to:
        parser.error("--quick needs --to: docs/report.md is for what was measured in full")
    kept, images, text = results.RESULTS, IMAGES, PAGE
    if options.to:
        kept, images, text = options.to, options.to / "images", options.to / "report.md"
    failed = []
    again = [] if options.run is None else options.run or list(results.RUNS)
    for name in again:
        print(f"{name}:", file=sys.stderr)
        if results.run(name, kept, options.quick):
            failed.append(name)  # a limit that does not hold belongs on the page, too
    raw = results.read(results.raw_folder(kept))
    for name in (*again, *options.keep):
        if name in raw:
            results.write(summaries.summarised(raw[name], draw), kept)
        else:
            print(f"{results.raw_folder(kept)} has no result {name}.", file=sys.stderr)
            failed += [name] if name not in failed else []
    found = results.read(kept)
    if not found:
        print(f"There are no results in {kept}: ./scripts/report --run measures them.", file=sys.stderr)
        return 1
    draw(found, images, results.raw_folder(kept))
    text.write_text(page.text(found, images, text), encoding="utf-8")
    _, others = records.compared(found, images)
    if others:
        print(f"Images of other results: {', '.join(others)}.", file=sys.stderr)
    missing = [name for name in results.RUNS if name not in found]
    if missing:
        print(
            f"Without results: {', '.join(missing)}. ./scripts/report --run {' '.join(missing)} measures them.",
            file=sys.stderr,
        )
    if failed:
        print(f"Failed: {', '.join(failed)}.", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
