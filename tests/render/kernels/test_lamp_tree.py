# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The hierarchy over lamps finds every lamp that a ray meets, and few others."""

import numpy as np
import pytest

from sdf_lights.emitter.arrays import Lamps
from sdf_lights.emitter.building.build import build_lamp
from sdf_lights.jit import block_dtype, fill_table, kernel
from sdf_lights.render.kernels.lamp_tree import (
    TABLES,
    WORKSPACE_TABLES,
    found_table,
    lamps_along,
    pack_lamp_tree,
    workspace_counts,
)
from sdf_lights.render.scene import Ray
from sdf_lights.sdf import shapes
from sdf_lights.sdf.expression import Expression
from support.scenes import rotation, scaling, translation

SHAPES = (
    shapes.Sphere(0.5),
    shapes.Torus(0.5, 0.2),
    shapes.Box((0.4, 0.3, 0.5)),
    shapes.Difference((shapes.Box((0.4, 0.4, 0.4)), shapes.Sphere(0.5))),
    Expression("smooth_union(sphere(0.3), translate(sphere(0.3), 0.4, 0, 0), 0.2)").shape(),
)


def crowd(count, seed=1):
    """Lamps of all kinds, overlapping and in one another, of sizes over four powers of ten."""
    rng = np.random.default_rng(seed)
    made = []
    for index in range(count):
        turned = rotation("x", rng.uniform(0.0, 360.0)) @ rotation("z", rng.uniform(0.0, 360.0))
        size = 10.0 ** rng.uniform(-3.0, 1.0) * rng.uniform(0.3, 1.0, 3)
        matrix = translation(*rng.normal(0.0, 3.0, 3)) @ turned @ scaling(*size)
        visibility = Ray.ALL if rng.random() < 0.7 else Ray.ALL & ~Ray.CAMERA
        made.append(build_lamp("", SHAPES[index % len(SHAPES)], matrix, visibility=visibility))
    return made


class Tree:
    """The hierarchy over built lamps in a block of its own."""

    def __init__(self, made):
        rows = (
            np.array([lamp.row[0] for lamp in made])
            if made
            else np.zeros(0, [("center", float, 3), ("half", float, 3), ("visibility", int)])
        )
        self._tables = pack_lamp_tree(rows["center"] - rows["half"], rows["center"] + rows["half"], rows["visibility"])
        self._tables |= {
            name: np.zeros(count, WORKSPACE_TABLES[name]) for name, count in workspace_counts(len(made)).items()
        }
        self._block = np.zeros(1, block_dtype({**TABLES, **WORKSPACE_TABLES}))
        for name, array in self._tables.items():
            fill_table(self._block, name, array)

    def along(self, o, d, t_max, kind):
        return _along(self._block, tuple(map(float, o)), tuple(map(float, d)), float(t_max), int(kind))


@kernel
def _along(blocks, o, d, t_max, kind):
    count = lamps_along(blocks[0], blocks[0], o, d, t_max, kind)
    return found_table(blocks[0])[:count].copy()


def rays(made, count, seed=5):
    """(o, d, t_max, kind): from far away, from inside lamps, along axes, and where a surface ends the ray."""
    rng = np.random.default_rng(seed)
    for index in range(count):
        row = made[rng.integers(len(made))].row[0]
        target = row["center"] + row["half"] * rng.uniform(-1.0, 1.0, 3)
        o = target if index % 3 == 0 else rng.normal(0.0, 10.0 ** rng.uniform(0.0, 4.0), 3)
        d = target - o if index % 3 else rng.normal(size=3)
        if index % 5 == 0:
            d = np.eye(3)[index % 3] * rng.choice([-1.0, 1.0])
        t_max = np.inf if index % 4 else np.linalg.norm(target - o) + rng.uniform(0.0, 0.5)
        yield o, d / np.linalg.norm(d), t_max, Ray.CAMERA if index % 2 else Ray.DIFFUSE


@pytest.mark.parametrize("count", [1, 2, 8, 9, 70, 300])
def test_finds_what_a_linear_scan_does(count):
    made = crowd(count)
    tree, alone = Tree(made), [Lamps(lamp) for lamp in made]
    met = hits = 0
    for o, d, t_max, kind in rays(made, 300):
        found = tree.along(o, d, t_max, kind)
        assert len(set(found)) == len(found)
        visible = {index for index, lamp in enumerate(alone) if lamp.row["visibility"] & kind}
        spans = {index: alone[index].trace(o, d) for index in visible}
        meets = {index for index, rows in spans.items() if len(rows) and rows[0, 0] - rows[0, 1] < t_max}
        assert meets <= set(found) <= visible
        met, hits = met + len(found), hits + len(meets)
    # A ray through the box of a turned ring misses that more often than not.
    assert 50 < hits <= met < 8 * hits


def test_without_lamps_there_is_none():
    assert len(Tree([]).along((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), np.inf, Ray.ALL)) == 0
