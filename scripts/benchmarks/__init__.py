# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One module per benchmark, and their shared code. A benchmark has

- ``HELP``: one line;
- ``run(options) -> (summary, rows)``: ``summary`` maps names to numbers, ``rows`` is a list of flat dictionaries;
- ``arguments(parser)``, where it has options of its own; their names differ between benchmarks;
- ``BRIEF``, where ``all --quick`` is to run less than its quick form: values of options that are not given;
- ``complaints(rows) -> sentences``, where it judges what it has found: one for each failure, and the exit code is 1.

``options`` has ``quick`` (few repeats, small pictures), ``repeats`` (None: the benchmark's own number) and ``device``
(value of ``scene.sdf_lights.device``).
"""

import argparse

import host  # puts the measured package on the path

NAMES = (
    "throughput",
    "startup",
    "start",
    "intervals",
    "kinds",
    "grids",
    "builds",
    "estimators",
    "lamps",
    "cycles",
    "paper",
    "scaling",
    "programs",
    "wavefront",
    "gpucuts",
    "viewport",
    "nodes",
    "files",
    "fuzz",
    "features",
    "scenes",
    "allocation",
    "indirect",
    "caustics",
    "revisions",
    "trust",
    "hard",
    "check",
)


def some_of(known):
    """Type of an argument that is a list of ``known`` names, separated by commas."""

    def read(text: str) -> list[str]:
        names = text.split(",")
        for name in names:
            if name not in known:
                raise argparse.ArgumentTypeError(f"there is no '{name}': choose from {', '.join(known)}")
        return names

    return read
