# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels of textures where Numba is missing: ``python plain_textures.py CALLS.json RESULT.json``.

A call is [name of the kernel, static arguments, rows of operands]; its result is a list for each row.
"""

import itertools
import json
import pathlib
import sys

sys.modules["numba"] = None
sys.path.insert(0, str(pathlib.Path(__file__).parents[3]))

from sdf_lights import jit  # noqa: E402
from sdf_lights.render.textures import brick, gabor, noise, voronoi, white_noise  # noqa: E402

assert not jit.AVAILABLE


def kernels() -> dict:
    found = [brick.brick, *gabor.KERNELS.values(), *white_noise.VALUE.values(), *white_noise.COLOR.values()]
    for dimensions in (1, 2, 3, 4):
        found += [noise.value(dimensions), noise.color(dimensions), noise.free_value(dimensions)]
        for hashing in (voronoi.WHOLE, voronoi.FLOATS):
            found += [voronoi.edge(dimensions, hashing), voronoi.radius(dimensions, hashing)]
            for make, feature in itertools.product((voronoi.distance, voronoi.cell), voronoi.FEATURES.values()):
                found.append(make(feature, dimensions, hashing))
    return {f"{kernel.__module__}.{kernel.__name__}": kernel for kernel in found}


def main(calls, result):
    known = kernels()
    found = [[known[name](*static, *row) for row in rows] for name, static, rows in json.loads(calls.read_text())]
    result.write_text(json.dumps([[row if isinstance(row, tuple) else [row] for row in rows] for rows in found]))


if __name__ == "__main__":
    main(*map(pathlib.Path, sys.argv[-2:]))
