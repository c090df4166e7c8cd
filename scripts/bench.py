# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs benchmarks: ``bench NAME [--json] [--quick]``."""

from __future__ import annotations

import argparse
import contextlib
import importlib
import json
import os
import pathlib
import shlex
import sys

import benchmarks
import host
from benchmarks import machine
from benchmarks.resume import Parts


@contextlib.contextmanager
def standard_output_for_results():
    """A stream to the real standard output; everything that Blender prints goes to standard error."""
    sys.stdout.flush()
    results = os.dup(1)
    os.dup2(2, 1)
    try:
        with os.fdopen(results, "w", encoding="utf-8") as stream:
            yield stream
    finally:
        sys.stdout.flush()


def cell(value) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def table(rows: list[dict]) -> str:
    """Rows as a text table; consecutive rows with the same columns share a heading."""
    blocks, columns = [], None
    for row in rows:
        if list(row) != columns:
            columns = list(row)
            blocks.append([columns])
        blocks[-1].append([cell(value) for value in row.values()])
    texts = []
    for block in blocks:
        widths = [max(map(len, column)) for column in zip(*block)]
        texts.append(
            "\n".join("  ".join(value.ljust(width) for value, width in zip(line, widths)).rstrip() for line in block)
        )
    return "\n\n".join(texts)


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="bench", description="Measure SDF Lights. scripts/README.md describes each benchmark."
    )
    subcommands = parser.add_subparsers(dest="name", required=True, metavar="NAME")
    modules = {name: importlib.import_module(f"benchmarks.{name}") for name in benchmarks.NAMES}
    for name, text in [*((name, module.HELP) for name, module in modules.items()), ("all", "all of them")]:
        # For ``all``: benchmarks that share an option get it from the same function.
        text = text.replace("%", "%%")  # argparse formats it
        command = subcommands.add_parser(name, help=text, description=text, conflict_handler="resolve")
        command.add_argument(
            "--json", action="store_true", help="print one JSON object: command, summary, rows, machine"
        )
        command.add_argument("--quick", action="store_true", help="fewer repeats and samples: only shows that it works")
        command.add_argument("--out", type=pathlib.Path, metavar="FILE", help="write that JSON object to a file, too")
        command.add_argument("--repeats", type=int, help="measurements of each figure; the median counts")
        command.add_argument(
            "--device",
            choices=["automatic", "cpu", "gpu", "reference"],
            default="automatic",
            help="back end (default: automatic)",
        )
        for module in modules.values() if name == "all" else [modules[name]]:
            if hasattr(module, "arguments"):
                module.arguments(command)
    options = parser.parse_args(arguments)
    options.device = options.device.upper()
    if options.repeats is not None and options.repeats < 1:
        parser.error("--repeats must be at least 1")
    options.defaults = vars(parser.parse_args([options.name]))
    options.modules = modules if options.name == "all" else {options.name: modules[options.name]}
    return options


def options_of(name: str, options: argparse.Namespace) -> argparse.Namespace:
    """The options of one benchmark, with its own values of shared options."""
    given = vars(options)
    brief = getattr(options.modules[name], "BRIEF", {}) if options.name == "all" and options.quick else {}
    chosen = {key: value for key, value in brief.items() if given[key] == options.defaults[key]}
    return argparse.Namespace(**given | chosen, benchmark=name)


def main(arguments: list[str]) -> int:
    options = parse(arguments)
    with standard_output_for_results() as stream:
        before = machine.describe()
        host.register_extension()
        summary, rows = {}, []
        parts = Parts(options)
        for place, (name, module) in enumerate(options.modules.items(), 1):
            if len(options.modules) > 1:
                print(f"{name} ({place} of {len(options.modules)})", file=sys.stderr)
            found, more = parts.of(name, lambda: module.run(options_of(name, options)))
            summary |= found
            rows += [row for row in more if row not in rows]
        parts.finish()
        command = shlex.join(["./scripts/bench", *arguments])
        result = dict(command=command, summary=summary, rows=rows, machine=before)
        if options.out:
            options.out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        if options.json:
            json.dump(result, stream)
            stream.write("\n")
        else:
            stream.write(f"{', '.join(f'{name} {value}' for name, value in before.items())}\n\n{table(rows)}\n\n")
            for name, value in summary.items():
                stream.write(f"{name}: {cell(value)}\n")
    said = [
        sentence
        for module in options.modules.values()
        if hasattr(module, "complaints")
        for sentence in module.complaints(rows)
    ]
    for sentence in said:
        print(sentence, file=sys.stderr)
    return 1 if said else 0


if __name__ == "__main__":
    try:
        code = main(sys.argv[1:])
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 1
    host.finish(code)
