# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One module a benchmark, and what they share. A benchmark has

- ``HELP``: one line;
- ``run(options) -> (summary, rows)``: ``summary`` maps names to numbers, ``rows`` is a list of flat dictionaries;
- ``arguments(parser)``, where it has options of its own; their names differ between benchmarks.

``options`` has ``quick`` (few repeats, small pictures), ``repeats`` (None: the benchmark's own number) and ``device``
(value of ``scene.sdf_lights.device``).
"""

NAMES = ("throughput", "startup", "intervals", "estimators", "lamps", "scaling", "viewport")
