# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Crossings of rays with a shape by its interior tree, against an independent march."""

from __future__ import annotations

from .. import grids
from . import oracle
from .rays import Traced


def wrong_crossings(shape, rays: int, seed: int = 5) -> float:
    """Fraction of ``rays`` around a certified shape that have a wrong number of crossings."""
    origins, directions = grids.rays_around(shape, rays, seed)
    traced = Traced(shape)
    assert traced.tree.certified
    found = traced.trace(origins, directions)
    truth = oracle.find(shape, origins, directions)
    assert truth.counts.sum() > rays // 20
    return oracle.judge(shape, origins, directions, found[:, 0].astype(int), found[:, 1], truth).wrong
