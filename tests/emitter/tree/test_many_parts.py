# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of many parts and of fine detail: how many boxes rays pass, and that they give nothing up."""

import numpy as np
import pytest

from sdf_lights.emitter.tree import interior
from sdf_lights.emitter.tree.nodes import BOUNDARY
from sdf_lights.emitter.tree.splitting_programs import SHORT_PROGRAM
from sdf_lights.sdf.shapes.orbits import Mandelbulb
from support.lamps import oracle
from support.lamps.hard_cases import around, scattered
from support.lamps.rays import Traced


def _nodes_passed(nodes: np.ndarray, o: np.ndarray, d: np.ndarray, low: float, high: float) -> int:
    """Nodes of a tree that a ray comes to, down to boxes with a short list."""
    waiting, passed = [(0, low, high)], 0
    while waiting:
        index, low, high = waiting.pop()
        passed += 1
        node = nodes[index]
        if node["first"] < 0 or node["state"] != BOUNDARY or node["row_count"] <= SHORT_PROGRAM:
            continue
        crossing = (node["split"] - o[node["axis"]]) / d[node["axis"]]
        near = node["first"] + (d[node["axis"]] < 0.0)
        far = 2 * node["first"] + 1 - near
        if crossing > low:
            waiting.append((near, low, min(crossing, high)))
        if crossing < high:
            waiting.append((far, max(crossing, low), high))
    return passed


@pytest.mark.parametrize("count, most", [(10, 25), (1000, 130)])
def test_rays_pass_few_boxes(count, most):
    """A cube of half size 1 with parts that leave each other some room: 1000 of them are ten times as many on a line.

    Cut in the middle, boxes around 1000 parts make that 230 nodes a ray.
    """
    shape = scattered(count, smooth=False)
    traced = Traced(shape)
    origins, directions, segments = traced.segments(*around(shape, np.random.default_rng(3), 100, (2.0,)))
    passed = [
        _nodes_passed(traced.tree.nodes, *ray, *ends)
        for *ray, ends in zip(origins, directions, segments)
        if ends[0] < ends[1]
    ]
    assert len(passed) > 50
    assert np.mean(passed) < most


def test_boxes_are_no_slivers():
    """Cuts do not close in on a face for ever, whatever they leave to do."""
    tree = interior.tree(scattered(100, smooth=False))
    sides = tree.boxes[:, 3:] - tree.boxes[:, :3]
    assert sides.min() > 1e-4 * sides.max()


def test_rays_do_not_give_up_on_fine_detail():
    """Crossings closer than 1e-6 of the size, dozens of them on a ray, in a field that bounds the distance loosely."""
    shape = Mandelbulb(rounds=5.0)
    origins, directions = around(shape, np.random.default_rng(5), 100)
    found = Traced(shape).trace(origins, directions)
    verdict = oracle.judge(
        shape, origins, directions, found[:, 0], found[:, 1], oracle.find(shape, origins, directions)
    )
    assert verdict.wrong == 0.0 and verdict.below == 0.0
    assert found[:, 0].max() > 30
    assert found[:, 2].sum() < 1e-3 * found[:, 1].sum()
