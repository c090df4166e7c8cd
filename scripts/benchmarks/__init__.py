# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One module a benchmark, each with

- ``HELP``: one line;
- ``run(options) -> (summary, rows)``: ``summary`` maps names to numbers, ``rows`` is a list of flat dictionaries.

``options`` has ``quick`` (few repeats, small pictures), ``repeats`` (None: the benchmark's own number) and ``device``
(value of ``scene.sdf_lights.device``).
"""

NAMES = ("throughput", "startup", "intervals", "estimators")
